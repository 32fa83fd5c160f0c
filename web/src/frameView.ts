// A frame on a body: its axes, red x, green y, blue z, with its name.
import * as THREE from "three";
import { combined, type Frame } from "./modesData";

/** The name as a picture that always faces the viewer; `height` in metres. */
function label(text: string, height: number): THREE.Sprite {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  const font = "600 44px system-ui, sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 16;
  canvas.height = 60;
  context.font = font;
  context.lineWidth = 8;
  context.lineJoin = "round";
  context.strokeStyle = "#ffffff";
  context.fillStyle = "#1c2430";
  context.textBaseline = "middle";
  context.strokeText(text, 8, 30);
  context.fillText(text, 8, 30);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map, depthTest: false, depthWrite: false, fog: false, toneMapped: false }));
  sprite.scale.set((height * canvas.width) / canvas.height, height, 1);
  sprite.renderOrder = 3;
  return sprite;
}

export class FrameView {
  readonly group = new THREE.Group();
  private rest = new THREE.Quaternion();
  private turn = new THREE.Quaternion();

  constructor(
    private frame: Frame,
    size: number,
  ) {
    const [a, b, c, d, e, f, g, h, i] = frame.rotation;
    this.rest.setFromRotationMatrix(new THREE.Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1));
    const axes = new THREE.AxesHelper(size);
    axes.setColors("#d11", "#1a8a1a", "#22d");
    // In front of the surface that they are in.
    Object.assign(axes.material, { depthTest: false, fog: false });
    axes.renderOrder = 2;
    const name = label(frame.name, 0.45 * size);
    name.position.set(0, 0, 0.35 * size);
    this.group.add(axes, name);
    this.update([], 0);
  }

  update(amplitudes: ArrayLike<number>, exaggeration: number): void {
    const { position, shapes, turns } = this.frame;
    const moved = exaggeration === 0 ? [0, 0, 0] : combined(shapes, amplitudes);
    const [x, y, z] = position.map((value, k) => value + exaggeration * moved[k]);
    this.group.position.set(x, y, z);
    const axis = new THREE.Vector3(...(exaggeration === 0 ? [0, 0, 0] : combined(turns, amplitudes)));
    const angle = exaggeration * axis.length();
    this.turn.setFromAxisAngle(axis.normalize(), angle);
    this.group.quaternion.multiplyQuaternions(this.turn, this.rest);
  }
}
