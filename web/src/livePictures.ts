// A buffer of pictures, which arrive irregularly. The screen shows the mechanism with a small delay, so that there is
// always a picture before and one after to interpolate between.
import type { Animation } from "./data";
import type { Picture } from "./liveProtocol";

const window = 5; // s; the quickest picture in it measures the difference of the clocks
const kept = 1; // s of pictures
const behind = 2; // pictures that the screen is late
const [leastDelay, mostDelay] = [0.02, 0.5]; // s

export interface Between {
  earlier: Picture;
  later: Picture;
  /** Of the simulation, s. */
  time: number;
}

export class PictureBuffer {
  private pictures: Picture[] = []; // in the order of the server's clock
  private leads: { arrived: number; lead: number }[] = []; // this machine's clock less the server's
  private interval = 1 / 60;

  get newest(): Picture | undefined {
    return this.pictures[this.pictures.length - 1];
  }

  /** s between two pictures, usually. */
  get usual(): number {
    return this.interval;
  }

  /** `arrived`: by this machine's clock, s. */
  add(picture: Picture, arrived: number): void {
    const last = this.newest;
    if (last && picture.clock <= last.clock) this.clear(); // another run of the server
    else if (last) this.interval += 0.1 * (Math.min(picture.clock - last.clock, mostDelay) - this.interval);
    this.pictures.push(picture);
    const oldest = picture.clock - kept;
    while (this.pictures.length > 2 && this.pictures[0].clock < oldest) this.pictures.shift();
    this.leads.push({ arrived, lead: arrived - picture.clock });
    while (this.leads[0].arrived < arrived - window) this.leads.shift();
  }

  clear(): void {
    this.pictures = [];
    this.leads = [];
  }

  /** What the screen shows now; null before the first picture. */
  at(now: number): Between | null {
    const { pictures } = this;
    if (pictures.length === 0) return null;
    const delay = Math.min(Math.max(behind * this.interval, leastDelay), mostDelay);
    const clock = now - Math.min(...this.leads.map(({ lead }) => lead)) - delay;
    let k = pictures.length - 1;
    while (k > 0 && pictures[k].clock > clock) --k;
    const earlier = pictures[k];
    const later = pictures[k + 1];
    // Nothing is between the pictures before and after a reset.
    if (!later || clock <= earlier.clock || later.steps < earlier.steps) return { earlier, later: earlier, time: earlier.time };
    const fraction = (clock - earlier.clock) / (later.clock - earlier.clock);
    return { earlier, later, time: earlier.time + fraction * (later.time - earlier.time) };
  }
}

/** With two instants, to be filled with pictures. */
export function liveAnimation({ bodies, amplitudes, time, positions, rotations, modes }: Animation): Animation {
  const twice = <T extends Float32Array | Float64Array>(values: T, made: T): T => {
    made.set(values);
    made.set(values, values.length);
    return made;
  };
  return {
    time: twice(time, new Float64Array(2)),
    positions: twice(positions, new Float64Array(6 * bodies)),
    rotations: twice(rotations, new Float32Array(8 * bodies)),
    modes: twice(modes, new Float32Array(2 * amplitudes)),
    bodies,
    amplitudes,
  };
}

/** Copies two pictures into the animation; the view interpolates between them. */
export function fill(animation: Animation, { earlier, later }: Between): void {
  const { time, positions, rotations, modes } = animation;
  time[0] = earlier.time;
  time[1] = later.time;
  positions.set(earlier.positions);
  positions.set(later.positions, earlier.positions.length);
  rotations.set(earlier.rotations);
  rotations.set(later.rotations, earlier.rotations.length);
  modes.set(earlier.amplitudes);
  modes.set(later.amplitudes, earlier.amplitudes.length);
}
