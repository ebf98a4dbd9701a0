/**
 * Colours, as in the program's own pictures (crates/plot/src/palette, whose test compares): those of sensors and zones are of
 * Okabe's and Ito's and of Tol's sets, which the colour-blind tell apart. What is text or line on the ground differs by
 * theme.
 */
import { SensorKind } from "../gen/baudbot/v1/brain_link_pb";
import type { Look, Zone } from "../gen/baudbot/v1/observe_pb";

/** A colour that what is below shines through. */
export interface Tint {
  hue: string;
  opacity: number;
}

export interface Theme {
  dark: boolean;
  /** Around the floor, and the floor itself. */
  ground: string;
  floor: string;
  grid: string;
  gridStrong: string;
  ink: string;
  paleInk: string;
  frame: string;
  /** Of what the scenario gives no colour. */
  wall: string;
  wallRim: string;
  robot: string;
  body: string;
  chosen: string;
  /** What a brain believes, and nothing else, has this colour. */
  belief: string;
  /** Dead reckoning. */
  ghost: string;
  /** Cells of the floor that bodies have covered, and those that sensors have reached. */
  covered: Tint;
  sensed: Tint;
  late: string;
  /** Behind text that is on a drawing. */
  halo: string;
}

export const LIGHT: Theme = {
  dark: false,
  ground: "#eef0f4",
  floor: "#ffffff",
  grid: "#e9ecf1",
  gridStrong: "#d5dae3",
  ink: "#1d2430",
  paleInk: "#566074",
  frame: "#8a93a3",
  wall: "#8a93a3",
  wallRim: "#5a606a",
  robot: "#1f5fa8",
  body: "#d7e4f7",
  chosen: "#1f5fa8",
  belief: "#8e3ad1",
  ghost: "#666f80",
  covered: { hue: "#86b817", opacity: 0.5 },
  sensed: { hue: "#86b817", opacity: 0.17 },
  late: "#d0312d",
  halo: "rgba(255,255,255,0.85)",
};

export const DARK: Theme = {
  dark: true,
  ground: "#12161d",
  floor: "#191f29",
  grid: "#222a36",
  gridStrong: "#303a4a",
  ink: "#e4e9f1",
  paleInk: "#9aa6b8",
  frame: "#5b6678",
  wall: "#667185",
  wallRim: "#97a3b7",
  robot: "#7db4f0",
  body: "#26405f",
  chosen: "#8fc1ff",
  belief: "#c58bff",
  ghost: "#a9b3c3",
  covered: { hue: "#86b817", opacity: 0.4 },
  sensed: { hue: "#86b817", opacity: 0.14 },
  late: "#f0605b",
  halo: "rgba(18,22,29,0.8)",
};

export const MOVER = "#994455";
export const LAMP = "#f2b01e";
export const LAMP_RIM = "#8a6100";
export const FIELDS = ["#cc3311", "#009988", "#aa4499", "#999933"];
/** A field's bell that goes down. */
export const HOLLOW = "#0077bb";
/** What a sensor of the robot itself, not of its surroundings, is drawn in. */
const INNER = "#5b6678";

const HUES: Partial<Record<SensorKind, string>> = {
  [SensorKind.IR]: "#d55e00",
  [SensorKind.IR_VOLTAGE]: "#ee8800",
  [SensorKind.SONAR]: "#0072b2",
  [SensorKind.LASER]: "#009e73",
  [SensorKind.LINE_CAMERA]: "#cc79a7",
  [SensorKind.CAMERA]: "#cc79a7",
  [SensorKind.OPTICAL_FLOW]: "#661100",
  [SensorKind.WHISKER]: "#882255",
  [SensorKind.BUMPER]: "#332288",
  [SensorKind.PHOTORESISTOR]: "#b58900",
  [SensorKind.LIGHT]: "#b58900",
  [SensorKind.FIELD]: "#44aa99",
  [SensorKind.MICROPHONE]: "#aa4499",
  [SensorKind.FLOOR]: "#117733",
  [SensorKind.STRAIN_GAUGE]: "#aa3377",
  [SensorKind.IR_BEACONS]: "#999933",
};

/** A hue for each kind of sensor. */
export function hue(kind: SensorKind | undefined): string {
  return (kind !== undefined && HUES[kind]) || INNER;
}

/** What scenarios call it. */
export function kindName(kind: SensorKind | undefined): string {
  return SensorKind[kind ?? SensorKind.UNSPECIFIED]?.toLowerCase().replaceAll("_", "-") ?? "unknown";
}

/** What a zone is for, in words, and the hue of its first use. */
export function uses(zone: Zone): { hue: string; words: string[] } {
  const all: [boolean, string, string][] = [
    [zone.goal, "#0072b2", "goal"],
    [zone.chargerW > 0, "#009e73", `charger ${zone.chargerW} W`],
    [zone.slip > 0, "#56b4e9", `slippery ${zone.slip}`],
    [zone.indoors, "#882255", "indoors"],
  ];
  const used = all.filter(([is]) => is);
  const words = used.map(([, , text]) => text);
  if (zone.floor !== undefined) words.push(`floor ${zone.floor}`);
  return { hue: used[0]?.[1] ?? "#8a93a3", words };
}

type Rgb = [number, number, number];

/** Of what the server tells if the scenario gives a thing no colour. */
const NO_COLOR: Rgb = [128, 128, 128];
const MOVABLE: Rgb = [200, 160, 100];

/** The colour of something's own, or undefined if the scenario gives it none. */
function ownColor(look: Look | undefined): Rgb | undefined {
  if (!look) return undefined;
  const { red, green, blue } = look;
  const isDefault = red === NO_COLOR[0] && green === NO_COLOR[1] && blue === NO_COLOR[2];
  return isDefault ? undefined : [red, green, blue];
}

/** Fill and rim of something solid. The rim differs enough from the floor in either theme, whatever the fill is. */
export function solidColors(look: Look | undefined, theme: Theme, movable: boolean): { fill: string; rim: string } {
  const own = ownColor(look) ?? (movable ? MOVABLE : undefined);
  const isLow = look?.heightM !== undefined;
  if (!own) return { fill: isLow ? faded(theme.wall, theme) : theme.wall, rim: theme.wallRim };
  const rim = theme.dark ? mixed(own, [255, 255, 255], 0.45) : mixed(own, [0, 0, 0], 0.4);
  return { fill: isLow ? faded(css(own), theme) : css(own), rim: css(rim) };
}

/** Body and rim of a robot. */
export function robotColors(look: Look | undefined, theme: Theme): { body: string; rim: string } {
  const own = ownColor(look);
  if (!own) return { body: theme.body, rim: theme.robot };
  const rim = theme.dark ? mixed(own, [255, 255, 255], 0.45) : mixed(own, [0, 0, 0], 0.35);
  return { body: css(mixed(own, rgb(theme.floor), 0.45)), rim: css(rim) };
}

/** The grey of a floor that throws so much of the light back: not as dark as it is, for there is much to read on it. */
export function floorColor(reflectance: number, theme: Theme): string {
  const share = Math.min(1, Math.max(0, reflectance));
  const level = Math.round(theme.dark ? 8 + 60 * share : 90 + 165 * share);
  return css([level, level, level]);
}

/** The same colour with an opacity. */
export function withAlpha(color: string, alpha: number): string {
  const [red, green, blue] = rgb(color);
  return `rgba(${red},${green},${blue},${alpha})`;
}

/** The same hue for text on a dark ground. */
export function paled(color: string): string {
  return css(mixed(rgb(color), [255, 255, 255], 0.5));
}

/** The same hue for text on a light ground. */
export function darkened(color: string): string {
  return css(mixed(rgb(color), [0, 0, 0], 0.35));
}

export function rgb(color: string): Rgb {
  const level = (at: number) => parseInt(color.slice(at, at + 2), 16) || 0;
  return [level(1), level(3), level(5)];
}

/** What is low is paler: some sensors overlook it. */
function faded(color: string, theme: Theme): string {
  return css(mixed(rgb(color), rgb(theme.floor), 0.55));
}

function mixed(a: Rgb, b: Rgb, share: number): Rgb {
  const mix = (i: 0 | 1 | 2) => Math.round(a[i] + share * (b[i] - a[i]));
  return [mix(0), mix(1), mix(2)];
}

function css([red, green, blue]: Rgb): string {
  const two = (level: number) => level.toString(16).padStart(2, "0");
  return `#${two(red)}${two(green)}${two(blue)}`;
}
