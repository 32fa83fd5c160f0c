// The surface of a body with the lines worth drawing on it; seen from both sides, so that shells are.
import * as THREE from "three";
import type { Body } from "./data";

/** Part of the light comes from the colour itself: one in the shade must still be found on the scale. */
function glow(material: THREE.MeshStandardMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <color_fragment>",
      "#include <color_fragment>\ntotalEmissiveRadiance += 0.35 * vColor;\ndiffuseColor.rgb *= 0.7;",
    );
  };
}

export class SurfaceView {
  readonly mesh: THREE.Mesh;
  readonly lines: THREE.LineSegments;
  private positions: THREE.BufferAttribute; // of both
  private colors?: THREE.BufferAttribute;

  constructor(body: Body, color: THREE.Color, flexible: boolean, line: THREE.LineBasicMaterial) {
    this.positions = new THREE.BufferAttribute(Float32Array.from(body.points), 3);
    if (flexible) this.positions.setUsage(THREE.DynamicDrawUsage);
    const geometry = new THREE.BufferGeometry().setAttribute("position", this.positions);
    geometry.setIndex(new THREE.BufferAttribute(body.triangles, 1));
    if (flexible) {
      this.colors = new THREE.BufferAttribute(new Float32Array(body.points.length), 3);
      geometry.setAttribute("color", this.colors);
    }
    const material = new THREE.MeshStandardMaterial({
      color: flexible ? "#ffffff" : color,
      vertexColors: flexible,
      side: THREE.DoubleSide,
      flatShading: true, // by the shader: no normals to be kept up with the deformation
      roughness: 0.6,
      metalness: 0.05,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    if (flexible) glow(material);
    this.mesh = new THREE.Mesh(geometry, material);
    const edges = new THREE.BufferGeometry().setAttribute("position", this.positions);
    edges.setIndex(new THREE.BufferAttribute(body.edges, 1));
    this.lines = new THREE.LineSegments(edges, line);
    // Their bounds change with every frame.
    this.mesh.frustumCulled = this.lines.frustumCulled = false;
    this.mesh.castShadow = true;
  }

  place(points: Float32Array): void {
    (this.positions.array as Float32Array).set(points);
    this.positions.needsUpdate = true;
  }

  paint(colorOf: (point: number) => THREE.Color): void {
    if (!this.colors) return;
    for (let k = 0; k < this.colors.count; ++k) colorOf(k).toArray(this.colors.array, 3 * k);
    this.colors.needsUpdate = true;
  }
}
