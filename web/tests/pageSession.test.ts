import assert from "node:assert/strict";
import { test } from "node:test";
import type { Order, Said } from "../src/liveProtocol";
import { PageSession } from "../src/pageSession";
import { beginning, type Solver } from "../src/pageSolver";

/** Counts steps of 10 ms; its state is the sum of its input over time. */
class Counting {
  stepSize = 0.01;
  iterations = 1;
  parts = 1;
  steps = 0;
  sum = 0;
  value = 0;
  saved = new Map<number, [number, number, number]>([[beginning, [0, 0, 0]]]);
  get time() {
    return this.stepSize * this.steps;
  }
  step = () => {
    ++this.steps;
    this.sum += this.value;
    return this.steps === 500 ? 1 : 0;
  };
  text = () => "";
  setInput = (_: number, value: number) => void (this.value = value);
  input = () => this.value;
  channel = () => 0;
  choose = () => {};
  picture = () => new ArrayBuffer(0);
  save = (place: number) => void this.saved.set(place, [this.steps, this.sum, this.value]);
  restore = (place: number) => void ([this.steps, this.sum, this.value] = this.saved.get(place)!);
  timed = () => {};
  timings = () => ({ spread: [0, 0, 0, 0] as [number, number, number, number], edges: [], counts: [] });
}

function started() {
  const solver = new Counting();
  const said: Said[] = [];
  let now = 0;
  const session = new PageSession(
    solver as unknown as Solver,
    { inputs: [{ name: "push", min: -1, max: 1 }], channels: 1, shown: [0], speed: 1 },
    () => now,
    (message) => void (message instanceof ArrayBuffer || said.push(message)),
  );
  /** A turn every millisecond. */
  const wait = (seconds: number) => {
    for (const end = now + seconds; now < end - 1e-9; ) {
      now += 0.001;
      session.turn();
    }
  };
  return { solver, said, session, wait, order: (order: Order) => session.hear(order) };
}

test("steps begin at their instants of the clock", () => {
  const { solver, wait, session } = started();
  wait(1);
  assert.ok(Math.abs(solver.steps - 101) <= 1, `${solver.steps}`);
  assert.equal(session.status().state, "running");
});

test("paused, it steps when it is asked to", () => {
  const { solver, wait, order } = started();
  wait(0.1);
  order({ do: "pause" });
  const { steps } = solver;
  wait(0.5);
  assert.equal(solver.steps, steps);
  order({ do: "step" });
  assert.equal(solver.steps, steps + 1);
  order({ do: "resume" });
  wait(0.1);
  assert.ok(Math.abs(solver.steps - steps - 12) <= 1, `${solver.steps - steps}`);
});

test("recorded inputs played from the start give the same state", () => {
  const { solver, wait, order, session } = started();
  wait(0.2);
  order({ do: "inputs", values: { push: 0.5 } });
  wait(0.3);
  order({ do: "inputs", values: { push: -0.25 } });
  wait(0.2);
  order({ do: "pause" });
  const { steps, sum } = solver;
  const { tracks } = JSON.parse(session.driven());
  assert.deepEqual(tracks.push.values, [0, 0.5, -0.25]);
  order({ do: "reset" });
  assert.equal(solver.steps, 0);
  order({ do: "play", tracks });
  for (let k = 0; k < steps; ++k) order({ do: "step" });
  assert.equal(solver.sum, sum);
});

test("what an event sets lasts until the next point that is played", () => {
  const { solver, order, said } = started();
  order({ do: "pause" });
  order({ do: "play", tracks: { push: { times: [0.1, 0.2, 0.4], values: [0.5, 1, -1] } } });
  const values: number[] = [];
  for (let k = 0; k < 50; ++k) {
    order({ do: "step" });
    if (k === 30 || k === 45) solver.value = 0; // after the step to 0.31 s
    values.push(solver.value);
  }
  assert.deepEqual([5, 15, 25, 35, 42, 49].map((k) => values[k]), [0, 0.5, 1, 0, -1, 0]);
  assert.deepEqual(said.flatMap((one) => (one.say === "played" ? [one.on] : [])), [true, false]);
});

test("snapshots by name; the oldest goes where there is no place", () => {
  const { solver, wait, order, said } = started();
  order({ do: "pause" });
  for (let k = 0; k < 18; ++k) {
    order({ do: "snapshot", name: `s${k}` });
    order({ do: "step" });
  }
  wait(0.01);
  const names = said.flatMap((one) => (one.say === "snapshots" ? [one.names] : [])).at(-1)!;
  assert.deepEqual([names.length, names[0], names[15]], [16, "s2", "s17"]);
  order({ do: "restore", name: "s5" });
  assert.equal(solver.steps, 5);
  order({ do: "restore", name: "s0" });
  assert.match(JSON.stringify(said.at(-1)), /there is no snapshot 's0'/);
});

test("an input without a name that is known, and one beyond its range", () => {
  const { said, order, wait, session } = started();
  order({ do: "inputs", values: { pull: 1 } });
  assert.match(JSON.stringify(said.at(-1)), /there is no input 'pull'/);
  order({ do: "inputs", values: { push: 7 } });
  wait(0.05);
  assert.deepEqual(JSON.parse(session.driven()).tracks.push.values, [0, 1]);
});

test("an event of the model ends it", () => {
  const { wait, session, solver } = started();
  wait(6);
  assert.equal(solver.steps, 500);
  assert.equal(session.status().state, "ended");
});
