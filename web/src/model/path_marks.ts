import {
  BufferGeometry,
  Float32BufferAttribute,
  Group,
  Line,
  LineBasicMaterial,
  LineSegments,
  Quaternion,
  type Raycaster,
  Vector3,
} from "three";
import type { Keyframe, Keyframes, Pose } from "./result_files";

const kLargestGap = 3;

// The path of the sensor and the frusta of its keyframes.
export class PathMarks {
  readonly group = new Group();
  readonly path = new Group();
  readonly cameras = new Group();
  readonly #materials = [
    new LineBasicMaterial({ color: 0xff5d3a }),
    new LineBasicMaterial({ color: 0x36c5d8 }),
    new LineBasicMaterial({ color: 0xffd54a }),
  ] as const;
  #geometries: BufferGeometry[] = [];
  #keyframes: Keyframe[] = [];
  #depth_m = 0.1;

  constructor() {
    this.group.add(this.path, this.cameras);
  }

  // Draws the path; a gap in time is no line.
  set_path(poses: Pose[]): void {
    const steps = poses.slice(1).map((pose, index) => pose.time_s - (poses[index] as Pose).time_s);
    const usual = [...steps].sort((a, b) => a - b)[Math.floor(steps.length / 2)] ?? 0;
    let run: Pose[] = [];
    poses.forEach((pose, index) => {
      if (index > 0 && (steps[index - 1] as number) > kLargestGap * usual) {
        this.#add_line(run);
        run = [];
      }
      run.push(pose);
    });
    this.#add_line(run);
  }

  set_keyframes(keyframes: Keyframes, depth_m: number): void {
    this.#keyframes = keyframes.keyframes;
    this.#depth_m = depth_m;
    for (const keyframe of keyframes.keyframes) {
      const geometry = frustum(keyframe, keyframes, depth_m);
      this.#geometries.push(geometry);
      this.cameras.add(new LineSegments(geometry, this.#materials[1]));
    }
  }

  select(index: number | undefined): void {
    this.cameras.children.forEach((child, place) => {
      (child as LineSegments).material = place === index ? this.#materials[2] : this.#materials[1];
    });
  }

  // Returns the keyframe nearest to a ray, if the ray passes by its frustum.
  pick(raycaster: Raycaster): number | undefined {
    if (!this.cameras.visible) return undefined;
    let nearest: number | undefined;
    let least = this.#depth_m * 0.6;
    this.#keyframes.forEach((keyframe, index) => {
      const distance = raycaster.ray.distanceToPoint(centre_of(keyframe, this.#depth_m));
      if (distance >= least) return;
      least = distance;
      nearest = index;
    });
    return nearest;
  }

  dispose(): void {
    for (const geometry of this.#geometries) geometry.dispose();
    for (const material of this.#materials) material.dispose();
  }

  #add_line(run: Pose[]): void {
    if (run.length < 2) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(run.flatMap(({ position }) => [...position]), 3));
    this.#geometries.push(geometry);
    this.path.add(new Line(geometry, this.#materials[0]));
  }
}

export function rotation_of(keyframe: Keyframe): Quaternion {
  const [w, x, y, z] = keyframe.orientation_wxyz;
  return new Quaternion(x, y, z, w);
}

function centre_of(keyframe: Keyframe, depth_m: number): Vector3 {
  return new Vector3(0, 0, 0.6 * depth_m).applyQuaternion(rotation_of(keyframe)).add(new Vector3(...keyframe.position_m));
}

function frustum(keyframe: Keyframe, { focal_px, image_size_px, principal_point_px }: Keyframes, depth_m: number): BufferGeometry {
  const [width, height] = image_size_px;
  const [cx, cy] = principal_point_px ?? [width / 2, height / 2];
  const corner = (x: number, y: number): Vector3 =>
    new Vector3(((x - cx) / focal_px) * depth_m, ((y - cy) / focal_px) * depth_m, depth_m)
      .applyQuaternion(rotation_of(keyframe))
      .add(new Vector3(...keyframe.position_m));
  const eye = new Vector3(...keyframe.position_m);
  const corners = [corner(0, 0), corner(width, 0), corner(width, height), corner(0, height)] as const;
  const lines: Vector3[] = [];
  corners.forEach((point, index) => lines.push(eye, point, point, corners[(index + 1) % 4] as Vector3));
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(lines.flatMap((point) => point.toArray()), 3));
  return geometry;
}

// Returns the pixel of a keyframe's picture, as shares of its size, at which a point of the world is; nothing where it is outside.
export function place_in(keyframe: Keyframe, { focal_px, image_size_px, principal_point_px }: Keyframes, point: readonly [number, number, number]): [number, number] | undefined {
  const [width, height] = image_size_px;
  const [cx, cy] = principal_point_px ?? [width / 2, height / 2];
  const p = new Vector3(...point).sub(new Vector3(...keyframe.position_m)).applyQuaternion(rotation_of(keyframe).invert());
  if (p.z <= 0.05) return undefined;
  const x = (focal_px * p.x) / p.z + cx;
  const y = (focal_px * p.y) / p.z + cy;
  return x >= 0 && y >= 0 && x < width && y < height ? [x / width, y / height] : undefined;
}
