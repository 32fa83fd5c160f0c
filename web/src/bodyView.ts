// One body in the 3D view: lines as tubes and surfaces, deformed where the body is flexible, and solids with their edges.
import * as THREE from "three";
import { turbo } from "./color";
import { has, PointValues, peak, type Quantity } from "./coloring";
import type { Body, Solid } from "./data";
import { deformed, displacements } from "./deform";
import { SurfaceView } from "./surfaceView";

/** Of what is in the same place nothing flickers. */
const behind = { polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 12 };

const fewLines = 2000; // up to here tubes are round and their ends closed by balls

/** The colours of the points in the linear colour space of the shaders. */
const scale = Array.from({ length: 256 }, (_, i) => {
  const [r, g, b] = turbo(i / 255);
  return new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
});

/** A tube whose colour runs from one end's (`from`) to the other's (`to`). */
function gradientMaterial(): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({ roughness: 0.45, metalness: 0.1, vertexColors: true });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nattribute vec3 colorFrom;\nattribute vec3 colorTo;")
      .replace("#include <color_vertex>", "vColor = mix(colorFrom, colorTo, position.y + 0.5);");
  };
  return material;
}

/** Two opposite quarters of a disc are darker, so that a wheel is seen to turn. */
function marked(geometry: THREE.BufferGeometry): THREE.BufferGeometry {
  const apart = geometry.toNonIndexed();
  const position = apart.getAttribute("position");
  const colors = new Float32Array(3 * position.count);
  for (let triangle = 0; triangle < position.count; triangle += 3) {
    const mean = (get: (k: number) => number) => get(triangle) + get(triangle + 1) + get(triangle + 2);
    const dark = mean((k) => position.getX(k)) * mean((k) => position.getY(k)) > 0;
    colors.fill(dark ? 0.55 : 1, 3 * triangle, 3 * triangle + 9);
  }
  return apart.setAttribute("color", new THREE.BufferAttribute(colors, 3));
}

const isDisc = ({ kind, size }: Solid) => kind === "cylinder" && size[0] > 0.5 * size[1];

function solidGeometry(solid: Solid): THREE.BufferGeometry {
  const [a, b, c] = solid.size;
  if (solid.kind === "box") return new THREE.BoxGeometry(a, b, c);
  if (solid.kind === "sphere") return new THREE.SphereGeometry(a, 32, 20);
  return new THREE.CylinderGeometry(a, a, b, 48).rotateX(Math.PI / 2); // three's axis is y
}

/** The sharp edges; three.js takes points less than 0.1 mm apart for one, so that they are found at a size of 1. */
function edgesOf(geometry: THREE.BufferGeometry, size: number): THREE.BufferGeometry {
  const scaled = geometry.clone().scale(1 / size, 1 / size, 1 / size);
  return new THREE.EdgesGeometry(scaled, 30).scale(size, size, size);
}

export class BodyView {
  readonly group = new THREE.Group();
  /** In body axes, undeformed. */
  readonly bounds = new THREE.Box3();
  /** Nothing of it is drawn. */
  readonly bare: boolean;
  private tubes?: THREE.InstancedMesh;
  private balls?: THREE.InstancedMesh;
  readonly solidMeshes: THREE.Mesh[] = [];
  private solids: THREE.MeshStandardMaterial[] = [];
  private surface?: SurfaceView;
  private edges = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.55 });
  private undeformed?: THREE.LineSegments;
  private u: Float32Array;
  private points: Float32Array;
  private computed = new Map<Quantity, PointValues>();
  private least = 0; // radius of a line
  private faded = false;
  private used: number[]; // points at the ends of lines

  constructor(
    private body: Body,
    private color: THREE.Color,
  ) {
    this.u = new Float32Array(body.points.length);
    this.points = Float32Array.from(body.points);
    this.used = [...new Set(body.lines)];
    if (body.lines.length > 0) this.addLines(color);
    if (body.triangles.length > 0) {
      this.surface = new SurfaceView(body, color, this.flexible, this.edges);
      this.group.add(this.surface.mesh, this.surface.lines);
    }
    for (const solid of body.shapes) this.addSolid(solid, color);
    for (const point of [...this.used, ...new Set(body.triangles)])
      this.bounds.expandByPoint(new THREE.Vector3().fromArray(body.points, 3 * point));
    this.bare = this.bounds.isEmpty();
    if (this.bare) this.bounds.expandByPoint(new THREE.Vector3());
    this.group.name = body.name;
    if (this.tubes) this.place();
    this.paint([], "none", 0);
  }

  get flexible(): boolean {
    return this.body.pointShapes.length > 0;
  }

  deform(amplitudes: ArrayLike<number>, exaggeration: number): void {
    if (!this.flexible) return;
    displacements(this.body, amplitudes, this.u);
    deformed(this.body, this.u, exaggeration, this.points);
    if (this.tubes) this.place();
    this.surface?.place(this.points);
  }

  /** By a quantity whose scale ends at `end`; what has none gets the body's own colour. */
  paint(amplitudes: ArrayLike<number>, quantity: Quantity, end: number): void {
    if (!this.flexible) return;
    const last = scale.length - 1; // also for what is not a number
    const values = has(this.body, quantity) && end > 0 ? this.valuesAt(amplitudes, quantity) : null;
    const colorOf = (point: number) => (values ? (scale[Math.round(last * Math.min(values[point] / end, 1))] ?? scale[last]) : this.color);
    if (this.tubes) this.paintTubes(colorOf);
    this.surface?.paint(colorOf);
  }

  /** Of every point; valid until the next call. */
  valuesAt(amplitudes: ArrayLike<number>, quantity: Quantity): Float32Array {
    let computed = this.computed.get(quantity);
    if (!computed) this.computed.set(quantity, (computed = new PointValues(this.body, quantity)));
    return computed.at(amplitudes);
  }

  /** The largest, and where; a value of 0 at −1 where the body has none. */
  largest(amplitudes: ArrayLike<number>, quantity: Quantity): { value: number; point: number } {
    if (!has(this.body, quantity)) return { value: 0, point: -1 };
    const values = this.valuesAt(amplitudes, quantity);
    const point = peak(values);
    return { value: values[point] ?? 0, point };
  }

  /** The point nearest to where a ray hit one of this body's meshes; −1 on a solid. */
  pointAt({ object, face, instanceId, point }: THREE.Intersection): number {
    let near: number[] = [];
    if (object === this.surface?.mesh && face) near = [face.a, face.b, face.c];
    else if (object === this.tubes && instanceId !== undefined) near = [...this.body.lines.subarray(2 * instanceId, 2 * instanceId + 2)];
    else if (object === this.balls && instanceId !== undefined) near = [this.used[instanceId]];
    const place = this.group.worldToLocal(point.clone());
    const distance = (k: number) => new THREE.Vector3().fromArray(this.points, 3 * k).distanceTo(place);
    return near.reduce((best, k) => (best < 0 || distance(k) < distance(best) ? k : best), -1);
  }

  /** At most so many of the points that are drawn, where they are now. */
  someOfThePoints(most: number): THREE.Vector3[] {
    const drawn = [...new Set([...this.used, ...this.body.triangles])];
    const every = Math.max(1, Math.ceil(drawn.length / most));
    return drawn.filter((_, k) => k % every === 0).map((point) => this.group.localToWorld(new THREE.Vector3().fromArray(this.points, 3 * point)));
  }

  /** Rays are checked against the shape as it is, not as it was. */
  refreshBounds(): void {
    this.tubes?.computeBoundingSphere();
    this.balls?.computeBoundingSphere();
    this.surface?.mesh.geometry.computeBoundingSphere();
  }

  showUndeformed(on: boolean): void {
    if (!this.undeformed) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(this.body.points), 3));
      geometry.setIndex([...this.body.edges, ...this.body.lines]);
      this.undeformed = new THREE.LineSegments(geometry, this.edges);
      this.group.add(this.undeformed);
    }
    this.undeformed.visible = on;
  }

  /** Lines of long slender bars are drawn thick enough to be seen. */
  thicken(radius: number): void {
    this.least = radius;
    if (this.tubes) this.place();
  }

  seeThrough(on: boolean): void {
    for (const material of this.solids) {
      material.transparent = on;
      material.opacity = on ? 0.3 : 1;
      material.depthWrite = !on;
      material.needsUpdate = true;
    }
  }

  /** Another run's body, drawn through the first run's. */
  fade(): void {
    this.faded = true;
    if (this.balls) this.balls.visible = false; // where they overlap tubes they would show as beads
    this.edges.color.copy(this.color);
    this.edges.opacity = 1;
    this.group.traverse((object) => {
      if (!(object instanceof THREE.Mesh)) return;
      object.castShadow = object.receiveShadow = false;
      Object.assign(object.material as THREE.Material, { transparent: true, opacity: 0.28, depthWrite: false, ...behind });
    });
  }

  theme(edge: string): void {
    if (this.faded) return;
    this.edges.color.set(edge);
  }

  private addLines(color: THREE.Color): void {
    const count = this.body.lines.length / 2;
    const round = count <= fewLines;
    const tube = new THREE.CylinderGeometry(1, 1, 1, round ? 16 : 5, 1, true);
    this.tubes = this.instanced(tube, count, color);
    if (!round) return;
    this.balls = this.instanced(new THREE.SphereGeometry(1, 16, 12), this.used.length, color);
  }

  private instanced(geometry: THREE.BufferGeometry, count: number, color: THREE.Color): THREE.InstancedMesh {
    const colored = this.flexible;
    if (colored) {
      const white = new Float32Array(geometry.getAttribute("position").count * 3).fill(1);
      geometry.setAttribute("color", new THREE.BufferAttribute(white, 3));
      for (const name of ["colorFrom", "colorTo"])
        geometry.setAttribute(name, new THREE.InstancedBufferAttribute(new Float32Array(3 * count), 3));
    }
    const material = colored
      ? gradientMaterial()
      : new THREE.MeshStandardMaterial({ color, roughness: 0.45, metalness: 0.1 });
    const mesh = new THREE.InstancedMesh(geometry, material, count);
    mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    mesh.frustumCulled = false; // its bounds change with every frame
    mesh.castShadow = true;
    this.group.add(mesh);
    return mesh;
  }

  private addSolid(solid: Solid, color: THREE.Color): void {
    const geometry = solidGeometry(solid);
    const material = new THREE.MeshStandardMaterial({
      color,
      vertexColors: isDisc(solid),
      roughness: 0.55,
      metalness: 0.05,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    this.solids.push(material);
    const mesh = new THREE.Mesh(isDisc(solid) ? marked(geometry) : geometry, material);
    const [a, b, c, d, e, f, g, h, i] = solid.rotation;
    const [x, y, z] = solid.position;
    mesh.matrix.set(a, b, c, x, d, e, f, y, g, h, i, z, 0, 0, 0, 1);
    mesh.matrixAutoUpdate = false;
    mesh.castShadow = true;
    this.solidMeshes.push(mesh);
    if (solid.kind !== "sphere") mesh.add(new THREE.LineSegments(edgesOf(geometry, Math.max(...solid.size)), this.edges));
    geometry.computeBoundingBox();
    this.bounds.union(geometry.boundingBox!.clone().applyMatrix4(mesh.matrix));
    this.group.add(mesh);
  }

  private place(): void {
    const { lines } = this.body;
    const lineRadius = Math.max(this.body.lineRadius, this.least);
    const a = new THREE.Vector3();
    const b = new THREE.Vector3();
    const along = new THREE.Vector3();
    const x = new THREE.Vector3();
    const z = new THREE.Vector3();
    const matrix = new THREE.Matrix4();
    for (let line = 0; line < lines.length / 2; ++line) {
      a.fromArray(this.points, 3 * lines[2 * line]);
      b.fromArray(this.points, 3 * lines[2 * line + 1]);
      along.subVectors(b, a);
      // Any direction across; the one least along the line is safe.
      if (Math.abs(along.x) < Math.abs(along.y)) x.set(1, 0, 0);
      else x.set(0, 1, 0);
      z.crossVectors(x, along).normalize().multiplyScalar(lineRadius);
      x.crossVectors(along, z).normalize().multiplyScalar(lineRadius);
      matrix.makeBasis(x, along, z).setPosition(a.add(b).multiplyScalar(0.5));
      this.tubes!.setMatrixAt(line, matrix);
    }
    this.tubes!.instanceMatrix.needsUpdate = true;
    if (!this.balls) return;
    matrix.makeScale(lineRadius, lineRadius, lineRadius);
    this.used.forEach((point, k) => {
      matrix.setPosition(a.fromArray(this.points, 3 * point));
      this.balls!.setMatrixAt(k, matrix);
    });
    this.balls.instanceMatrix.needsUpdate = true;
  }

  private paintTubes(colorOf: (point: number) => THREE.Color): void {
    const { lines } = this.body;
    const fill = (mesh: THREE.InstancedMesh, name: string, point: (k: number) => number) => {
      const attribute = mesh.geometry.getAttribute(name) as THREE.InstancedBufferAttribute;
      for (let k = 0; k < mesh.count; ++k) colorOf(point(k)).toArray(attribute.array as Float32Array, 3 * k);
      attribute.needsUpdate = true;
    };
    fill(this.tubes!, "colorFrom", (k) => lines[2 * k]);
    fill(this.tubes!, "colorTo", (k) => lines[2 * k + 1]);
    if (!this.balls) return;
    fill(this.balls, "colorFrom", (k) => this.used[k]);
    fill(this.balls, "colorTo", (k) => this.used[k]);
  }
}
