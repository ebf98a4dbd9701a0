/** The keyboard. Whoever types into a field means the field. */
import type { Arena } from "./arena/arena";
import type { Hands } from "./arena/hands";
import { isDriveKey } from "./model/stick";
import type { Store } from "./model/store";
import type { Drive } from "./net/drive";
import type { Orders } from "./net/orders";
import type { Replayer } from "./net/replayer";
import type { CablePanel } from "./panels/cable";
import type { Toolbar } from "./panels/toolbar";

/** Pixels that an arrow pans. */
const PAN = 60;

export interface Desk {
  store: Store;
  arena: Arena;
  hands: Hands;
  orders: Orders;
  drive: Drive;
  replayer: Replayer;
  toolbar: Toolbar;
  cable: CablePanel;
  help: HTMLDialogElement;
  switchTheme(): void;
}

export function listen(desk: Desk): void {
  const { drive } = desk;
  window.addEventListener("keydown", (event) => {
    if (isTyping(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (drive.state !== "off" && isDriveKey(event.key)) {
      drive.wake();
      drive.keys.add(event.key.toLowerCase());
    } else if (!press(desk, event)) return;
    event.preventDefault();
  });
  window.addEventListener("keyup", (event) => drive.keys.delete(event.key.toLowerCase()));
  // A key that is let go elsewhere is not heard of.
  window.addEventListener("blur", () => drive.rest());
  document.addEventListener("visibilitychange", () => document.hidden && drive.rest());
  window.addEventListener("focus", () => drive.wake());
}

function isTyping(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement;
  if (document.querySelector("dialog[open]")) return true;
  // A slider means only the keys that move it.
  if ((target as HTMLInputElement).type === "range") return /^(Arrow|Page|Home|End|Tab)/.test(event.key);
  if (["INPUT", "TEXTAREA", "SELECT"].includes(target.tagName)) return true;
  // A button under the focus takes these two for itself.
  return (event.key === " " || event.key === "Enter") && (target.tagName === "BUTTON" || target.tagName === "SUMMARY");
}

/** Whether the key meant something. */
function press(desk: Desk, event: KeyboardEvent): boolean {
  const { arena, orders, hands, drive, store } = desk;
  const replayer = desk.replayer.isOn ? desk.replayer : undefined;
  const actions: Record<string, (() => unknown) | undefined> = {
    " ": () => (replayer ?? orders).toggle(),
    ".": () => (replayer ? replayer.step(1) : orders.step(1)),
    ",": replayer && (() => replayer.step(-1)),
    "<": replayer && (() => replayer.toEvent(-1)),
    ">": replayer && (() => replayer.toEvent(1)),
    "+": () => arena.zoom(1.25),
    "=": () => arena.zoom(1.25),
    "-": () => arena.zoom(0.8),
    "0": () => arena.fit(),
    ArrowLeft: () => arena.pan(PAN, 0),
    ArrowRight: () => arena.pan(-PAN, 0),
    ArrowUp: () => arena.pan(0, PAN),
    ArrowDown: () => arena.pan(0, -PAN),
    f: () => arena.setFollows(!arena.follows),
    r: () => arena.toggle("rays"),
    g: () => arena.toggle("ghost"),
    b: () => arena.toggle("belief"),
    c: () => arena.toggle("coverage"),
    m: () => desk.toolbar.toggleMove(),
    d: () => (replayer ? undefined : drive.start()),
    q: () => hands.turn(Math.PI / 12),
    e: () => hands.turn(-Math.PI / 12),
    t: () => desk.switchTheme(),
    y: () => desk.cable.toggle(),
    "?": () => desk.help.showModal(),
    "[": () => next(store, -1),
    "]": () => next(store, 1),
    Escape: () => escape(desk),
  };
  const action = actions[event.key] ?? actions[event.key.toLowerCase()];
  if (!action) return false;
  action();
  return true;
}

function next(store: Store, by: number): void {
  const robots = store.description?.robots ?? [];
  const robot = robots[(store.robotIndex + by + robots.length) % Math.max(1, robots.length)];
  if (robot) store.chooseRobot(robot.robot);
}

function escape({ arena, hands, drive, toolbar }: Desk): void {
  if (arena.held) hands.drop();
  else if (drive.state !== "off") drive.stop();
  else if (hands.moves) toolbar.toggleMove();
}
