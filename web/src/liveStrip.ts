// The last seconds of the chosen channels.
import type { Picture } from "./liveProtocol";

export class StripRecord {
  time: number[] = [];
  private values = new Map<number, (number | null)[]>();
  private indices: number[] = []; // of the channels in pictures
  private choice = -1;

  /** `length`: s that are kept at least. */
  constructor(public length: number) {}

  /** The choice of channels that pictures have from its number on. */
  choose(indices: number[], choice: number): void {
    this.indices = indices;
    this.choice = choice;
    for (const channel of this.values.keys()) if (!indices.includes(channel)) this.values.delete(channel);
    for (const channel of indices) if (!this.values.has(channel)) this.values.set(channel, this.time.map(() => null));
  }

  /** Place of a channel in a picture; −1: it is not in it. */
  place(channel: number, picture: Picture): number {
    return picture.choice === this.choice ? this.indices.indexOf(channel) : -1;
  }

  add(picture: Picture): void {
    const last = this.time[this.time.length - 1];
    if (picture.time === last) return; // it is paused
    if (picture.time < last) this.clear();
    this.time.push(picture.time);
    const known = picture.choice === this.choice;
    for (const [channel, values] of this.values) {
      const value = known ? picture.channels[this.indices.indexOf(channel)] : NaN;
      values.push(Number.isFinite(value) ? value : null);
    }
    // Moved only now and then: not with every picture.
    if (this.time[0] >= picture.time - 1.5 * this.length) return;
    const from = this.time.findIndex((time) => time >= picture.time - this.length);
    this.time.splice(0, from);
    for (const values of this.values.values()) values.splice(0, from);
  }

  of(channel: number): (number | null)[] {
    return this.values.get(channel) ?? [];
  }

  private clear(): void {
    this.time = [];
    for (const channel of this.values.keys()) this.values.set(channel, []);
  }
}
