// Order in the list of channels.
import type { ChannelName } from "./data";

export type Grouping = "name" | "unit";

/** Of a channel "front_left.arm.z": "front_left". Names without a dot are among "general". */
export function groupOf(channel: { name: string; unit: string }, grouping: Grouping): string {
  if (grouping === "unit") return unitLabel(channel.unit);
  const dot = channel.name.indexOf(".");
  return dot > 0 ? channel.name.slice(0, dot) : "general";
}

export function unitLabel(unit: string): string {
  return unit === "" || unit === "1" ? "no unit" : unit;
}

/** Groups in the order of their first channel, channels as they come; only those whose name, unit or meaning has all words. */
export function grouped(channels: ChannelName[], grouping: Grouping, search: string): Map<string, number[]> {
  const words = search.toLowerCase().split(/\s+/).filter((word) => word !== "");
  const groups = new Map<string, number[]>();
  channels.forEach((channel, index) => {
    const text = `${channel.name} ${channel.unit} ${channel.meaning}`.toLowerCase();
    if (!words.every((word) => text.includes(word))) return;
    const group = groupOf(channel, grouping);
    groups.set(group, [...(groups.get(group) ?? []), index]);
  });
  return groups;
}

/** Channels that every run has, after the model's own outputs. */
const standard = /^(joint|spring|tyre|load|energy|solver)\./;

/** What is plotted at first: the first outputs, few enough per unit and of few enough units to be read at a glance. */
export function firstSelection(channels: { name: string; unit: string }[], perUnit = 4, units = 3): number[] {
  const all = [...channels.keys()];
  const outputs = all.filter((index) => !standard.test(channels[index].name));
  const counts = new Map<string, number>();
  return (outputs.length > 0 ? outputs : all).filter((index) => {
    const { unit } = channels[index];
    const count = counts.get(unit) ?? 0;
    if (count >= perUnit || (count === 0 && counts.size >= units)) return false;
    counts.set(unit, count + 1);
    return true;
  });
}
