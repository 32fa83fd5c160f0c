// A server that speaks docs/live-protocol.md without simulating: it plays the animation of a report round and round,
// and carries the vehicle where a steered point would go.
//   node mockLive.mjs REPORT.html [PORT]
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { fileURLToPath, pathToFileURL } from "node:url";
import { accept } from "./webSocket.mjs";

const protocol = "mimbre-live-1";
const step = 0.002;
const wheelbase = 2;

const unpack = ({ type, data }) => {
  const bytes = Buffer.from(data, "base64");
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  return new { f32: Float32Array, f64: Float64Array, u32: Uint32Array }[type](buffer);
};
const pack = (type, values) => ({ type, size: values.length, data: Buffer.from(values.buffer, values.byteOffset, values.byteLength).toString("base64") });

const inputs = () => [
  { name: "steering", unit: "1", min: -1, max: 1, start: 0, value: 0, tunable: false, about: "1 is full lock to the left" },
  { name: "throttle", unit: "1", min: 0, max: 1, start: 0, value: 0, tunable: false },
  { name: "brake", unit: "1", min: 0, max: 1, start: 0, value: 0, tunable: false },
  { name: "crosswind", unit: "m/s", start: 0, value: 0, tunable: false, about: "from the left" },
  { name: "damping", unit: "N s/m", min: 500, max: 5000, start: 1500, value: 1500, tunable: true, about: "of the shock absorbers" },
];

export async function mockLive(report, port = 0) {
  const html = await readFile(report, "utf8");
  const packed = JSON.parse(/<script type="application\/json" id="mimbre-data">(.*?)<\/script>/s.exec(html)[1]);
  const live = await readFile(fileURLToPath(new URL("../../dist/live.html", import.meta.url)));
  const animation = Object.fromEntries(Object.entries(packed.animation).map(([name, array]) => [name, unpack(array)]));
  const bodies = packed.bodies.length;
  const amplitudes = packed.bodies.reduce((sum, { modes }) => sum + modes, 0);
  const instants = animation.time.length;
  const resultTime = unpack(packed.time);
  const resultValues = unpack(packed.values);
  const chassis = Math.max(packed.bodies.findIndex(({ name }) => name === "chassis"), 0);
  const first = (array, width) => array.slice(0, width);

  const state = { time: 0, steps: 0, paused: false, failed: false, ended: false, recording: false, x: 0, y: 0, yaw: 0, speed: 5, inputs: inputs(), message: "", playing: null };
  const snapshots = new Map();
  const viewers = new Map();
  let next = 1;
  let holder = 0;
  const heard = [];

  const scene = () => ({
    format: protocol,
    title: packed.title,
    step,
    speed: 1,
    model: packed.model,
    bodies: packed.bodies,
    roads: packed.roads,
    frames: packed.frames,
    elements: packed.elements,
    animation: {
      time: pack("f64", first(animation.time, 1)),
      positions: pack("f64", first(animation.positions, 3 * bodies)),
      rotations: pack("f32", first(animation.rotations, 4 * bodies)),
      modes: pack("f32", first(animation.modes, amplitudes)),
    },
    channels: packed.channels.map(({ name, unit, meaning }) => ({ name, unit, meaning })),
    outputs: Math.min(16, packed.channels.length),
    shown: packed.shown.slice(0, 8),
    inputs: state.inputs,
    policy: "catch_up",
    recording: state.recording,
    record: "drive.h5",
  });

  const begin = () => Object.fromEntries(state.inputs.map(({ name, value }) => [name, { times: [state.time], values: [value] }]));
  let driven = begin();
  const set = (name, one) => {
    const input = state.inputs.find((other) => other.name === name);
    if (input.value === one) return;
    input.value = one;
    driven[name].times.push(state.time);
    driven[name].values.push(one);
  };
  const value = (name) => state.inputs.find((input) => input.name === name).value;
  const advance = () => {
    state.time += step;
    state.steps += 1;
    if (state.playing) {
      const at = state.time - state.playing.from;
      for (const [name, { times, values }] of Object.entries(state.playing.tracks)) {
        let k = 0;
        while (k + 1 < times.length && times[k + 1] <= at) ++k;
        if (times[k] <= at) set(name, values[k]);
      }
      if (Object.values(state.playing.tracks).every(({ times }) => times[times.length - 1] < at)) endPlay();
    }
    state.speed = Math.max(0, state.speed + step * (4 * value("throttle") - 9 * value("brake") - 0.02 * state.speed));
    state.yaw += (step * state.speed * Math.tan(0.5 * value("steering"))) / wheelbase;
    state.x += step * state.speed * Math.cos(state.yaw);
    state.y += step * state.speed * Math.sin(state.yaw);
  };
  const broadcast = (message) => {
    for (const { peer } of viewers.values()) peer.text(message);
  };
  const endPlay = () => {
    state.playing = null;
    broadcast({ say: "played", on: false });
  };
  const tellControl = () => {
    for (const [number, { peer }] of viewers) peer.text({ say: "control", yours: number === holder, taken: holder !== 0 });
  };

  const picture = (viewer) => {
    const span = animation.time[instants - 1] - animation.time[0];
    const k = Math.floor(((state.time % span) / span) * (instants - 1));
    const r = Math.floor(((state.time % span) / span) * (resultTime.length - 1));
    const chosen = viewer.channels;
    const bytes = Buffer.alloc(40 + 40 * bodies + 4 * (amplitudes + chosen.length + state.inputs.length));
    const bits = [state.paused, state.recording, state.failed, state.ended, state.playing !== null, viewer.number === holder];
    bytes[0] = 1;
    bytes[1] = bits.reduce((sum, on, bit) => sum + (on ? 1 << bit : 0), 0);
    bytes.writeUInt16LE(chosen.length, 2);
    bytes.writeUInt32LE(state.inputs.length, 4);
    bytes.writeDoubleLE(state.time, 8);
    bytes.writeDoubleLE(performance.now() / 1000, 16);
    bytes.writeBigUInt64LE(BigInt(state.steps), 24);
    bytes.writeFloatLE(0.35 + 0.1 * Math.sin(3 * state.time), 32);
    bytes.writeUInt32LE(viewer.choice, 36);
    let at = 40;
    const [cos, sin] = [Math.cos(state.yaw), Math.sin(state.yaw)];
    for (let body = 0; body < bodies; ++body) {
      const p = (axis) => animation.positions[3 * (k * bodies + body) + axis];
      const c = (axis) => animation.positions[3 * (k * bodies + chassis) + axis];
      const [dx, dy] = [p(0) - c(0), p(1) - c(1)];
      for (const place of [state.x + cos * dx - sin * dy, state.y + sin * dx + cos * dy, p(2)]) at = bytes.writeDoubleLE(place, at);
    }
    const [c, s] = [Math.cos(state.yaw / 2), Math.sin(state.yaw / 2)];
    for (let body = 0; body < bodies; ++body) {
      const [w, x, y, z] = animation.rotations.subarray(4 * (k * bodies + body), 4 * (k * bodies + body) + 4);
      for (const part of [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]) at = bytes.writeFloatLE(part, at);
    }
    for (let mode = 0; mode < amplitudes; ++mode) at = bytes.writeFloatLE(animation.modes[k * amplitudes + mode], at);
    for (const channel of chosen) at = bytes.writeFloatLE(resultValues[channel * resultTime.length + r] + packed.channels[channel].offset, at);
    for (const input of state.inputs) at = bytes.writeFloatLE(input.value, at);
    return bytes;
  };

  const status = () => {
    const edges = Array.from({ length: 41 }, (_, k) => 1e-6 * 10 ** (k / 10));
    const bell = (centre, width) => edges.slice(1).map((edge) => Math.round(state.steps * 0.2 * Math.exp(-(((Math.log10(edge) - Math.log10(centre)) / width) ** 2))));
    return {
      time: state.time,
      steps: state.steps,
      state: state.failed ? "failed" : state.ended ? "ended" : state.paused ? "paused" : "running",
      message: state.message,
      step,
      speed: 1,
      viewers: viewers.size,
      recording: state.recording,
      clock: { scheduling: "SCHED_OTHER: no permission for SCHED_FIFO", memory: "locked", cpu: "any" },
      computation: { median: 3e-4, p99: 4.2e-4, p9999: 6e-4, worst: 2.3e-3 },
      cpu: { median: 3e-4, p99: 4e-4, p9999: 5.5e-4, worst: 7e-4 },
      latency: { median: 5e-5, p99: 1e-4, p9999: 3e-4, worst: 1e-3 },
      overruns: { count: 3, latency: 1, preemption: 2, page_faults: 0, parts: 0, iterations: 0, computation: 0, skipped_outputs: 0 },
      histogram: { edges, computation: bell(3e-4, 0.12), latency: bell(5e-5, 0.25) },
      iterations: { mean: 1.9, most: 6 },
      worst_case: "at most 20 iterations in each of at most 1 + 4 parts",
    };
  };

  const orders = {
    channels: ({ indices }, viewer) => {
      viewer.channels = indices.slice(0, 64);
      viewer.choice += 1;
      viewer.peer.text({ say: "channels", indices: viewer.channels, choice: viewer.choice });
    },
    control: ({ take }, viewer) => {
      if (take && holder !== 0 && holder !== viewer.number) return viewer.peer.text({ say: "error", message: "another viewer has control; it has to release it first" });
      holder = take ? viewer.number : 0;
      tellControl();
    },
    inputs: ({ values }) => {
      for (const [name, one] of Object.entries(values)) set(name, one);
    },
    pause: () => (state.paused = true),
    resume: () => (state.paused = false),
    step: () => state.paused && advance(),
    reset: () => {
      Object.assign(state, { time: 0, steps: 0, x: 0, y: 0, yaw: 0, speed: 5, failed: false, ended: false, message: "", inputs: inputs() });
      driven = begin();
    },
    snapshot: ({ name }) => {
      snapshots.delete(name);
      const { recording, playing, paused, ...kept } = state;
      snapshots.set(name, structuredClone(kept));
      broadcast({ say: "snapshots", names: [...snapshots.keys()] });
    },
    restore: ({ name }) => {
      Object.assign(state, structuredClone(snapshots.get(name)));
      driven = begin();
    },
    record: ({ on }) => {
      state.recording = on;
      broadcast({ say: "recording", on, file: "drive.h5" });
    },
    play: ({ tracks }) => {
      if (!tracks) return endPlay();
      state.playing = { from: state.time, tracks };
      broadcast({ say: "played", on: true });
    },
  };

  const server = createServer((request, answer) => {
    const { pathname } = new URL(request.url, "http://mock");
    const send = (type, body) => {
      answer.writeHead(200, { "content-type": type });
      answer.end(body);
    };
    if (pathname === "/") send("text/html; charset=utf-8", live);
    else if (pathname === "/scene") send("application/json", JSON.stringify(scene()));
    else if (pathname === "/status") send("application/json", JSON.stringify(status()));
    else if (pathname === "/inputs") send("application/json", JSON.stringify({ format: "mimbre-inputs-1", tracks: driven }));
    else {
      answer.writeHead(404);
      answer.end();
    }
  });
  server.on("upgrade", (request, socket) => {
    const viewer = { number: next++, channels: scene().shown, choice: 0, peer: accept(request, socket, protocol) };
    viewers.set(viewer.number, viewer);
    viewer.peer.onClose = () => {
      viewers.delete(viewer.number);
      if (holder === viewer.number) holder = 0;
      tellControl();
    };
    viewer.peer.onText = (text) => {
      const order = JSON.parse(text);
      heard.push({ viewer: viewer.number, at: performance.now(), ...order });
      if (!["channels", "control"].includes(order.do) && viewer.number !== holder) viewer.peer.text({ say: "error", message: "only the viewer in control can do this" });
      else orders[order.do](order, viewer);
    };
    viewer.peer.text({ say: "hello", viewer: viewer.number, control: false, channels: viewer.channels });
    viewer.peer.text({ say: "control", yours: false, taken: holder !== 0 });
    viewer.peer.text({ say: "snapshots", names: [...snapshots.keys()] });
  });

  let last = performance.now();
  const ticking = setInterval(() => {
    const now = performance.now();
    const steps = Math.min(Math.round((now - last) / 1000 / step), 100);
    last = now;
    if (!state.paused && !state.failed && !state.ended) for (let k = 0; k < steps; ++k) advance();
    for (const viewer of viewers.values()) viewer.peer.binary(picture(viewer));
  }, 16);
  const telling = setInterval(() => broadcast({ say: "status", ...status() }), 500);
  await new Promise((done) => server.listen(port, "127.0.0.1", done));
  return {
    url: `http://127.0.0.1:${server.address().port}/`,
    port: server.address().port,
    state,
    heard,
    channels: packed.channels,
    say: broadcast,
    /** `code`: that of the WebSockets' end. */
    async stop(code = 1001) {
      clearInterval(ticking);
      clearInterval(telling);
      for (const { peer } of viewers.values()) peer.close(code);
      server.closeAllConnections();
      await new Promise((done) => server.close(done));
    },
  };
}

if (import.meta.url === pathToFileURL(process.argv[1] ?? "").href) {
  const { url } = await mockLive(process.argv[2], Number(process.argv[3] ?? 0));
  console.log(url);
}
