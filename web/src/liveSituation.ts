// The state of the connection, of control and of the simulation, and its texts.
import type { Picture } from "./liveProtocol";

export interface Situation {
  connection: "first" | "open" | "lost" | "ended";
  /** This viewer has control; some viewer has; this viewer has requested it. */
  control: boolean;
  taken: boolean;
  asked: boolean;
  /** The viewer that requests control from this one; 0: none. */
  asker: number;
  paused: boolean;
  recording: boolean;
  failed: boolean;
  ended: boolean;
  played: boolean;
  /** Why it failed, or why it does not record. */
  message: string;
}

export const atFirst: Situation = { connection: "first", control: false, taken: false, asked: false, asker: 0, paused: false, recording: false, failed: false, ended: false, played: false, message: "" };

/** The server accepts this viewer's orders. */
export const mayDrive = ({ connection, control }: Situation) => connection === "open" && control;

export function seenIn({ control, paused, recording, failed, ended, played }: Picture): Partial<Situation> {
  return { control, paused, recording, failed, ended, played, ...(control ? { taken: true, asked: false } : { asker: 0 }) };
}

/** The state in a word or two, and its severity. */
export function stateWord({ connection, failed, ended, paused }: Situation): [word: string, kind: "good" | "rest" | "bad"] {
  if (connection === "first") return ["Connecting", "rest"];
  if (connection === "ended") return ["Server ended", "bad"];
  if (connection === "lost") return ["Connection lost", "bad"];
  if (failed) return ["Failed", "bad"];
  if (ended) return ["Ended", "rest"];
  return paused ? ["Paused", "rest"] : ["Running", "good"];
}

/** Who is in control, and what this viewer can do. */
export function controlWords({ connection, control, taken, asked }: Situation): string {
  if (connection !== "open") return "Not connected: the simulation cannot be driven.";
  if (control) return "You are in control.";
  if (asked) return "You have requested control. You get it when the other viewer releases it.";
  return taken ? "Another viewer is in control. You can watch, or request control." : "Nobody is in control. Take control to drive.";
}

/** The announcement of a change to a screen reader; "": none. */
export function announcement(before: Situation, now: Situation): string {
  const parts: string[] = [];
  const [word, kind] = stateWord(now);
  if (word !== stateWord(before)[0]) parts.push(kind === "bad" && now.failed && now.message ? `${word}: ${now.message}` : word);
  if (now.connection === "open" && now.control !== before.control) parts.push(now.control ? "You are in control" : "You are no longer in control");
  else if (now.asked && !before.asked) parts.push("Control requested");
  else if (now.asker !== 0 && now.asker !== before.asker) parts.push(`Viewer ${now.asker} requests control`);
  if (now.recording !== before.recording) parts.push(now.recording ? "Recording" : "Recording has ended");
  if (now.played !== before.played) parts.push(now.played ? "Playing back inputs" : "Playback has ended");
  return parts.join(". ");
}
