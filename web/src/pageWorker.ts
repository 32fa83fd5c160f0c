// The worker of a page that simulates: the solver runs here, so that drawing never delays a step.
import type { Order } from "./liveProtocol";
import { PageSession, type SessionFacts } from "./pageSession";
import { Solver } from "./pageSolver";

/** The first message. */
export interface Beginning {
  wasm: ArrayBuffer;
  model: Uint8Array;
  facts: SessionFacts;
}

const post = (message: unknown, moved: Transferable[] = []) => (self as unknown as Worker).postMessage(message, moved);
const turnEvery = 2; // ms
let session: PageSession | null = null;

function start({ wasm, model, facts }: Beginning): void {
  const solver = Solver.open(wasm, model);
  const made = new PageSession(
    solver,
    facts,
    () => performance.now() / 1000,
    (message) => (message instanceof ArrayBuffer ? post(message, [message]) : post(JSON.stringify(message))),
  );
  session = made;
  const turn = () => {
    made.turn();
    setTimeout(turn, turnEvery);
  };
  turn();
}

self.onmessage = ({ data }: MessageEvent<string | Beginning | { driven: true }>) => {
  try {
    if (typeof data === "string") session?.hear(JSON.parse(data) as Order);
    else if ("driven" in data) post({ driven: session?.driven() ?? "{}" });
    else start(data);
  } catch (error) {
    post({ failed: error instanceof Error ? error.message : String(error) });
  }
};
