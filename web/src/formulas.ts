// Channels that the reader makes of others.
import type { Channel, Curve } from "./data";
import { evaluate, type Source, type Values } from "./formula";

export function curveOf(values: Values): Curve {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values)
    if (value !== null) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  return { values, range: Math.max(high - low, 0) };
}

/** The formula as a channel; throws an Error that describes its mistake. */
export function formulaChannel(text: string, source: Source): Channel {
  const { values, unit } = evaluate(text, source);
  return { name: text, unit, meaning: "formula, evaluated by this page", ...curveOf(values) };
}
