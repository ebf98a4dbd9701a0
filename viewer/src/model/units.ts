/** Numbers as people read them. */

/**
 * Simulated nanoseconds as a number. Exact to 2^53 ns, which are 104 days; beyond, microseconds get lost, and nobody
 * looks that closely.
 */
export function numberOf(ns: bigint): number {
  return Number(ns);
}

/** Nanoseconds as seconds. */
export function secondsOf(ns: bigint): number {
  return Number(ns) / 1e9;
}

/** A number with about so many digits that matter, without an exponent where that is possible. */
export function short(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size < 1e-9) return (0).toFixed(digits - 1);
  if (size >= 1e7 || size < 1e-4) return minus(value.toExponential(digits - 1));
  const whole = size < 1 ? 1 : Math.floor(Math.log10(size)) + 1;
  return minus(value.toFixed(Math.max(0, digits - whole)));
}

/** A number with a fixed count of decimals. */
export function fixed(value: number, decimals: number): string {
  return Number.isFinite(value) ? minus(value.toFixed(decimals)) : "–";
}

/** A true minus is as wide as a digit, so that columns stay where they are; and there is no minus before a zero. */
function minus(text: string): string {
  return /^-[0.]*$/.test(text) ? text.slice(1) : text.replace("-", "−");
}

/** A duration. */
export function duration(ns: number): string {
  const size = Math.abs(ns);
  if (size === 0) return "0 ms";
  if (size < 1e3) return `${short(ns)} ns`;
  if (size < 1e6) return `${short(ns / 1e3)} µs`;
  if (size < 1e9) return `${short(ns / 1e6)} ms`;
  return `${short(ns / 1e9)} s`;
}

/** Milliseconds to the nanosecond, and no zeros at their end. */
export function exactMs(ns: number): string {
  const text = (ns / 1e6).toFixed(6);
  return text.replace(/0+$/, "").replace(/\.$/, "");
}

/** The time of a world. */
export function clock(time_s: number): string {
  if (time_s < 60) return `${time_s.toFixed(3)} s`;
  const minutes = Math.floor(time_s / 60);
  const rest = (time_s - 60 * minutes).toFixed(2).padStart(5, "0");
  return minutes < 60
    ? `${minutes}:${rest}`
    : `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}:${rest}`;
}

/** Degrees, for eyes; inside everything is in radians. */
export function degrees(angle_rad: number): string {
  return `${fixed((angle_rad * 180) / Math.PI, 1)}°`;
}

/** Whole numbers with thin spaces between thousands. */
export function count(value: number | bigint): string {
  return String(value).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** A value with its unit; `1` is the unit of a ratio. */
export function withUnit(value: number, unit: string): string {
  const text = short(value);
  return unit === "" || unit === "1" ? text : `${text} ${unit}`;
}

/** How long a file is. */
export function bytesText(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${short(bytes / 1e3)} kB`;
  return bytes < 1e9 ? `${short(bytes / 1e6)} MB` : `${short(bytes / 1e9)} GB`;
}

/** A round length in the unit that suits it. */
export function lengthText(length_m: number): string {
  const round = (value: number) => String(Number(value.toPrecision(3)));
  if (length_m >= 1000) return `${round(length_m / 1000)} km`;
  return length_m < 0.01 ? `${round(1000 * length_m)} mm` : `${round(length_m)} m`;
}

/** The smallest of 1, 2, 5, 10, 20 and so on (or their tenths) that is not below. */
export function roundStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  const digit = [1, 2, 5].find((digit) => digit * power >= least * (1 - 1e-9));
  return (digit ?? 10) * power;
}

/** What somebody else has said, cut if it is long. */
export function brief(text: string, most: number): string {
  const characters = [...text];
  return characters.length <= most ? text : `${characters.slice(0, most).join("")}…`;
}
