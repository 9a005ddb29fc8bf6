import { describe, expect, it } from "vitest";
import { measure, outline_area, type Point } from "../src/model/measure";

const square: Point[] = [
  [0, 0, 0],
  [2, 0, 0],
  [2, 2, 0],
  [0, 2, 0],
];

describe("measure", () => {
  it("gives the length between two points", () => {
    expect(measure("length", [[0, 0, 0], [3, 4, 0]], { sigma_at: () => null, scale_sigma: 0 })).toEqual({ value: 5, half: null });
  });

  it("adds the errors of both ends and of the scale in quadrature", () => {
    const { half } = measure("length", [[0, 0, 0], [10, 0, 0]], { sigma_at: () => 0.01, scale_sigma: 0.002 });
    expect(half).toBeCloseTo(1.959964 * Math.sqrt(2 * 0.01 ** 2 + 0.02 ** 2), 6);
  });

  it("takes the error of each point at its place", () => {
    const sigma_at = ([x]: Point): number => (x === 0 ? 0.03 : 0.04);
    const { half } = measure("length", [[0, 0, 0], [1, 0, 0]], { sigma_at, scale_sigma: 0 });
    expect(half).toBeCloseTo(1.959964 * 0.05, 6);
  });

  it("gives the area of an outline that stands upright", () => {
    expect(outline_area(square.map(([x, y]) => [x, 0, y] as const))).toBeCloseTo(4, 12);
  });

  it("counts the scale twice for an area", () => {
    const { half } = measure("area", square, { sigma_at: () => 0, scale_sigma: 0.01 });
    expect(half).toBeCloseTo(1.959964 * 2 * 0.01 * 4, 6);
  });

  it("gives a right angle, without an error of scale", () => {
    const { value, half } = measure("angle", [[1, 0, 0], [0, 0, 0], [0, 1, 0]], { sigma_at: () => 0, scale_sigma: 0.01 });
    expect(value).toBeCloseTo(Math.PI / 2, 12);
    expect(half).toBeCloseTo(0, 9);
  });
});
