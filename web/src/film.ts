// Films of the animation: picture by picture at a fixed rate where the browser encodes video (WebCodecs), however long each
// takes to draw; else recorded while it plays (MediaRecorder), as smooth as the machine is fast.
import { webm, type Film, type Picture } from "./webm";

export const picturesPerSecond = 30;
const bitsPerSecond = 8e6;
const keyEvery = 60; // pictures: two seconds, between which players jump

const codecs: [name: string, id: Film["codec"]][] = [
  ["vp09.00.51.08", "V_VP9"],
  ["vp8", "V_VP8"],
  ["av01.0.12M.08", "V_AV1"],
];
const recorded = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** How a film is made of pictures of this size. */
export type Way = { kind: "pictures"; config: VideoEncoderConfig; codec: Film["codec"] } | { kind: "recording"; type: string } | { kind: "none"; reason: string };

/** Encoders want even numbers. */
export const even = (pixels: number) => 2 * Math.max(1, Math.floor(pixels / 2));

export async function bestWay(width: number, height: number): Promise<Way> {
  if (typeof VideoEncoder !== "undefined")
    for (const [codec, id] of codecs) {
      const config: VideoEncoderConfig = { codec, width, height, bitrate: bitsPerSecond, framerate: picturesPerSecond, latencyMode: "quality" };
      const known = await VideoEncoder.isConfigSupported(config).catch(() => null);
      if (known?.supported) return { kind: "pictures", config, codec: id };
    }
  if (typeof MediaRecorder === "undefined") return { kind: "none", reason: "This browser cannot make a film: it has neither WebCodecs nor MediaRecorder" };
  if (!("captureStream" in HTMLCanvasElement.prototype)) return { kind: "none", reason: "This browser cannot record a canvas" };
  const type = recorded.find((kind) => MediaRecorder.isTypeSupported(kind));
  return type ? { kind: "recording", type } : { kind: "none", reason: "This browser supports no video format" };
}

/** Instants of the pictures of a film: equal steps of `speed` per picture, the end included. */
export function filmTimes(start: number, end: number, speed: number): number[] {
  const steps = Math.max(Math.ceil(((end - start) / speed) * picturesPerSecond - 1e-6), 0);
  return Array.from({ length: steps + 1 }, (_, k) => Math.min(start + (k * speed) / picturesPerSecond, end));
}

/** The view with a text in its corner, of even size. */
export class Stage {
  readonly canvas = document.createElement("canvas");

  constructor(private source: HTMLCanvasElement) {
    this.canvas.width = even(source.width);
    this.canvas.height = even(source.height);
  }

  draw(text: string): void {
    const context = this.canvas.getContext("2d")!;
    context.drawImage(this.source, 0, 0);
    const size = Math.max(14, Math.round(this.canvas.height / 28));
    context.font = `600 ${size}px system-ui, sans-serif`;
    context.lineWidth = size / 5;
    context.lineJoin = "round";
    context.strokeStyle = "#ffffffcc";
    context.fillStyle = "#1c2430";
    context.strokeText(text, size, 1.6 * size);
    context.fillText(text, size, 1.6 * size);
  }
}

/** Encodes `count` pictures; `draw` draws the k-th and returns its canvas, or null to end. Throws the encoder's error. */
export async function encoded(way: Way & { kind: "pictures" }, count: number, draw: (k: number) => HTMLCanvasElement | null): Promise<Blob> {
  const pictures: Picture[] = [];
  let wrong: unknown = null;
  const encoder = new VideoEncoder({
    output: (chunk) => {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      pictures.push({ time: chunk.timestamp, key: chunk.type === "key", data });
    },
    error: (error) => (wrong = error),
  });
  const microseconds = (k: number) => Math.round((1e6 * k) / picturesPerSecond);
  try {
    encoder.configure(way.config);
    for (let k = 0; k < count && wrong === null; ++k) {
      const canvas = draw(k);
      if (!canvas) break;
      const frame = new VideoFrame(canvas, { timestamp: microseconds(k), duration: microseconds(1) });
      encoder.encode(frame, { keyFrame: k % keyEvery === 0 });
      frame.close();
      // The page stays alive, and the encoder's queue short.
      do await new Promise((done) => setTimeout(done, 0));
      while (encoder.encodeQueueSize > 4 && wrong === null);
    }
    if (wrong === null) await encoder.flush();
  } catch (error) {
    wrong ??= error;
  }
  if (encoder.state !== "closed") encoder.close();
  if (wrong !== null) throw wrong;
  const { width, height } = way.config;
  return new Blob([webm({ codec: way.codec, width, height, pictures, last: microseconds(1) })], { type: "video/webm" });
}

/** Records a canvas until it is stopped. */
export class Recording {
  private recorder: MediaRecorder;
  private parts: Blob[] = [];

  constructor(way: Way & { kind: "recording" }, canvas: HTMLCanvasElement, finished: (film: Blob) => void) {
    this.recorder = new MediaRecorder(canvas.captureStream(picturesPerSecond), { mimeType: way.type, videoBitsPerSecond: bitsPerSecond });
    this.recorder.addEventListener("dataavailable", ({ data }) => this.parts.push(data));
    this.recorder.addEventListener("stop", () => finished(new Blob(this.parts, { type: way.type })));
    this.recorder.start();
  }

  stop(): void {
    if (this.recorder.state !== "inactive") this.recorder.stop();
  }
}
