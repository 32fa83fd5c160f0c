// Sends inputs to the server: only changed values, at most once per frame of the screen.

export class InputSender {
  private wanted = new Map<string, number>();
  private sent = new Map<string, number>();
  private last = -Infinity; // when, s

  /** `send` returns false without a connection; `every`: s between two messages at least. */
  constructor(
    private send: (values: Record<string, number>) => boolean,
    private every = 1 / 60,
  ) {}

  set(name: string, value: number): void {
    if (Number.isFinite(value)) this.wanted.set(name, value);
  }

  /** The value of an input that is not yet sent. */
  pending(name: string): number | undefined {
    return this.wanted.get(name);
  }

  /** Others may have changed the inputs: the server's values are unknown. */
  forget(): void {
    this.wanted.clear();
    this.sent.clear();
  }

  flush(now: number, atOnce = false): void {
    for (const [name, value] of this.wanted) if (this.sent.get(name) === value) this.wanted.delete(name);
    // A hair earlier is not too often: screens tick as fast.
    if (this.wanted.size === 0 || (!atOnce && now - this.last < 0.9 * this.every)) return;
    if (!this.send(Object.fromEntries(this.wanted))) return;
    for (const [name, value] of this.wanted) this.sent.set(name, value);
    this.wanted.clear();
    this.last = now;
  }
}
