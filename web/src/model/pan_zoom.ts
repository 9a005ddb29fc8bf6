// Pans and zooms a picture by mouse, touch, wheel and keys. The picture's pixel p is drawn at
// scale * p + offset, in CSS pixels of the frame.
export interface PictureView {
  scale: number;
  x: number;
  y: number;
}

export function fitted(width: number, height: number, frame_width: number, frame_height: number): PictureView {
  const scale = Math.min(frame_width / width, frame_height / height);
  return { scale, x: (frame_width - scale * width) / 2, y: (frame_height - scale * height) / 2 };
}

// Returns the view after a zoom by a factor about a place of the frame, which stays where it is.
export function zoomed(view: PictureView, factor: number, x: number, y: number, least: number): PictureView {
  const scale = Math.min(Math.max(view.scale * factor, least), 16);
  const applied = scale / view.scale;
  return { scale, x: x - applied * (x - view.x), y: y - applied * (y - view.y) };
}

export class PanZoom {
  #fingers = new Map<number, { x: number; y: number }>();
  #moved_px = 0;

  constructor(
    readonly get: () => PictureView,
    readonly set: (view: PictureView) => void,
    readonly least_scale: () => number,
    readonly on_tap: (x: number, y: number) => void,
  ) {}

  down(event: PointerEvent): void {
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, place(event));
    this.#moved_px = 0;
  }

  move(event: PointerEvent): void {
    const before = this.#fingers.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    this.#moved_px += Math.hypot(now.x - before.x, now.y - before.y);
    const other = [...this.#fingers].find(([id]) => id !== event.pointerId)?.[1];
    const view = this.get();
    if (other) {
      const factor = Math.hypot(now.x - other.x, now.y - other.y) / Math.max(1, Math.hypot(before.x - other.x, before.y - other.y));
      this.set(zoomed(view, factor, other.x, other.y, this.least_scale()));
    } else {
      this.set({ ...view, x: view.x + now.x - before.x, y: view.y + now.y - before.y });
    }
    this.#fingers.set(event.pointerId, now);
  }

  up(event: PointerEvent): void {
    const was_down = this.#fingers.delete(event.pointerId);
    const at = place(event);
    if (was_down && this.#moved_px < 5 && event.button === 0) this.on_tap(at.x, at.y);
  }

  cancel(event: PointerEvent): void {
    this.#fingers.delete(event.pointerId);
  }

  wheel(event: WheelEvent): void {
    event.preventDefault();
    const at = place(event);
    this.set(zoomed(this.get(), Math.exp(-event.deltaY * 0.0015), at.x, at.y, this.least_scale()));
  }
}

function place(event: MouseEvent): { x: number; y: number } {
  const bounds = (event.currentTarget as HTMLElement).getBoundingClientRect();
  return { x: event.clientX - bounds.left, y: event.clientY - bounds.top };
}
