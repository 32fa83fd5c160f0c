// Steps the solver against the clock, and answers orders as the live server does (docs/live-protocol.md).
import type { Order, RunState, Said, Spread, Status, Track } from "./liveProtocol";
import { beginning, snapshotPlaces, type Solver } from "./pageSolver";

export interface SessionFacts {
  inputs: { name: string; min?: number; max?: number }[];
  channels: number; // how many
  shown: number[];
  speed: number;
}

const pictureEvery = 1 / 60; // s
const statusEvery = 0.5; // s
const longestTurn = 0.03; // s, of stepping before orders are heard again
const mostBehind = 0.1; // s, after which the clock is set back
const longestHistory = 1_000_000;

const spread = ([median, p99, p9999, worst]: [number, number, number, number]): Spread => ({ median, p99, p9999, worst });

export class PageSession {
  private state: RunState = "running";
  private message = "";
  private begin: number; // s of the clock, when step 0 of the present stretch was due
  private since = 0; // steps since then
  private steps = 0;
  private lag = 0; // s
  private late = 0;
  private overruns = 0;
  private load = 0;
  private iterations = 0;
  private mostIterations = 0;
  private mostParts = 1;
  private wanted = new Map<number, number>();
  private tracks: { input: number; track: Track; next: number }[] = [];
  private playing = false;
  private playedSince = 0; // s, of the simulation
  private histories: Track[] = [];
  private choice = 0;
  private snapshots: { name: string; place: number }[] = [];
  private shownAt = -Infinity;
  private statusAt = -Infinity;
  private dirty = true; // there is something new to show

  constructor(
    private solver: Solver,
    private facts: SessionFacts,
    private now: () => number, // s
    private send: (message: ArrayBuffer | Said) => void,
  ) {
    this.begin = now();
    this.noteAll();
    solver.choose(facts.shown);
    send({ say: "hello", viewer: 1, control: true, channels: facts.shown });
    send({ say: "snapshots", names: [] });
  }

  private get period(): number {
    return this.solver.stepSize / this.facts.speed;
  }

  /** Makes the steps that are due, and shows what is new; to be called every few milliseconds. */
  turn(): void {
    const start = this.now();
    while (this.state === "running") {
      const due = this.begin + this.since * this.period;
      const before = this.now();
      if (due > before || before - start > longestTurn) break;
      this.step(due, before);
    }
    this.show();
  }

  private step(due: number, before: number): void {
    this.takeInputs();
    const result = this.solver.step();
    const after = this.now();
    const computation = after - before;
    this.solver.timed(computation, before - due);
    ++this.since;
    ++this.steps;
    this.load = computation / this.period;
    if (computation > this.period) ++this.overruns;
    this.iterations += this.solver.iterations;
    this.mostIterations = Math.max(this.mostIterations, this.solver.iterations);
    this.mostParts = Math.max(this.mostParts, this.solver.parts);
    this.dirty = true;
    if (result < 0) this.finish("failed", this.solver.text());
    else if (result === 1) this.finish("ended", "an event of the model ended it");
    const behind = after - (this.begin + this.since * this.period);
    if (behind > 0) ++this.late;
    if (behind > mostBehind) {
      this.begin += behind;
      this.lag += behind;
    }
  }

  private finish(state: RunState, message: string): void {
    this.state = state;
    this.message = message;
    this.statusAt = -Infinity;
  }

  // Inputs.

  private put(input: number, value: number): void {
    const { min = -Infinity, max = Infinity } = this.facts.inputs[input];
    if (this.solver.input(input) === value) return;
    this.solver.setInput(input, value);
    this.note(input, Math.min(Math.max(value, min), max));
  }

  private note(input: number, value: number): void {
    const { times, values } = this.histories[input];
    if (times.length >= longestHistory) return;
    times.push(this.solver.time);
    values.push(value);
  }

  /** The simulation was put elsewhere, or begins. */
  private noteAll(): void {
    this.histories = this.facts.inputs.map(() => ({ times: [], values: [] }));
    this.facts.inputs.forEach((_, k) => this.note(k, this.solver.input(k)));
    this.playedSince = this.solver.time;
    for (const one of this.tracks) one.next = 0;
    this.wanted.clear();
  }

  private takeInputs(): void {
    for (const [input, value] of this.wanted) this.put(input, value);
    this.wanted.clear();
    if (!this.playing) return;
    // Times are sums of steps: what is due within a millionth of one is due.
    const now = this.solver.time - this.playedSince + 1e-6 * this.solver.stepSize;
    let over = true;
    for (const one of this.tracks) {
      const { times, values } = one.track;
      const due = one.next;
      while (times[one.next] <= now) ++one.next;
      // Until the next point others, as events, may set it.
      if (one.next > due) this.put(one.input, values[one.next - 1]);
      over = over && one.next === times.length;
    }
    if (over) this.play([]);
  }

  private play(tracks: typeof this.tracks): void {
    this.tracks = tracks;
    this.playedSince = this.solver.time;
    this.playing = tracks.length > 0;
    this.send({ say: "played", on: this.playing });
    this.dirty = true;
  }

  /** All inputs since the simulation was put where it began, as `/inputs` of the server. */
  driven(): string {
    return JSON.stringify({ format: "mimbre-inputs-1", tracks: Object.fromEntries(this.facts.inputs.map(({ name }, k) => [name, this.histories[k]])) });
  }

  // Orders.

  hear(order: Order): void {
    try {
      this.act(order);
    } catch (error) {
      this.send({ say: "error", message: error instanceof Error ? error.message : String(error) });
    }
    this.dirty = true;
  }

  private inputNamed(name: string): number {
    const input = this.facts.inputs.findIndex((one) => one.name === name);
    if (input < 0) throw new Error(`there is no input '${name}'`);
    return input;
  }

  private act(order: Order): void {
    switch (order.do) {
      case "channels": {
        const indices = order.indices.filter((k) => Number.isInteger(k) && k >= 0 && k < this.facts.channels);
        this.solver.choose(indices);
        this.send({ say: "channels", indices, choice: ++this.choice });
        break;
      }
      case "control":
        this.send({ say: "control", yours: true, taken: true });
        break;
      case "inputs":
        for (const [name, value] of Object.entries(order.values)) if (Number.isFinite(value)) this.wanted.set(this.inputNamed(name), value);
        break;
      case "pause":
        if (this.state === "running") this.state = "paused";
        break;
      case "resume":
        if (this.state === "paused") this.goOn();
        break;
      case "step":
        if (this.state === "paused") {
          const now = this.now();
          [this.begin, this.since] = [now, 0];
          this.step(now, now);
        }
        break;
      case "reset":
        this.putTo(beginning);
        break;
      case "snapshot":
        this.solver.save(this.keep(order.name));
        this.tellSnapshots();
        break;
      case "restore": {
        const found = this.snapshots.find(({ name }) => name === order.name);
        if (!found) throw new Error(`there is no snapshot '${order.name}'`);
        this.putTo(found.place);
        break;
      }
      case "play": {
        const tracks = Object.entries(order.tracks ?? {}).map(([name, track]) => ({ input: this.inputNamed(name), track, next: 0 }));
        this.play(tracks.filter(({ track }) => track.times.length > 0));
        break;
      }
      case "record":
        throw new Error("there is no server that records; save the inputs, and run them with mimbre run --input");
    }
  }

  private goOn(): void {
    [this.begin, this.since] = [this.now(), 0];
    this.state = "running";
  }

  private putTo(place: number): void {
    this.solver.restore(place);
    this.message = "";
    if (this.state !== "paused") this.goOn();
    this.noteAll();
  }

  /** A place for a snapshot of that name; the oldest goes where there is none. */
  private keep(name: string): number {
    const free = [...Array(snapshotPlaces).keys()].filter((k) => this.snapshots.every(({ place }) => place !== k));
    let old = this.snapshots.findIndex((one) => one.name === name);
    if (old < 0 && free.length === 0) old = 0;
    const place = old < 0 ? free[0] : this.snapshots.splice(old, 1)[0].place;
    this.snapshots.push({ name, place });
    return place;
  }

  private tellSnapshots(): void {
    this.send({ say: "snapshots", names: this.snapshots.map(({ name }) => name) });
  }

  // Pictures.

  private show(): void {
    const now = this.now();
    if (this.dirty && now - this.shownAt >= pictureEvery) {
      const marks = Number(this.state === "paused") | (Number(this.state === "failed") << 2) | (Number(this.state === "ended") << 3) | (Number(this.playing) << 4);
      this.send(this.solver.picture(marks, this.choice, now, this.steps, this.load));
      this.shownAt = now;
      this.dirty = false;
    }
    if (now - this.statusAt >= statusEvery) {
      this.send({ say: "status", ...this.status() });
      this.statusAt = now;
    }
  }

  status(): Status {
    const computation = this.solver.timings("computation");
    const latency = this.solver.timings("latency");
    return {
      time: this.solver.time,
      steps: this.steps,
      state: this.state,
      message: this.message,
      step: this.solver.stepSize,
      speed: this.facts.speed,
      viewers: 1,
      recording: false,
      clock: { scheduling: "a worker of this page", memory: "of the browser", cpu: "any" },
      computation: spread(computation.spread),
      cpu: spread(computation.spread),
      latency: spread(latency.spread),
      overruns: { count: this.overruns, latency: 0, preemption: 0, page_faults: 0, parts: 0, iterations: 0, computation: this.overruns, late_steps: this.late, skipped_outputs: 0, lag: this.lag },
      histogram: { edges: computation.edges, computation: computation.counts, latency: latency.counts },
      iterations: { mean: this.steps > 0 ? this.iterations / this.steps : 0, most: this.mostIterations },
      worst_case: "",
    };
  }
}
