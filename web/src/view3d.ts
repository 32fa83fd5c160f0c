// The animated 3D view. z points up; the scene's origin is the first body's place at the beginning, so that single
// precision is enough far from the global origin.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Arrows, type Shown } from "./arrows";
import { BodyView } from "./bodyView";
import type { Clock } from "./clock";
import { has, peaks, type Peak, type Quantity } from "./coloring";
import type { Element, Scene } from "./data";
import { onThemeChange, themeColor } from "./dom";
import { firstExaggeration, tellingInstant } from "./firstPicture";
import { framing } from "./framing";
import { drape } from "./drape";
import { elementMaterials, ElementView } from "./elementView";
import { amplitudesAt, poseAt, valueAt } from "./interpolate";
import { amplitudesOf, Placement, posesAt, type Pose } from "./placement";
import { LandView } from "./landView";
import { lengthAlong, slideOf } from "./slidingSpring";
import { finiteProfile, gridView, niceLength, roadView } from "./surroundings";
import { turnAfterTap } from "./touch";

const bodyColors = ["#7c93b2", "#d08c60", "#7fa883", "#b07aa1", "#c9a94f", "#6fa8b5", "#b8736f", "#8f8f8f"];

const gridCells = 120;

const farthest = 1e6; // sizes; a run that travels farther has diverged

/** Links of one kind ("front_left.arm", "rear_right.arm") share a colour. */
function colorKey(name: string): string {
  return name.slice(name.lastIndexOf(".") + 1);
}

/** From the centre to the eye: onto the plane of what moves in one, else from the side and above. */
function viewDirection(box: THREE.Box3): THREE.Vector3 {
  const { x, y, z } = box.getSize(new THREE.Vector3());
  const flat = 0.1 * Math.max(x, y, z);
  if (z < flat && Math.min(x, y) > flat) return new THREE.Vector3(0.3, -0.7, 1).normalize();
  if (y < flat && Math.min(x, z) > flat) return new THREE.Vector3(0.3, -1, 0.2).normalize();
  return new THREE.Vector3(0.62, -1, 0.42).normalize();
}

const extent = (box: THREE.Box3) => box.getSize(new THREE.Vector3()).length();

export interface ViewOptions {
  /** Colours are those at the end of the clock's time, not of the present instant. */
  steadyColors?: boolean;
  /** A grid on the ground; default: there is one. */
  grid?: boolean;
  /** The animation is filled while it is shown: its first content does not show what comes. */
  live?: boolean;
  /** From the centre to the eye when the view is fitted; without, and where it is null, from where most is seen. */
  from?: () => THREE.Vector3 | null;
  /** Other runs, drawn through the first in a colour of their own. */
  ghosts?: { scene: Scene; color: string }[];
}

interface Ghost {
  scene: Scene;
  views: BodyView[];
  placement: Placement;
  visible: boolean;
}

/** What a click met. */
export interface Picked {
  body: number; // −1: nothing
  point: number; // of the body; −1: none is near
  element: number; // −1: none
}

export class View3D {
  readonly canvas: HTMLCanvasElement;
  /** Largest displacement of a flexible body's point; 0 when there is none. */
  readonly largest: number;
  /** What the bodies can be coloured by. */
  readonly quantities: Quantity[];
  readonly arrows: Arrows;
  followed = -1; // body; −1: none
  private exaggeration = 1;
  private quantity: Quantity = "none";
  private ends: number[] = []; // of each body's colour scale
  private repaint = true;
  private knownPeaks = new Map<Quantity, Peak[]>();
  private placement: Placement;
  private elements: ElementView[];
  private anchors: THREE.Vector3[]; // where joints and springs are held on the ground
  private plates: { element: Element; mesh: THREE.Mesh }[] = [];
  private ghosts: Ghost[];
  private placed: Pose[] | null = null; // null where some pose is not finite
  private drawn: (() => void)[] = [];
  private attached: { body: number; update: (amplitudes: Float64Array, exaggeration: number) => void }[] = [];
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
  private controls: OrbitControls;
  private bodies: BodyView[];
  private origin = new THREE.Vector3();
  private place = new THREE.Vector3(); // of the followed body when last drawn
  private sun = new THREE.DirectionalLight("#ffffff", 2.2);
  private grid?: THREE.LineSegments;
  private land?: LandView;
  /** Of the grid, m. */
  cell = 1;
  private ground = 0;
  /** Of the mechanism at the beginning, m. */
  size = 1;
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
    // Below the road's surface by more than their depths differ where large triangles are cut by the picture's border.
    land: new THREE.MeshStandardMaterial({ roughness: 1, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 96 }),
    line: new THREE.LineBasicMaterial({ depthWrite: false }),
    patch: new THREE.MeshStandardMaterial({ roughness: 0.4, side: THREE.DoubleSide, transparent: true, opacity: 0.75, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -8 }),
  };
  private fog = new THREE.Fog("#000000");
  private solid = true; // the first run is shown
  private wide = -1; // body that is ground far and wide
  private fitted = false; // to the canvas's true size
  private sharpness = 1; // pixels drawn of those that the screen has, along a side
  private waiting = 0; // what requestAnimationFrame returned; 0: nothing is
  /** The shaders are compiled; until then nothing is drawn, and the rest of the page does not wait for it. */
  ready = false;

  /** Throws where there is no WebGL. */
  constructor(
    private report: Scene,
    private clock: Clock,
    private holder: HTMLElement,
    private options: ViewOptions = {},
  ) {
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.debug.checkShaderErrors = false; // asking for them waits for the compiler
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "Animation of the mechanism; arrow keys rotate the view, + and − zoom");
    this.canvas.tabIndex = 0;
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    holder.prepend(this.canvas);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => this.request());
    turnAfterTap(this.controls); // which take every touch

    const { animation, bodies } = report;
    const { position } = poseAt(animation, animation.time[0] ?? 0, 0);
    if (position.every(Number.isFinite)) this.origin.set(...position);

    this.largest = this.peak("displacement").value;
    this.quantities = (["none", "displacement", "stress"] as const).filter(
      (quantity) => quantity === "none" || (quantity === "displacement" && !options.live ? this.largest > 0 : bodies.some((body) => has(body, quantity))),
    );
    const kinds = [...new Set(bodies.map((body) => colorKey(body.name)))];
    this.bodies = bodies.map(
      (body) => new BodyView(body, new THREE.Color(bodyColors[kinds.indexOf(colorKey(body.name)) % bodyColors.length])),
    );
    const holding = report.elements.filter(({ kind }) => kind !== "floating").flatMap(({ a, b }) => [report.frames[a], report.frames[b]]);
    this.anchors = holding.filter((frame) => frame?.body === -1).map(({ position: [x, y, z] }) => new THREE.Vector3(x, y, z).sub(this.origin));
    this.placement = new Placement(bodies, report.frames, report.elements, this.origin);
    this.ghosts = (options.ghosts ?? []).map(({ scene, color }) => {
      const views = scene.bodies.map((body) => new BodyView(body, new THREE.Color(color)));
      for (const view of views) view.fade();
      return { scene, views, placement: new Placement(scene.bodies, scene.frames, scene.elements, this.origin), visible: true };
    });
    this.scene.add(...[...this.bodies, ...this.ghosts.flatMap(({ views }) => views)].map((body) => body.group));
    this.addSurroundings();
    for (const view of [...this.bodies, ...this.ghosts.flatMap(({ views }) => views)]) view.thicken(0.0025 * this.size);
    this.arrows = new Arrows(report, this.size, options.live);
    this.elements = this.addElements();
    this.followed = this.defaultFollowed();
    this.update();
    this.fit();
    this.theme();
    const ready = () => {
      this.ready = true;
      performance.mark("mimbre: compiled");
      this.request();
    };
    this.renderer.compileAsync(this.scene, this.camera).then(ready, ready);

    clock.onChange(() => this.request());
    onThemeChange(() => this.theme());
    new ResizeObserver(() => this.resize()).observe(holder);
  }

  /** What is in front at a place of the canvas, in pixels. */
  pick(x: number, y: number): Picked {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    for (const body of this.bodies) body.refreshBounds();
    // What is inside a solid that is seen through comes first.
    const hits = ray.intersectObjects(this.bodies.map((body) => body.group)).filter((hit) => hit.object instanceof THREE.Mesh);
    const opaque = ({ object }: THREE.Intersection) => !((object as THREE.Mesh).material as THREE.Material).transparent;
    const hit = hits.find(opaque) ?? hits[0];
    const body = hit ? this.bodies.findIndex(({ group }) => group === hit.object.parent) : -1;
    // Joints are small and often inside bodies: what the ray meets of them counts before the bodies.
    const met = ray.intersectObjects(this.elements.map(({ group }) => group).filter(({ visible }) => visible))[0];
    const element = met ? this.elements.findIndex(({ group }) => group === met.object.parent) : -1;
    if (element >= 0) return { body: -1, point: -1, element: this.report.elements.indexOf(this.elements[element].element) };
    return { body, point: body < 0 ? -1 : this.bodies[body].pointAt(hit), element: -1 };
  }

  /** Values of a body's points now, not exaggerated; valid until the next call. */
  valuesNow(body: number, quantity: Quantity): Float32Array {
    return this.bodies[body].valuesAt(this.amplitudes(body), quantity);
  }

  /** The largest of a body's points now. */
  largestNow(body: number, quantity: Quantity): { value: number; point: number } {
    return this.bodies[body].largest(this.amplitudes(body), quantity);
  }

  /** The largest of all bodies over the whole time. */
  peak(quantity: Quantity): Peak & { body: number } {
    return this.peaks(quantity)
      .map((peak, body) => ({ ...peak, body }))
      .reduce((most, peak) => (peak.value > most.value ? peak : most), { value: 0, point: -1, time: 0, body: -1 });
  }

  /** Colours the flexible bodies, on a scale up to the largest of all or of each. */
  color(quantity: Quantity, perBody = false): void {
    const largest = perBody ? 0 : this.peak(quantity).value;
    this.colorUpTo(quantity, this.peaks(quantity).map(({ value }) => (perBody ? value : largest)));
  }

  /** Colours the flexible bodies; `ends`: of each body's scale. */
  colorUpTo(quantity: Quantity, ends: number[]): void {
    this.quantity = quantity;
    this.ends = ends;
    this.request(true);
  }

  /** The amplitudes of the animation were changed; colour() and the exaggeration have to follow. */
  forgetPeaks(): void {
    this.knownPeaks.clear();
    this.request(true);
  }

  /** Adds what moves along with a body; `update` is called before it is drawn. */
  attach(body: number, object: THREE.Object3D, update: (amplitudes: Float64Array, exaggeration: number) => void): void {
    this.bodies[body].group.add(object);
    this.attached.push({ body, update });
    this.request();
  }

  /** With shadows and all pixels; without, for machines that draw slowly. */
  refine(on: boolean): void {
    this.sharpness = on ? 1 : 0.6;
    this.sun.castShadow = on;
    this.resize();
  }

  showUndeformed(on: boolean): void {
    for (const body of this.bodies) body.showUndeformed(on);
    this.request();
  }

  /** Where most happens. */
  tellingInstant(): number {
    const radii = this.bodies.map(({ bounds }) => 0.5 * extent(bounds));
    return tellingInstant(this.report.animation, this.peaks("displacement"), radii, this.followed);
  }

  /** By which deformations are seen. */
  firstExaggeration(largest: number): number {
    const peaks = this.peaks("displacement");
    const deflections = this.bodies.flatMap(({ bounds, flexible }, k) => (flexible ? [{ value: peaks[k].value, length: extent(bounds) }] : []));
    return firstExaggeration(deflections, this.size, largest);
  }

  /** Whether solids cover a good part of the flexible bodies, seen from where the camera is now. */
  hidesFlexible(): boolean {
    const solids = this.bodies.flatMap(({ solidMeshes }) => solidMeshes);
    if (solids.length === 0) return false;
    this.update();
    this.scene.updateMatrixWorld(true);
    const eye = this.camera.position;
    const points = this.bodies.filter(({ flexible }) => flexible).flatMap((body) => body.someOfThePoints(40));
    const covered = points.filter((point) => {
      const along = point.clone().sub(eye);
      return new THREE.Raycaster(eye, along.clone().normalize(), 0, 0.999 * along.length()).intersectObjects(solids, false).length > 0;
    });
    return covered.length > 0.1 * points.length;
  }

  /** Whether less of the mechanism is in the upper left corner of the picture than in the upper right one. */
  emptierLeft(): boolean {
    const corners = this.cornersAt(this.clock.time).concat(this.bodies.filter(({ flexible }) => flexible).flatMap((body) => body.someOfThePoints(40)));
    const seen = corners.map((point) => point.project(this.camera)).filter(({ y }) => y > 0.5);
    return seen.filter(({ x }) => x < -0.25).length < seen.filter(({ x }) => x > 0.25).length;
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
    this.fit();
  }

  /** Looks at all bodies: as they are now when one is followed, else over the whole time. */
  fit(): void {
    const points = this.followed >= 0 ? this.cornersAt(this.clock.time) : this.cornersOverTime();
    const box = new THREE.Box3().setFromPoints(points);
    const direction = this.options.from?.() ?? viewDirection(box);
    const { center, distance } = framing(points, direction, Math.tan((this.camera.fov * Math.PI) / 360), this.camera.aspect, this.lone ? 0.4 : undefined);
    this.place.copy(this.followedPlace());
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(direction, Math.max(distance, 0.5 * extent(box), 0.15 * this.size));
    this.controls.update();
    this.request();
  }

  /** One body on a ground: seen with what is around it. */
  private get lone(): boolean {
    return this.wide >= 0 && this.bodies.length === 2 && this.followed >= 0;
  }

  showElements(on: boolean): void {
    for (const { group } of this.elements) group.visible = on;
    this.request();
  }

  showArrows(shown: Shown, factor: number): void {
    this.arrows.shown = shown;
    this.arrows.factor = factor;
    this.request();
  }

  /** The second run is number 0. */
  showGhost(run: number, on: boolean): void {
    if (this.ghosts[run]) this.ghosts[run].visible = on;
    this.request();
  }

  /** The first run. */
  showBodies(on: boolean): void {
    this.solid = on;
    this.request();
  }

  /** Called after each picture, while the canvas still holds it. */
  onDrawn(listener: () => void): () => void {
    this.drawn.push(listener);
    return () => (this.drawn = this.drawn.filter((one) => one !== listener));
  }

  /** Draws now what waits for the next animation frame; for callers that are in an animation frame. */
  flush(): void {
    if (this.waiting === 0) return;
    cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    this.update();
    this.draw();
  }

  /** Draws at once, for a picture to be taken. */
  redraw(): void {
    cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    this.ready = true;
    this.update();
    this.draw();
  }

  /** Turns the view by angles, or comes nearer (factor below 1). */
  turn(azimuth: number, elevation: number, factor = 1): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const sphere = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
    sphere.theta += azimuth;
    sphere.phi = Math.min(Math.max(sphere.phi - elevation, 0.02), Math.PI - 0.02);
    sphere.radius *= factor;
    const { x, y, z } = new THREE.Vector3().setFromSpherical(sphere);
    this.camera.position.copy(this.controls.target).add(new THREE.Vector3(x, -z, y));
    this.controls.update();
    this.request();
  }

  private key(event: KeyboardEvent): void {
    const keys: Record<string, [number, number, number]> = {
      ArrowLeft: [-0.1, 0, 1],
      ArrowRight: [0.1, 0, 1],
      ArrowUp: [0, 0.1, 1],
      ArrowDown: [0, -0.1, 1],
      "+": [0, 0, 0.9],
      "-": [0, 0, 1 / 0.9],
    };
    const by = keys[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    this.turn(...by);
    event.preventDefault();
    event.stopPropagation(); // elsewhere the arrows step through time
  }

  private addElements(): ElementView[] {
    const { report } = this;
    const { frames, elements } = report;
    const poses = posesAt(this.report.animation, this.clock.start, this.origin);
    if (poses.includes(null)) return [];
    const amplitudes = amplitudesOf(this.report, this.clock.start);
    const at = (frame: number) => (frame >= 0 ? this.placement.at(frame, poses as Pose[], amplitudes, 1) : null);
    const materials = elementMaterials();
    const thickness = (frame: number) => (report.bodies[frames[frame].body]?.lines.length > 0 ? report.bodies[frames[frame].body].lineRadius : 0);
    const views = elements
      .filter(({ a, b }) => frames[a] && frames[b])
      .map((element) => new ElementView(element, at(element.a), at(element.b), this.size, Math.max(thickness(element.a), thickness(element.b)), materials, this.travel(element)));
    for (const element of elements.filter(({ kind, a }) => kind === "tyre on rig" && frames[a])) {
      const side = 1.6 * element.size;
      const mesh = new THREE.Mesh(new THREE.BoxGeometry(side, side, 0.06 * side).translate(0, 0, -0.03 * side), this.road.surface);
      mesh.receiveShadow = true;
      this.plates.push({ element, mesh });
    }
    this.scene.add(...views.map(({ group }) => group), ...this.plates.map(({ mesh }) => mesh), this.arrows.group);
    return views;
  }

  /** Of a joint's sliding spring: the smallest and the largest length over the time. */
  private travel(element: Element): [number, number] {
    const slide = slideOf(element);
    if (!slide) return [0, 0];
    const { time } = this.report.animation;
    const every = Math.max(1, Math.floor(time.length / 200));
    const lengths = Array.from({ length: Math.ceil(time.length / every) }, (_, k) => time[k * every]).flatMap((t) => {
      const poses = posesAt(this.report.animation, t, this.origin);
      if (poses.includes(null)) return [];
      const amplitudes = amplitudesOf(this.report, t);
      const at = (frame: number) => this.placement.at(frame, poses as Pose[], amplitudes, 1);
      return lengthAlong(slide.axis, at(element.a), at(element.b));
    });
    return [Math.min(...lengths), Math.max(...lengths)];
  }

  private updateElements(): void {
    const { placed } = this;
    const { time } = this.clock;
    if (!placed) return;
    const amplitudes = amplitudesOf(this.report, time);
    const at = (frame: number) => this.placement.at(frame, placed, amplitudes, this.exaggeration);
    for (const view of this.elements) if (view.group.visible) view.update(at(view.element.a), at(view.element.b));
    for (const { element, mesh } of this.plates) {
      const signal = this.report.signals?.(`tyre.${element.name}.road`);
      const height = signal ? valueAt(signal.time, signal.values, time) : null;
      mesh.visible = height !== null;
      if (height !== null) mesh.position.copy(at(element.a).position).setZ(height - this.origin.z);
    }
    this.arrows.update(time, ({ kind, a, b, size }) => {
      const frame = kind === "load" || kind === "drag" || kind.startsWith("tyre") ? a : b;
      if (frame < 0) return null;
      const pose = at(frame);
      if (kind.startsWith("tyre")) pose.position.z -= size;
      return pose;
    });
  }

  private updateGhosts(): void {
    const time = Math.min(this.clock.time, this.clock.end);
    for (const { scene, views, placement, visible } of this.ghosts) {
      const poses = posesAt(scene.animation, time, this.origin);
      const amplitudes = amplitudesOf(scene, time);
      const placed = poses.includes(null) ? poses : placement.place(poses as Pose[], amplitudes, this.exaggeration);
      views.forEach((view, k) => {
        const pose = placed[k];
        view.group.visible = visible && pose !== null;
        if (!pose) return;
        view.group.position.copy(pose.position);
        view.group.quaternion.copy(pose.rotation);
        view.deform(amplitudes[k], this.exaggeration);
      });
    }
  }

  private peaks(quantity: Quantity): Peak[] {
    const { bodies, animation } = this.report;
    let known = this.knownPeaks.get(quantity);
    if (!known) this.knownPeaks.set(quantity, (known = peaks(bodies, animation, quantity)));
    return known;
  }

  private amplitudes(body: number, time = this.clock.time): Float64Array {
    const { firstMode, modes } = this.report.bodies[body];
    return amplitudesAt(this.report.animation, time, firstMode, modes);
  }

  /** The chassis; without one the first body where things travel far, else none. */
  private defaultFollowed(): number {
    const chassis = this.report.bodies.findIndex((body) => /(^|\.)chassis$/i.test(body.name));
    if (chassis >= 0) return chassis;
    return extent(this.boundsOverTime()) > 4 * this.size ? 0 : -1;
  }

  /** The ground where it is far wider than what moves on it: then it does not count for the size of the mechanism. */
  private wideGround(): number {
    const ground = this.report.bodies.findIndex(({ name }) => name === "ground");
    if (ground < 0) return -1;
    this.wide = ground;
    return extent(this.bodies[ground].bounds) > 4 * extent(this.boundsAt(this.clock.start)) ? ground : -1;
  }

  private boundsAt(time: number): THREE.Box3 {
    return new THREE.Box3().setFromPoints(this.cornersAt(time));
  }

  private boundsOverTime(): THREE.Box3 {
    return new THREE.Box3().setFromPoints(this.cornersOverTime());
  }

  /** Of the boxes around the bodies, and the points on the ground. */
  private cornersAt(time: number): THREE.Vector3[] {
    const corners = this.bodies.flatMap(({ bounds: { min, max } }, k) => {
      const matrix = k === this.wide ? null : this.poseMatrix(time, k);
      if (!matrix) return [];
      return [0, 1, 2, 3, 4, 5, 6, 7].map((corner) => new THREE.Vector3(corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z).applyMatrix4(matrix));
    });
    if (corners.length === 0) return [-0.5, 0.5].map((half) => new THREE.Vector3(half, half, half));
    return [...corners, ...this.anchors.map((point) => point.clone())];
  }

  private cornersOverTime(): THREE.Vector3[] {
    const { time } = this.report.animation;
    const every = Math.max(1, Math.floor(time.length / 60));
    const all = this.cornersAt(time[0] ?? 0);
    const box = new THREE.Box3().setFromPoints(all);
    const first = extent(box) || 10;
    for (let i = every; i < time.length; i += every) {
      const now = this.cornersAt(time[i]);
      const wider = box.clone().union(new THREE.Box3().setFromPoints(now));
      // A run that diverged would make the rest invisibly small.
      if (!(extent(wider) < farthest * first)) continue;
      box.copy(wider);
      all.push(...now);
    }
    return all;
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
    this.wide = this.wideGround();
    this.size = extent(this.boundsAt(this.clock.start)) || extent(this.boundsOverTime()) || 1;
    // A body without any drawing is at least seen as its axes.
    for (const body of this.bodies) if (body.bare) body.group.add(new THREE.AxesHelper(0.08 * this.size));
    this.cell = niceLength(this.size / 4);
    const drawn = this.report.roads.map(({ profile, patches = [] }) => ({ profile: finiteProfile(profile), patches })).filter(({ profile }) => profile.length > 1);
    const roads = drawn.map(({ profile }) => profile);
    const halfWidth = 0.45 * this.size;
    // What is driven leaves the road's middle; of several roads none is known to be the land.
    if (this.options.live && roads.length === 1) {
      this.land = new LandView(roads[0], drawn[0].patches, this.origin, this.cell, gridCells, halfWidth, this.road);
      this.scene.add(this.land.group);
    } else for (const profile of roads) this.scene.add(roadView(profile, this.origin, this.cell, halfWidth, this.road));
    if (this.options.live) this.paintGround();
    // Below everything, and under the road by a hair: coplanar surfaces flicker.
    const bottom = this.boundsOverTime().min.z + this.origin.z;
    // What hovers high above the origin has its ground where it can be seen.
    const above = bottom > 5 * this.size ? bottom : Math.min(0, bottom);
    const lowest = roads.flat().reduce((least, [, z]) => Math.min(least, z), above);
    this.ground = lowest - this.origin.z - 2e-3 * this.size;
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#a39a8e", 1.9), this.sun, this.sun.target);
    // From where one looks: no side is ever dark.
    this.camera.add(new THREE.DirectionalLight("#ffffff", 0.7));
    this.scene.add(this.camera);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.bias = -1e-4;
    this.sun.shadow.normalBias = 2e-3 * this.size;
    const reach = 1.2 * this.size;
    Object.assign(this.sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * this.size, far: 8 * this.size });
    this.sun.shadow.camera.updateProjectionMatrix();
  }

  /** Where the ground's surface is a road, its patches. */
  private paintGround(): void {
    const ground = this.report.bodies.findIndex(({ name }) => name === "ground");
    const patches = this.report.roads.flatMap(({ profile, patches = [] }) => (profile.length === 0 ? patches : []));
    if (ground < 0) return;
    const { points, triangles } = this.report.bodies[ground];
    for (const { x, y } of patches) {
      const corners = new THREE.Float32BufferAttribute(drape(points, triangles, x, y), 3);
      const mesh = new THREE.Mesh(new THREE.BufferGeometry().setAttribute("position", corners), this.road.patch);
      mesh.geometry.computeVertexNormals();
      mesh.name = "patch";
      this.bodies[ground].group.add(mesh);
    }
  }

  private theme(): void {
    this.scene.background = new THREE.Color(themeColor("sky"));
    this.scene.fog = this.fog;
    this.fog.color.set(themeColor("sky"));
    this.road.surface.color.set(themeColor("road"));
    for (const line of [this.road.border, this.road.mark]) line.color.set(themeColor("road-line"));
    this.road.land.color.set(themeColor("land"));
    this.road.line.color.set(themeColor("ground-line"));
    this.road.patch.color.set(themeColor("patch"));
    for (const body of this.bodies) body.theme(themeColor("edge"));
    if (this.grid) this.scene.remove(this.grid);
    if (this.options.grid !== false) {
      this.grid = gridView(this.cell, gridCells, themeColor("ground-line"));
      this.scene.add(this.grid);
    }
    this.request();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (width === 0 || height === 0) return;
    const before = this.camera.aspect;
    this.renderer.setPixelRatio(this.sharpness * Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // A view that fitted a wide canvas would be cut by a narrow one.
    if (!this.fitted || before > 1 !== this.camera.aspect > 1) this.fit();
    this.fitted = true;
    this.request();
  }

  private request(repaint = false): void {
    this.repaint ||= repaint;
    if (this.waiting !== 0) return;
    this.waiting = requestAnimationFrame(() => this.flush());
  }

  private update(): void {
    const { time, end } = this.clock;
    const { steadyColors } = this.options;
    const poses = posesAt(this.report.animation, time, this.origin);
    this.placed = poses.includes(null) ? null : this.placement.place(poses as Pose[], amplitudesOf(this.report, time), this.exaggeration);
    this.bodies.forEach((view, k) => {
      const pose = (this.placed ?? poses)[k];
      view.group.visible = this.solid && pose !== null;
      if (!pose) return;
      view.group.position.copy(pose.position);
      view.group.quaternion.copy(pose.rotation);
      if (!view.flexible) return;
      const amplitudes = this.amplitudes(k);
      view.deform(amplitudes, this.exaggeration);
      if (this.repaint || (!steadyColors && this.quantity !== "none"))
        view.paint(steadyColors ? this.amplitudes(k, end) : amplitudes, this.quantity, this.ends[k] ?? 0);
    });
    this.repaint = false;
    this.updateElements();
    this.updateGhosts();
    for (const { body, update } of this.attached) update(this.amplitudes(body), this.exaggeration);
    if (this.followed < 0) return;
    const place = this.followedPlace();
    const moved = place.clone().sub(this.place);
    this.place.copy(place);
    this.camera.position.add(moved);
    this.controls.target.add(moved);
  }

  private draw(): void {
    if (!this.ready) return;
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
    this.land?.look(target, this.fog.far);
    this.sun.target.position.copy(target);
    this.sun.position.copy(target).addScaledVector(new THREE.Vector3(0.35, -0.5, 1).normalize(), 4 * this.size);
    this.camera.lookAt(target);
    this.renderer.render(this.scene, this.camera);
    for (const listener of this.drawn) listener();
  }
}
