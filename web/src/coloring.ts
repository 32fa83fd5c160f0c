// By what the flexible bodies are coloured, and the ends of the colour scales.
import type { Animation, Body } from "./data";
import { displacements, magnitudes } from "./deform";
import { amplitudesAt } from "./interpolate";
import { barVonMises, stresses, vonMises } from "./stress";

export type Quantity = "none" | "displacement" | "stress";

export function has(body: Body, quantity: Quantity): boolean {
  if (quantity === "stress") return body.stress.length > 0 || body.barStress.length > 0;
  return quantity === "displacement" && body.pointShapes.length > 0;
}

/** Computes a quantity at the points of one body, without allocating. */
export class PointValues {
  readonly values: Float32Array;
  private components: Float32Array; // displacements or stresses, of bars at the ends of the lines

  private ofBars: boolean;

  constructor(
    private body: Body,
    private quantity: Quantity,
  ) {
    const points = body.points.length / 3;
    this.values = new Float32Array(points);
    this.ofBars = quantity === "stress" && body.stress.length === 0;
    this.components = new Float32Array(this.ofBars ? 4 * body.lines.length : quantity === "stress" ? 6 * points : 3 * points);
  }

  at(amplitudes: ArrayLike<number>): Float32Array {
    if (this.ofBars) {
      barVonMises(this.body, amplitudes, this.components, this.values);
    } else if (this.quantity === "stress") {
      stresses(this.body, amplitudes, this.components);
      vonMises(this.components, this.values);
    } else {
      displacements(this.body, amplitudes, this.components);
      magnitudes(this.components, this.values);
    }
    return this.values;
  }
}

/** Place of the largest finite value; −1 where there is none. */
export function peak(values: ArrayLike<number>): number {
  let place = -1;
  for (let i = 0; i < values.length; ++i) if (Number.isFinite(values[i]) && (place < 0 || values[i] > values[place])) place = i;
  return place;
}

export interface Peak {
  value: number;
  point: number; // −1: there is none
  time: number;
}

/** The largest of each body over the animation. Of large models a sample of the instants finds the scale well enough. */
export function peaks(bodies: Body[], animation: Animation, quantity: Quantity, budget = quantity === "stress" ? 4e8 : 2e7): Peak[] {
  const concerned = bodies.filter((body) => has(body, quantity));
  const size = (body: Body) => (quantity === "stress" ? body.stress.length + body.barStress.length : body.pointShapes.length);
  const work = concerned.reduce((sum, body) => sum + size(body), 0);
  const every = Math.max(1, Math.ceil((work * animation.time.length) / budget));
  return bodies.map((body) => {
    const largest: Peak = { value: 0, point: -1, time: 0 };
    if (!has(body, quantity)) return largest;
    const computed = new PointValues(body, quantity);
    for (let i = 0; i < animation.time.length; i += every) {
      const time = animation.time[i];
      const values = computed.at(amplitudesAt(animation, time, body.firstMode, body.modes));
      const point = peak(values);
      if (point >= 0 && values[point] > largest.value) Object.assign(largest, { value: values[point], point, time });
    }
    return largest;
  });
}

/** " at node 12", where the mesh numbers its nodes. */
export function atNode(body: Body, point: number): string {
  return point >= 0 && point < body.labels.length ? ` at node ${body.labels[point]}` : "";
}
