// The summary of a run in a dozen lines, for people; everything else stays in the details.
import { formatNumber } from "./format";
import { axisScale, scaleFor } from "./engineering";

export interface Line {
  label: string;
  value: string;
}

type Summary = Record<string, unknown>;

const isNumber = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);

/** A number with the unit in which it reads well. */
export function quantity(value: number, unit: string, digits = 3): string {
  const scale = scaleFor(unit, value);
  return `${formatNumber(value / scale.size, digits)} ${scale.unit}`.trim();
}

/** A time of a run: 0.2 s rather than 200 ms. */
export function instant(time: number, digits = 4): string {
  const scale = axisScale("s", time);
  return `${formatNumber(time / scale.size, digits)} ${scale.unit}`;
}

const words = (value: unknown) => (typeof value === "string" ? value.replace(/_/g, " ") : "");

const asSummary = (summary: unknown): Summary => (typeof summary === "object" && summary !== null ? (summary as Summary) : {});

/** What stands above everything else: that a run failed, and its warnings. */
export function warningsOf(summary: unknown): string[] {
  const { status, message, warnings } = asSummary(summary);
  const failed = status !== undefined && status !== "ok" ? [`${words(status)}${message ? `: ${message}` : ""}`] : [];
  const listed = Array.isArray(warnings) ? warnings.map(String) : [];
  return [...failed.map((text) => `The run ${text.startsWith("failed") ? text : `ended as ${text}`}`), ...listed];
}

const neglected = [
  ["deflection", "deflection"],
  ["foreshortening", "shortening"],
  ["compression", "compression"],
  ["tension", "tension"],
  ["lag", "error by tension or compression over time"],
  ["held", "stretching between fixed ends"],
  ["high_modes", "highest modes"],
];

/** The largest of what linear theory neglected, of all bodies. */
function worstValidity(bodies: unknown): string {
  if (!Array.isArray(bodies)) return "";
  let worst = { value: -1, text: "" };
  for (const body of bodies as Summary[])
    for (const [key, name] of neglected) {
      const value = body[key];
      if (!isNumber(value) || value <= worst.value) continue;
      const at = asSummary(body.time)[key];
      worst = { value, text: `${formatNumber(100 * value, 2)} % (${name} of ${body.body}${isNumber(at) ? ` at ${instant(at)}` : ""})` };
    }
  return worst.text;
}

function energyLine(energy: unknown): string {
  const terms = asSummary(energy);
  const known = (key: string, name: string) => (isNumber(terms[key]) ? `${name} ${quantity(terms[key], "J")}` : "");
  return [known("kinetic", "kinetic"), known("elastic", "strain"), known("numerical", "numerical gain")].filter((text) => text !== "").join(" · ");
}

/** What is smaller is printed as "below" it: 1 nm, 1 nm/s, a millionth of a degree. */
const least: Record<string, [value: number, text: string]> = {
  m: [1e-9, "1 nm"],
  "m/s": [1e-9, "1 nm/s"],
  rad: [Math.PI / 180e6, "10⁻⁶ °"],
  "rad/s": [Math.PI / 180e6, "10⁻⁶ °/s"],
};

/** The largest violations, as far as the file has them. */
function violations(...values: [unknown, string][]): string {
  const known = values.filter((one): one is [number, string] => isNumber(one[0]));
  return known.map(([value, unit]) => (Math.abs(value) < least[unit][0] ? `below ${least[unit][1]}` : quantity(value, unit, 2))).join(", ");
}

/** At most twelve; what is not known is left out. */
export function summaryLines(summary: unknown, facts: { end: number; step: number; instants: number; bodies: number; joints: number }): Line[] {
  const s = asSummary(summary);
  const count = (value: unknown, one: string, many = `${one}s`) => (isNumber(value) ? `${formatNumber(value)} ${value === 1 ? one : many}` : "");
  const join = (...parts: string[]) => parts.filter((part) => part !== "").join(" · ");
  const ended = s.status === undefined ? "" : s.status === "ok" ? "completed" : words(s.status);
  const some = (value: unknown, what: string) => (isNumber(value) && value > 0 ? `${formatNumber(value)} ${what}` : "");
  const lines: [string, string][] = [
    ["Simulated", join(Number.isFinite(facts.end) ? instant(facts.end, 5) : "", ended)],
    ["Steps", join(`${isNumber(s.steps) ? `${formatNumber(s.steps)} ` : ""}of ${quantity(facts.step, "s")}`, some(s.repeated_steps, "repeated in smaller parts"), some(s.unconverged_steps, "accepted without convergence"))],
    ["Recorded", count(facts.instants, "instant")],
    ["Mechanism", join(count(facts.bodies, "body", "bodies"), facts.joints > 0 ? count(facts.joints, "joint") : "", count(s.coordinates, "coordinate"))],
    ["Method", join(words(s.formulation), words(s.formalism), words(s.integrator), isNumber(s.rho) ? `ρ∞ ${formatNumber(s.rho)}` : "")],
    ["Iterations", isNumber(s.iterations_per_step) ? `${formatNumber(s.iterations_per_step, 3)} per step` : ""],
    ["CPU time", isNumber(s.cpu_seconds) ? join(quantity(s.cpu_seconds, "s"), isNumber(s.real_time_factor) ? `${formatNumber(s.real_time_factor, 3)}× real time` : "") : ""],
    ["Position error of joints", violations([s.max_position_violation, "m"], [s.max_angle_violation, "rad"])],
    ["Velocity error of joints", violations([s.max_velocity_violation, "m/s"], [s.max_angular_velocity_violation, "rad/s"])],
    ["Energy at the end", energyLine(s.energy)],
    ["Neglected by linear theory", worstValidity(s.validity)],
    ["Warnings", Array.isArray(s.warnings) ? (s.warnings.length === 0 ? "none" : `${s.warnings.length}, above`) : ""],
  ];
  return lines.filter(([, value]) => value !== "").map(([label, value]) => ({ label, value }));
}
