import type { Units } from "../app/settings.svelte";
import { area_with_error, length_with_error } from "../app/units";
import type { Measurement } from "./measurements.svelte";

// Returns a measured value with its error as text.
export function words_of({ tool, value, half }: Measurement, units: Units): string {
  if (tool === "area") return area_with_error(value, half, units);
  if (tool !== "angle") return length_with_error(value, half, units);
  const degrees = (radians: number): number => (radians * 180) / Math.PI;
  return half === null ? `${degrees(value).toFixed(1)}°` : `${degrees(value).toFixed(1)} ± ${degrees(half).toFixed(1)}°`;
}
