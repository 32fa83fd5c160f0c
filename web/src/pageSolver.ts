// The solver as WebAssembly (cmake/wasm/exports.cpp): its functions, and the few that it asks the page for.

interface Exports {
  memory: WebAssembly.Memory;
  _initialize?: () => void;
  mimbre_allocate(size: number): number;
  mimbre_free(at: number): void;
  mimbre_text(): number;
  mimbre_open(at: number, size: number): number;
  mimbre_step(): number;
  mimbre_iterations(): number;
  mimbre_parts(): number;
  mimbre_time(): number;
  mimbre_step_size(): number;
  mimbre_set_input(input: number, value: number): void;
  mimbre_input(input: number): number;
  mimbre_channel(channel: number): number;
  mimbre_choose(at: number, count: number): void;
  mimbre_picture(marks: number, choice: number, clock: number, steps: number, load: number): number;
  mimbre_picture_size(): number;
  mimbre_save(place: number): void;
  mimbre_restore(place: number): void;
  mimbre_timed(computation: number, latency: number): void;
  mimbre_timings(which: number): number;
}

/** The place of Solver.restore that holds the beginning. */
export const beginning = 16;
export const snapshotPlaces = 16;

export class Solver {
  private constructor(private exports: Exports) {}

  /** Starts the model that the program wrote. Throws with the reason where it cannot. */
  static open(wasm: BufferSource, model: Uint8Array): Solver {
    const code = new WebAssembly.Module(wasm);
    let memory: WebAssembly.Memory;
    const view = () => new DataView(memory.buffer);
    const clock = (_which: number, _precision: bigint, at: number) => {
      view().setBigUint64(at, BigInt(Math.round(1e6 * performance.now())), true);
      return 0;
    };
    const known: Record<string, (...words: never[]) => unknown> = {
      clock_time_get: clock,
      proc_exit: (code: number) => {
        throw new Error(`the solver has ended with code ${code}`);
      },
    };
    // What it never needs here (files, the environment) does nothing.
    const imports: Record<string, Record<string, WebAssembly.ImportValue>> = {};
    for (const { module, name } of WebAssembly.Module.imports(code)) (imports[module] ??= {})[name] = (known[name] ?? (() => 0)) as WebAssembly.ImportValue;
    const exports = new WebAssembly.Instance(code, imports).exports as unknown as Exports;
    memory = exports.memory;
    exports._initialize?.();
    const solver = new Solver(exports);
    const at = exports.mimbre_allocate(model.byteLength);
    new Uint8Array(memory.buffer).set(model, at);
    const failed = exports.mimbre_open(at, model.byteLength) < 0;
    exports.mimbre_free(at);
    if (failed) throw new Error(solver.text());
    return solver;
  }

  /** Why the last call failed. */
  text(): string {
    const bytes = new Uint8Array(this.exports.memory.buffer, this.exports.mimbre_text());
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  /** 0; 1: an event of the model stopped the run; negative: it failed, text() has the reason. */
  step = (): number => this.exports.mimbre_step();
  get iterations(): number {
    return this.exports.mimbre_iterations();
  }
  get parts(): number {
    return this.exports.mimbre_parts();
  }
  get time(): number {
    return this.exports.mimbre_time();
  }
  get stepSize(): number {
    return this.exports.mimbre_step_size();
  }
  setInput(input: number, value: number): void {
    this.exports.mimbre_set_input(input, value);
  }
  input(input: number): number {
    return this.exports.mimbre_input(input);
  }
  channel(channel: number): number {
    return this.exports.mimbre_channel(channel);
  }

  choose(channels: number[]): void {
    const at = this.exports.mimbre_allocate(4 * channels.length + 4);
    new Int32Array(this.exports.memory.buffer, at, channels.length).set(channels);
    this.exports.mimbre_choose(at, channels.length);
    this.exports.mimbre_free(at);
  }

  picture(marks: number, choice: number, clock: number, steps: number, load: number): ArrayBuffer {
    const at = this.exports.mimbre_picture(marks, choice, clock, steps, load);
    return this.exports.memory.buffer.slice(at, at + this.exports.mimbre_picture_size()) as ArrayBuffer;
  }

  save(place: number): void {
    this.exports.mimbre_save(place);
  }
  restore(place: number): void {
    this.exports.mimbre_restore(place);
  }

  timed(computation: number, latency: number): void {
    this.exports.mimbre_timed(computation, latency);
  }
  /** Median, 99 %, 99.99 %, worst; edges of bins and their counts. */
  timings(which: "computation" | "latency"): { spread: [number, number, number, number]; edges: number[]; counts: number[] } {
    const all = [...new Float64Array(this.exports.memory.buffer, this.exports.mimbre_timings(which === "computation" ? 0 : 1), 125)];
    return { spread: all.slice(0, 4) as [number, number, number, number], edges: all.slice(4, 65), counts: all.slice(65) };
  }
}
