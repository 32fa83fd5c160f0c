// Steering and pedals for fingers, over the lower end of the screen. Who cannot see them has the sliders.
import { element } from "./dom";
import type { Driver, Lever, Role } from "./liveDrive";

const words: Record<Role, string> = { steering: "Steer", throttle: "Throttle", brake: "Brake", other: "" };

/** A place for one finger; `reading`: from where it is, in parts of the width and height from the left and the bottom. */
function pad(driver: Driver, lever: Lever, reading: (x: number, y: number) => number): HTMLElement {
  const knob = element("span", { class: "knob" });
  const root = element("div", { class: `pad ${lever.role}` }, knob, element("span", { class: "pad-name" }, words[lever.role]));
  const place = (value: number) => {
    if (lever.role === "steering") knob.style.left = `${50 - 42 * value}%`;
    else knob.style.height = `${100 * value}%`;
  };
  const move = (event: PointerEvent) => {
    const { left, bottom, width, height } = root.getBoundingClientRect();
    const value = reading((event.clientX - left) / width, (bottom - event.clientY) / height);
    driver.touch(lever, value);
    place(value);
  };
  const leave = () => {
    driver.touch(lever, null);
    place(0);
  };
  root.addEventListener("pointerdown", (event) => {
    root.setPointerCapture(event.pointerId);
    event.preventDefault();
    move(event);
  });
  root.addEventListener("pointermove", (event) => root.hasPointerCapture(event.pointerId) && move(event));
  for (const end of ["pointerup", "pointercancel"]) root.addEventListener(end, leave);
  place(0);
  return root;
}

const within = (value: number, low: number, high: number) => Math.min(Math.max(value, low), high);

/** null where there is nothing of a vehicle's to drive. */
export function touchPads(driver: Driver): HTMLElement | null {
  const of = (role: Role) => driver.levers.find((lever) => lever.role === role);
  const pedal = (_: number, y: number) => within((y - 0.1) / 0.8, 0, 1);
  const steer = (x: number) => within((0.5 - x) / 0.42, -1, 1);
  const [steering, brake, throttle] = [of("steering"), of("brake"), of("throttle")];
  const made = [
    ...(steering ? [pad(driver, steering, steer)] : []),
    ...(brake ? [pad(driver, brake, pedal)] : []),
    ...(throttle ? [pad(driver, throttle, pedal)] : []),
  ];
  return made.length > 0 ? element("div", { class: "pads", "aria-hidden": "true" }, ...made) : null;
}
