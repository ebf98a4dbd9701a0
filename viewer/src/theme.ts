/** Dark or light: as the system has it, until somebody chooses. */
import { DARK, LIGHT, type Theme } from "./arena/palette";

const KEY = "baudbot-theme";

export class ThemeSwitch {
  /** Called when it has changed. */
  changed: (theme: Theme) => void = () => {};
  private readonly system = matchMedia("(prefers-color-scheme: dark)");
  private chosen = remembered();

  constructor() {
    this.system.addEventListener("change", () => this.apply());
    this.apply();
  }

  get theme(): Theme {
    const isDark = this.chosen ? this.chosen === "dark" : this.system.matches;
    return isDark ? DARK : LIGHT;
  }

  toggle(): void {
    this.chosen = this.theme.dark ? "light" : "dark";
    try {
      localStorage.setItem(KEY, this.chosen);
    } catch {
      // Where nothing may be kept it holds until the page is closed.
    }
    this.apply();
  }

  private apply(): void {
    document.documentElement.dataset.theme = this.theme.dark ? "dark" : "light";
    this.changed(this.theme);
  }
}

function remembered(): string {
  try {
    return localStorage.getItem(KEY) ?? "";
  } catch {
    return "";
  }
}
