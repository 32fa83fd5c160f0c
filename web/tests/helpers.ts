import assert from "node:assert/strict";
import type { PackedArray } from "../src/data";

export function packed(type: "f32" | "f64" | "u32", values: number[]): PackedArray {
  const array = type === "f32" ? new Float32Array(values) : type === "f64" ? new Float64Array(values) : new Uint32Array(values);
  return { type, size: values.length, data: Buffer.from(array.buffer).toString("base64") };
}

export function near(actual: ArrayLike<number>, expected: number[], tolerance = 1e-12): void {
  assert.equal(actual.length, expected.length);
  expected.forEach((value, k) => assert.ok(Math.abs(actual[k] - value) <= tolerance, `[${k}]: ${actual[k]} ≠ ${value}`));
}
