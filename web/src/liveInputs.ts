// The card from which the simulation is driven: who has control, and every input with its slider, number and keys.
import { element } from "./dom";
import { formatNumber } from "./format";
import { unitLabel } from "./groups";
import { leverOf, sourcesOf, type Driver, type Lever, type Pad } from "./liveDrive";
import type { Input } from "./liveProtocol";
import { controlWords, mayDrive, type Situation } from "./liveSituation";

const keyNames: Record<string, string> = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" };

export const keyName = (code: string) => keyNames[code] ?? code.replace(/^(Key|Digit)/, "").replace(/^Numpad/, "Num ");

/** Keys that mean something else on this page. */
const reserved = ["KeyR", "KeyP", "Tab", "Escape", "Enter"];

interface Row {
  root: HTMLElement;
  show: (value: number) => void;
}

export class Inputs {
  readonly root: HTMLElement;
  private words = element("p", { class: "control-words" });
  private take = element("button", { class: "take" });
  private driving = element("fieldset", { class: "inputs" }, element("legend", { class: "unseen" }, "Inputs"));
  private tuning = element("fieldset", { class: "inputs" }, element("legend", { class: "unseen" }, "Parameters of the model"));
  private rows: Row[];
  private situation: Situation | null = null;
  private touched = new Map<number, number>(); // when this viewer last set an input, s
  private hint = element("p", { class: "hint" });
  private sources: HTMLSelectElement[] = [];
  private offered = ""; // sources that are in the lists
  private keyLabels: (() => void)[] = []; // write each input's keys

  constructor(
    private inputs: Input[],
    private driver: Driver,
    /** Requests control, or releases it. */
    ask: (take: boolean) => void,
    private set: (name: string, value: number) => void,
  ) {
    this.take.addEventListener("click", () => ask(!this.situation?.control && !this.situation?.asked));
    this.rows = inputs.map((input, k) => this.row(input, k));
    const fold = element("details", { class: "all" }, element("summary", {}, `Parameters (${inputs.filter(({ tunable }) => tunable).length})`), this.tuning);
    fold.hidden = !inputs.some(({ tunable }) => tunable);
    this.driving.hidden = !inputs.some(({ tunable }) => !tunable);
    this.root = element("section", { class: "card driving" }, element("div", { class: "row heading" }, element("h2", {}, "Control"), this.take), this.words, this.driving, this.hint, fold);
    this.writeHint();
  }

  /** What the server has; not where this viewer is just setting something else. */
  update(values: ArrayLike<number>, now: number): void {
    this.rows.forEach(({ show }, k) => now - (this.touched.get(k) ?? -Infinity) > 0.4 && show(values[k]));
  }

  /** By keys, a gamepad or a finger. */
  driven(name: string, value: number, now: number): void {
    const k = this.inputs.findIndex((input) => input.name === name);
    this.touched.set(k, now);
    this.rows[k].show(value);
  }

  show(situation: Situation): void {
    this.situation = situation;
    const { connection, control, taken, asked } = situation;
    this.words.textContent = controlWords(situation);
    this.take.textContent = control ? "Release control" : asked ? "Cancel request" : taken ? "Request control" : "Take control";
    this.take.classList.toggle("primary", !control && !asked);
    this.take.disabled = connection !== "open";
    this.driving.disabled = this.tuning.disabled = !mayDrive(situation) || situation.played;
  }

  /** The pad that is there has these. */
  offer(pad: Pad | null): void {
    const all = pad ? sourcesOf(pad) : [];
    const key = all.join();
    if (key === this.offered) return;
    this.offered = key;
    this.sources.forEach((select, k) => {
      const { source } = this.driver.levers[k];
      const names = [...new Set(["", ...all, source])];
      select.replaceChildren(...names.map((name) => element("option", { value: name }, name === "" ? "none" : name)));
      select.value = source;
    });
  }

  private row(input: Input, k: number): Row {
    const { name, unit, about = "", tunable, min, max } = input;
    const lever = this.driver.levers.find((one) => one.name === name) ?? leverOf(input);
    const id = `input${k}`;
    const slider = element("input", { type: "range", id, min: lever.low, max: lever.high, step: "any" });
    if (lever.role === "steering") slider.dir = "rtl"; // to the left is left
    const number = element("input", { type: "number", step: "any", "aria-label": `${name}, as a number`, ...(min === undefined ? {} : { min }), ...(max === undefined ? {} : { max }) });
    const label = unit === "" || unit === "1" ? "" : unitLabel(unit);
    let typing = false;
    const show = (value: number) => {
      slider.value = String(value);
      slider.setAttribute("aria-valuetext", `${formatNumber(value, 4)} ${label}`.trim());
      if (!typing) number.value = String(Number(value.toPrecision(5)));
    };
    const set = (value: number) => {
      if (!Number.isFinite(value)) return;
      const within = Math.min(Math.max(value, min ?? -Infinity), max ?? Infinity);
      this.touched.set(k, performance.now() / 1000);
      this.driver.leave(name);
      show(within);
      this.set(name, within);
    };
    slider.addEventListener("input", () => set(Number(slider.value)));
    number.addEventListener("input", () => (typing = true));
    number.addEventListener("blur", () => (typing = false));
    number.addEventListener("change", () => {
      typing = false;
      if (number.value !== "") set(Number(number.value));
    });
    show(input.value);
    const parts: (Node | string)[] = [element("label", { for: id, title: about }, name, element("small", { class: "muted" }, about)), slider, number, element("span", { class: "unit muted" }, label)];
    if (!tunable) parts.push(this.keys(lever, slider));
    const root = element("div", { class: "input" }, ...parts);
    (tunable ? this.tuning : this.driving).append(root);
    return { root, show };
  }

  /** What drives it, behind a fold. */
  private keys(lever: Lever, slider: HTMLInputElement): HTMLElement {
    const title = element("summary", { "aria-label": `Keys of ${lever.name}` });
    const writeKeys = () => {
      const names = (codes: string[]) => (codes.length > 0 ? codes.map(keyName).join(" ") : "");
      title.replaceChildren(...[names(lever.plus), names(lever.minus)].filter((text) => text !== "").map((text) => element("kbd", {}, text)));
      if (lever.plus.length + lever.minus.length === 0) title.textContent = "keys";
      this.writeHint();
    };
    const bind = (text: string, side: "plus" | "minus") => {
      const button = element("button", { type: "button" }, text);
      const wait = (on: boolean) => {
        button.textContent = on ? "press a key" : text;
        button.classList.toggle("waiting", on);
      };
      button.addEventListener("click", () => wait(true));
      button.addEventListener("blur", () => wait(false));
      button.addEventListener("keydown", (event) => {
        if (!button.classList.contains("waiting") || event.code === "Tab") return;
        event.preventDefault();
        event.stopPropagation();
        wait(false);
        if (reserved.includes(event.code)) return;
        for (const other of this.driver.levers) {
          other.plus = other.plus.filter((code) => code !== event.code);
          other.minus = other.minus.filter((code) => code !== event.code);
        }
        lever[side] = [event.code];
        for (const write of this.keyLabels) write();
      });
      return button;
    };
    const none = element("button", { type: "button" }, "No keys");
    none.addEventListener("click", () => {
      [lever.plus, lever.minus] = [[], []];
      writeKeys();
    });
    const source = element("select", { "aria-label": `Gamepad control for ${lever.name}` });
    source.append(element("option", { value: lever.source }, lever.source || "none"));
    source.addEventListener("change", () => (lever.source = source.value));
    this.sources.push(source);
    const back = element("input", { type: "checkbox" });
    back.checked = lever.returns;
    back.addEventListener("change", () => (lever.returns = back.checked));
    const turned = element("input", { type: "checkbox" });
    turned.addEventListener("change", () => {
      [lever.plus, lever.minus] = [lever.minus, lever.plus];
      slider.dir = slider.dir === "rtl" ? "ltr" : "rtl";
      lever.source = lever.source.endsWith(" reversed") ? lever.source.slice(0, -9) : lever.source.startsWith("axis") ? `${lever.source} reversed` : lever.source;
      this.offered = "-"; // the lists follow
      writeKeys();
    });
    this.keyLabels.push(writeKeys);
    writeKeys();
    const box = (input: HTMLInputElement, text: string) => element("label", {}, input, element("span", {}, text));
    return element(
      "details",
      { class: "keys" },
      title,
      element("div", { class: "settings" }, bind("Key to increase", "plus"), bind("Key to decrease", "minus"), none, element("label", {}, element("span", {}, "Gamepad"), source), box(back, "returns to its start"), ...(lever.role === "steering" ? [box(turned, "reversed")] : [])),
    );
  }

  private writeHint(): void {
    const driven = this.driver.levers.some(({ plus }) => plus.length > 0);
    const how = this.driver.levers.length === 0 ? "" : driven ? "Drive with the keys above or a gamepad · " : "Keys and gamepads can be assigned to the inputs above · ";
    this.hint.replaceChildren(how, element("kbd", {}, "P"), " pause · ", element("kbd", {}, "R"), " reset");
  }
}
