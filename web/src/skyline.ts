// Normal equations of a sparse least-squares problem, in skyline storage: of each row what lies between its first
// non-zero and the diagonal. Bodies numbered along a tree of joints leave little of it.

export class SkylineMatrix {
  private first: Int32Array;
  private rows: Float64Array[];
  private right: Float64Array;

  /** `groups`: first unknowns of the blocks of six that an equation couples. */
  constructor(size: number, groups: number[][]) {
    this.first = Int32Array.from({ length: size }, (_, i) => 6 * Math.floor(i / 6));
    for (const group of groups) {
      const lowest = Math.min(...group);
      for (const at of group) for (let i = at; i < at + 6; ++i) this.first[i] = Math.min(this.first[i], lowest);
    }
    this.rows = Array.from(this.first, (start, i) => new Float64Array(i - start + 1));
    this.right = new Float64Array(size);
  }

  /** The equation Σ factor·x = value, each [unknown, factor] once. */
  add(equation: [number, number][], value: number): void {
    for (const [i, a] of equation) {
      this.right[i] += a * value;
      for (const [j, b] of equation) if (j <= i) this.rows[i][j - this.first[i]] += a * b;
    }
  }

  /** By Cholesky factors; unknowns without an equation stay zero. Overwrites the matrix. */
  solve(): Float64Array {
    const { rows, first } = this;
    const size = rows.length;
    const x = this.right;
    const floor = 1e-12 * Math.max(...rows.map((row) => row[row.length - 1]), 1e-300);
    for (let i = 0; i < size; ++i) {
      const row = rows[i];
      for (let j = first[i]; j <= i; ++j) {
        let sum = row[j - first[i]];
        for (let k = Math.max(first[i], first[j]); k < j; ++k) sum -= row[k - first[i]] * rows[j][k - first[j]];
        if (j < i) row[j - first[i]] = sum / rows[j][j - first[j]];
        else row[j - first[i]] = sum > floor ? Math.sqrt(sum) : Infinity;
      }
      let sum = x[i];
      for (let k = first[i]; k < i; ++k) sum -= row[k - first[i]] * x[k];
      x[i] = sum / row[i - first[i]];
    }
    for (let i = size - 1; i >= 0; --i) {
      const row = rows[i];
      x[i] /= row[i - first[i]];
      for (let k = first[i]; k < i; ++k) x[k] -= row[k - first[i]] * x[i];
    }
    return x;
  }
}
