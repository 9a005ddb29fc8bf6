// Times are shown in the visitor's zone; the tooltip states UTC.
const kDay = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "short" });
const kClock = new Intl.DateTimeFormat(undefined, { timeStyle: "medium" });

export function local_time(time_ms: number): string {
  return kDay.format(time_ms);
}

export function local_clock(time_ms: number): string {
  return kClock.format(time_ms);
}

export function utc_time(time_ms: number): string {
  return new Date(time_ms).toISOString().replace("T", " ").replace(/\.\d+Z$/, " UTC");
}

// Returns an age in one unit, rounded down: "3 s", "12 min", "5 h", "4 d".
export function age(milliseconds: number): string {
  const seconds = Math.max(0, Math.floor(milliseconds / 1000));
  if (seconds < 60) return `${seconds} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min`;
  if (seconds < 86400) return `${Math.floor(seconds / 3600)} h`;
  return `${Math.floor(seconds / 86400)} d`;
}
