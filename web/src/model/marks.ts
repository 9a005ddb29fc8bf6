import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Line,
  LineBasicMaterial,
  LineLoop,
  Mesh,
  MeshBasicMaterial,
  SphereGeometry,
} from "three";
import type { Point } from "./measure";

const kDot_px = 5;

// The points and lines of measurements, drawn over the surface.
export class Marks {
  readonly group = new Group();
  readonly #dot = new SphereGeometry(1, 12, 8);
  readonly #dot_material = new MeshBasicMaterial({ color: 0xffb300, depthTest: false, transparent: true });
  readonly #line_material = new LineBasicMaterial({ color: 0xffb300, depthTest: false, transparent: true });
  #lines: BufferGeometry[] = [];

  constructor() {
    this.group.renderOrder = 10;
  }

  set(shapes: { points: readonly Point[]; closed: boolean }[]): void {
    this.#clear();
    for (const { points, closed } of shapes) {
      for (const point of points) {
        const dot = new Mesh(this.#dot, this.#dot_material);
        dot.position.set(...point);
        dot.renderOrder = 11;
        this.group.add(dot);
      }
      if (points.length < 2) continue;
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new Float32BufferAttribute(points.flat(), 3));
      this.#lines.push(geometry);
      const line = closed ? new LineLoop(geometry, this.#line_material) : new Line(geometry, this.#line_material);
      line.renderOrder = 10;
      this.group.add(line);
    }
  }

  // Keeps the dots equally large on the screen.
  set_size(metres_per_pixel: number): void {
    for (const object of this.group.children) {
      if (object instanceof Mesh) object.scale.setScalar(kDot_px * metres_per_pixel);
    }
  }

  dispose(): void {
    this.#clear();
    this.#dot.dispose();
    this.#dot_material.dispose();
    this.#line_material.dispose();
  }

  #clear(): void {
    this.group.clear();
    for (const geometry of this.#lines) geometry.dispose();
    this.#lines = [];
  }
}
