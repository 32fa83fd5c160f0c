// The card with the recorded inputs: saved to files, played back.
import { element } from "./dom";
import { fileName, save } from "./download";
import { longestOrder, type Input, type Order } from "./liveProtocol";
import { mayDrive, type Situation } from "./liveSituation";
import { duration, fromNow, readTracks, toCsv, type Tracks } from "./liveTracks";
import { instant } from "./summaryLines";

export class RecordedInputs {
  readonly root: HTMLElement;
  private again = element("button", { title: "Reset, then play back the inputs recorded since the last reset" }, "Play back");
  private open = element("button", {}, "Play a file…");
  private end = element("button", {}, "Stop playback");
  private fresh = element("input", { type: "checkbox" });
  private file = element("input", { type: "file", accept: ".json,.csv,application/json,text/csv", class: "unseen", tabindex: -1, "aria-label": "File of recorded inputs" });
  private words = element("p", { class: "hint", role: "status" });
  private wrong = element("p", { class: "wrong", role: "alert" });

  constructor(
    private inputs: Input[],
    private order: (order: Order) => void,
    /** The inputs since the last reset, as the server recorded them. */
    private driven: () => Promise<string>,
    /** Resets the simulation, and leaves it paused. */
    private reset: () => Promise<void>,
    at: "server" | "page" = "server",
  ) {
    const json = element("button", { title: "For this page" }, "Save JSON");
    const csv = element("button", { title: "All inputs or one of them; for this page, spreadsheets and mimbre run --input" }, "Save CSV");
    const which = element("select", { "aria-label": "Inputs in the CSV file" }, element("option", { value: "" }, "all inputs"), ...inputs.map(({ name }) => element("option", { value: name }, name)));
    json.addEventListener("click", () => this.attempt(async () => save(fileName("inputs", "json"), new Blob([await driven()], { type: "application/json" }))));
    csv.addEventListener("click", () => this.attempt(async () => this.saveCsv(which.value)));
    this.again.addEventListener("click", () => this.attempt(async () => this.play(await driven(), true)));
    this.open.addEventListener("click", () => this.file.click());
    this.end.addEventListener("click", () => order({ do: "play" }));
    this.file.addEventListener("change", () => {
      const [chosen] = this.file.files ?? [];
      if (chosen) void this.attempt(async () => this.play(await chosen.text(), this.fresh.checked));
      this.file.value = ""; // the same one may be chosen again
    });
    this.fresh.checked = true;
    this.root = element(
      "section",
      { class: "card recorded-inputs" },
      element("h2", {}, "Recorded inputs"),
      element("p", { class: "hint" }, `The ${at} records all inputs since the last reset. Playing them back reproduces the motion.`),
      element("div", { class: "row" }, json, csv, which),
      element("div", { class: "row" }, this.again, this.open, this.end, this.file, element("label", {}, this.fresh, element("span", {}, " reset first"))),
      this.words,
      this.wrong,
    );
    this.root.hidden = inputs.length === 0;
  }

  show(situation: Situation): void {
    const free = mayDrive(situation);
    const { played } = situation;
    this.again.disabled = this.open.disabled = this.fresh.disabled = !free || played;
    this.end.hidden = !played;
    this.end.disabled = !free;
    if (!played) this.words.textContent = "";
    else if (this.words.textContent === "") this.words.textContent = "Playing back inputs.";
  }

  private async saveCsv(name: string): Promise<void> {
    const tracks = readTracks(await this.driven(), this.inputs);
    const chosen = name === "" ? tracks : { [name]: tracks[name] ?? { times: [], values: [] } };
    const units = new Map(this.inputs.map(({ name, unit }) => [name, unit]));
    save(fileName(name === "" ? "inputs" : name.replace(/[^\p{L}\p{N}]+/gu, "-"), "csv"), new Blob([toCsv(chosen, units)], { type: "text/csv" }));
  }

  private async play(text: string, reset: boolean): Promise<void> {
    const read = readTracks(text, this.inputs);
    const tracks: Tracks = reset ? read : fromNow(read);
    const order: Order = { do: "play", tracks };
    if (JSON.stringify(order).length > longestOrder) throw new Error("the recording is too long for the server");
    if (reset) await this.reset();
    this.order(order);
    if (reset) this.order({ do: "resume" });
    this.words.textContent = `Playing back ${instant(duration(tracks))} of inputs.`;
  }

  private async attempt(action: () => Promise<void>): Promise<void> {
    this.wrong.textContent = "";
    try {
      await action();
    } catch (error) {
      this.wrong.textContent = `This did not work: ${error instanceof Error ? error.message : error}.`;
    }
  }
}
