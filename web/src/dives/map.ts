import type { Dive } from "../api/types";

// A plain plot of positions: east and north of a place among them, metres. No tiles: boats have no internet.
export interface Placed {
  dive: Dive;
  east_m: number;
  north_m: number;
}

// What of it is shown: the place in the middle, and the metres of a pixel.
export interface MapView {
  east_m: number;
  north_m: number;
  m_per_px: number;
}

// Dives that lie within a few pixels of each other.
export interface Spot {
  x: number;
  y: number;
  dives: Dive[];
}

const kEarth_m = 6_371_008.8; // mean radius
const kMinSpan_m = 200;
const kReach_px = 26;

export type Origin = NonNullable<Dive["position"]>;

// Returns the dives that have a position, as seen from an origin. Longitudes are taken the short way round the earth.
export function placed(dives: Dive[], first: Origin | undefined = origin_of(dives)): Placed[] {
  if (!first) return [];
  const known = dives.filter(({ position }) => position);
  const radians = Math.PI / 180;
  return known.map((dive) => {
    const { latitude_deg, longitude_deg } = dive.position as NonNullable<Dive["position"]>;
    const turn_deg = ((longitude_deg - first.longitude_deg + 540) % 360) - 180;
    return {
      dive,
      east_m: turn_deg * radians * kEarth_m * Math.cos(first.latitude_deg * radians),
      north_m: (latitude_deg - first.latitude_deg) * radians * kEarth_m,
    };
  });
}

export function origin_of(dives: Dive[]): Origin | undefined {
  return dives.find(({ position }) => position)?.position ?? undefined;
}

// Returns the view that shows all of them, of which there is at least one.
export function view_of_all(places: Placed[], width: number, height: number): MapView {
  const middle = (values: number[]): [number, number] => {
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return [(low + high) / 2, Math.max(high - low, kMinSpan_m)];
  };
  const [east_m, wide_m] = middle(places.map((place) => place.east_m));
  const [north_m, tall_m] = middle(places.map((place) => place.north_m));
  return { east_m, north_m, m_per_px: 1.25 * Math.max(wide_m / width, tall_m / height) };
}

// Returns the spots within the view. A dive joins the nearest spot that is no more than a marker's width away.
export function spots_in(places: Placed[], view: MapView, width: number, height: number): Spot[] {
  const spots: Spot[] = [];
  for (const { dive, east_m, north_m } of places) {
    const x = width / 2 + (east_m - view.east_m) / view.m_per_px;
    const y = height / 2 - (north_m - view.north_m) / view.m_per_px;
    if (x < 0 || y < 0 || x > width || y > height) continue;
    const away = (spot: Spot): number => Math.hypot(spot.x - x, spot.y - y);
    const nearest = spots.reduce<Spot | undefined>((best, spot) => (!best || away(spot) < away(best) ? spot : best), undefined);
    if (nearest && away(nearest) < kReach_px) nearest.dives.push(dive);
    else spots.push({ x, y, dives: [dive] });
  }
  return spots;
}

// Returns a position for people: "54.32210° N, 10.12000° E", a metre or so.
export function position_words({ latitude_deg, longitude_deg }: { latitude_deg: number; longitude_deg: number }): string {
  const part = (value: number, ends: readonly [string, string]): string =>
    `${Math.abs(value).toFixed(5)}° ${value < 0 ? ends[1] : ends[0]}`;
  return `${part(latitude_deg, ["N", "S"])}, ${part(longitude_deg, ["E", "W"])}`;
}
