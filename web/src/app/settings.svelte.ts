// What the visitor chose for this browser: theme and units. Nothing secret is kept here.
export type Theme = "system" | "light" | "dark" | "sun";
export type Units = "metric" | "imperial";

const kKey = "divemesh.settings";

interface Stored {
  theme?: Theme;
  units?: Units;
  preset?: string;
}

function stored(): Stored {
  try {
    return JSON.parse(localStorage.getItem(kKey) ?? "{}") as Stored;
  } catch {
    return {};
  }
}

class Settings {
  theme = $state<Theme>(stored().theme ?? "system");
  units = $state<Units>(stored().units ?? "metric");
  preset = $state(stored().preset ?? "standard");
  prefers_dark = $state(window.matchMedia("(prefers-color-scheme: dark)").matches);
  prefers_contrast = $state(window.matchMedia("(prefers-contrast: more)").matches);

  constructor() {
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (query) => {
      this.prefers_dark = query.matches;
    });
  }

  // Returns the theme that is shown.
  get shown_theme(): "light" | "dark" | "sun" {
    if (this.theme !== "system") return this.theme;
    if (this.prefers_contrast && !this.prefers_dark) return "sun";
    return this.prefers_dark ? "dark" : "light";
  }

  store(): void {
    const values: Stored = { theme: this.theme, units: this.units, preset: this.preset };
    try {
      localStorage.setItem(kKey, JSON.stringify(values));
    } catch {
      // A browser without storage keeps the choice until the tab is closed.
    }
  }
}

export const settings = new Settings();
export const reduced_motion = (): boolean => window.matchMedia("(prefers-reduced-motion: reduce)").matches;
