// The card that keeps what was driven and drives it again.
import { element } from "./dom";
import { fileName, save } from "./download";
import type { Input, Order, Picture } from "./liveProtocol";
import { mayDrive, type Situation } from "./liveSituation";
import { fitting, readTracks, Tape, toCsv, toJson, type Tracks } from "./liveTape";
import { instant } from "./summaryLines";

export class Tapes {
  readonly root: HTMLElement;
  private tape: Tape;
  private run = element("button", { "aria-pressed": "false" }, "Record inputs");
  private json = element("button", {}, "Save JSON");
  private csv = element("button", {}, "Save CSV");
  private again = element("button", { title: "Drive what was recorded once more, from the present state" }, "Play back");
  private open = element("button", {}, "Play a file…");
  private end = element("button", {}, "Stop playback");
  private file = element("input", { type: "file", accept: ".json,.csv,application/json,text/csv", class: "unseen", tabindex: -1, "aria-label": "File of recorded inputs" });
  private words = element("p", { class: "hint", role: "status" });
  private wrong = element("p", { class: "wrong", role: "alert" });
  private situation: Situation | null = null;

  constructor(
    private inputs: Input[],
    private order: (order: Order) => void,
  ) {
    this.tape = new Tape(inputs);
    this.run.addEventListener("click", () => this.toggle());
    this.json.addEventListener("click", () => save(fileName("inputs", "json"), new Blob([toJson(this.tape.recorded())], { type: "application/json" })));
    this.csv.addEventListener("click", () => {
      const units = new Map(inputs.map(({ name, unit }) => [name, unit]));
      save(fileName("inputs", "csv"), new Blob([toCsv(this.tape.recorded(), units)], { type: "text/csv" }));
    });
    this.again.addEventListener("click", () => this.play(() => this.tape.recorded()));
    this.open.addEventListener("click", () => this.file.click());
    this.end.addEventListener("click", () => order({ do: "play" }));
    this.file.addEventListener("change", async () => {
      const text = await this.file.files?.[0]?.text();
      this.file.value = ""; // the same one may be chosen again
      if (text !== undefined) this.play(() => readTracks(text, this.inputs));
    });
    this.root = element(
      "section",
      { class: "card tapes" },
      element("h2", {}, "Recorded inputs"),
      element("div", { class: "row" }, this.run, this.json, this.csv, this.again, this.open, this.end, this.file),
      this.words,
      this.wrong,
    );
    this.root.hidden = inputs.length === 0;
    this.refresh();
  }

  add({ time, inputs }: Picture): void {
    this.tape.add(time, inputs);
  }

  show(situation: Situation): void {
    this.situation = situation;
    this.refresh();
  }

  private toggle(): void {
    if (this.tape.running) this.tape.stop();
    else this.tape.start();
    this.refresh();
  }

  private play(tracks: () => Tracks): void {
    this.wrong.textContent = "";
    try {
      const { tracks: fitted, tolerance } = fitting(tracks());
      this.order({ do: "play", tracks: fitted });
      if (tolerance > 0) this.words.textContent = `Thinned to fit into one message: within ${100 * tolerance} % of what each input does.`;
    } catch (error) {
      this.wrong.textContent = `This cannot be played: ${error instanceof Error ? error.message : error}.`;
    }
  }

  private refresh(): void {
    const { running, length } = this.tape;
    const has = !running && Object.keys(this.tape.recorded()).length > 0;
    const free = this.situation !== null && mayDrive(this.situation);
    const played = this.situation?.played ?? false;
    this.run.setAttribute("aria-pressed", String(running));
    this.run.textContent = running ? "Stop" : "Record inputs";
    this.json.disabled = this.csv.disabled = !has;
    this.again.disabled = !has || !free || played;
    this.open.disabled = !free || played;
    this.end.hidden = !played;
    this.end.disabled = !free;
    this.words.textContent = played
      ? "Inputs are being played back."
      : running
        ? "Recording what every input does, whoever drives; a reset begins anew."
        : has
          ? `${instant(length)} recorded in this page.`
          : "Records in this page what every input does, to be saved and played again.";
  }
}
