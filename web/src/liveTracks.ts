// Recorded inputs, in files and for playback. An input keeps each value until the next.
import { field } from "./csv";
import type { Input, Track } from "./liveProtocol";

export type Tracks = Record<string, Track>;

const format = "mimbre-inputs-1";

/** A row for each time that one of them is set, with the values of all from then on. */
export function toCsv(tracks: Tracks, units: Map<string, string>): string {
  const names = Object.keys(tracks);
  const times = [...new Set(names.flatMap((name) => tracks[name].times))].sort((a, b) => a - b);
  const heads = names.map((name) => {
    const unit = units.get(name) ?? "";
    return field(unit === "" || unit === "1" ? name : `${name} [${unit}]`);
  });
  const at = names.map(() => -1); // the last point of each that is not after the row
  const rows = times.map((time) => {
    const cells = names.map((name, k) => {
      const track = tracks[name];
      while (track.times[at[k] + 1] <= time) ++at[k];
      return at[k] < 0 ? "" : String(track.values[at[k]]);
    });
    return [String(time), ...cells].join(",");
  });
  return [["t [s]", ...heads].join(","), ...rows].join("\r\n") + "\r\n";
}

/** "steering [1]" or "\"a, b\"" → the name. */
const nameOf = (head: string) => head.trim().replace(/^"(.*)"$/, "$1").replace(/""/g, '"').replace(/^'/, "").replace(/ \[[^\]]*\]$/, "");

function cells(line: string): string[] {
  const found: string[] = [];
  for (const [, cell] of `${line},`.matchAll(/("(?:[^"]|"")*"|[^,;\t]*)[,;\t]/g)) found.push(cell);
  return found;
}

function ofCsv(text: string): Tracks {
  const [head, ...lines] = text.replace(/^\uFEFF/, "").split(/\r?\n/).filter((line) => line.trim() !== "");
  const names = cells(head ?? "").slice(1).map(nameOf);
  const tracks: Tracks = Object.fromEntries(names.map((name) => [name, { times: [], values: [] }]));
  for (const line of lines) {
    const [time, ...values] = cells(line);
    names.forEach((name, k) => {
      if ((values[k] ?? "").trim() === "") return;
      tracks[name].times.push(Number(time));
      tracks[name].values.push(Number(values[k]));
    });
  }
  return tracks;
}

/** Keeps the last of several values at one time, and drops points that change nothing. */
function tidy({ times, values }: Track): Track {
  const last = times.flatMap((time, k) => (time === times[k + 1] ? [] : [k]));
  const kept = last.filter((k, i) => i === 0 || i === last.length - 1 || values[k] !== values[last[i - 1]]);
  return { times: kept.map((k) => times[k]), values: kept.map((k) => values[k]) };
}

/** Of a file, JSON or CSV. Throws an Error that describes its mistake. */
export function readTracks(text: string, inputs: Pick<Input, "name">[]): Tracks {
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
    if (times.some((time, k) => k > 0 && time < times[k - 1])) throw new Error(`the times of “${name}” do not ascend`);
  }
  const filled = Object.entries(tracks).filter(([, { times }]) => times.length > 0);
  if (filled.length === 0) throw new Error("the file holds no values");
  return Object.fromEntries(filled.map(([name, track]) => [name, tidy(track)]));
}

/** With times from the first one on. */
export function fromNow(tracks: Tracks): Tracks {
  const begin = Object.values(tracks).reduce((least, { times }) => Math.min(least, times[0] ?? Infinity), Infinity);
  return Object.fromEntries(Object.entries(tracks).map(([name, { times, values }]) => [name, { times: times.map((time) => time - begin), values }]));
}

export const duration = (tracks: Tracks) => Object.values(tracks).reduce((most, { times }) => Math.max(most, times[times.length - 1] ?? 0), 0);
