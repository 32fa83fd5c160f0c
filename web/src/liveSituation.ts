// How things stand between this viewer and the simulation, in words.
import type { Picture } from "./liveProtocol";

export interface Situation {
  connection: "first" | "open" | "lost" | "ended";
  /** This viewer has control; somebody has; this viewer has asked for it. */
  control: boolean;
  taken: boolean;
  asked: boolean;
  /** The viewer that asks this one for control; 0: none does. */
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

/** This viewer's orders would be heard. */
export const mayDrive = ({ connection, control }: Situation) => connection === "open" && control;

export function seenIn({ control, paused, recording, failed, ended, played }: Picture): Partial<Situation> {
  return { control, paused, recording, failed, ended, played, ...(control ? { taken: true, asked: false } : { asker: 0 }) };
}

/** In a word or two, and how alarming it is. */
export function stateWord({ connection, failed, ended, paused }: Situation): [word: string, kind: "good" | "rest" | "bad"] {
  if (connection === "first") return ["Connecting", "rest"];
  if (connection === "ended") return ["Server ended", "bad"];
  if (connection === "lost") return ["Connection lost", "bad"];
  if (failed) return ["Failed", "bad"];
  if (ended) return ["Ended", "rest"];
  return paused ? ["Paused", "rest"] : ["Running", "good"];
}

/** Who drives, and what can be done about it. */
export function controlWords({ connection, control, taken, asked }: Situation): string {
  if (connection !== "open") return "Without the server nothing can be driven.";
  if (control) return "You are in control.";
  if (asked) return "You have asked for control, and get it as soon as the other viewer gives it back.";
  return taken ? "Another viewer is in control: you see everything, and can ask for it." : "Nobody is in control: take it to drive.";
}

/** What a listener has to hear of a change; "": nothing. */
export function announcement(before: Situation, now: Situation): string {
  const said: string[] = [];
  const [word, kind] = stateWord(now);
  if (word !== stateWord(before)[0]) said.push(kind === "bad" && now.failed && now.message ? `${word}: ${now.message}` : word);
  if (now.connection === "open" && now.control !== before.control) said.push(now.control ? "You are in control" : "You are no longer in control");
  else if (now.asked && !before.asked) said.push("Asked for control");
  else if (now.asker !== 0 && now.asker !== before.asker) said.push(`Viewer ${now.asker} asks for control`);
  if (now.recording !== before.recording) said.push(now.recording ? "Recording" : "Recording has ended");
  if (now.played !== before.played) said.push(now.played ? "Inputs are played back" : "Playback has ended");
  return said.join(". ");
}
