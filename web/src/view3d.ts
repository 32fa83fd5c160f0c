// The animated 3D view. z points up; the scene's origin is the first body's place at the beginning, so that single
// precision is enough far from the global origin.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { BodyView } from "./bodyView";
import type { Clock } from "./clock";
import type { Scene } from "./data";
import { largestDisplacement, suggestedExaggeration } from "./deform";
import { onThemeChange, themeColor } from "./dom";
import { amplitudesAt, poseAt } from "./interpolate";
import { finiteProfile, gridView, niceLength, roadView } from "./surroundings";

const bodyColors = ["#7c93b2", "#d08c60", "#7fa883", "#b07aa1", "#c9a94f", "#6fa8b5", "#b8736f", "#8f8f8f"];

const gridCells = 120;

/** Links of one kind ("front_left.arm", "rear_right.arm") share a colour. */
function colorKey(name: string): string {
  return name.slice(name.lastIndexOf(".") + 1);
}

const extent = (box: THREE.Box3) => box.getSize(new THREE.Vector3()).length();

export class View3D {
  readonly canvas: HTMLCanvasElement;
  /** Largest displacement of a flexible body's point, the end of the colour scale; 0 when there is none. */
  readonly largest: number;
  readonly suggested: number;
  followed = -1; // body; −1: none
  private exaggeration = 1;
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
  private controls: OrbitControls;
  private bodies: BodyView[];
  private origin = new THREE.Vector3();
  private place = new THREE.Vector3(); // of the followed body when last drawn
  private sun = new THREE.DirectionalLight("#ffffff", 2.2);
  private grid?: THREE.GridHelper;
  private cell = 1;
  private ground = 0;
  private size = 1;
  private road = {
    surface: new THREE.MeshStandardMaterial({
      roughness: 0.95,
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    }),
    border: new THREE.LineBasicMaterial(),
    mark: new THREE.LineBasicMaterial({ transparent: true, opacity: 0.35 }),
  };
  private fog = new THREE.Fog("#000000");
  private fitted = false; // to the canvas's true size
  private waiting = false;

  /** Throws where there is no WebGL. */
  constructor(
    private report: Scene,
    private clock: Clock,
    private holder: HTMLElement,
  ) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Animation of the mechanism; drag to turn, scroll to zoom");
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    holder.prepend(this.canvas);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.request());

    const { animation, bodies } = report;
    const { position } = poseAt(animation, animation.time[0] ?? 0, 0);
    if (position.every(Number.isFinite)) this.origin.set(...position);

    this.largest = largestDisplacement(bodies, animation);
    const kinds = [...new Set(bodies.map((body) => colorKey(body.name)))];
    this.bodies = bodies.map(
      (body) => new BodyView(body, new THREE.Color(bodyColors[kinds.indexOf(colorKey(body.name)) % bodyColors.length]), this.largest),
    );
    this.suggested = this.suggestExaggeration();
    this.scene.add(...this.bodies.map((body) => body.group));
    this.addSurroundings();
    this.followed = this.defaultFollowed();
    this.update();
    this.place.copy(this.followedPlace());
    this.fit();
    this.theme();

    clock.onChange(() => this.request());
    onThemeChange(() => this.theme());
    new ResizeObserver(() => this.resize()).observe(holder);
  }

  /** The body in front at a place of the canvas, in pixels; −1 where there is none. */
  pick(x: number, y: number): number {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    for (const mesh of this.bodies.flatMap((body) => body.group.children))
      if (mesh instanceof THREE.InstancedMesh) mesh.computeBoundingSphere(); // else that of an earlier frame is used
    // Lines inside a solid that is seen through come first.
    const hits = ray.intersectObjects(this.bodies.map((body) => body.group)).filter((hit) => hit.object instanceof THREE.Mesh);
    const hit = hits.find(({ object }) => object instanceof THREE.InstancedMesh) ?? hits[0];
    return hit ? this.bodies.findIndex((body) => body.group === hit.object.parent) : -1;
  }

  /** Largest displacement of a body's points now, m. */
  displacement(body: number): number {
    return this.bodies[body].largest;
  }

  exaggerate(factor: number): void {
    this.exaggeration = factor;
    this.request();
  }

  seeThrough(on: boolean): void {
    for (const body of this.bodies) body.seeThrough(on);
    this.request();
  }

  follow(body: number): void {
    this.followed = body;
    this.place.copy(this.followedPlace());
    this.fit();
  }

  /** Looks at all bodies: as they are now when one is followed, else over the whole time. */
  fit(): void {
    const box = this.followed >= 0 ? this.boundsAt(this.clock.time) : this.boundsOverTime();
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const radius = Math.max(sphere.radius, 0.15 * this.size);
    const narrow = Math.min(1, this.camera.aspect);
    const distance = radius / Math.sin((this.camera.fov * Math.PI) / 360) / narrow;
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(new THREE.Vector3(0.62, -1, 0.42).normalize(), distance);
    this.controls.update();
    this.request();
  }

  private suggestExaggeration(): number {
    let relative = 0;
    this.report.bodies.forEach((body, k) => {
      const size = extent(this.bodies[k].bounds);
      if (this.bodies[k].flexible && size > 0)
        relative = Math.max(relative, largestDisplacement([body], this.report.animation) / size);
    });
    return suggestedExaggeration(relative, 1);
  }

  /** The chassis; without one the first body where things travel far, else none. */
  private defaultFollowed(): number {
    const chassis = this.report.bodies.findIndex((body) => /(^|\.)chassis$/i.test(body.name));
    if (chassis >= 0) return chassis;
    return extent(this.boundsOverTime()) > 4 * this.size ? 0 : -1;
  }

  private boundsAt(time: number): THREE.Box3 {
    const box = new THREE.Box3();
    this.bodies.forEach((body, k) => {
      const matrix = this.poseMatrix(time, k);
      if (matrix) box.union(body.bounds.clone().applyMatrix4(matrix));
    });
    return box.isEmpty() ? box.setFromCenterAndSize(new THREE.Vector3(), new THREE.Vector3(1, 1, 1)) : box;
  }

  private boundsOverTime(): THREE.Box3 {
    const { time } = this.report.animation;
    const box = new THREE.Box3();
    const every = Math.max(1, Math.floor(time.length / 60));
    for (let i = 0; i < time.length; i += every) {
      const now = this.boundsAt(time[i]);
      // A run that diverged would make the rest invisibly small.
      if (extent(box.clone().union(now)) < 1e7) box.union(now);
    }
    return box;
  }

  /** In the scene; null where the results hold no finite pose. */
  private poseMatrix(time: number, body: number): THREE.Matrix4 | null {
    const { position, rotation } = poseAt(this.report.animation, time, body);
    if (![...position, ...rotation].every(Number.isFinite)) return null;
    const [w, x, y, z] = rotation;
    const place = new THREE.Vector3(...position).sub(this.origin);
    return new THREE.Matrix4().compose(place, new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));
  }

  private followedPlace(): THREE.Vector3 {
    const place = new THREE.Vector3();
    const matrix = this.followed >= 0 ? this.poseMatrix(this.clock.time, this.followed) : null;
    return matrix ? place.setFromMatrixPosition(matrix) : place;
  }

  private addSurroundings(): void {
    this.size = extent(this.boundsAt(this.clock.start)) || extent(this.boundsOverTime()) || 1;
    // A body without any drawing is at least seen as its axes.
    for (const body of this.bodies) if (body.bare) body.group.add(new THREE.AxesHelper(0.08 * this.size));
    this.cell = niceLength(this.size / 4);
    const roads = this.report.roads.map((road) => finiteProfile(road.profile)).filter((profile) => profile.length > 1);
    for (const profile of roads) this.scene.add(roadView(profile, this.origin, this.cell, this.road));
    // Below everything, and under the road by a hair: coplanar surfaces flicker.
    const lowest = roads.flat().reduce((least, [, z]) => Math.min(least, z), Math.min(0, this.boundsOverTime().min.z + this.origin.z));
    this.ground = lowest - this.origin.z - 2e-3 * this.size;
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8d8478", 1.5), this.sun, this.sun.target);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.bias = -1e-4;
    this.sun.shadow.normalBias = 2e-3 * this.size;
    const reach = 1.2 * this.size;
    Object.assign(this.sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * this.size, far: 8 * this.size });
    this.sun.shadow.camera.updateProjectionMatrix();
  }

  private theme(): void {
    this.scene.background = new THREE.Color(themeColor("sky"));
    this.scene.fog = this.fog;
    this.fog.color.set(themeColor("sky"));
    this.road.surface.color.set(themeColor("road"));
    for (const line of [this.road.border, this.road.mark]) line.color.set(themeColor("road-line"));
    for (const body of this.bodies) body.theme(themeColor("edge"));
    if (this.grid) this.scene.remove(this.grid);
    this.grid = gridView(this.cell, gridCells, themeColor("ground-line"));
    this.scene.add(this.grid);
    this.request();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (width === 0 || height === 0) return;
    const before = this.camera.aspect;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // A view that fitted a wide canvas would be cut by a narrow one.
    if (!this.fitted || before > 1 !== this.camera.aspect > 1) this.fit();
    this.fitted = true;
    this.request();
  }

  private request(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.update();
      this.draw();
    });
  }

  private update(): void {
    const { animation, bodies } = this.report;
    const { time } = this.clock;
    this.bodies.forEach((view, k) => {
      const matrix = this.poseMatrix(time, k);
      view.group.visible = matrix !== null;
      if (!matrix) return;
      matrix.decompose(view.group.position, view.group.quaternion, view.group.scale);
      if (view.flexible) view.deform(amplitudesAt(animation, time, bodies[k].firstMode, bodies[k].modes), this.exaggeration);
    });
    if (this.followed < 0) return;
    const place = this.followedPlace();
    const moved = place.clone().sub(this.place);
    this.place.copy(place);
    this.camera.position.add(moved);
    this.controls.target.add(moved);
  }

  private draw(): void {
    const { target } = this.controls;
    const distance = this.camera.position.distanceTo(target);
    this.camera.near = distance / 100;
    this.camera.far = Math.max(20 * distance, 60 * this.size);
    this.camera.updateProjectionMatrix();
    // The grid ends in the fog, however far one looks from.
    this.fog.near = 2.5 * distance;
    this.fog.far = Math.max(this.fog.near + 0.35 * gridCells * this.cell, 4 * distance);
    const whole = (value: number) => Math.round(value / this.cell) * this.cell;
    this.grid?.position.set(
      whole(target.x + this.origin.x) - this.origin.x,
      whole(target.y + this.origin.y) - this.origin.y,
      this.ground,
    );
    this.sun.target.position.copy(target);
    this.sun.position.copy(target).addScaledVector(new THREE.Vector3(0.35, -0.5, 1).normalize(), 4 * this.size);
    this.camera.lookAt(target);
    this.renderer.render(this.scene, this.camera);
  }
}
