// Forces and moments as arrows: so many metres long as they have newtons, by one scale for all.
import * as THREE from "three";
import { valueAt } from "./interpolate";
import { isJoint, type Pose } from "./placement";
import type { Element, Scene, Signals } from "./data";

export type Shown = "none" | "loads" | "all";

/** One force or moment over time, global axes. */
interface Vector {
  /** Of its channels. */
  names: string[];
  element: Element;
  moment: boolean;
  /** In the axes of its frame instead. */
  own: boolean;
  /** Of the bodies on each other, not from outside. */
  reaction: boolean;
  at: (time: number) => THREE.Vector3 | null;
  /** The 90th percentile of its size: impacts would make all other arrows invisibly small. Live: follows the sizes seen so far. */
  usual: number;
}

/** Of three channels, or of one along z. */
function vector(signals: Signals, names: string[]): Pick<Vector, "names" | "at" | "usual"> | null {
  const found = names.map((name) => (name === "" ? null : signals(name)));
  if (found.every((signal) => signal === null)) return null;
  const { time } = found.find((signal) => signal !== null)!;
  const sizes = Float64Array.from(time, (_, i) => Math.hypot(...found.map((signal) => signal?.values[i] ?? 0))).sort();
  const largest = sizes[sizes.length - 1] ?? 0;
  const most = sizes[Math.floor(0.9 * (sizes.length - 1))] ?? 0;
  const at = (t: number) => {
    const values = found.map((signal) => (signal ? valueAt(signal.time, signal.values, t) : 0));
    return values.includes(null) ? null : new THREE.Vector3(...(values as [number, number, number]));
  };
  return { names: names.filter((name, k) => name !== "" && found[k]), at, usual: most > 0 ? most : largest };
}

/** `silent`: also those that are zero all the time. */
export function vectorsOf(scene: Scene, silent = false): Vector[] {
  const { signals } = scene;
  if (!signals) return [];
  const axes = (stem: string) => ["x", "y", "z"].map((axis) => `${stem}.${axis}`);
  return scene.elements.flatMap((element): Vector[] => {
    const all: [string[], moment: boolean, reaction: boolean][] =
      element.kind === "load"
        ? [[axes(`load.${element.name}.force`), false, false], [axes(`load.${element.name}.moment`), true, false]]
        : element.kind === "drag"
          ? [[axes(`drag.${element.name}.force`), false, false]]
          : element.kind.startsWith("tyre")
            ? [[["", "", `tyre.${element.name}.vertical`], false, true]]
            : isJoint(element)
              ? [[axes(`joint.${element.name}.force`), false, true]]
              : [];
    return all.flatMap(([names, moment, reaction]) => {
      const found = vector(signals, names);
      return found && (silent || found.usual > 0) ? [{ element, moment, own: element.kind === "drag", reaction, ...found }] : [];
    });
  });
}

/** Whose reactions are drawn at first: of many those with the largest forces, and what is outside, that is tyres. */
export function firstChosen(vectors: Pick<Vector, "element" | "reaction" | "usual">[], most = 10): Element[] {
  const reacting = vectors.filter(({ reaction }) => reaction);
  if (reacting.length <= most) return reacting.map(({ element }) => element);
  const inside = reacting.filter(({ element }) => isJoint(element)).sort((a, b) => b.usual - a.usual);
  const outside = reacting.filter(({ element }) => !isJoint(element));
  return [...outside, ...inside.slice(0, Math.max(most - outside.length, 4))].map(({ element }) => element);
}

/** 1, 2 or 5 times a power of ten, not below `value`; 0 for 0. */
export function niceAbove(value: number): number {
  if (!(value > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([1, 2, 5].find((lead) => lead * power >= value * (1 - 1e-9)) ?? 10);
}

/** A length of 1, along y; a moment has two heads. */
const shaft = new THREE.CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0);
const head = new THREE.ConeGeometry(1, 1, 16).translate(0, -0.5, 0);
const up = new THREE.Vector3(0, 1, 0);

class Arrow {
  readonly group = new THREE.Group();
  private shaft: THREE.Mesh;
  private heads: THREE.Mesh[];

  constructor(
    readonly vector: Vector,
    material: THREE.Material,
    private thickness: number,
  ) {
    this.shaft = new THREE.Mesh(shaft, material);
    this.heads = (vector.moment ? [0, 1] : [0]).map(() => new THREE.Mesh(head, material));
    this.group.add(this.shaft, ...this.heads);
    for (const mesh of [this.shaft, ...this.heads]) mesh.renderOrder = 4;
  }

  place(from: THREE.Vector3, along: THREE.Vector3): void {
    const length = along.length();
    const t = this.thickness;
    this.group.visible = length > 0.2 * t;
    if (!this.group.visible) return;
    this.group.position.copy(from);
    this.group.quaternion.setFromUnitVectors(up, along.clone().divideScalar(length));
    const tip = Math.min(5 * t, 0.5 * length);
    this.shaft.scale.set(0.55 * t, Math.max(length - tip, 1e-9), 0.55 * t);
    this.heads.forEach((mesh, k) => {
      mesh.position.y = length - 0.75 * k * tip;
      mesh.scale.set((1.6 * t * tip) / (5 * t), tip, (1.6 * t * tip) / (5 * t));
    });
  }
}

/** Of forces and of moments, in N per m and N m per m at scale 1; 0: there are none. */
interface ArrowScale {
  force: number;
  moment: number;
}

export class Arrows {
  readonly group = new THREE.Group();
  readonly hasLoads: boolean;
  readonly hasReactions: boolean;
  /** Joints and tyres that have reactions, and those whose are drawn. */
  readonly reacting: Element[];
  readonly chosen: Set<Element>;
  shown: Shown = "none";
  /** As many times the default as an arrow stands for. */
  factor = 1;
  private arrows: Arrow[];
  private scales: { loads: ArrowScale; all: ArrowScale };
  private vectors: Vector[];

  /** `live`: the forces are not known before they are drawn. */
  constructor(
    scene: Scene,
    private size: number,
    private live = false,
  ) {
    const vectors = (this.vectors = vectorsOf(scene, live));
    // Most begin inside bodies: they are seen through them.
    const material = (color: string) => new THREE.MeshStandardMaterial({ color, emissive: color, emissiveIntensity: 0.45, roughness: 0.6, depthTest: false, transparent: true });
    const colors = { load: material("#e11d48"), reaction: material("#2563eb"), moment: material("#9333ea") };
    this.scales = this.measured();
    this.hasLoads = vectors.some((v) => !v.reaction);
    this.reacting = vectors.filter(({ reaction }) => reaction).map(({ element }) => element);
    this.hasReactions = this.reacting.length > 0;
    this.chosen = new Set(firstChosen(vectors));
    this.arrows = vectors.map((v) => new Arrow(v, v.moment ? colors.moment : v.reaction ? colors.reaction : colors.load, 0.005 * size));
    for (const { group } of this.arrows) this.group.add(group);
  }

  /** Reactions may be much larger than loads: where only those are drawn the scale is theirs. */
  get perMetre(): ArrowScale {
    return this.shown === "loads" ? this.scales.loads : this.scales.all;
  }

  /** Channels of the forces that are drawn. */
  get channels(): string[] {
    return this.vectors.filter((vector) => this.wanted(vector)).flatMap(({ names }) => names);
  }

  private measured(): { loads: ArrowScale; all: ArrowScale } {
    const usual = (moment: boolean, reactions: boolean) =>
      Math.max(0, ...this.vectors.filter((v) => v.moment === moment && (reactions || !v.reaction)).map((v) => v.usual));
    const scale = (reactions: boolean) => ({ force: niceAbove(usual(false, reactions) / (0.4 * this.size)), moment: niceAbove(usual(true, reactions) / (0.4 * this.size)) });
    return { loads: scale(false), all: scale(true) };
  }

  private wanted({ reaction, element }: Vector): boolean {
    return reaction ? this.shown === "all" && this.chosen.has(element) : this.shown !== "none";
  }

  /** Follows sizes that stay large, hardly the short peaks of impacts. */
  private learn(vector: Vector, size: number): void {
    if (!(size > vector.usual)) return;
    vector.usual += (vector.usual > 0 ? 0.03 : 1) * (size - vector.usual);
    this.scales = this.measured();
  }

  /** `place`: where an element is drawn now. */
  update(time: number, place: (element: Element) => Pose | null): void {
    for (const arrow of this.arrows) {
      const { vector } = arrow;
      const from = this.wanted(vector) ? place(vector.element) : null;
      const along = from && vector.at(time);
      arrow.group.visible = false;
      if (!from || !along) continue;
      if (this.live) this.learn(vector, along.length());
      if (vector.own) along.applyQuaternion(from.rotation);
      arrow.place(from.position, along.divideScalar((vector.moment ? this.perMetre.moment : this.perMetre.force) * this.factor));
    }
  }
}
