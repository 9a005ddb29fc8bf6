import type { CameraPose, ColorMode } from "./viewer";

const kModes: ColorMode[] = ["photo", "height", "plain", "sigma", "observations"];

// The camera in the fragment of the address, so that a link opens this very view.
export function fragment_of({ position, target }: CameraPose, color: ColorMode): string {
  const words = [...position, ...target].map((value) => value.toFixed(4).replace(/\.?0+$/, ""));
  return `#camera=${words.join(",")}${color === "photo" ? "" : `&color=${color}`}`;
}

export function view_in(fragment: string): { pose: CameraPose | undefined; color: ColorMode } {
  const query = new URLSearchParams(fragment.slice(1));
  const numbers = (query.get("camera") ?? "").split(",").map(Number);
  const [a, b, c, d, e, f] = numbers;
  const complete = numbers.length === 6 && numbers.every(Number.isFinite);
  const color = kModes.find((mode) => mode === query.get("color")) ?? "photo";
  const pose = complete ? { position: [a, b, c] as never, target: [d, e, f] as never } : undefined;
  return { pose, color };
}
