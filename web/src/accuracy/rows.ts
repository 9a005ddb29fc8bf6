import type { Units } from "../app/settings.svelte";
import { area_with_error, length, percent, significant } from "../app/units";
import { type Metrics, metric_at, number_at } from "../model/result_files";
import { texts } from "../texts/en";

export interface Row {
  name: string;
  metric: string;
  value: string | undefined;
  bound: string | undefined;
}

const t = texts.accuracy.row;

// Returns the accuracy that the dive itself lets one expect; a value that was not measured has no text.
export function expected_rows(metrics: Metrics, units: Units): Row[] {
  const at = (path: string): number | undefined => number_at(metrics, `expected_accuracy.${path}`);
  const metres = (value: number | undefined): string | undefined => (value === undefined ? undefined : length(value, units));
  const below = (value: number | undefined): string | undefined => (value === undefined ? undefined : `≤ ${length(value, units)}`);
  const sigma = number_at(metrics, "calibration.scale_sigma");
  return [
    { name: t.path_length, metric: "trajectory.path_length_m", value: metres(number_at(metrics, "trajectory.path_length_m")), bound: undefined },
    { name: t.path_bound, metric: "expected_accuracy.trajectory.ate", value: metres(at("trajectory.ate.expected_m")), bound: below(at("trajectory.ate.bound_m")) },
    {
      name: t.end_bound,
      metric: "expected_accuracy.trajectory.end_position",
      value: metres(at("trajectory.end_position.expected_m")),
      bound: below(at("trajectory.end_position.bound_m")),
    },
    { name: t.surface, metric: "expected_accuracy.surface", value: metres(at("surface.sigma_median_m")), bound: below(at("surface.error_95_m")) },
    {
      name: t.scale,
      metric: "calibration.scale_sigma",
      value: sigma === undefined ? undefined : percent(sigma, 2),
      bound: sigma === undefined ? undefined : `± ${percent(1.96 * sigma, 2)}`,
    },
  ];
}

// Returns the errors against known truth, those that were measured.
export function truth_rows(metrics: Metrics, units: Units): Row[] {
  const at = (path: string): number | undefined => number_at(metrics, path);
  const scores = metric_at(metrics, "surface.scores") as { f1: number; threshold_m: number }[] | undefined;
  const f1 = scores?.find(({ threshold_m }) => threshold_m === 0.02)?.f1;
  const rows: [string, string, number | undefined, (value: number) => string][] = [
    [t.ate, "trajectory.final.ate_rmse_m", at("trajectory.final.ate_rmse_m"), (v) => length(v, units)],
    [t.drift, "trajectory.final.drift_percent", at("trajectory.final.drift_percent"), (v) => `${significant(v)} %`],
    [t.end_drift, "trajectory.final.end_drift_m", at("trajectory.final.end_drift_m"), (v) => length(v, units)],
    [t.rotation, "trajectory.final.rotation_rmse_deg", at("trajectory.final.rotation_rmse_deg"), (v) => `${significant(v, 2)}°`],
    [t.surface_accuracy, "surface.accuracy.median_m", at("surface.accuracy.median_m"), (v) => length(v, units)],
    [t.surface_p90, "surface.accuracy.p90_m", at("surface.accuracy.p90_m"), (v) => length(v, units)],
    [t.completeness, "surface.completeness.median_m", at("surface.completeness.median_m"), (v) => length(v, units)],
    [t.f1, "surface.scores[0.02].f1", f1, (v) => percent(v)],
    [t.false_share, "surface.false_share_50mm", at("surface.false_share_50mm"), (v) => percent(v, 2)],
    [t.distances, "known_distances.rmse_m", at("known_distances.rmse_m"), (v) => length(v, units)],
  ];
  return rows
    .filter(([, , value]) => value !== undefined)
    .map(([name, metric, value, words]) => ({ name, metric, value: words(value as number), bound: undefined }));
}

export interface BesideRow {
  name: string;
  metric: string;
  here: string | undefined;
  there: string | undefined;
  times: number | undefined;
}

// Returns the figures of two results of one dive beside each other: those that at least one of them has. `times` is how
// many times the other's value this one's is, where both are positive.
export function beside_rows(here: Metrics, there: Metrics, units: Units): BesideRow[] {
  const metres = (v: number): string => length(v, units);
  const below = (v: number): string => `≤ ${length(v, units)}`;
  const figures: [string, string, (value: number) => string][] = [
    [t.path_length, "trajectory.path_length_m", metres],
    [t.tracked, "frames.coverage", (v) => percent(v)],
    [t.path_bound, "expected_accuracy.trajectory.ate.bound_m", below],
    [t.end_bound, "expected_accuracy.trajectory.end_position.bound_m", below],
    [t.surface, "expected_accuracy.surface.error_95_m", below],
    [t.scale, "calibration.scale_sigma", (v) => `± ${percent(1.96 * v, 2)}`],
    [t.ate, "trajectory.final.ate_rmse_m", metres],
    [t.rotation, "trajectory.final.rotation_rmse_deg", (v) => `${significant(v, 2)}°`],
    [t.surface_accuracy, "surface.accuracy.median_m", metres],
    [t.completeness, "surface.completeness.median_m", metres],
    [t.false_share, "surface.false_share_50mm", (v) => percent(v, 2)],
    [t.distances, "known_distances.rmse_m", metres],
    [t.area, "mesh.area_m2", (v) => area_with_error(v, null, units)],
  ];
  return figures.flatMap(([name, metric, words]) => {
    const values = [number_at(here, metric), number_at(there, metric)] as const;
    if (values[0] === undefined && values[1] === undefined) return [];
    const [a, b] = values.map((value) => (value === undefined ? undefined : words(value)));
    const comparable = values[0] !== undefined && values[1] !== undefined && values[0] > 0 && values[1] > 0;
    return [{ name, metric, here: a, there: b, times: comparable ? (values[0] as number) / (values[1] as number) : undefined }];
  });
}

// Returns the options that two jobs differ in, with both values; undefined: not set.
export function other_options(here: Record<string, unknown>, there: Record<string, unknown>): [string, unknown, unknown][] {
  const names = [...new Set([...Object.keys(here), ...Object.keys(there)])].sort();
  return names
    .filter((name) => JSON.stringify(here[name]) !== JSON.stringify(there[name]))
    .map((name) => [name, here[name], there[name]]);
}

// Returns every number of metrics.json with its path, for those who look for one.
export function all_rows(metrics: Metrics): [string, string][] {
  const rows: [string, string][] = [];
  const walk = (value: unknown, path: string): void => {
    if (value === null) rows.push([path, texts.common.not_measured]);
    else if (Array.isArray(value)) value.forEach((item, index) => walk(item, `${path}[${labelled(item, index)}]`));
    else if (typeof value === "object") for (const [key, item] of Object.entries(value as Metrics)) walk(item, path ? `${path}.${key}` : key);
    else rows.push([path, typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value)]);
  };
  walk(metrics, "");
  return rows;
}

function labelled(item: unknown, index: number): string {
  const names = item && typeof item === "object" ? (item as Metrics) : {};
  return String(names.name ?? names.stage ?? names.figure ?? index);
}
