import type { Sensor } from "../api/types";
import type { Units } from "../app/settings.svelte";
import { bytes, length, percent, significant, temperature } from "../app/units";
import { texts } from "../texts/en";

export const kStale_ms = 15000;

export interface StatusValue {
  name: string;
  text: string;
}

// Returns the age of a sensor's status by the server's clock; nothing where none has arrived.
export function status_age_ms(sensor: Sensor, now_ms: number): number | undefined {
  return sensor.status_at_ms > 0 ? Math.max(0, now_ms - sensor.status_at_ms) : undefined;
}

export function is_live(sensor: Sensor, now_ms: number): boolean {
  const age = status_age_ms(sensor, now_ms);
  return age !== undefined && age <= kStale_ms && !sensor.stale;
}

// Returns what a status says, in the units of the visitor. A value that the sensor does not send is
// said to be not measured.
export function values_of(sensor: Sensor, units: Units): StatusValue[] {
  const t = texts.sensors;
  const number = (name: string): number | undefined => {
    const value = sensor.status[name];
    return typeof value === "number" ? value : undefined;
  };
  const text = (name: string, words: (value: number) => string): string => {
    const value = number(name);
    return value === undefined ? texts.common.not_measured : words(value);
  };
  const link = number("link_rssi_dbm");
  const rate = number("link_bytes_per_s");
  return [
    { name: t.battery, text: text("battery", (value) => percent(value, 2)) },
    { name: t.storage, text: text("storage_free_bytes", bytes) },
    { name: t.depth, text: text("depth_m", (value) => length(value, units, 2)) },
    { name: t.temperature, text: text("temperature_c", (value) => temperature(value, units)) },
    {
      name: t.link,
      text:
        link === undefined && rate === undefined
          ? texts.common.not_measured
          : [link === undefined ? "" : `${link.toFixed(0)} dBm`, rate === undefined ? "" : `${bytes(rate)}/s`].filter(Boolean).join(", "),
    },
    { name: t.rate, text: text("frame_rate_hz", (value) => `${significant(value, 2)} Hz`) },
    { name: t.dropped, text: text("num_dropped_frames", (value) => value.toLocaleString("en")) },
  ];
}
