import { describe, expect, it } from "vitest";
import { beside_rows, other_options } from "../src/accuracy/rows";

const here = { trajectory: { path_length_m: 5, final: { ate_rmse_m: 0.002 } }, mesh: { area_m2: 3 }, frames: { coverage: 1 } };
const there = { trajectory: { path_length_m: 5, final: { ate_rmse_m: 0.004 } }, frames: { coverage: 0.5 }, calibration: { scale_sigma: 0.01 } };

describe("two results beside each other", () => {
  it("shows what one of them has, in the units asked for", () => {
    const rows = new Map(beside_rows(here, there, "metric").map((row) => [row.metric, row]));
    expect(rows.get("trajectory.final.ate_rmse_m")).toMatchObject({ here: "2.00 mm", there: "4.00 mm", times: 0.5 });
    expect(rows.get("frames.coverage")).toMatchObject({ here: "100 %", there: "50.0 %", times: 2 });
    expect(rows.get("mesh.area_m2")).toMatchObject({ here: "3.00 m²", there: undefined, times: undefined });
    expect(rows.get("calibration.scale_sigma")).toMatchObject({ here: undefined, there: "± 2.0 %" });
    expect(rows.has("surface.accuracy.median_m")).toBe(false);
    expect(beside_rows(here, there, "imperial").find(({ metric }) => metric === "mesh.area_m2")?.here).toBe("32.3 ft²");
  });

  it("never divides by nothing", () => {
    const rows = beside_rows({ surface: { false_share_50mm: 0 } }, { surface: { false_share_50mm: 0.1 } }, "metric");
    expect(rows).toHaveLength(1);
    expect(rows[0]?.times).toBeUndefined();
  });

  it("lists the options that differ, set in one job alone or in both", () => {
    expect(other_options({ a: 1, b: true, c: [1, 2] }, { b: false, c: [1, 2], d: "x" })).toEqual([
      ["a", 1, undefined],
      ["b", true, false],
      ["d", undefined, "x"],
    ]);
  });
});
