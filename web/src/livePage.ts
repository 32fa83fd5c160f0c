// Assembles the live page: messages of the server go to the cards that show them, orders of the cards to the server.
import { element } from "./dom";
import { formatNumber } from "./format";
import { firstSelection } from "./groups";
import { Driver, type Pad } from "./liveDrive";
import { Inputs } from "./liveInputs";
import { LiveLink, type Socket } from "./liveLink";
import { Monitor } from "./liveMonitor";
import { touchPads } from "./livePads";
import { PictureBuffer } from "./livePictures";
import { decodePicture, mostChannels, sameModel, type LiveScene, type Order, type PackedLiveScene, type Picture, type Said } from "./liveProtocol";
import { InputSender } from "./liveSender";
import { announcement, atFirst, mayDrive, seenIn, stateWord, type Situation } from "./liveSituation";
import { StripRecord } from "./liveStrip";
import { Strips } from "./liveStrips";
import { RecordedInputs } from "./liveRecordedInputs";
import { Transport } from "./liveTransport";
import { LiveView } from "./liveView";

const seconds = () => performance.now() / 1000;

const chartsEvery = 0.045; // s: every third picture of a screen, all of a machine that draws slowly
const errorsStay = 8; // s
const patience = 5; // s, with what is to be done before something else

/** Whether a key already has a meaning where it is pressed: typing, choosing, pressing a button. */
function hasMeaning(target: Element, code: string): boolean {
  if (target.closest("select, textarea, input:not([type=range], [type=checkbox])")) return true;
  if (target.closest("input[type=range]")) return /^(Arrow|Home|End|Page)/.test(code);
  return (code === "Space" || code === "Enter") && target.closest("button, summary, input") !== null;
}

export class LivePage {
  readonly parts: HTMLElement[];
  private link: LiveLink;
  private situation = atFirst;
  private pictures = new PictureBuffer();
  private record = new StripRecord(10);
  private asked: number[] = []; // channels
  private driver: Driver;
  private sender = new InputSender((values) => this.link.send({ do: "inputs", values }));
  private view: LiveView;
  private transport: Transport;
  private inputs: Inputs;
  private strips: Strips;
  private monitor = new Monitor();
  private recordedInputs: RecordedInputs;
  private pads: HTMLElement | null;
  private places: Map<string, number>; // of channels, by name
  private begin: number; // of the simulation's time, s
  private state = element("span", { class: "pill" });
  private facts = element("span", { class: "muted" });
  private banner = element("p", { class: "banner", role: "alert", hidden: true });
  private wrong = element("p", { class: "banner", role: "alert", hidden: true });
  private asking = element("p", { class: "banner asking", hidden: true });
  private spoken = element("p", { class: "unseen", role: "status" });
  private viewers = 1;
  private retryAt = 0; // s
  private paces: { clock: number; time: number }[] = []; // of the last second
  private last = seconds(); // when the screen was last asked for a picture
  private written = seconds(); // when the charts were drawn
  private hiding = 0; // the timer that takes an error away

  constructor(
    private packed: PackedLiveScene,
    live: LiveScene,
    fetchScene: () => Promise<PackedLiveScene>,
    driven: () => Promise<string>,
    /** Connects to the server, or to the solver in the page. */
    open: () => Socket,
    at: "server" | "page" = "server",
  ) {
    const order = (one: Order) => this.order(one);
    this.places = new Map(live.channels.map(({ name }, k) => [name, k]));
    this.begin = live.scene.animation.time[0] ?? 0;
    this.driver = new Driver(live.inputs);
    this.view = new LiveView(live, () => this.ask());
    this.transport = new Transport(order, live.record);
    this.inputs = new Inputs(live.inputs, this.driver, (take) => this.requestControl(take), (name, value) => this.sender.set(name, value));
    this.strips = new Strips(live.channels, live.shown.length > 0 ? live.shown : firstSelection(live.channels), this.record, () => this.ask());
    this.recordedInputs = new RecordedInputs(live.inputs, order, driven, () => this.toStart(), at);
    this.pads = touchPads(this.driver);
    this.view.holder.after(this.transport.root);
    const model = element("details", { class: "card model" }, element("summary", {}, element("h2", {}, "Model")), element("pre", { tabindex: 0 }, live.model));
    const header = element("header", {}, element("h1", {}, live.title || "Untitled model"), element("div", { class: "row states" }, this.state, this.facts), this.banner, this.wrong, this.asking, this.spoken);
    const left = element("div", { class: "column" }, this.view.root, this.inputs.root);
    const right = element("div", { class: "column" }, this.strips.root, this.monitor.root, this.recordedInputs.root, model);
    this.parts = [header, element("main", {}, left, right), ...(this.pads ? [this.pads] : [])];
    this.listen();

    this.link = new LiveLink({
      open,
      picture: (message) => this.add(decodePicture(message, live.scene.bodies.length, live.scene.animation.amplitudes), live),
      said: (said) => this.hear(said),
      connected: () => {
        this.pictures.clear();
        this.sender.forget();
        this.become({ ...atFirst, connection: "open" });
      },
      lost: (ended, retry) => {
        this.retryAt = seconds() + retry;
        this.driver.letGo();
        this.become({ ...this.situation, connection: ended ? "ended" : "lost", control: false, taken: false, asked: false, asker: 0 });
      },
      again: async () => {
        const same = sameModel(this.packed, await fetchScene());
        if (!same) location.reload();
        return same;
      },
    });
    this.show();
    this.link.connect();
    this.draw();
    setInterval(() => this.showFacts(seconds()), 250);
  }

  private order(one: Order): void {
    this.link.send(one);
  }

  /** Takes or releases control; where another viewer has it, it is taken as soon as it is free. */
  private requestControl(take: boolean): void {
    const { control, taken } = this.situation;
    if (!control && taken) this.become({ ...this.situation, asked: take });
    if (control || take) this.order({ do: "control", take }); // the server informs the viewer in control of the request
  }

  private hear(said: Said): void {
    if (said.say === "hello") {
      this.record.choose(said.channels, 0);
      this.asked = said.channels;
      this.ask();
      this.become({ ...this.situation, control: said.control, taken: said.control });
    } else if (said.say === "status") {
      this.viewers = said.viewers;
      this.monitor.show(said);
      const message = said.message || (said.record_failure ?? "");
      if (message !== this.situation.message) this.become({ ...this.situation, message });
    } else if (said.say === "control") {
      const { asked } = this.situation;
      if (asked && !said.taken) this.order({ do: "control", take: true });
      this.become({ ...this.situation, control: said.yours, taken: said.taken, asked: asked && !said.yours, asker: 0 });
    } else if (said.say === "asked") this.become({ ...this.situation, asker: said.viewer });
    else if (said.say === "channels") this.record.choose(said.indices, said.choice);
    else if (said.say === "snapshots") {
      this.transport.offer(said.names);
      this.transport.show(this.situation);
    } else if (said.say === "recording") this.become({ ...this.situation, recording: said.on });
    else if (said.say === "played") this.become({ ...this.situation, played: said.on });
    else if (said.say === "error" && !this.situation.asked) this.showError(said.message); // while control is requested, another viewer may get it first
  }

  private add(picture: Picture, { inputs }: LiveScene): void {
    // Put back, with the inputs: what is held down meanwhile is to be sent again.
    if (picture.time < (this.pictures.newest?.time ?? 0)) {
      this.paces = [];
      this.sender.forget();
    }
    this.pictures.add(picture, seconds());
    this.record.add(picture);
    this.paces.push({ clock: picture.clock, time: picture.time });
    while (this.paces[0].clock < picture.clock - 1) this.paces.shift();
    if (picture.inputs.length === inputs.length) this.inputs.update(picture.inputs, seconds());
    this.become({ ...this.situation, ...seenIn(picture) });
  }

  /** Resets and pauses, so that playback begins with the first step. */
  private async toStart(): Promise<void> {
    this.order({ do: "pause" });
    this.order({ do: "reset" });
    const end = seconds() + patience;
    const there = () => {
      const { newest } = this.pictures;
      return newest !== undefined && newest.paused && newest.time <= this.begin;
    };
    while (!there()) {
      if (seconds() > end) throw new Error("the server does not reset");
      await new Promise((done) => setTimeout(done, 20));
    }
  }

  /** The channels that charts and arrows need; charts come first. */
  private ask(): void {
    if (this.situation.connection !== "open") return; // hello asks again
    const arrows = this.view.channels.map((name) => this.places.get(name)!);
    const indices = [...new Set([...this.strips.selected, ...arrows])].slice(0, mostChannels);
    if (indices.join() !== this.asked.join() && this.link.send({ do: "channels", indices })) this.asked = indices;
  }

  private become(now: Situation): void {
    const before = this.situation;
    if ((Object.keys(now) as (keyof Situation)[]).every((key) => now[key] === before[key])) return;
    this.situation = now;
    if (before.control !== now.control) {
      this.sender.forget();
      this.driver.letGo();
    }
    const said = announcement(before, now);
    if (said !== "") this.spoken.textContent = said;
    this.show();
  }

  private show(): void {
    const { situation } = this;
    const [word, kind] = stateWord(situation);
    this.state.textContent = word;
    this.state.className = `pill ${kind}`;
    for (const part of [this.transport, this.inputs, this.recordedInputs]) part.show(situation);
    if (this.pads) this.pads.hidden = !mayDrive(situation) || situation.played;
    document.body.classList.toggle("with-pads", this.pads !== null && !this.pads.hidden);
    this.warn();
  }

  /** Banners above everything, with their remedies. */
  private warn(): void {
    const { connection, failed, message, asker } = this.situation;
    const button = (text: string, pressed: () => void) => {
      const made = element("button", {}, text);
      made.addEventListener("click", pressed);
      return made;
    };
    const away = connection === "lost" || connection === "ended";
    this.banner.hidden = !away && !failed && message === "";
    if (away) this.banner.replaceChildren(connection === "ended" ? "The server has ended or cannot be reached. The page reconnects automatically. " : "The connection is lost. The page reconnects automatically. ", button("Try now", () => void this.link.retry()));
    else if (failed) this.banner.replaceChildren(`The simulation failed${message ? `: ${message}` : "."} `, ...(mayDrive(this.situation) ? [button("Reset", () => this.order({ do: "reset" }))] : ["The viewer in control can reset it."]));
    else this.banner.replaceChildren(message);
    this.asking.hidden = asker === 0;
    this.asking.replaceChildren(`Viewer ${asker} requests control. `, button("Hand over", () => this.requestControl(false)), button("Not now", () => this.become({ ...this.situation, asker: 0 })));
  }

  private showError(message: string): void {
    this.wrong.textContent = `Server: ${message}`;
    this.wrong.hidden = false;
    clearTimeout(this.hiding);
    this.hiding = window.setTimeout(() => (this.wrong.hidden = true), 1000 * errorsStay);
  }

  private listen(): void {
    document.addEventListener("keydown", (event) => this.key(event), true);
    document.addEventListener("keyup", ({ code }) => this.driver.release(code), true);
    const away = () => {
      for (const [name, value] of Object.entries(this.driver.letGo())) this.sender.set(name, value);
      if (mayDrive(this.situation)) this.sender.flush(seconds(), true);
    };
    addEventListener("blur", away);
    document.addEventListener("visibilitychange", () => document.hidden && away());
    // After a click with the mouse the keys drive, rather than press the button again.
    document.addEventListener("click", ({ target, detail }) => {
      const button = target instanceof Element ? target.closest("button") : null;
      if (detail > 0 && button && !button.closest(".keys, form, .strips, [role=tablist]")) {
        button.blur();
        this.view.view?.canvas.focus({ preventScroll: true });
      }
    });
  }

  private key(event: KeyboardEvent): void {
    const { target, code, repeat } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || !(target instanceof Element) || hasMeaning(target, code)) return;
    if (!mayDrive(this.situation) || target.closest(".waiting")) return;
    if (code === "KeyP" || code === "KeyR") {
      if (!repeat && code === "KeyP") this.transport.toggle();
      else if (!repeat) this.order({ do: "reset" });
    } else if (this.driver.takes(code) && !this.situation.played) this.driver.press(code);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  private drive(dt: number, now: number, present: Picture): void {
    const pad: Pad | null = navigator.getGamepads?.().find((one) => one?.connected) ?? null;
    this.inputs.offer(pad);
    if (!mayDrive(this.situation) || this.situation.played) return;
    const names = this.packed.inputs.map(({ name }) => name);
    const driven = this.driver.advance(dt, (name) => present.inputs[names.indexOf(name)], pad);
    for (const [name, value] of Object.entries(driven)) {
      this.sender.set(name, value);
      this.inputs.driven(name, value, now);
    }
    this.sender.flush(now);
  }

  private draw = (): void => {
    requestAnimationFrame(this.draw);
    const now = seconds();
    const dt = Math.min(now - this.last, 0.4); // pedals of a machine that draws slowly are as quick, but never jump
    this.last = now;
    const between = this.pictures.at(now);
    const { newest } = this.pictures;
    if (between && newest) {
      this.drive(dt, now, newest);
      this.view.show(between, (name, picture) => this.valueIn(picture, name), now);
      if (now - this.written >= chartsEvery) this.write(now, between.time, newest.deadline);
    }
  };

  /** Texts and charts, less often than the picture. */
  private write(now: number, time: number, deadline: number): void {
    this.strips.draw(now, time);
    this.monitor.tick(deadline, Math.min(now - this.written, 1));
    this.transport.time.textContent = `${time.toFixed(2)} s`;
    this.written = now;
  }

  private valueIn(picture: Picture, name: string): number | null {
    const place = this.record.place(this.places.get(name)!, picture);
    return place < 0 ? null : picture.channels[place];
  }

  private showFacts(now: number): void {
    const { connection } = this.situation;
    const [first, last] = [this.paces[0], this.paces[this.paces.length - 1]];
    const pace = last && last.clock - first.clock > 0.3 ? (last.time - first.time) / (last.clock - first.clock) : NaN;
    const words =
      connection === "open"
        ? [Number.isFinite(pace) ? `${formatNumber(Math.round(100 * pace) / 100)}× real time` : "", this.viewers > 1 ? `${this.viewers} viewers` : "1 viewer"]
        : connection === "first"
          ? []
          : [this.retryAt > now ? `next attempt in ${Math.ceil(this.retryAt - now)} s` : "connecting"];
    const text = words.filter((word) => word !== "").join(" · ");
    if (this.facts.textContent !== text) this.facts.textContent = text;
  }
}
