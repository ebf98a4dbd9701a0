/** Puts the page together. */
import { create } from "@bufbuild/protobuf";
import { readChoice, writeChoice } from "./address";
import { Arena } from "./arena/arena";
import { Hands } from "./arena/hands";
import type { Held } from "./arena/scene";
import { el, find, setPressed } from "./dom";
import { PlaceRobotSchema, PlaceThingSchema } from "./gen/baudbot/v1/control_pb";
import { host } from "./host";
import { listen } from "./keys";
import { wrapped } from "./model/pose";
import { Store } from "./model/store";
import { Connection } from "./net/connection";
import { Drive } from "./net/drive";
import { Orders } from "./net/orders";
import { Recordings } from "./net/recordings";
import { Replayer } from "./net/replayer";
import { showToken, takeToken, wantsToken } from "./net/session";
import { Surveyor } from "./net/surveyor";
import { Watcher } from "./net/watcher";
import { CablePanel } from "./panels/cable";
import { ChartPanel } from "./panels/chart";
import { Controls } from "./panels/controls";
import { CreateDialog } from "./panels/create";
import { FilmDialog } from "./panels/film";
import { HandSection } from "./panels/hand";
import { helpDialog } from "./panels/help";
import { Pad } from "./panels/pad";
import { RecordControl } from "./panels/record_control";
import { RecordingsSection } from "./panels/recordings";
import { ReplayBar } from "./panels/replay_bar";
import { RobotPanel } from "./panels/robot";
import { StatusBar } from "./panels/status_bar";
import { TimingPanel } from "./panels/timing";
import { TokenDialog } from "./panels/token";
import { Toolbar } from "./panels/toolbar";
import { WorldsPanel } from "./panels/worlds";
import { ThemeSwitch } from "./theme";
import { exposeForTests } from "./testing";

/** How often the list of worlds is asked for; a server with large ones is asked less often. */
const LIST_MS = 1000;

/** How often the list of recordings is. */
const RECORDINGS_MS = 5000;

export const connection = new Connection(() => host.connect());
export const store = new Store();
const themes = new ThemeSwitch();
const watcher = new Watcher(connection, store);
export const orders = new Orders(connection, store, watcher);
const drive = new Drive(connection, store);
const replayer = new Replayer(connection, store, orders);
const recordings = new Recordings(connection, store, orders);

const canvas = el("canvas", {
  class: "arena-canvas",
  test: "arena-canvas",
  role: "application",
  label: "Arena",
  attributes: { tabindex: "0" },
});
const arena = new Arena(canvas, store, themes.theme);
const surveyor = new Surveyor(connection, store, () => arena.layers.coverage);
const hands = new Hands(arena, (held) => void putDown(held));
const help = helpDialog();
const cable = new CablePanel(store, connection);
const toolbar = new Toolbar(
  arena,
  hands,
  () => help.showModal(),
  () => themes.toggle(),
);
const create_dialog = new CreateDialog(orders);
const worlds = new WorldsPanel(store, orders, new RecordingsSection(recordings, store), () => create_dialog.show());
const chart = new ChartPanel(store, themes.theme);
const robot = new RobotPanel(store, chart, new HandSection(store, orders, drive), themes.theme);
const timing = new TimingPanel(store, themes.theme, cable);
const controls = new Controls(store, orders, new RecordControl(store, recordings));
const film = new FilmDialog({ store, connection, watcher, surveyor, orders, replayer, arena });
const replay = new ReplayBar(store, orders, replayer, () => film.show(), themes.theme);
const status = new StatusBar(store, connection, watcher);
const pad = new Pad(drive);
const token = new TokenDialog(() => connection.open());

lay();
store.on("worlds", () => toolbar.allowMove(!replayer.isOn));
store.on("world", () => toolbar.allowMove(!replayer.isOn));
arena.changed = () => {
  toolbar.refresh();
  surveyor.look();
};
themes.changed = (theme) => {
  for (const part of [arena, chart, robot, timing, replay]) part.setTheme(theme);
};
listen({ store, arena, hands, orders, drive, replayer, toolbar, cable, help, switchTheme: () => themes.toggle() });
keepAddress();
connection.changed = () => {
  status.refresh();
  if (connection.link.state === "open") void arrive();
  if (connection.link.state === "waiting") void askForToken();
};
void begin();
setTimeout(() => void poll(), LIST_MS);
setInterval(() => {
  if (!document.hidden && recordings.hasFolder) void recordings.list();
}, RECORDINGS_MS);
exposeForTests({ store, arena, watcher, replayer });

/** Puts the parts into their places, and makes the tabs of small screens. */
function lay(): void {
  find("bar").append(controls.element);
  find("arena").append(
    el("div", { class: "arena-view" }, canvas, toolbar.element, pad.element, cable.element),
    replay.element,
  );
  find("worlds").append(worlds.element);
  find("robot").append(robot.element);
  find("timing").append(timing.element);
  find("chart").append(chart.element);
  find("page").append(
    status.element,
    status.notes,
    status.banner,
    help,
    create_dialog.element,
    film.element,
    token.element,
  );
  const sheets = ["robot", "timing", "chart", "worlds"];
  const tabs = sheets.map((name) => {
    const click = () => showSheet(name);
    return el("button", {
      type: "button",
      text: name,
      title: `Show ${name}`,
      click,
      attributes: { "data-sheet": name },
    });
  });
  find("tabs").append(...tabs);
  showSheet("robot");
}

/** On a small screen one panel is shown at a time; choosing it again hides it. */
function showSheet(name: string): void {
  const { dataset } = document.body;
  dataset.sheet = dataset.sheet === name && dataset.ready ? "" : name;
  dataset.ready = "yes";
  for (const tab of find("tabs").children)
    setPressed(tab as HTMLElement, (tab as HTMLElement).dataset.sheet === dataset.sheet);
}

/** With the token of the page's address, if there is one. */
async function begin(): Promise<void> {
  const given = takeToken();
  const problem = given === "" ? "" : await showToken(given);
  if (problem === "") connection.open();
  else token.show(problem);
}

/** A browser does not say why a socket was refused. */
async function askForToken(): Promise<void> {
  if (await wantsToken()) token.show();
}

/** The connection is there, perhaps again: what the address says is looked at, or else the first world. */
async function arrive(): Promise<void> {
  cable.watch.again();
  void recordings.list();
  if (!(await orders.list())) return;
  const wanted = readChoice(location.hash);
  const known = store.worlds.some((status) => status.world === wanted.world);
  if (store.world !== "") return void watcher.begin();
  if (known) orders.choose(wanted.world, wanted.robot);
  else if (store.worlds[0]) orders.choose(store.worlds[0].world);
}

/** Asks for the worlds again and again. A server that needs long for it gets time. */
async function poll(): Promise<void> {
  const begun = performance.now();
  if (!document.hidden && connection.link.state === "open") {
    await orders.list();
    if (store.world === "" && store.worlds[0]) orders.choose(store.worlds[0].world);
  }
  const took_ms = performance.now() - begun;
  setTimeout(() => void poll(), Math.max(LIST_MS, 20 * took_ms));
}

function keepAddress(): void {
  const write = () => {
    const hash = writeChoice(store);
    if (hash !== "" && store.description && location.hash !== hash) history.replaceState(null, "", hash);
  };
  store.on("robot", write);
  window.addEventListener("hashchange", () => {
    const { world, robot } = readChoice(location.hash);
    if (world !== store.world && store.worlds.some((status) => status.world === world)) orders.choose(world, robot);
    else if (world === store.world && robot !== "") store.chooseRobot(robot);
  });
}

/** Somebody has carried a robot or a thing elsewhere. If the server does not want it there, it stays where it was. */
async function putDown({ kind, index, pose }: Held): Promise<void> {
  const place = { xM: pose.x_m, yM: pose.y_m, headingRad: wrapped(pose.heading_rad) };
  const named = kind === "robot" ? store.description?.robots[index]?.robot : store.description?.things[index]?.thing;
  if (named === undefined) return;
  if (kind === "robot") {
    const done = await orders.intervene({
      case: "placeRobot",
      value: create(PlaceRobotSchema, { robot: named, ...place }),
    });
    // It did not come there on its wheels.
    if (done) store.trails.all[index]?.clear();
  } else await orders.intervene({ case: "placeThing", value: create(PlaceThingSchema, { thing: named, ...place }) });
}
