import type { Artifact, Job } from "../api/types";
import type { Point } from "./measure";
import type { Measurements } from "./measurements.svelte";
import { parse_model, read_with_progress } from "./load_model";
import { values_group } from "./load_values";
import { place_in } from "./path_marks";
import { quantiles, sigma_near, type VertexValues } from "./ply";
import { address_in, artifact_named, errors_of, json_of, poses_of, text_of, type Keyframe, type Keyframes, type Metrics } from "./result_files";
import { type ColorMode, type Section, Viewer } from "./viewer";
import { fragment_of, view_in } from "./view_link";

const kPicturesOfPoint = 6;
const kReachOfSigma_m = 0.1;
const kSmallPly_bytes = 80e6;

export interface PlaceInPicture {
  keyframe: Keyframe;
  index: number;
  x: number;
  y: number;
}

// The model of one job as the page shows it: loads the files, and holds what the panels show.
export class ModelScene {
  viewer = $state.raw<Viewer>();
  loaded = $state(false);
  no_webgl = $state(false);
  fraction = $state(0);
  problem = $state.raw<unknown>();
  frame = $state(0);
  metres_per_pixel = $state(0.01);
  up = $state.raw<[number, number]>([0, -1]);
  color = $state<ColorMode>("photo");
  range = $state.raw<[number, number]>([0, 1]);
  values_fraction = $state(-1);
  section = $state<Section>({ axis: "none", share: 1 });
  show_path = $state(true);
  show_cameras = $state(true);
  keyframes = $state.raw<Keyframes>();
  keyframe = $state<number>();
  seen_in = $state.raw<PlaceInPicture[]>([]);
  looked_up = $state.raw<Point>();
  num_triangles = $state(0);
  #abort = new AbortController();
  #values: VertexValues | undefined;

  constructor(
    readonly job: Job,
    readonly artifacts: Artifact[],
    readonly measurements: Measurements,
  ) {}

  async open(canvas: HTMLCanvasElement): Promise<void> {
    const mesh = artifact_named(this.artifacts, "mesh.glb");
    if (!mesh) return;
    this.problem = undefined;
    if (!this.viewer) {
      try {
        this.viewer = new Viewer(canvas, () => this.#drawn(), () => this.#moved());
      } catch {
        this.no_webgl = true;
        return;
      }
    }
    const viewer = this.viewer;
    window.addEventListener("hashchange", this.#follow_address);
    try {
      const bytes = await read_with_progress(address_in(this.job, mesh), mesh.size_bytes, (share) => (this.fraction = share), this.#abort.signal);
      const model = await parse_model(bytes);
      if (this.#abort.signal.aborted) return;
      viewer.set_model(model);
      this.num_triangles = viewer.num_triangles;
      this.#open_view(viewer);
      this.loaded = true;
      await this.#load_path(viewer);
    } catch (thrown) {
      if (!this.#abort.signal.aborted) this.problem = thrown;
    }
  }

  // Shows the view of the address, as when another link is pasted into it.
  #follow_address = (): void => {
    if (this.viewer && this.loaded) this.#open_view(this.viewer);
  };

  close(): void {
    window.removeEventListener("hashchange", this.#follow_address);
    this.#abort.abort();
    this.viewer?.dispose();
    this.viewer = undefined;
  }

  async set_color(mode: ColorMode): Promise<void> {
    const viewer = this.viewer;
    if (!viewer) return;
    if ((mode === "sigma" || mode === "observations") && !viewer.has_values) {
      try {
        await this.#load_values(viewer);
      } catch (thrown) {
        if (!this.#abort.signal.aborted) this.problem = thrown;
        return;
      }
    }
    this.color = mode;
    this.range = this.#range_of(mode, viewer);
    viewer.set_color(mode, ...this.range);
    this.#moved();
  }

  set_section(section: Section): void {
    this.section = section;
    this.viewer?.set_section(section);
  }

  show(path: boolean, cameras: boolean): void {
    this.show_path = path;
    this.show_cameras = cameras;
    if (!this.viewer) return;
    this.viewer.path.path.visible = path;
    this.viewer.path.cameras.visible = cameras;
    this.viewer.draw();
  }

  // A tap sets a point while something is measured, and otherwise chooses a keyframe or a point to look up.
  tapped(x: number, y: number): void {
    const viewer = this.viewer;
    if (!viewer) return;
    if (this.measurements.tool !== "orbit") {
      const point = viewer.pick(x, y);
      if (point) this.measurements.add_point(point);
      return;
    }
    const keyframe = viewer.pick_keyframe(x, y);
    this.choose_keyframe(keyframe);
    const point = keyframe === undefined ? viewer.pick(x, y) : undefined;
    this.seen_in = point ? this.#pictures_of(point, viewer) : [];
    this.looked_up = this.seen_in.length > 0 ? point : undefined;
    if (this.seen_in[0]) this.choose_keyframe(this.seen_in[0].index, true);
  }

  choose_keyframe(index: number | undefined, keeps_point = false): void {
    this.keyframe = index;
    if (!keeps_point) {
      this.seen_in = [];
      this.looked_up = undefined;
    }
    this.viewer?.path.select(index);
    this.viewer?.draw();
  }

  look_from_keyframe(): void {
    const keyframe = this.keyframes?.keyframes[this.keyframe ?? -1];
    if (!keyframe || !this.viewer) return;
    const [w, x, y, z] = keyframe.orientation_wxyz;
    const forward: Point = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
    const eye = keyframe.position_m;
    this.viewer.set_pose({ position: eye, target: [eye[0] + forward[0], eye[1] + forward[1], eye[2] + forward[2]] });
  }

  turn_about(x: number, y: number): void {
    const point = this.viewer?.pick(x, y);
    if (point) this.viewer?.turn_about(point);
  }

  come_nearer(factor: number): void {
    if (!this.viewer) return;
    const { position, target } = this.viewer.pose();
    const moved = position.map((value, axis) => (target[axis] as number) + factor * (value - (target[axis] as number)));
    this.viewer.set_pose({ position: moved as unknown as Point, target });
  }

  // Moves the camera about the point that it looks at, by an arrow key.
  turn(key: string): void {
    if (!this.viewer) return;
    const { position, target } = this.viewer.pose();
    const [x, y, z] = position.map((value, axis) => value - (target[axis] as number)) as [number, number, number];
    const range = Math.hypot(x, y, z);
    const around = Math.atan2(y, x) + (key === "ArrowLeft" ? -0.1 : key === "ArrowRight" ? 0.1 : 0);
    const above = Math.asin(z / range) + (key === "ArrowUp" ? 0.1 : key === "ArrowDown" ? -0.1 : 0);
    const limited = Math.min(1.55, Math.max(-1.55, above));
    const flat = range * Math.cos(limited);
    const turned = [flat * Math.cos(around), flat * Math.sin(around), range * Math.sin(limited)];
    this.viewer.set_pose({ position: turned.map((value, axis) => value + (target[axis] as number)) as unknown as Point, target });
  }

  #open_view(viewer: Viewer): void {
    const { pose, color } = view_in(window.location.hash);
    if (pose) viewer.set_pose(pose);
    else viewer.look("whole");
    if (color !== this.color) void this.set_color(color);
  }

  async #load_path(viewer: Viewer): Promise<void> {
    const [path, keyframes, metrics] = await Promise.all([
      text_of(this.job, this.artifacts, "trajectory.tum"),
      json_of<Keyframes>(this.job, this.artifacts, "keyframes.json"),
      json_of<Metrics>(this.job, this.artifacts, "metrics.json"),
    ]);
    if (this.#abort.signal.aborted) return;
    this.measurements.set_errors(errors_of(metrics));
    if (path) viewer.path.set_path(poses_of(path));
    if (keyframes) viewer.path.set_keyframes(keyframes, Math.min(0.3, viewer.size() / 30));
    this.keyframes = keyframes;
    viewer.draw();
  }

  // Loads the sigma of each place of the surface for what is measured, unless the file is large.
  async want_sigma(): Promise<void> {
    const ply = artifact_named(this.artifacts, "mesh.ply");
    if (!this.viewer || !ply || this.#values || this.values_fraction >= 0 || ply.size_bytes > kSmallPly_bytes) return;
    await this.#load_values(this.viewer).catch(() => undefined);
  }

  async #load_values(viewer: Viewer): Promise<void> {
    const ply = artifact_named(this.artifacts, "mesh.ply");
    if (!ply) return;
    this.values_fraction = 0;
    try {
      const bytes = await read_with_progress(address_in(this.job, ply), ply.size_bytes, (share) => (this.values_fraction = share), this.#abort.signal);
      const { group, values } = await values_group(bytes);
      this.#values = values;
      viewer.set_values(group);
      const { sigma_at, scale_sigma } = this.measurements.errors;
      this.measurements.set_errors({ sigma_at: (point) => sigma_near(values, point, kReachOfSigma_m) ?? sigma_at(point), scale_sigma });
    } finally {
      this.values_fraction = -1;
    }
  }

  #range_of(mode: ColorMode, viewer: Viewer): [number, number] {
    if (mode === "height") return [viewer.box.min.z, viewer.box.max.z];
    const values = mode === "sigma" ? this.#values?.sigma : mode === "observations" ? this.#values?.observations : undefined;
    if (!values) return [0, 1];
    const [low = 0, high = 1] = quantiles(values, [0.02, 0.95]);
    return [low, high];
  }

  // Returns the keyframes that see a point, those that have it nearest to their middle first.
  #pictures_of(point: Point, viewer: Viewer): PlaceInPicture[] {
    const keyframes = this.keyframes;
    if (!keyframes) return [];
    return keyframes.keyframes
      .flatMap((keyframe, index) => {
        const place = keyframe.picture ? place_in(keyframe, keyframes, point) : undefined;
        if (!place || !viewer.sees(keyframe.position_m, point)) return [];
        return [{ keyframe, index, x: place[0], y: place[1] }];
      })
      .sort((a, b) => Math.hypot(a.x - 0.5, a.y - 0.5) - Math.hypot(b.x - 0.5, b.y - 0.5))
      .slice(0, kPicturesOfPoint);
  }

  #drawn(): void {
    if (!this.viewer) return;
    this.frame += 1;
    this.metres_per_pixel = this.viewer.metres_per_pixel();
    this.up = this.viewer.up_on_screen();
  }

  #moved(): void {
    if (!this.viewer || !this.loaded) return;
    window.history.replaceState(null, "", fragment_of(this.viewer.pose(), this.color));
  }
}
