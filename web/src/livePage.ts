// The parts of the live page put together: what the server says goes to those that show it, what they want to the server.
import { element } from "./dom";
import { LiveLink, type Socket } from "./liveLink";
import { PictureBuffer } from "./livePictures";
import { decodePicture, protocol, sameModel, type LiveScene, type PackedLiveScene, type Picture, type Said } from "./liveProtocol";
import { LiveView } from "./liveView";

const seconds = () => performance.now() / 1000;

export class LivePage {
  readonly parts: HTMLElement[];
  private link: LiveLink;
  private pictures = new PictureBuffer();
  private view: LiveView;

  constructor(
    private packed: PackedLiveScene,
    live: LiveScene,
    fetchScene: () => Promise<PackedLiveScene>,
    address: URL,
  ) {
    this.view = new LiveView(live, () => {});
    this.parts = [element("header", {}, element("h1", {}, live.title || "Untitled model")), element("main", {}, this.view.root)];
    address.protocol = address.protocol.replace("http", "ws");
    this.link = new LiveLink({
      open: () => {
        const socket = new WebSocket(address, protocol);
        socket.binaryType = "arraybuffer";
        return socket as Socket;
      },
      picture: (message) => this.add(decodePicture(message, live.scene.bodies.length, live.scene.animation.amplitudes)),
      said: (said) => this.hear(said),
      connected: () => this.pictures.clear(),
      lost: () => {},
      again: async () => {
        const same = sameModel(this.packed, await fetchScene());
        if (!same) location.reload();
        return same;
      },
    });
    this.link.connect();
    this.draw();
  }

  private hear(said: Said): void {
    if (said.say === "error") console.warn(said.message);
  }

  private add(picture: Picture): void {
    this.pictures.add(picture, seconds());
  }

  private draw = (): void => {
    requestAnimationFrame(this.draw);
    const now = seconds();
    const between = this.pictures.at(now);
    if (between) this.view.show(between, () => null, now);
  };
}
