import assert from "node:assert/strict";
import { test } from "node:test";
import { Quaternion, Vector3 } from "three";
import { Arrows } from "../src/arrows";
import type { Scene } from "../src/data";
import { amplitudesAt, poseAt } from "../src/interpolate";
import { advance, Driver, leverOf, padValue, readPad, roleOf } from "../src/liveDrive";
import { LiveLink, patience, type Socket } from "../src/liveLink";
import { alongEdges, heights } from "../src/liveMonitor";
import { fill, liveAnimation, PictureBuffer } from "../src/livePictures";
import { decodePicture, type Input, type Picture } from "../src/liveProtocol";
import { InputSender } from "../src/liveSender";
import { announcement, atFirst, controlWords, seenIn, stateWord } from "../src/liveSituation";
import { StripRecord } from "../src/liveStrip";
import { duration, fromNow, readTracks, toCsv, type Tracks } from "../src/liveTracks";
import { heading, leadingBody, turnBetween } from "../src/liveView";
import { near } from "./helpers";

const blank = { paused: false, recording: false, failed: false, ended: false, played: false, control: false };

function picture(time: number, clock: number, more: Partial<Picture> = {}): Picture {
  const empty = new Float32Array();
  return { ...blank, time, clock, steps: Math.round(1000 * time), deadline: 0.5, choice: 0, positions: new Float64Array(), rotations: empty, amplitudes: empty, channels: empty, inputs: empty, ...more };
}

const steering: Input = { name: "car.steering", unit: "1", min: -0.5, max: 0.5, start: 0, value: 0, tunable: false, about: "" };
const throttle: Input = { name: "throttle", unit: "1", min: 0, max: 1, start: 0, value: 0, tunable: false, about: "" };

/** Byte by byte as docs/live-protocol.md says, apart from the decoder. */
function packedPicture(bits: number): ArrayBuffer {
  const parts: [type: string, value: number][] = [["u8", 1], ["u8", bits], ["u16", 2], ["u32", 1], ["f64", 1.25], ["f64", 100.5], ["u64", 1250], ["f32", 0.75], ["u32", 7]];
  for (const value of [1e6, 2, 3, 4, 5, 6]) parts.push(["f64", value]);
  for (const value of [1, 0, 0, 0, 0.5, 0.5, 0.5, 0.5, 0.25, -0.25, 0.125, 8, 9, -1]) parts.push(["f32", value]);
  const sizes: Record<string, number> = { u8: 1, u16: 2, u32: 4, u64: 8, f32: 4, f64: 8 };
  const bytes = new DataView(new ArrayBuffer(parts.reduce((sum, [type]) => sum + sizes[type], 0)));
  let at = 0;
  for (const [type, value] of parts) {
    if (type === "u8") bytes.setUint8(at, value);
    else if (type === "u16") bytes.setUint16(at, value, true);
    else if (type === "u32") bytes.setUint32(at, value, true);
    else if (type === "u64") bytes.setBigUint64(at, BigInt(value), true);
    else if (type === "f32") bytes.setFloat32(at, value, true);
    else bytes.setFloat64(at, value, true);
    at += sizes[type];
  }
  return bytes.buffer as ArrayBuffer;
}

test("a picture is decoded field by field", () => {
  const seen = decodePicture(packedPicture(0b100101), 2, 3);
  assert.deepEqual([seen.paused, seen.recording, seen.failed, seen.ended, seen.played, seen.control], [true, false, true, false, false, true]);
  assert.deepEqual([seen.time, seen.clock, seen.steps, seen.deadline, seen.choice], [1.25, 100.5, 1250, 0.75, 7]);
  near(seen.positions, [1e6, 2, 3, 4, 5, 6]);
  near(seen.rotations, [1, 0, 0, 0, 0.5, 0.5, 0.5, 0.5]);
  near(seen.amplitudes, [0.25, -0.25, 0.125]);
  near(seen.channels, [8, 9]);
  near(seen.inputs, [-1]);
  assert.throws(() => decodePicture(packedPicture(0), 2, 2), /picture of 144 bytes instead of 140/);
  assert.throws(() => decodePicture(new ArrayBuffer(12), 0, 0), /12 bytes/);
});

test("what is shown lies between two pictures, two intervals late, however unevenly they come", () => {
  const buffer = new PictureBuffer();
  // The simulation at half speed; this machine's clock is 1000 s ahead, pictures take 3 to 15 ms.
  for (let k = 0; k < 60; ++k) buffer.add(picture(k / 120, k / 60), 1000 + k / 60 + (k % 5 === 0 ? 0.003 : 0.015));
  const now = 1000 + 59 / 60 + 0.003;
  const late = 2 * buffer.usual;
  assert.ok(Math.abs(buffer.usual - 1 / 60) < 1e-9);
  for (const back of [0, 0.004, 0.1]) {
    const between = buffer.at(now - back)!;
    assert.ok(Math.abs(between.time - 0.5 * (59 / 60 - back - late)) < 1e-9, `${between.time}`);
    assert.ok(between.earlier.time <= between.time && between.time <= between.later.time);
  }
  // When none come the last stays.
  assert.equal(buffer.at(now + 3)!.time, 59 / 120);
});

test("nothing is between the pictures before and after a reset, and another server's clock begins anew", () => {
  const buffer = new PictureBuffer();
  assert.equal(buffer.at(0), null);
  buffer.add(picture(5, 1.0), 1.0);
  buffer.add(picture(0, 1.1), 1.1);
  for (let now = 1.0; now < 1.5; now += 0.01) assert.ok([0, 5].includes(buffer.at(now)!.time));
  buffer.add(picture(3, 0.2), 2);
  assert.equal(buffer.at(2)!.time, 3);
});

test("the animation holds the two pictures, and is interpolated by who draws it", () => {
  const quarter = Math.SQRT1_2;
  const animation = liveAnimation({ time: new Float64Array([0]), positions: new Float64Array([1, 2, 3]), rotations: new Float32Array([1, 0, 0, 0]), modes: new Float32Array([0.5]), bodies: 1, amplitudes: 1 });
  near(poseAt(animation, 0, 0).position, [1, 2, 3]);
  const earlier = picture(1, 1, { positions: new Float64Array([0, 0, 0]), rotations: new Float32Array([1, 0, 0, 0]), amplitudes: new Float32Array([1]) });
  const later = picture(2, 2, { positions: new Float64Array([4, 0, 8]), rotations: new Float32Array([quarter, 0, 0, quarter]), amplitudes: new Float32Array([3]) });
  fill(animation, { earlier, later, time: 1.25 });
  const { position, rotation } = poseAt(animation, 1.25, 0);
  near(position, [1, 0, 2]);
  near(rotation, [Math.cos(Math.PI / 16), 0, 0, Math.sin(Math.PI / 16)], 1e-7);
  near(amplitudesAt(animation, 1.25, 0, 1), [1.5]);
});

test("roles are known by the last word of a name", () => {
  assert.deepEqual(["steering", "car.steering_wheel", "Throttle", "accelerator", "front.brake", "brake_pressure", "oversteering"].map(roleOf), ["steering", "steering", "throttle", "throttle", "brake", "other", "other"]);
  assert.deepEqual(leverOf({ ...throttle, name: "steering", tunable: true }).plus, []);
});

test("steering turns while a key is held, comes back when it is let go, and never beyond its bounds", () => {
  const lever = leverOf(steering);
  assert.equal(advance(lever, 0, 1, 0.1), 0.1); // its range of 1 in a second
  assert.equal(advance(lever, 0.45, 1, 0.1), 0.5);
  near([advance(lever, 0.5, 0, 0.1)], [0.34]);
  assert.equal(advance(lever, 0.01, 0, 0.1), 0); // not past the middle
  near([advance(lever, 0.5, -1, 0.1)], [0.34]); // from the other side as fast as by itself
  assert.equal(advance(leverOf({ ...throttle, name: "gear", start: 0.3 }), 0.8, 0, 1), 0.8); // others stay
});

test("an input without bounds has a slider with room around its start", () => {
  const { low, high, rest } = leverOf({ ...throttle, name: "wind", min: undefined, max: undefined, start: 30 });
  assert.deepEqual([low, high, rest], [-70, 130, 30]);
  const half = leverOf({ ...throttle, name: "wind", max: undefined });
  assert.deepEqual([half.low, half.high], [0, 1]);
});

test("keys drive, let go and leave alone", () => {
  const driver = new Driver([steering, throttle]);
  const present = () => 0.2;
  assert.deepEqual(driver.advance(0.1, present, null), {}); // nobody has touched it
  assert.ok(driver.takes("KeyA") && driver.takes("ArrowUp") && !driver.takes("KeyQ"));
  driver.press("KeyD");
  near([driver.advance(0.01, present, null)["car.steering"]], [0.184]); // from where it is, back over the middle
  driver.press("ArrowLeft");
  near([driver.advance(0.01, () => 9, null)["car.steering"]], [0.168]); // both: as if none
  driver.release("KeyD");
  driver.release("ArrowLeft");
  assert.deepEqual(driver.advance(10, present, null), { "car.steering": 0 });
  assert.deepEqual(driver.advance(0.1, present, null), {});
  driver.press("KeyW");
  driver.advance(0.1, () => 0, null);
  assert.deepEqual(driver.letGo(), { throttle: 0 });
  assert.deepEqual(driver.advance(0.1, () => 0.7, null), {});
});

test("a finger holds, and what it leaves goes back by itself", () => {
  const driver = new Driver([steering]);
  driver.touch(driver.levers[0], 1);
  assert.deepEqual(driver.advance(0.1, () => 0, null), { "car.steering": 0.5 });
  driver.touch(driver.levers[0], null);
  near([driver.advance(0.1, () => 0.5, null)["car.steering"]], [0.34]);
});

const padOf = (axes: number[], pressed: Record<number, number> = {}) => ({ axes, buttons: Array.from({ length: 10 }, (_, k) => ({ value: pressed[k] ?? 0 })) });

test("gamepads: sticks with a dead zone, pedals, triggers", () => {
  const pad = padOf([0.05, -1, 1, -1], { 7: 0.6 });
  assert.equal(readPad(pad, "axis 0"), 0);
  assert.equal(readPad(pad, "axis 1"), -1);
  assert.equal(readPad(pad, "axis 1 reversed"), 1);
  near([readPad(padOf([0.54]), "axis 0")!], [0.5]);
  assert.deepEqual([readPad(pad, "axis 2 pedal"), readPad(pad, "axis 3 pedal"), readPad(pad, "axis 2 pedal reversed")], [0, 1, 1]);
  assert.equal(readPad(pad, "button 7"), 0.6);
  assert.equal(readPad(pad, "axis 9"), null);
  assert.equal(readPad(pad, ""), null);
  const uneven = leverOf({ ...throttle, name: "steering", min: -2, max: 4, start: 1 });
  assert.deepEqual([-1, 0, 0.5, 1].map((reading) => padValue(uneven, reading)), [-2, 1, 2.5, 4]);
});

test("a pad that rests does not fight the keys; one that moves takes over, with the stick's left to the left", () => {
  const driver = new Driver([steering, throttle]);
  const at = (pad: ReturnType<typeof padOf>) => driver.advance(0.1, () => 0, pad);
  assert.deepEqual(at(padOf([0, 0])), {});
  driver.press("KeyA");
  near([at(padOf([0, 0]))["car.steering"]], [0.1]);
  driver.release("KeyA");
  assert.deepEqual(at(padOf([-1, 0], { 7: 1 })), { "car.steering": 0.5, throttle: 1 });
  assert.deepEqual(at(padOf([-1, 0], { 7: 1 })), { "car.steering": 0.5, throttle: 1 }); // held still
  driver.leave("throttle"); // by the slider
  assert.deepEqual(at(padOf([-1, 0], { 7: 1 })), { "car.steering": 0.5 });
  driver.press("KeyD");
  near([at(padOf([-1, 0], { 7: 1 }))["car.steering"]], [-0.1]); // keys again
});

test("inputs are sent sixty times a second at most, only what has changed, and the last of all", () => {
  const sent: Record<string, number>[] = [];
  let listening = true;
  const sender = new InputSender((values) => (listening && sent.push(values), listening));
  sender.set("a", 1);
  sender.set("b", NaN);
  sender.flush(0);
  sender.set("a", 2);
  sender.flush(0.005);
  sender.set("a", 3);
  sender.flush(0.01);
  assert.deepEqual(sent, [{ a: 1 }]);
  sender.flush(1 / 60);
  sender.set("a", 3);
  sender.flush(1);
  assert.deepEqual(sent, [{ a: 1 }, { a: 3 }]);
  // What could not be sent is sent later; at once where it must.
  listening = false;
  sender.set("b", 5);
  sender.flush(2);
  listening = true;
  sender.flush(2.5);
  sender.set("a", 0);
  sender.flush(2.5, true);
  assert.deepEqual(sent.slice(2), [{ b: 5 }, { a: 0 }]);
  // 10 s of a screen with 240 pictures a second.
  sent.length = 0;
  for (let k = 0; k < 2400; ++k) {
    sender.set("a", k);
    sender.flush(10 + k / 240);
  }
  assert.ok(sent.length >= 590 && sent.length <= 600, `${sent.length}`);
});

class FakeSocket implements Socket {
  onopen: ((event: Event) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  sent: string[] = [];
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {}
  opened(): void {
    this.onopen?.({} as Event);
  }
  closed(code: number): void {
    this.onclose?.({ code } as CloseEvent);
  }
}

const settled = () => new Promise((done) => setImmediate(done));

test("the link comes back by itself, ever more patiently, and at once when it is asked to", async () => {
  const sockets: FakeSocket[] = [];
  const waits: { seconds: number; call: () => void }[] = [];
  const log: string[] = [];
  let answer: () => Promise<boolean> = async () => true;
  const link = new LiveLink({
    open: () => {
      sockets.push(new FakeSocket());
      return sockets[sockets.length - 1];
    },
    picture: (bytes) => log.push(`picture ${bytes.byteLength}`),
    said: ({ say }) => log.push(say),
    connected: () => log.push("connected"),
    lost: (ended, retry) => log.push(`lost ${ended} ${retry}`),
    again: () => answer(),
    after: (seconds, call) => waits.push({ seconds, call }),
  });
  link.connect();
  assert.equal(link.send({ do: "pause" }), false);
  sockets[0].opened();
  assert.equal(link.send({ do: "pause" }), true);
  assert.deepEqual(sockets[0].sent, ['{"do":"pause"}']);
  sockets[0].onmessage!({ data: '{"say":"played","on":true}' } as MessageEvent);
  sockets[0].onmessage!({ data: new ArrayBuffer(3) } as MessageEvent);
  sockets[0].closed(1001);
  assert.deepEqual(log.splice(0), ["connected", "played", "picture 3", "lost true 0.5"]);
  answer = async () => Promise.reject(new Error("nobody there"));
  waits[0].call();
  await settled();
  waits[1].call();
  await settled();
  assert.deepEqual(log.splice(0), ["lost true 1", "lost true 2"]);
  answer = async () => true;
  await link.retry(); // by the button
  assert.equal(sockets.length, 2);
  waits[2].call(); // the attempt that was waited for comes too late
  await settled();
  assert.equal(sockets.length, 2);
  sockets[1].opened();
  sockets[1].closed(1006);
  assert.deepEqual(log.splice(0), ["connected", "lost false 0.5"]);
  // Another model: the page does not go on.
  answer = async () => false;
  waits[3].call();
  await settled();
  assert.equal(sockets.length, 2);
  assert.deepEqual([0, 1, 2, 3, 4, 5].map(patience), [0.5, 1, 2, 4, 8, 8]);
});

test("strips keep the last seconds, gaps where a channel was not chosen, and begin anew after a reset", () => {
  const record = new StripRecord(1);
  record.choose([4, 7], 0);
  record.add(picture(0, 0, { channels: new Float32Array([1, 2]) }));
  record.add(picture(0, 0.1, { channels: new Float32Array([1, 2]) })); // paused
  record.choose([7, 9], 1);
  record.add(picture(0.1, 0.2, { channels: new Float32Array([5, 6]) })); // of the old choice
  record.add(picture(0.2, 0.3, { choice: 1, channels: new Float32Array([3, NaN]) }));
  near(record.time, [0, 0.1, 0.2]);
  assert.deepEqual([record.of(7), record.of(9), record.of(4)], [[2, null, 3], [null, null, null], []]);
  assert.equal(record.place(9, picture(0, 0, { choice: 1 })), 1);
  assert.equal(record.place(9, picture(0, 0)), -1);
  for (let k = 3; k < 40; ++k) record.add(picture(k / 10, k, { choice: 1, channels: new Float32Array([k, 0]) }));
  assert.ok(record.time[0] >= 2.3 && record.time[0] <= 2.9 && record.time.length === record.of(7).length);
  record.add(picture(0, 99, { choice: 1, channels: new Float32Array([8, 8]) }));
  assert.deepEqual([record.time, record.of(7)], [[0], [8]]);
});

test("what was driven survives its files, is played from now on, and the last of two at a time counts", () => {
  const inputs = [steering, { ...throttle, unit: "N" }];
  const kept = { "car.steering": { times: [0, 0, 1.5, 2, 2.25], values: [0.5, 0, 0.3, 0.3, 0.3] }, throttle: { times: [0, 2.1], values: [1, 0.25] } };
  const tracks = readTracks(JSON.stringify({ format: "mimbre-inputs-1", tracks: kept }), inputs);
  assert.deepEqual(tracks, { "car.steering": { times: [0, 1.5, 2.25], values: [0, 0.3, 0.3] }, throttle: kept.throttle });
  const csv = toCsv(tracks, new Map(inputs.map(({ name, unit }) => [name, unit])));
  assert.equal(csv, "t [s],car.steering,throttle [N]\r\n0,0,1\r\n1.5,0.3,1\r\n2.1,0.3,0.25\r\n2.25,0.3,0.25\r\n");
  // Values at any time are the same, though the points are others.
  const again = readTracks(csv, inputs);
  const at = ({ times, values }: { times: number[]; values: number[] }, t: number) => values[times.filter((time) => time <= t).length - 1];
  for (let t = 0; t < 3; t += 0.05) for (const name of Object.keys(tracks)) assert.equal(at(again[name], t), at((tracks as Tracks)[name], t), `${name} at ${t}`);
  assert.equal(duration(tracks), 2.25);
  assert.deepEqual(fromNow({ a: { times: [3, 4], values: [1, 2] }, b: { times: [3.5], values: [0] } }), { a: { times: [0, 1], values: [1, 2] }, b: { times: [0.5], values: [0] } });
});

test("files that are none of recorded inputs are told so", () => {
  const inputs = [steering, throttle];
  assert.throws(() => readTracks('{"format": "other"}', inputs), /no recorded inputs/);
  assert.throws(() => readTracks("t,gas\n0,1\n", inputs), /no input “gas”; it has car.steering, throttle/);
  assert.throws(() => readTracks("t,throttle\n1,1\n0,2\n", inputs), /times of “throttle” do not ascend/);
  assert.throws(() => readTracks("t,throttle\n0,fast\n", inputs), /all of them numbers/);
  assert.throws(() => readTracks("t,throttle\n", inputs), /no values/);
  assert.throws(() => readTracks('{"format": "mimbre-inputs-1", "tracks": {"throttle": {"times": [0, 1], "values": [0]}}}', inputs), /as many times as values/);
  const odd: Input = { ...throttle, name: 'a, "b"', unit: "N m" };
  const tracks = { [odd.name]: { times: [0, 1], values: [1, -2] } };
  assert.deepEqual(readTracks(toCsv(tracks, new Map([[odd.name, odd.unit]])), [odd]), tracks);
});

test("words for how things stand", () => {
  const open = { ...atFirst, connection: "open" as const };
  assert.deepEqual(stateWord({ ...open, paused: true }), ["Paused", "rest"]);
  assert.deepEqual(stateWord({ ...open, paused: true, failed: true }), ["Failed", "bad"]);
  assert.deepEqual(stateWord({ ...open, connection: "ended" }), ["Server ended", "bad"]);
  assert.equal(announcement(open, { ...open, control: true, taken: true }), "You are in control");
  assert.equal(announcement(open, { ...open, failed: true, message: "singular" }), "Failed: singular");
  assert.equal(announcement({ ...open, control: true }, { ...open, connection: "lost" }), "Connection lost");
  const driving = { ...open, control: true, taken: true };
  assert.equal(announcement(driving, { ...driving, asker: 3 }), "Viewer 3 requests control");
  assert.equal(announcement({ ...driving, asker: 3 }, driving), "");
  assert.equal(announcement(open, open), "");
  assert.match(controlWords({ ...open, taken: true }), /Another viewer/);
  assert.match(controlWords({ ...open, taken: true, asked: true }), /requested/);
  assert.deepEqual(seenIn({ ...picture(0, 0), control: true }), { ...blank, control: true, taken: true, asked: false });
  assert.deepEqual(seenIn(picture(0, 0)), { ...blank, asker: 0 });
});

test("the histogram shows one step in a million, and the deadline where it belongs", () => {
  const [none, one, most] = heights([0, 1, 1e6]);
  assert.ok(none === 0 && one >= 0.04 && most === 1);
  near([alongEdges([1e-6, 1e-5, 1e-4], 1e-5), alongEdges([1e-6, 1e-4], 1e-5)], [0.5, 0.5]);
});

/** A wheel, then a chassis that floats; a load on it. */
function vehicle(): Scene {
  const body = { firstMode: 0, modes: 0, lineRadius: 0, points: new Float32Array(), pointShapes: new Float32Array(), lines: new Uint32Array(), triangles: new Uint32Array(), edges: new Uint32Array(), labels: new Float64Array(), stress: new Float32Array(), barStress: new Float32Array(), roundLines: new Uint32Array() };
  const box = (size: number) => [{ kind: "box" as const, size: [size, size, size], position: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1] }];
  const frame = (name: string, on: number) => ({ name, body: on, position: [0, 0, 0], rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], motion: new Float32Array() });
  const values = new Map(["x", "y", "z"].map((axis) => [`load.push.force.${axis}`, { time: [0, 1], values: [0, 0] }]));
  return {
    bodies: [{ ...body, name: "wheel", shapes: box(3) }, { ...body, name: "chassis", shapes: box(1) }],
    roads: [],
    frames: [frame("ground", -1), frame("middle", 1)],
    elements: [{ name: "free", kind: "floating", a: 0, b: 1, size: 0 }, { name: "push", kind: "load", a: 1, b: -1, size: 0 }],
    animation: liveAnimation({ time: new Float64Array([0]), positions: new Float64Array(6), rotations: new Float32Array(8), modes: new Float32Array(), bodies: 2, amplitudes: 0 }),
    signals: (name) => values.get(name) ?? null,
  };
}

test("the camera goes with what floats, else with the largest", () => {
  const scene = vehicle();
  assert.equal(leadingBody(scene), 1);
  assert.equal(leadingBody({ ...scene, elements: [] }), 0);
  assert.equal(leadingBody({ ...scene, bodies: [], elements: [] }), -1);
  near([heading(Math.cos(0.4), 0, 0, Math.sin(0.4))], [0.8]);
  near([turnBetween(3, -3), turnBetween(-3, 3), turnBetween(0.5, 7)], [2 * Math.PI - 6, 6 - 2 * Math.PI, 6.5 - 2 * Math.PI]);
});

test("arrows of forces that are not known before: they are there, ask for their channels and learn their scale", () => {
  const scene = vehicle();
  assert.equal(new Arrows(scene, 1).hasLoads, false); // of a report: nought all the time
  const arrows = new Arrows(scene, 1, true);
  assert.ok(arrows.hasLoads);
  assert.deepEqual(arrows.channels, []);
  arrows.shown = "loads";
  assert.deepEqual(arrows.channels, ["load.push.force.x", "load.push.force.y", "load.push.force.z"]);
  (scene.signals!("load.push.force.y")!.values as number[]).fill(-300);
  arrows.update(0.5, () => null);
  assert.equal(arrows.perMetre.force, 0); // not drawn, not learned
  arrows.update(0.5, () => ({ position: new Vector3(), rotation: new Quaternion() }));
  assert.equal(arrows.perMetre.force, 1000); // at most 0.4 m long, of a mechanism of 1 m
});
