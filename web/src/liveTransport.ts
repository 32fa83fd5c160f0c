// Pause, single steps, reset, snapshots, recording of the results.
import { element } from "./dom";
import type { Order } from "./liveProtocol";
import { mayDrive, type Situation } from "./liveSituation";

export class Transport {
  readonly root: HTMLElement;
  readonly time = element("span", { class: "time", role: "timer", "aria-label": "Time of the simulation" });
  private play = element("button", { class: "play" });
  private step = element("button", { title: "One step" }, "Step");
  private reset = element("button", { title: "Start again (R)" }, "Reset");
  private record = element("button", { class: "record", "aria-pressed": "false" }, "Record");
  private name = element("input", { type: "text", maxlength: 40, placeholder: "Name", "aria-label": "Name of the snapshot", autocomplete: "off", spellcheck: "false" });
  private save = element("button", { type: "submit", title: "Save the present state" }, "Snapshot");
  private list = element("select", { "aria-label": "Snapshot to restore" });
  private restore = element("button", { title: "Restore the selected snapshot" }, "Restore");
  private file = element("small", { class: "muted" });
  private counted = 0;
  private paused = false;

  constructor(
    private order: (order: Order) => void,
    private records: string | undefined,
  ) {
    this.play.addEventListener("click", () => this.toggle());
    this.step.addEventListener("click", () => order({ do: "step" }));
    this.reset.addEventListener("click", () => order({ do: "reset" }));
    this.record.addEventListener("click", () => order({ do: "record", on: this.record.getAttribute("aria-pressed") !== "true" }));
    this.restore.addEventListener("click", () => this.list.value !== "" && order({ do: "restore", name: this.list.value }));
    const snapshots = element("form", { class: "row snapshots" }, this.name, this.save, this.list, this.restore);
    snapshots.addEventListener("submit", (event) => {
      event.preventDefault();
      order({ do: "snapshot", name: this.name.value.trim() || `Snapshot ${++this.counted}` });
      this.name.value = "";
    });
    this.restore.type = "button";
    this.record.hidden = records === undefined;
    if (records !== undefined) this.record.title = `Record the channels to ${records} on the server's machine`;
    this.root = element("div", { class: "transport" }, element("div", { class: "row" }, this.play, this.step, this.reset, this.record, this.file, this.time), snapshots);
    this.offer([]);
  }

  toggle(): void {
    this.order({ do: this.paused ? "resume" : "pause" });
  }

  /** Names of the snapshots, newest last. */
  offer(names: string[]): void {
    const before = this.list.value;
    const added = names.length > this.list.options.length;
    this.list.replaceChildren(...[...names].reverse().map((name) => element("option", { value: name }, name)));
    if (names.length === 0) this.list.append(element("option", { value: "" }, "no snapshots"));
    if (!added && names.includes(before)) this.list.value = before;
  }

  show(situation: Situation): void {
    const { paused, recording, failed, ended } = situation;
    const free = mayDrive(situation);
    const stopped = failed || ended;
    this.paused = paused;
    this.play.textContent = paused ? "▶" : "❚❚";
    this.play.setAttribute("aria-label", paused ? "Resume" : "Pause");
    this.play.title = `${paused ? "Resume" : "Pause"} (P)`;
    this.play.disabled = !free || stopped;
    this.step.disabled = !free || stopped || !paused;
    for (const one of [this.reset, this.save, this.name, this.list, this.record]) one.disabled = !free;
    this.restore.disabled = !free || this.list.value === "";
    this.record.setAttribute("aria-pressed", String(recording));
    this.record.textContent = recording ? "Stop recording" : "Record";
    this.file.textContent = recording ? `to ${this.records ?? "a file"}` : "";
  }
}
