import { describe, expect, it } from "vitest";
import { area_with_error, bytes, duration, length, length_with_error, round_length } from "../src/app/units";

describe("units", () => {
  it("chooses the unit by the size", () => {
    expect(length(0.00738, "metric")).toBe("7.38 mm");
    expect(length(0.62, "metric")).toBe("62.0 cm");
    expect(length(2.98, "metric")).toBe("2.98 m");
    expect(length(0.3048, "imperial")).toBe("1.00 ft");
    expect(length(0.0254, "imperial")).toBe("1.00 in");
  });

  it("gives a value as many digits as its interval allows", () => {
    expect(length_with_error(1.40727, 0.0131, "metric")).toBe("1.407 ± 0.013 m");
    expect(length_with_error(1.40727, null, "metric")).toBe("1.41 m");
    expect(area_with_error(2.5, 0.12, "metric")).toBe("2.50 ± 0.12 m²");
  });

  it("states durations and sizes in words that people use", () => {
    expect(duration(8.3)).toBe("8.3 s");
    expect(duration(250)).toBe("4 min 10 s");
    expect(duration(7500)).toBe("2 h 5 min");
    expect(bytes(27055104)).toBe("27.1 MB");
  });

  it("makes scale bars of 1, 2 or 5", () => {
    expect(round_length(0.37)).toBeCloseTo(0.2, 12);
    expect(round_length(7.3)).toBe(5);
    expect(round_length(1.9)).toBe(1);
  });
});
