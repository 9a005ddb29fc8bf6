import {
  Box3,
  Color,
  type Group,
  type Material,
  Mesh,
  PerspectiveCamera,
  Plane,
  Raycaster,
  Scene,
  SRGBColorSpace,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Point } from "./measure";
import { dispose_of, index_for_picking } from "./load_model";
import { value_material } from "./materials";
import { Marks } from "./marks";
import { PathMarks } from "./path_marks";

export const kFieldOfView_deg = 50;
export type ColorMode = "photo" | "height" | "plain" | "sigma" | "observations";
export type Section = { axis: "none" | "x" | "y" | "z"; share: number };
export type Side = "whole" | "top" | "side" | "front";

export interface CameraPose {
  position: Point;
  target: Point;
}

export interface Screen {
  x: number;
  y: number;
  visible: boolean;
}

// The 3D scene of one model: world frame, metres, z up. It draws when something has changed, and
// frees the graphics memory when it is disposed of.
export class Viewer {
  readonly marks = new Marks();
  readonly path = new PathMarks();
  readonly box = new Box3();
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera(kFieldOfView_deg, 1, 0.01, 1000);
  readonly #controls: OrbitControls;
  readonly #plane = new Plane(new Vector3(0, 0, -1), 0);
  readonly #resize: ResizeObserver;
  #model: Group | undefined;
  #values: Group | undefined;
  #photos = new Map<Mesh, Material | Material[]>();
  #scheduled = 0;
  num_triangles = 0;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly on_frame: () => void,
    readonly on_moved: () => void,
  ) {
    this.#renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: false });
    this.#renderer.outputColorSpace = SRGBColorSpace;
    this.#renderer.localClippingEnabled = true;
    this.#camera.up.set(0, 0, 1);
    this.#scene.add(this.marks.group, this.path.group);
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.enableDamping = false;
    this.#controls.screenSpacePanning = true;
    this.#controls.zoomToCursor = true;
    this.#controls.listenToKeyEvents(canvas);
    this.#controls.addEventListener("change", () => this.draw());
    this.#controls.addEventListener("end", () => this.on_moved());
    this.#resize = new ResizeObserver(() => this.#fit_canvas());
    this.#resize.observe(canvas.parentElement ?? canvas);
    this.#fit_canvas();
  }

  dispose(): void {
    cancelAnimationFrame(this.#scheduled);
    this.#resize.disconnect();
    this.#controls.dispose();
    this.marks.dispose();
    this.path.dispose();
    if (this.#model) dispose_of(this.#model);
    if (this.#values) dispose_of(this.#values);
    this.#renderer.dispose();
    this.#renderer.forceContextLoss();
  }

  set_model(model: Group): void {
    this.#model = model;
    this.#scene.add(model);
    this.box.setFromObject(model);
    model.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      this.#photos.set(object, object.material as Material | Material[]);
      this.num_triangles += (object.geometry.index?.count ?? object.geometry.attributes.position.count) / 3;
      const map = (object.material as { map?: { anisotropy: number } }).map;
      if (map) map.anisotropy = Math.min(8, this.#renderer.capabilities.getMaxAnisotropy());
    });
    index_for_picking(model);
    const size = this.size();
    this.#camera.near = size / 2000;
    this.#camera.far = size * 50;
    this.#controls.minDistance = size / 500;
    this.#controls.maxDistance = size * 10;
    this.draw();
  }

  // The surface with a value at each vertex (mesh.ply), which is shown instead of the photos.
  set_values(values: Group): void {
    this.#values = values;
    values.visible = false;
    this.#scene.add(values);
  }

  get has_values(): boolean {
    return this.#values !== undefined;
  }

  size(): number {
    return this.box.isEmpty() ? 1 : this.box.getSize(new Vector3()).length();
  }

  set_color(mode: ColorMode, low: number, high: number): void {
    const by_vertex = mode === "sigma" || mode === "observations";
    if (this.#model) this.#model.visible = !by_vertex;
    if (this.#values) this.#values.visible = by_vertex;
    for (const [mesh, photo] of this.#photos) {
      if (mesh.material !== photo) (mesh.material as Material).dispose();
      mesh.material = mode === "photo" ? photo : value_material(mode === "height" ? "height" : "none");
      this.#limit(mesh, low, high);
    }
    this.#values?.traverse((object) => {
      if (!(object instanceof Mesh) || !by_vertex) return;
      (object.material as Material).dispose();
      object.geometry.setAttribute("shade", object.geometry.getAttribute(mode));
      object.material = value_material("shade");
      this.#limit(object, low, high);
    });
    this.#apply_clipping();
    this.draw();
  }

  set_section(section: Section): void {
    const axis = { none: 2, x: 0, y: 1, z: 2 }[section.axis];
    this.#plane.normal.set(0, 0, 0).setComponent(axis, -1);
    const low = this.box.min.getComponent(axis);
    const high = this.box.max.getComponent(axis);
    this.#plane.constant = section.axis === "none" ? Infinity : low + section.share * (high - low) + 1e-6;
    this.#apply_clipping(section.axis !== "none");
    this.draw();
  }

  look(side: Side): void {
    const centre = this.box.getCenter(new Vector3());
    const direction = { whole: [0.45, -0.75, 0.75], top: [0, -0.0001, 1], side: [0, -1, 0.02], front: [1, 0, 0.02] }[side];
    const half = kFieldOfView_deg * (Math.PI / 360);
    const narrow = Math.min(1, this.#camera.aspect);
    const away = (0.5 * this.size()) / Math.tan(half) / narrow;
    const position = new Vector3(...(direction as [number, number, number])).normalize().multiplyScalar(away * (side === "whole" ? 0.78 : 1)).add(centre);
    this.set_pose({ position: position.toArray() as unknown as Point, target: centre.toArray() as unknown as Point });
  }

  pose(): CameraPose {
    return {
      position: this.#camera.position.toArray() as unknown as Point,
      target: this.#controls.target.toArray() as unknown as Point,
    };
  }

  set_pose({ position, target }: CameraPose): void {
    this.#camera.position.set(...position);
    this.#controls.target.set(...target);
    this.#controls.update();
    this.draw();
    this.on_moved();
  }

  turn_about(target: Point): void {
    this.set_pose({ position: this.pose().position, target });
  }

  // Returns the point of the surface under a place of the canvas, in its CSS pixels.
  pick(x: number, y: number): Point | undefined {
    const raycaster = this.#ray(x, y);
    if (!this.#model) return undefined;
    const hits = raycaster.intersectObject(this.#model, true);
    const hit = hits.find(({ point }) => !this.#clips || this.#plane.distanceToPoint(point) >= 0);
    return hit ? (hit.point.toArray() as unknown as Point) : undefined;
  }

  pick_keyframe(x: number, y: number): number | undefined {
    const index = this.path.pick(this.#ray(x, y));
    return index;
  }

  // Returns whether nothing lies between a point and an eye, but for a margin before the point.
  sees(eye: Point, point: Point): boolean {
    if (!this.#model) return false;
    const from = new Vector3(...eye);
    const toward = new Vector3(...point).sub(from);
    const range = toward.length();
    const raycaster = new Raycaster(from, toward.normalize(), 0, range - 0.02 - 0.02 * range);
    raycaster.firstHitOnly = true;
    return raycaster.intersectObject(this.#model, true).length === 0;
  }

  // Returns where a point of the world is on the canvas, in CSS pixels.
  screen_of(point: Point): Screen {
    const projected = new Vector3(...point).project(this.#camera);
    const { clientWidth, clientHeight } = this.canvas;
    return {
      x: ((projected.x + 1) / 2) * clientWidth,
      y: ((1 - projected.y) / 2) * clientHeight,
      visible: projected.z < 1 && Math.abs(projected.x) <= 1.1 && Math.abs(projected.y) <= 1.1,
    };
  }

  // Returns the length of one CSS pixel at the point that the camera turns about, m.
  metres_per_pixel(): number {
    const range = this.#camera.position.distanceTo(this.#controls.target);
    return (2 * range * Math.tan((kFieldOfView_deg * Math.PI) / 360)) / Math.max(1, this.canvas.clientHeight);
  }

  // Returns the direction of the world's up on the screen, x right, y down, at most 1 long.
  up_on_screen(): [number, number] {
    const up = new Vector3(0, 0, 1).applyQuaternion(this.#camera.quaternion.clone().invert());
    return [up.x, -up.y];
  }

  set_ground(color: string): void {
    this.#scene.background = new Color(color);
    this.draw();
  }

  async picture(): Promise<Blob | null> {
    this.#render();
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }

  draw(): void {
    if (this.#scheduled) return;
    this.#scheduled = requestAnimationFrame(() => {
      this.#scheduled = 0;
      this.#render();
    });
  }

  #render(): void {
    this.marks.set_size(this.metres_per_pixel());
    this.#renderer.render(this.#scene, this.#camera);
    this.on_frame();
  }

  #clips = false;
  #apply_clipping(clips = this.#clips): void {
    this.#clips = clips;
    const planes = clips ? [this.#plane] : null;
    for (const group of [this.#model, this.#values]) {
      group?.traverse((object) => {
        if (!(object instanceof Mesh)) return;
        for (const material of [object.material].flat() as Material[]) {
          material.clippingPlanes = planes;
          material.needsUpdate = true;
        }
      });
    }
  }

  #limit(mesh: Mesh, low: number, high: number): void {
    const uniforms = (mesh.material as { uniforms?: Record<string, { value: unknown }> }).uniforms;
    if (!uniforms?.low || !uniforms.high) return;
    uniforms.low.value = low;
    uniforms.high.value = high;
  }

  #ray(x: number, y: number): Raycaster {
    const place = new Vector2((x / this.canvas.clientWidth) * 2 - 1, 1 - (y / this.canvas.clientHeight) * 2);
    const raycaster = new Raycaster();
    raycaster.setFromCamera(place, this.#camera);
    return raycaster;
  }

  #fit_canvas(): void {
    const frame = this.canvas.parentElement;
    if (!frame || frame.clientWidth === 0) return;
    this.#renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.#renderer.setSize(frame.clientWidth, frame.clientHeight, false);
    this.#camera.aspect = frame.clientWidth / frame.clientHeight;
    this.#camera.updateProjectionMatrix();
    this.draw();
  }
}
