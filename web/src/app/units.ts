import type { Units } from "./settings.svelte";

const kMetresPerFoot = 0.3048;
const kMetresPerInch = 0.0254;

// Returns a number with the given significant digits, without an exponent.
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const magnitude = Math.floor(Math.log10(Math.abs(value)));
  const decimals = Math.min(Math.max(digits - 1 - magnitude, 0), 6);
  return value.toLocaleString("en", { minimumFractionDigits: decimals, maximumFractionDigits: decimals });
}

interface Scaled {
  value: number;
  unit: string;
  factor: number;
}

function scaled_length(metres: number, units: Units): Scaled {
  const size = Math.abs(metres);
  if (units === "imperial") {
    const factor = size < kMetresPerFoot ? kMetresPerInch : kMetresPerFoot;
    return { value: metres / factor, unit: factor === kMetresPerInch ? "in" : "ft", factor };
  }
  if (size >= 1) return { value: metres, unit: "m", factor: 1 };
  if (size >= 0.1) return { value: metres * 100, unit: "cm", factor: 0.01 };
  return { value: metres * 1000, unit: "mm", factor: 0.001 };
}

// Returns a length for people: "7.38 mm", "62.1 cm", "2.98 m".
export function length(metres: number, units: Units, digits = 3): string {
  const { value, unit } = scaled_length(metres, units);
  return `${significant(value, digits)} ${unit}`;
}

// Returns a length in the unit that a length of another size has, so that the ends of a scale compare.
export function length_as(metres: number, like_m: number, units: Units): string {
  const { unit, factor } = scaled_length(like_m, units);
  const decimals = Math.min(Math.max(2 - Math.floor(Math.log10(Math.abs(like_m) / factor)), 0), 4);
  return `${(metres / factor).toFixed(decimals).replace("-", "−")} ${unit}`;
}

// Returns a measured length with half of its 95 % interval, both in one unit and with the digits that the interval allows.
export function length_with_error(metres: number, half_m: number | null, units: Units): string {
  if (half_m === null || !(half_m > 0)) return length(metres, units);
  const { factor, unit } = scaled_length(metres, units);
  const half = half_m / factor;
  const decimals = Math.min(Math.max(1 - Math.floor(Math.log10(half)), 0), 4);
  return `${(metres / factor).toFixed(decimals)} ± ${half.toFixed(decimals)} ${unit}`;
}

export function area_with_error(square_metres: number, half_m2: number | null, units: Units): string {
  const small = square_metres < 0.1;
  const imperial = units === "imperial";
  const factor = imperial ? (small ? kMetresPerInch ** 2 : kMetresPerFoot ** 2) : small ? 1e-4 : 1;
  const unit = imperial ? (small ? "in²" : "ft²") : small ? "cm²" : "m²";
  if (half_m2 === null || !(half_m2 > 0)) return `${significant(square_metres / factor)} ${unit}`;
  const half = half_m2 / factor;
  const decimals = Math.min(Math.max(1 - Math.floor(Math.log10(half)), 0), 4);
  return `${(square_metres / factor).toFixed(decimals)} ± ${half.toFixed(decimals)} ${unit}`;
}

export function temperature(celsius: number, units: Units): string {
  return units === "imperial" ? `${(celsius * 1.8 + 32).toFixed(1)} °F` : `${celsius.toFixed(1)} °C`;
}

export function bytes(count: number): string {
  const units = ["B", "kB", "MB", "GB", "TB"];
  let value = count;
  let step = 0;
  while (value >= 1000 && step < units.length - 1) {
    value /= 1000;
    step += 1;
  }
  return `${step === 0 ? value : significant(value)} ${units[step]}`;
}

export function percent(share: number, digits = 3): string {
  return `${significant(share * 100, digits)} %`;
}

// Returns a duration in at most two units: "8.3 s", "4 min 10 s", "2 h 5 min".
export function duration(seconds: number): string {
  if (seconds < 60) return `${seconds < 10 ? significant(seconds, 2) : Math.round(seconds)} s`;
  const whole = Math.round(seconds);
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  const days = Math.floor(whole / 86400);
  if (days > 0) return `${days} d ${Math.round((whole % 86400) / 3600)} h`;
  return `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

// Returns the round length nearest below the one given, for a scale bar: 1, 2 or 5 times a power of ten.
export function round_length(metres: number): number {
  const power = 10 ** Math.floor(Math.log10(metres));
  const lead = metres / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
