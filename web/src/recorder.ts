// A film of the animation, made by the browser while it plays.

const kinds = ["video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm", "video/mp4"];

/** Why this browser cannot; "" where it can. */
export function noVideo(): string {
  if (typeof MediaRecorder === "undefined") return "This browser cannot record video (it has no MediaRecorder)";
  if (!("captureStream" in HTMLCanvasElement.prototype)) return "This browser cannot record a canvas";
  return kinds.some((kind) => MediaRecorder.isTypeSupported(kind)) ? "" : "This browser writes no kind of video";
}

export class Recorder {
  readonly canvas = document.createElement("canvas");
  private recorder: MediaRecorder;
  private parts: Blob[] = [];

  constructor(
    private source: HTMLCanvasElement,
    private finished: (film: Blob, ending: string) => void,
  ) {
    // Encoders want even numbers.
    this.canvas.width = 2 * Math.floor(source.width / 2);
    this.canvas.height = 2 * Math.floor(source.height / 2);
    const mimeType = kinds.find((kind) => MediaRecorder.isTypeSupported(kind))!;
    this.recorder = new MediaRecorder(this.canvas.captureStream(30), { mimeType, videoBitsPerSecond: 8e6 });
    this.recorder.addEventListener("dataavailable", ({ data }) => this.parts.push(data));
    this.recorder.addEventListener("stop", () => this.finished(new Blob(this.parts, { type: mimeType }), mimeType.startsWith("video/mp4") ? "mp4" : "webm"));
    this.recorder.start();
  }

  /** Takes the picture that has just been drawn, with a text in its corner. */
  add(text: string): void {
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

  stop(): void {
    if (this.recorder.state !== "inactive") this.recorder.stop();
  }
}
