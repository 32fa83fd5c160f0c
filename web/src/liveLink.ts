// The connection to the server, which reconnects automatically.
import type { Order, Said } from "./liveProtocol";

/** What of a WebSocket is used. */
export interface Socket {
  onopen: ((event: Event) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  send(text: string): void;
  close(): void;
}

export interface LinkOptions {
  open: () => Socket;
  picture: (message: ArrayBuffer) => void;
  said: (said: Said) => void;
  connected: () => void;
  /** `ended`: the server went away, or nobody is there; `retry`: s until the next attempt. */
  lost: (ended: boolean, retry: number) => void;
  /** Before another attempt: false where this page cannot continue with the server. */
  again: () => Promise<boolean>;
  /** To be replaced in tests. */
  after?: (seconds: number, call: () => void) => unknown;
}

const goingAway = [1000, 1001, 1012];

/** s before an attempt; the first is number 0. */
export const patience = (attempt: number) => Math.min(0.5 * 2 ** attempt, 8);

export class LiveLink {
  private socket: Socket | null = null;
  private isOpen = false;
  private attempt = 0;
  private waiting = 0; // numbers the attempts that are waited for: of an older one nothing comes
  private after: (seconds: number, call: () => void) => unknown;

  constructor(private options: LinkOptions) {
    this.after = options.after ?? ((seconds, call) => setTimeout(call, 1000 * seconds));
  }

  get connected(): boolean {
    return this.isOpen;
  }

  connect(): void {
    const { options } = this;
    const socket = options.open();
    this.socket = socket;
    socket.onopen = () => {
      this.isOpen = true;
      this.attempt = 0;
      options.connected();
    };
    socket.onmessage = ({ data }) => {
      if (data instanceof ArrayBuffer) options.picture(data);
      else options.said(JSON.parse(data as string) as Said);
    };
    socket.onclose = ({ code }) => {
      this.isOpen = false;
      this.socket = null;
      this.wait(goingAway.includes(code));
    };
  }

  /** False where nobody listens. */
  send(order: Order): boolean {
    if (this.isOpen) this.socket!.send(JSON.stringify(order));
    return this.isOpen;
  }

  /** At once, rather than after the time that is left. */
  async retry(): Promise<void> {
    if (this.socket) return;
    const mine = ++this.waiting;
    const mayGoOn = await this.options.again().catch(() => null);
    if (mine !== this.waiting || this.socket || mayGoOn === false) return;
    if (mayGoOn) this.connect();
    else this.wait(true);
  }

  private wait(ended: boolean): void {
    const seconds = patience(this.attempt++);
    const mine = ++this.waiting;
    this.options.lost(ended, seconds);
    this.after(seconds, () => mine === this.waiting && void this.retry());
  }
}
