// The page of `mimbre page`: the live page, with the solver in a worker of its own in the place of a server.
import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./live.css";
import { element } from "./dom";
import type { Socket } from "./liveLink";
import { LivePage } from "./livePage";
import { decodeLiveScene, decodePicture, type Order, type PackedLiveScene, type Picture } from "./liveProtocol";
import type { Beginning } from "./pageWorker";

/** What the program puts into the page. */
interface Data {
  scene: PackedLiveScene;
  wasm: string; // base64 of gzip
  model: string; // likewise
}

declare global {
  interface Window {
    /** For programs that look on: all inputs since the start, the newest picture, and orders as to a server. */
    mimbrePage?: { driven: () => Promise<string>; newest: () => Picture | undefined; order: (order: Order) => void };
  }
}

const place = document.getElementById("page")!;

async function unpack(text: string): Promise<ArrayBuffer> {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** Looks like the connection to a server, and is one to the worker. */
class WorkerSocket implements Socket {
  onopen: ((event: Event) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  constructor(private worker: Worker) {
    setTimeout(() => this.onopen?.(new Event("open")));
  }
  send(text: string): void {
    this.worker.postMessage(text);
  }
  close(): void {
    this.worker.terminate();
  }
}

/** What a browser lacks that this page needs, in words; "" for none. */
function missing(): string {
  if (typeof WebAssembly === "undefined") return "WebAssembly, which may be switched off in its settings";
  if (typeof DecompressionStream === "undefined") return "DecompressionStream, which all have since 2023";
  // A function that makes a vector of one byte.
  const vectors = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];
  if (!WebAssembly.validate(new Uint8Array(vectors))) return "WebAssembly with vectors (SIMD), which all have since 2023";
  return "";
}

async function start(): Promise<void> {
  const lacking = missing();
  if (lacking !== "") throw new Error(`this browser lacks ${lacking}`);
  const data = JSON.parse(document.getElementById("data")!.textContent!) as Data;
  document.title = `${data.scene.title || "Untitled model"} – mimbre`;
  const code = document.getElementById("worker")!.textContent!;
  const worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  const [wasm, model] = await Promise.all([unpack(data.wasm), unpack(data.model)]);
  const { inputs, channels, shown, speed } = data.scene;
  const beginning: Beginning = { wasm, model: new Uint8Array(model), facts: { inputs, channels: channels.length, shown, speed } };

  const live = decodeLiveScene(data.scene);
  const waiting: ((text: string) => void)[] = [];
  const driven = () =>
    new Promise<string>((done) => {
      waiting.push(done);
      worker.postMessage({ driven: true });
    });
  let newest: Picture | undefined;
  let socket: WorkerSocket | null = null;
  const failed = (message: string) => place.prepend(element("p", { class: "warning", role: "alert" }, `The simulation has ended: ${message}`));
  worker.onerror = ({ message }) => failed(message);
  worker.onmessage = (event: MessageEvent<ArrayBuffer | string | { driven: string } | { failed: string }>) => {
    const { data: message } = event;
    if (message instanceof ArrayBuffer) newest = decodePicture(message, live.scene.bodies.length, live.scene.animation.amplitudes);
    if (typeof message === "string" || message instanceof ArrayBuffer) socket?.onmessage?.(event);
    else if ("driven" in message) waiting.shift()?.(message.driven);
    else failed(message.failed);
  };
  const open = () => {
    const made = new WorkerSocket(worker);
    // Begins when the page listens.
    setTimeout(() => worker.postMessage(beginning, [wasm]));
    socket = made;
    return made;
  };
  window.mimbrePage = { driven, newest: () => newest, order: (order) => worker.postMessage(JSON.stringify(order)) };
  place.append(...new LivePage(data.scene, live, async () => data.scene, driven, open, "page").parts);
}

start().catch((error: unknown) => {
  console.error(error);
  place.replaceChildren(element("p", { class: "warning", role: "alert" }, `The simulation cannot be shown: ${error instanceof Error ? error.message : error}`));
});
