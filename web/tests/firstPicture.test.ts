import assert from "node:assert/strict";
import { test } from "node:test";
import { PerspectiveCamera, Vector3 } from "three";
import type { Animation } from "../src/data";
import { firstExaggeration, playFrom, tellingInstant } from "../src/firstPicture";
import { framing } from "../src/framing";

test("deflections that are too small to see are exaggerated, by no more than their bodies' shape allows", () => {
  // 2.4 mm of a link 0.36 m long in a vehicle of 4 m.
  assert.equal(firstExaggeration([{ value: 2.4e-3, length: 0.36 }, { value: 0, length: 1 }], 4, 500), 10);
  // The shortest body decides: 0.08·0.1 m / 1 mm = 8.
  assert.equal(firstExaggeration([{ value: 1e-3, length: 1 }, { value: 1e-3, length: 0.1 }], 4, 500), 5);
  // The same mechanism a thousand times as large.
  assert.equal(firstExaggeration([{ value: 1, length: 1e3 }, { value: 1, length: 100 }], 4e3, 500), 5);
  // Seen as it is; nothing deforms; not seen with any factor.
  assert.equal(firstExaggeration([{ value: 3.6, length: 60 }], 144, 500), 1);
  assert.equal(firstExaggeration([], 1, 500), 1);
  assert.equal(firstExaggeration([{ value: 1e-9, length: 1 }], 1, 500), 1);
});

/** Two bodies: the second goes along x by `x`, and turns about z by `angles`. */
const moving = (x: number[], angles: number[]): Animation => ({
  time: Float64Array.from(x, (_, i) => 0.1 * i),
  positions: Float64Array.from(x.flatMap((value) => [2 * value, 0, 0, 3 * value, 0, 0])),
  rotations: Float32Array.from(angles.flatMap((angle) => [1, 0, 0, 0, Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)])),
  modes: new Float32Array(),
  bodies: 2,
  amplitudes: 0,
});

test("the first picture is where bodies deform most, else where the motion is fastest", () => {
  const still = [0, 0, 0, 0, 0, 0];
  const jump = [0, 0, 0, 1, 1, 1]; // fastest from 0.2 to 0.3 s
  const rigid = [0, 0].map(() => ({ value: 0, point: -1, time: 0 }));
  assert.equal(tellingInstant(moving(jump, still), [{ value: 1e-3, point: 4, time: 0.4 }, { value: 2e-3, point: 0, time: 0.5 }], [1, 1]), 0.5);
  assert.equal(tellingInstant(moving(jump, still), rigid, [1, 1]), 0.2);
  assert.equal(tellingInstant(moving(still, [0, 0, 0, 0, 2, 2]), rigid, [1, 1]), 0.1 * 3);
  // Seen from a body that goes along, its own motion is none.
  const both = moving(jump, [0, 0, 0, 0, 0, 2]);
  assert.equal(tellingInstant(both, rigid, [1, 0.1], -1), 0.2);
  assert.equal(tellingInstant(both, rigid, [1, 10], 1), 0.1 * 5);
  // A steady motion opens at its beginning, broken instants count for nothing.
  assert.equal(tellingInstant(moving([0, 1, 2, 3, 4, NaN], still), rigid, [1, 1]), 0);
  assert.equal(tellingInstant({ ...moving([], []), time: new Float64Array() }, rigid, [1, 1]), 0);
});

test("it plays from a moment before, by the speed at which it is watched", () => {
  assert.equal(playFrom(5.7, 0, 1), 5.45);
  assert.equal(playFrom(0.01, 0, 0.02), 0.005);
  assert.equal(playFrom(0.1, 0, 1), 0);
});

test("a camera that is framed sees all points, and they fill its picture", () => {
  const points = [[0, 0, 0], [3, 0, 0], [3, 1, 0.5], [0, 0.2, 2], [1, -1, 0]].map((place) => new Vector3(...(place as [number, number, number])));
  for (const aspect of [0.6, 1, 2.4])
    for (const direction of [new Vector3(0.62, -1, 0.42), new Vector3(0.3, -0.7, 1), new Vector3(-1, 0.1, 0.2)]) {
      const camera = new PerspectiveCamera(40, aspect, 0.01, 100);
      const { center, distance } = framing(points, direction.normalize(), Math.tan((20 * Math.PI) / 180), aspect);
      camera.up.set(0, 0, 1);
      camera.position.copy(center).addScaledVector(direction, distance);
      camera.lookAt(center);
      camera.updateMatrixWorld();
      const seen = points.map((point) => point.clone().project(camera));
      const [across, upwards] = (["x", "y"] as const).map((axis) => seen.map((place) => place[axis]));
      const outermost = Math.max(...[...across, ...upwards].map(Math.abs));
      assert.ok(outermost < 0.8401 && outermost > 0.83, `${outermost}`);
      // In the direction that decides, as far from one border as from the other.
      const middle = ([across, upwards].map((all) => [Math.max(...all), Math.min(...all)]).sort((a, b) => b[0] - b[1] - (a[0] - a[1])))[0];
      assert.ok(Math.abs(middle[0] + middle[1]) < 0.05, `${middle}`);
    }
});
