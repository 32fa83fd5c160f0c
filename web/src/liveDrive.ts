// How keys and gamepads move inputs: pedals that rise and fall, a steering wheel that goes back by itself.
import type { Input } from "./liveProtocol";

export type Role = "steering" | "throttle" | "brake" | "other";

export function roleOf(name: string): Role {
  const last = name.slice(name.lastIndexOf(".") + 1).toLowerCase();
  if (/^steer(ing)?(_?(wheel|angle|input))?$/.test(last)) return "steering";
  if (/^(throttle|accelerator|gas)(_?pedal)?$/.test(last)) return "throttle";
  return /^(brake|braking)(_?pedal)?$/.test(last) ? "brake" : "other";
}

/** An input as it is driven. */
export interface Lever {
  name: string;
  role: Role;
  low: number;
  high: number;
  /** Where it is when nobody touches it. */
  rest: number;
  /** It goes there by itself. */
  returns: boolean;
  /** Per second, away from the rest and back. */
  rise: number;
  fall: number;
  /** Keys (KeyboardEvent.code) that make it larger and smaller. */
  plus: string[];
  minus: string[];
  /** Of a gamepad, see readPad; "": none. */
  source: string;
}

/** Of an input without bounds: so far that a slider has room around the start. */
function bounds({ min, max, start, value }: Input): [number, number] {
  const room = 10 ** Math.ceil(Math.log10(Math.max(Math.abs(start), Math.abs(value), 1)));
  return [min ?? Math.min((max ?? Infinity) - room, start - room), max ?? Math.max((min ?? -Infinity) + room, start + room)];
}

/** Positive is left: ISO 8855 turns about the upward axis. */
export function leverOf(input: Input): Lever {
  const role = input.tunable ? "other" : roleOf(input.name);
  const [low, high] = bounds(input);
  const range = high - low;
  const rest = Math.min(Math.max(input.start, low), high);
  const common = { name: input.name, role, low, high, rest };
  if (role === "steering") return { ...common, returns: true, rise: range, fall: 1.6 * range, plus: ["KeyA", "ArrowLeft"], minus: ["KeyD", "ArrowRight"], source: "axis 0 reversed" };
  if (role === "throttle") return { ...common, returns: true, rise: 2 * range, fall: 4 * range, plus: ["KeyW", "ArrowUp"], minus: [], source: "button 7" };
  if (role === "brake") return { ...common, returns: true, rise: 2.5 * range, fall: 5 * range, plus: ["KeyS", "ArrowDown", "Space"], minus: [], source: "button 6" };
  return { ...common, returns: false, rise: 0.4 * range, fall: 0.4 * range, plus: [], minus: [], source: "" };
}

function towards(value: number, target: number, by: number): number {
  return value < target ? Math.min(value + by, target) : Math.max(value - by, target);
}

/** The value after `dt`; `pressed`: 1 the keys that make it larger, −1 smaller, 0 none. */
export function advance(lever: Lever, value: number, pressed: number, dt: number): number {
  const { low, high, rest, rise, fall, returns } = lever;
  if (pressed === 0) return returns ? towards(value, rest, fall * dt) : value;
  // From the other side it comes back as fast as when it is let go.
  const back = (value - rest) * pressed < 0;
  return towards(value, pressed > 0 ? high : low, (back ? fall : rise) * dt);
}

/** What of a Gamepad is read. */
export interface Pad {
  axes: readonly number[];
  buttons: readonly { value: number }[];
}

const deadZone = 0.08; // sticks do not rest at nought

/** "axis 0", "axis 2 pedal" (1 when free, −1 when pressed), each "… reversed", or "button 7". null: the pad has none such. */
export function readPad(pad: Pad, source: string): number | null {
  const [kind, number, ...words] = source.split(" ");
  if (kind === "button") return pad.buttons[Number(number)]?.value ?? null;
  const axis = kind === "axis" ? pad.axes[Number(number)] : undefined;
  if (axis === undefined) return null;
  const value = words.includes("reversed") ? -axis : axis;
  if (words.includes("pedal")) return Math.min(Math.max(0.5 * (1 - value), 0), 1);
  const size = Math.max(Math.abs(value) - deadZone, 0) / (1 - deadZone);
  return Math.sign(value) * Math.min(size, 1);
}

/** Of a reading between −1 and 1. */
export function padValue({ low, high, rest }: Lever, reading: number): number {
  return rest + (reading >= 0 ? reading * (high - rest) : reading * (rest - low));
}

/** Sources that a pad offers. */
export function sourcesOf({ axes, buttons }: Pad): string[] {
  const ofAxes = axes.flatMap((_, k) => [`axis ${k}`, `axis ${k} reversed`, `axis ${k} pedal`, `axis ${k} pedal reversed`]);
  return [...ofAxes, ...buttons.map((_, k) => `button ${k}`)];
}

/** Which of keys, fingers and pad moves what; an input that none has touched is left alone. */
export class Driver {
  readonly levers: Lever[];
  private pressed = new Set<string>();
  private byKeys = new Map<Lever, number>(); // what the keys have made of it
  private byPad = new Set<Lever>();
  private byFinger = new Map<Lever, number>(); // between −1 and 1
  private readings = new Map<Lever, number>(); // the pad's last

  constructor(inputs: Input[]) {
    this.levers = inputs.filter(({ tunable }) => !tunable).map(leverOf);
  }

  /** Whether the key drives something. */
  takes(code: string): boolean {
    return this.levers.some(({ plus, minus }) => plus.includes(code) || minus.includes(code));
  }

  press(code: string): void {
    this.pressed.add(code);
  }

  release(code: string): void {
    this.pressed.delete(code);
  }

  /** A finger on the screen; null: it is taken away. */
  touch(lever: Lever, reading: number | null): void {
    const before = this.byFinger.get(lever);
    if (reading !== null) this.byFinger.set(lever, reading);
    else if (before !== undefined) {
      this.byFinger.delete(lever);
      this.byKeys.set(lever, padValue(lever, before)); // it returns as from a key
    }
  }

  /** Somebody set it by other means. */
  leave(name: string): void {
    for (const lever of this.levers)
      if (lever.name === name) {
        this.byKeys.delete(lever);
        this.byPad.delete(lever);
      }
  }

  /** Nobody is at the keys: what returns by itself is at rest. */
  letGo(): Record<string, number> {
    this.pressed.clear();
    const back = [...this.byKeys.keys(), ...this.byFinger.keys(), ...this.byPad].filter(({ returns }) => returns);
    this.byKeys.clear();
    this.byFinger.clear();
    this.byPad.clear();
    this.readings.clear();
    return Object.fromEntries(back.map(({ name, rest }) => [name, rest]));
  }

  /** Values that are driven now; `present`: of an input, as the server has it. */
  advance(dt: number, present: (name: string) => number, pad: Pad | null): Record<string, number> {
    const driven: Record<string, number> = {};
    for (const lever of this.levers) {
      const held = (keys: string[]) => keys.some((key) => this.pressed.has(key));
      const pressed = Number(held(lever.plus)) - Number(held(lever.minus));
      const reading = pad && lever.source !== "" ? readPad(pad, lever.source) : null;
      const before = this.readings.get(lever);
      if (reading !== null) {
        if (before !== undefined && Math.abs(reading - before) > 0.01) {
          this.byPad.add(lever);
          this.byKeys.delete(lever);
        }
        if (before === undefined || this.byPad.has(lever)) this.readings.set(lever, reading);
      }
      if (pressed !== 0) {
        if (!this.byKeys.has(lever)) this.byKeys.set(lever, present(lever.name));
        this.byPad.delete(lever);
      }
      const value = this.byKeys.get(lever);
      const finger = this.byFinger.get(lever);
      if (finger !== undefined) driven[lever.name] = padValue(lever, finger);
      else if (value !== undefined) {
        const next = advance(lever, value, pressed, dt);
        driven[lever.name] = next;
        if (pressed === 0 && (!lever.returns || next === lever.rest)) this.byKeys.delete(lever);
        else this.byKeys.set(lever, next);
      } else if (this.byPad.has(lever) && reading !== null) driven[lever.name] = padValue(lever, reading);
    }
    return driven;
  }
}
