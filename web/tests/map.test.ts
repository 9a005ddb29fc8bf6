import { describe, expect, it } from "vitest";
import type { Dive } from "../src/api/types";
import { placed, position_words, spots_in, view_of_all } from "../src/dives/map";

const dive = (id: string, latitude_deg?: number, longitude_deg = 0): Dive =>
  ({ id, name: id, position: latitude_deg === undefined ? null : { latitude_deg, longitude_deg } }) as Dive;

describe("the map of dives", () => {
  it("knows distances: a minute of latitude is a nautical mile, one of longitude less", () => {
    const [a, north, east] = placed([dive("a", 60, 10), dive("b", 60 + 1 / 60, 10), dive("c", 60, 10 + 1 / 60)]);
    expect(a).toMatchObject({ east_m: 0, north_m: 0 });
    expect(north?.north_m).toBeCloseTo(1853, -1);
    expect(east?.east_m).toBeCloseTo(1853 / 2, -1);
  });

  it("goes the short way over the date line and leaves out what has no position", () => {
    const places = placed([dive("a", 0, 179.9), dive("none"), dive("b", 0, -179.9)]);
    expect(places.map((place) => place.dive.id)).toEqual(["a", "b"]);
    expect(places[1]?.east_m).toBeCloseTo(22239, -1);
    expect(placed([dive("none")])).toEqual([]);
  });

  it("shows all of them at first, and joins those that lie within a marker", () => {
    const places = placed([dive("a", 54, 10), dive("b", 54.00001, 10), dive("c", 54.2, 10.4)]);
    const spots = spots_in(places, view_of_all(places, 800, 400), 800, 400);
    expect(spots.map((spot) => spot.dives.map(({ id }) => id))).toEqual([["a", "b"], ["c"]]);
    expect(spots[1]?.x).toBeGreaterThan(spots[0]?.x as number);
    expect(spots[1]?.y).toBeLessThan(spots[0]?.y as number);
    const near = { east_m: 0, north_m: 0, m_per_px: 0.02 };
    expect(spots_in(places, near, 800, 400).map((spot) => spot.dives.length)).toEqual([1, 1]);
  });

  it("shows one dive without dividing by nothing", () => {
    const places = placed([dive("a", 54, 10)]);
    const view = view_of_all(places, 800, 400);
    expect(view.m_per_px).toBeGreaterThan(0);
    expect(spots_in(places, view, 800, 400)[0]).toMatchObject({ x: 400, y: 200 });
  });

  it("writes positions with their hemispheres", () => {
    expect(position_words({ latitude_deg: -12.5, longitude_deg: 170.25 })).toBe("12.50000° S, 170.25000° E");
  });
});
