// Inputs as they were driven: recorded from the pictures, kept in files, played again.
import { csv } from "./csv";
import { longestMessage, type Input, type Track } from "./liveProtocol";

export type Tracks = Record<string, Track>;

const format = "mimbre-inputs-1";

/** Records changes, and where a pause between them ends. */
export class Tape {
  private tracks: Track[];
  private begun: number | null = null; // time of the simulation
  private last = { time: 0, values: [] as number[] };

  constructor(private inputs: Input[]) {
    this.tracks = this.empty();
  }

  get running(): boolean {
    return this.begun !== null;
  }

  /** s recorded. */
  get length(): number {
    return Math.max(0, ...this.tracks.map(({ times }) => times[times.length - 1] ?? 0));
  }

  start(): void {
    this.tracks = this.empty();
    this.begun = NaN; // the first picture says when
  }

  stop(): void {
    if (this.begun !== null && Number.isFinite(this.begun)) this.end();
    this.begun = null;
  }

  /** A reset begins anew. */
  add(time: number, inputs: ArrayLike<number>): void {
    if (this.begun === null) return;
    const values = this.inputs.map((_, k) => Number(inputs[k].toPrecision(7)));
    if (Number.isNaN(this.begun) || time < this.last.time) {
      this.tracks = values.map((value) => ({ times: [0], values: [value] }));
      this.begun = time;
    } else if (time > this.last.time) {
      this.tracks.forEach((track, k) => {
        if (values[k] === this.last.values[k]) return;
        this.keep(track, this.last.time, this.last.values[k]);
        this.keep(track, time, values[k]);
      });
    }
    this.last = { time, values };
  }

  recorded(): Tracks {
    return Object.fromEntries(this.inputs.map(({ name }, k) => [name, this.tracks[k]]).filter(([, track]) => (track as Track).times.length > 0));
  }

  private empty(): Track[] {
    return this.inputs.map(() => ({ times: [], values: [] }));
  }

  private keep({ times, values }: Track, time: number, value: number): void {
    const at = Number((time - this.begun!).toFixed(6));
    if (times[times.length - 1] === at) return;
    times.push(at);
    values.push(value);
  }

  private end(): void {
    this.tracks.forEach((track, k) => this.keep(track, this.last.time, this.last.values[k]));
  }
}

export const toJson = (tracks: Tracks) => JSON.stringify({ format, tracks }, null, 1);

/** A column of times and one per input; empty where an input did not change. */
export function toCsv(tracks: Tracks, units: Map<string, string>): string {
  return csv(
    Object.entries(tracks).map(([name, { times, values }], channel) => ({ name, label: name, unit: units.get(name) ?? "", meaning: "", channel, run: 0, color: "", range: 0, time: times, values })),
  );
}

/** "steering [1]" or "\"a, b\"" → the name. */
const nameOf = (head: string) => head.replace(/^"(.*)"$/, "$1").replace(/""/g, '"').replace(/^'/, "").replace(/ \[[^\]]*\]$/, "");

function cells(line: string): string[] {
  return line.match(/("([^"]|"")*"|[^,;]*)([,;]|$)/g)!.slice(0, -1).concat(/[,;]$/.test(line) ? [""] : []).map((cell) => cell.replace(/[,;]$/, ""));
}

function ofCsv(text: string): Tracks {
  const [head, ...lines] = text.split(/\r?\n/).filter((line) => line.trim() !== "");
  const names = cells(head ?? "").slice(1).map(nameOf);
  const tracks: Tracks = Object.fromEntries(names.map((name) => [name, { times: [], values: [] }]));
  for (const line of lines) {
    const [time, ...values] = cells(line);
    names.forEach((name, k) => {
      if ((values[k] ?? "") === "") return;
      tracks[name].times.push(Number(time));
      tracks[name].values.push(Number(values[k]));
    });
  }
  return tracks;
}

/** Throws an Error that says what is wrong. */
export function readTracks(text: string, inputs: Input[]): Tracks {
  let tracks: Tracks;
  if (text.trimStart().startsWith("{")) {
    const read = JSON.parse(text) as { format?: string; tracks?: Tracks };
    if (read.format !== format || typeof read.tracks !== "object" || read.tracks === null) throw new Error(`the file holds no recorded inputs (no "format": "${format}")`);
    tracks = read.tracks;
  } else tracks = ofCsv(text);
  const names = inputs.map(({ name }) => name);
  for (const [name, { times, values }] of Object.entries(tracks)) {
    if (!names.includes(name)) throw new Error(`the model has no input “${name}”; it has ${names.join(", ")}`);
    if (!Array.isArray(times) || !Array.isArray(values) || times.length !== values.length || ![...times, ...values].every(Number.isFinite))
      throw new Error(`“${name}” must have as many times as values, all of them numbers`);
    if (times.some((time, k) => k > 0 && !(time > times[k - 1]))) throw new Error(`the times of “${name}” do not increase`);
  }
  if (!Object.values(tracks).some(({ times }) => times.length > 0)) throw new Error("the file holds no values");
  return Object.fromEntries(Object.entries(tracks).filter(([, { times }]) => times.length > 0));
}

/** Without points that lie on the line between their neighbours up to `tolerance` (Douglas and Peucker). */
export function thinned({ times, values }: Track, tolerance: number): Track {
  const keep = new Set([0, times.length - 1]);
  const parts: [number, number][] = [[0, times.length - 1]];
  for (let part = parts.pop(); part; part = parts.pop()) {
    const [from, to] = part;
    let [worst, off] = [-1, tolerance];
    for (let k = from + 1; k < to; ++k) {
      const on = values[from] + ((times[k] - times[from]) / (times[to] - times[from])) * (values[to] - values[from]);
      const distance = Math.abs(values[k] - on);
      if (distance > off) [worst, off] = [k, distance];
    }
    if (worst < 0) continue;
    keep.add(worst);
    parts.push([from, worst], [worst, to]);
  }
  const kept = [...keep].sort((a, b) => a - b);
  return { times: kept.map((k) => times[k]), values: kept.map((k) => values[k]) };
}

/** As fine as goes into one message; throws where that is coarser than a hundredth of what the inputs do. */
export function fitting(tracks: Tracks, length = longestMessage - 256): { tracks: Tracks; tolerance: number } {
  const range = ({ values }: Track) => values.reduce((most, value) => Math.max(most, value), -Infinity) - values.reduce((least, value) => Math.min(least, value), Infinity);
  for (const tolerance of [0, 1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2]) {
    const made = Object.fromEntries(Object.entries(tracks).map(([name, track]) => [name, thinned(track, tolerance * range(track))]));
    if (JSON.stringify(made).length <= length) return { tracks: made, tolerance };
  }
  throw new Error("the recording is too long to be played in one piece: record a shorter one");
}
