// Fingers on the picture, as on maps: nobody who scrolls the page is caught in it.
import type { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

/**
 * One finger up or down scrolls the page, sideways it turns the picture; after a tap on the picture it turns it in every
 * direction, until something beside it is touched. Two fingers always move and zoom it.
 */
export function turnAfterTap(controls: OrbitControls): void {
  const canvas = controls.domElement as HTMLElement;
  const take = (all: boolean) => {
    canvas.style.touchAction = all ? "none" : "pan-y";
    canvas.classList.toggle("taken", all);
  };
  take(false);
  canvas.addEventListener("click", () => take(true));
  document.addEventListener("pointerdown", ({ target }) => target !== canvas && take(false));

  // A finger has turned the picture a little before the browser sees that it scrolls.
  const { object: camera, target } = controls;
  const offset = camera.position.clone();
  canvas.addEventListener("pointerdown", ({ isPrimary }) => isPrimary && offset.copy(camera.position).sub(target));
  canvas.addEventListener("pointercancel", ({ isPrimary }) => {
    if (!isPrimary) return;
    camera.position.copy(target).add(offset);
    controls.update();
  });
}
