import assert from "node:assert/strict";
import { test } from "node:test";
import { filmTimes } from "../src/film";
import { webm, type Picture } from "../src/webm";
import { near } from "./helpers";

interface Node {
  id: number;
  at: number; // of its id, in the file
  data: number; // where its content begins
  end: number;
}

/** Elements of EBML one after the other, by RFC 8794: identifiers with their marker bit, sizes without. */
function nodes(file: Uint8Array, from: number, to: number): Node[] {
  const found: Node[] = [];
  for (let at = from; at < to; ) {
    const variable = (start: number, keep: boolean): [value: number, next: number] => {
      const length = Math.clz32(file[start]) - 23;
      let value = keep ? file[start] : file[start] & (0xff >> length);
      for (let k = 1; k < length; ++k) value = value * 256 + file[start + k];
      return [value, start + length];
    };
    const [id, size] = variable(at, true);
    const [length, data] = variable(size, false);
    found.push({ id, at, data, end: data + length });
    at = data + length;
  }
  assert.equal(found.length > 0 ? found[found.length - 1].end : to, to, "sizes add up");
  return found;
}

const pictures: Picture[] = Array.from({ length: 130 }, (_, k) => ({ time: Math.round((1e6 * k) / 30), key: k % 60 === 0, data: Uint8Array.of(k, 2, 3) }));

test("a film of WebM: its elements fit into each other, times and jumps are right", () => {
  const file = webm({ codec: "V_VP9", width: 640, height: 360, pictures, last: 33333 });
  const view = new DataView(file.buffer);
  const whole = ({ data, end }: Node) => file.subarray(data, end).reduce((sum, byte) => 256 * sum + byte, 0);
  const letters = ({ data, end }: Node) => new TextDecoder().decode(file.subarray(data, end));
  const top = nodes(file, 0, file.length);
  assert.deepEqual(top.map(({ id }) => id), [0x1a45dfa3, 0x18538067]);
  assert.equal(letters(nodes(file, top[0].data, top[0].end).find(({ id }) => id === 0x4282)!), "webm");
  const [, segment] = top;
  const parts = nodes(file, segment.data, segment.end);
  const all = (wanted: number, of = parts) => of.filter(({ id }) => id === wanted);
  const inside = (node: Node) => nodes(file, node.data, node.end);
  const [duration] = all(0x4489, inside(all(0x1549a966)[0]));
  assert.ok(Math.abs(view.getFloat64(duration.data) - 1000 * (130 / 30)) < 0.1);
  const [track] = all(0xae, inside(all(0x1654ae6b)[0]));
  assert.equal(letters(all(0x86, inside(track))[0]), "V_VP9");
  const [video] = all(0xe0, inside(track));
  assert.deepEqual(inside(video).map(whole), [640, 360]);

  const clusters = all(0x1f43b675);
  assert.equal(clusters.length, 3); // one a key picture
  const times: number[] = [];
  let count = 0;
  for (const cluster of clusters) {
    const start = whole(all(0xe7, inside(cluster))[0]);
    for (const block of all(0xa3, inside(cluster))) {
      assert.equal(file[block.data], 0x81); // the first track
      times.push(start + view.getInt16(block.data + 1));
      assert.equal(file[block.data + 3] === 0x80, pictures[count].key);
      assert.deepEqual([...file.subarray(block.data + 4, block.end)], [...pictures[count].data]);
      ++count;
    }
  }
  near(times, pictures.map(({ time }) => time / 1000), 0.5 + 1e-9);
  const jumps = inside(all(0x1c53bb6b)[0]).map((point) => inside(all(0xb7, inside(point))[0]).filter(({ id }) => id === 0xf1).map(whole)[0]);
  assert.deepEqual(jumps, clusters.map(({ at }) => at - segment.data));
});

test("a film of no pictures is a file still, and blocks stay near their cluster", () => {
  assert.doesNotThrow(() => nodes(webm({ codec: "V_VP8", width: 2, height: 2, pictures: [], last: 0 }), 0, 0));
  const slow = [0, 40e6].map((time) => ({ time, key: time === 0, data: new Uint8Array(1) })); // 16 bits hold 32 s
  const file = webm({ codec: "V_VP8", width: 2, height: 2, pictures: slow, last: 1e6 });
  const segment = nodes(file, 0, file.length)[1];
  assert.equal(nodes(file, segment.data, segment.end).filter(({ id }) => id === 0x1f43b675).length, 2);
});

test("a film's pictures are at equal steps of simulated time, the end included", () => {
  near(filmTimes(2, 2.1, 1), [2, 2 + 1 / 30, 2 + 2 / 30, 2.1], 1e-12);
  near(filmTimes(0, 0.1, 1.2), [0, 0.04, 0.08, 0.1], 1e-12);
  assert.equal(filmTimes(0, 10, 0.5).length, 601);
  assert.deepEqual(filmTimes(3, 3, 1), [3]);
});
