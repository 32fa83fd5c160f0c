import { element } from "./dom";

/** A labelled slider over a factor from `low` to `high`, logarithmic; `text` formats the factor. */
export function factorSlider(
  label: string,
  low: number,
  high: number,
  start: number,
  changed: (factor: number) => void,
  text: (factor: number) => string = (factor) => `${factor}×`,
): HTMLElement {
  const ratio = high / low;
  const shown = element("output");
  const slider = element("input", { type: "range", min: 0, max: 1, step: 0.001, "aria-label": label });
  const update = () => {
    const rounded = Number((low * ratio ** Number(slider.value)).toPrecision(2));
    shown.textContent = text(rounded);
    slider.setAttribute("aria-valuetext", shown.textContent);
    changed(rounded);
  };
  slider.value = String(Math.log(start / low) / Math.log(ratio));
  slider.addEventListener("input", update);
  update();
  return element("label", { class: "factor" }, element("span", {}, label), slider, shown);
}

export function checkbox(label: string, on: boolean, changed: (on: boolean) => void): HTMLElement {
  const box = element("input", { type: "checkbox" });
  box.checked = on;
  box.addEventListener("change", () => changed(box.checked));
  changed(on);
  return element("label", {}, box, element("span", {}, label));
}

/** A labelled choice of one of several values. */
export function choice<T extends string>(label: string, options: { value: T; text: string }[], start: T, changed: (value: T) => void): HTMLElement {
  const select = element("select", { "aria-label": label }, ...options.map(({ value, text }) => element("option", { value }, text)));
  select.value = start;
  select.addEventListener("change", () => changed(select.value as T));
  changed(start);
  return element("label", {}, element("span", {}, label), select);
}
