// Formulas over channels: `tip.z - 2*arm.z`. A recursive-descent parser that knows numbers, channels and a list of
// functions, and nothing else; a formula is never run as code.
//
//   sum     = product { (+|-) product }
//   product = power { (*|/) power }
//   power   = (-|+) power | value [ ^ power ]
//   value   = number | pi | name | `name` | function ( sum {, sum} ) | ( sum )

export type Values = (number | null)[];

/** What a formula is computed over. */
export interface Source {
  time: ArrayLike<number>;
  /** null where there is no such channel. */
  channel: (name: string) => { values: Values; unit: string } | null;
}

interface Result {
  values: Values;
  unit: string; // "" : unknown or none
  plain: boolean; // a number without unit
}

const functions: Record<string, { arguments: number; of: (...x: number[]) => number; keeps?: boolean; to?: string }> = {
  abs: { arguments: 1, of: Math.abs, keeps: true },
  sqrt: { arguments: 1, of: Math.sqrt },
  exp: { arguments: 1, of: Math.exp },
  ln: { arguments: 1, of: Math.log },
  log10: { arguments: 1, of: Math.log10 },
  sin: { arguments: 1, of: Math.sin },
  cos: { arguments: 1, of: Math.cos },
  tan: { arguments: 1, of: Math.tan },
  asin: { arguments: 1, of: Math.asin, to: "rad" },
  acos: { arguments: 1, of: Math.acos, to: "rad" },
  atan: { arguments: 1, of: Math.atan, to: "rad" },
  atan2: { arguments: 2, of: Math.atan2, to: "rad" },
  min: { arguments: 2, of: Math.min, keeps: true },
  max: { arguments: 2, of: Math.max, keeps: true },
  hypot: { arguments: 2, of: Math.hypot, keeps: true },
};

const overTime = ["ddt", "int"];

/** d/dt by central differences, at the ends and beside gaps by one-sided ones. */
export function derivative(time: ArrayLike<number>, values: Values): Values {
  return values.map((value, i) => {
    if (value === null) return null;
    const a = i > 0 && values[i - 1] !== null ? i - 1 : i;
    const b = i + 1 < values.length && values[i + 1] !== null ? i + 1 : i;
    return time[b] > time[a] ? (values[b]! - values[a]!) / (time[b] - time[a]) : null;
  });
}

/** ∫ from the first instant, by the trapezoidal rule; a gap adds nothing. */
export function integral(time: ArrayLike<number>, values: Values): Values {
  let sum = 0;
  return values.map((value, i) => {
    const before = i > 0 ? values[i - 1] : null;
    if (value !== null && before !== null) sum += ((time[i] - time[i - 1]) * (value + before)) / 2;
    return value === null ? null : sum;
  });
}

const most = 1000; // characters of a formula, and so of its depth

/** Throws an Error that describes the mistake in the formula, with its place. */
export function evaluate(text: string, source: Source): { values: Values; unit: string } {
  if (text.length > most) throw new Error(`a formula has at most ${most} characters`);
  return new Parser(text, source).all();
}

class Parser {
  private at = 0;

  constructor(
    private text: string,
    private source: Source,
  ) {}

  all(): { values: Values; unit: string } {
    const { values, unit } = this.sum();
    if (this.peek() !== "") this.fail(`'${this.peek()}' is not expected`);
    return { values, unit };
  }

  private fail(what: string): never {
    throw new Error(`${what} (character ${this.at + 1})`);
  }

  private peek(): string {
    while (/\s/.test(this.text[this.at] ?? "")) ++this.at;
    return this.text[this.at] ?? "";
  }

  private take(wanted: string): boolean {
    if (this.peek() !== wanted) return false;
    ++this.at;
    return true;
  }

  private expect(wanted: string): void {
    if (!this.take(wanted)) this.fail(`'${wanted}' is missing`);
  }

  private match(pattern: RegExp): string | null {
    this.peek();
    const found = pattern.exec(this.text.slice(this.at));
    if (!found) return null;
    this.at += found[0].length;
    return found[0];
  }

  private sum(): Result {
    let left = this.product();
    for (;;) {
      if (this.take("+")) left = same(left, this.product(), (a, b) => a + b);
      else if (this.take("-") || this.take("−")) left = same(left, this.product(), (a, b) => a - b);
      else return left;
    }
  }

  private product(): Result {
    let left = this.power();
    for (;;) {
      if (this.take("*") || this.take("·")) {
        const right = this.power();
        left = { ...combine(left, right, (a, b) => a * b), unit: left.plain ? right.unit : right.plain ? left.unit : "", plain: left.plain && right.plain };
      } else if (this.take("/")) {
        const right = this.power();
        const unit = right.plain ? left.unit : left.unit !== "" && left.unit === right.unit ? "1" : "";
        left = { ...combine(left, right, (a, b) => a / b), unit, plain: left.plain && right.plain };
      } else return left;
    }
  }

  private power(): Result {
    if (this.take("-") || this.take("−")) {
      const of = this.power();
      return { ...of, values: of.values.map((value) => (value === null ? null : -value)) };
    }
    if (this.take("+")) return this.power();
    const base = this.value();
    if (!this.take("^")) return base;
    const exponent = this.power();
    return { ...combine(base, exponent, (a, b) => a ** b), unit: "", plain: base.plain && exponent.plain };
  }

  private value(): Result {
    if (this.take("(")) {
      const inner = this.sum();
      this.expect(")");
      return inner;
    }
    const number = this.match(/^(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?/);
    if (number !== null) return this.constant(Number(number));
    const quoted = this.match(/^`[^`]*`/);
    if (quoted !== null) return this.channel(quoted.slice(1, -1));
    const name = this.match(/^[\p{L}_][\p{L}\p{N}_.]*/u);
    if (name === null) return this.fail(this.peek() === "" ? "a value is missing at the end" : `'${this.peek()}' is not expected`);
    if (this.peek() === "(") return this.call(name);
    if (name === "pi") return this.constant(Math.PI);
    if (name === "t" && !this.source.channel("t")) return { values: Array.from(this.source.time), unit: "s", plain: false };
    return this.channel(name);
  }

  private constant(value: number): Result {
    return { values: new Array(this.source.time.length).fill(value), unit: "", plain: true };
  }

  private channel(name: string): Result {
    const found = this.source.channel(name);
    if (!found) return this.fail(`there is no channel '${name}'`);
    return { ...found, plain: found.unit === "1" };
  }

  private call(name: string): Result {
    const known = Object.prototype.hasOwnProperty.call(functions, name) ? functions[name] : null;
    if (!known && !overTime.includes(name)) this.fail(`there is no function '${name}'; there are ${[...Object.keys(functions), ...overTime].join(", ")}`);
    this.expect("(");
    const given = [this.sum()];
    while (this.take(",")) given.push(this.sum());
    this.expect(")");
    const wanted = known?.arguments ?? 1;
    if (given.length !== wanted) this.fail(`'${name}' takes ${wanted} ${wanted === 1 ? "value" : "values"}, not ${given.length}`);
    const [x, y] = given;
    if (!known) {
      const values = (name === "ddt" ? derivative : integral)(this.source.time, x.values);
      const units: Record<string, string> = name === "ddt" ? { m: "m/s", "m/s": "m/s²", rad: "rad/s", J: "W" } : { "m/s²": "m/s", "m/s": "m", "rad/s": "rad", W: "J" };
      return { values, unit: units[x.unit] ?? "", plain: false };
    }
    const values = y ? combine(x, y, known.of).values : x.values.map((value) => finite(value === null ? null : known.of(value)));
    const kept = known.keeps && (!y || x.unit === y.unit) ? x.unit : "";
    return { values, unit: known.to ?? kept, plain: x.plain && (y?.plain ?? true) };
  }
}

const finite = (value: number | null) => (value !== null && Number.isFinite(value) ? value : null);

function combine(a: Result, b: Result, of: (x: number, y: number) => number): { values: Values } {
  return { values: a.values.map((x, i) => (x === null || b.values[i] === null ? null : finite(of(x, b.values[i]!)))) };
}

/** A sum keeps the unit that both have; a plain number takes the other's. */
function same(a: Result, b: Result, of: (x: number, y: number) => number): Result {
  const unit = a.unit === b.unit || b.plain ? a.unit : a.plain ? b.unit : "";
  return { ...combine(a, b, of), unit, plain: a.plain && b.plain };
}
