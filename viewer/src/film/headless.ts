/** Makes the film that the page's address asks for, and posts it to the server: there is nobody to look at the page. */
import { DARK, LIGHT } from "../arena/palette";
import { FIRST_LAYERS } from "../arena/scene";
import { ControlService } from "../gen/baudbot/v1/control_pb";
import { Store } from "../model/store";
import { secondsOf } from "../model/units";
import { host } from "../host";
import { ask, Connection } from "../net/connection";
import { Orders } from "../net/orders";
import { Surveyor } from "../net/surveyor";
import { Watcher } from "../net/watcher";
import { encoderFor, shoot, TYPES } from "./film";
import { planFilm } from "./plan";
import { ReplayProjector } from "./projector";
import { failurePath, readFilmRequest, type FilmRequest } from "./request";
import { Stage, wholeView } from "./stage";

/** How long the server may take for its first answers. */
const MOST_MS = 30_000;

/** Whether the address asked for a film; then this is all that the page does. */
export function filmWasAskedFor(): boolean {
  if (!new URLSearchParams(location.search).has("film")) return false;
  void make().then(
    () => (document.title = "film done"),
    (error: unknown) => fail(error instanceof Error ? error.message : String(error)),
  );
  return true;
}

async function make(): Promise<void> {
  const request = readFilmRequest(location.search, location.origin);
  if (!request) return;
  const connection = new Connection(() => host.connect());
  connection.open();
  const film = await render(connection, request);
  const headers = { "content-type": TYPES[request.format] };
  const body = new Blob([film as Uint8Array<ArrayBuffer>]);
  const answer = await fetch(request.post, { method: "POST", headers, body });
  if (!answer.ok) throw new Error(`${request.post} answered ${answer.status}`);
}

async function render(connection: Connection, request: FilmRequest): Promise<Uint8Array> {
  const store = new Store();
  const watcher = new Watcher(connection, store);
  const orders = new Orders(connection, store, watcher);
  store.on("note", ({ text, kind }) => kind === "error" && console.warn(text));
  await until("a connection", () => connection.link.state === "open", connection);
  if (!(await orders.list())) throw new Error("the server does not list its worlds");
  const { worlds } = store;
  const chosen = worlds.find(({ world, replay }) =>
    request.world === "" ? replay !== undefined : world === request.world,
  );
  if (!chosen) throw new Error(`there is no world \`${request.world}\``);
  if (!chosen.replay) throw new Error(`world \`${chosen.world}\` does not replay a recording`);
  await ask(connection, ControlService.method.pauseWorld, { world: chosen.world });
  orders.choose(chosen.world, request.robot);
  await until("a frame", () => store.frame !== undefined, connection);
  const range = { first: chosen.replay.firstTick, last: chosen.replay.lastTick };
  const ticks = planFilm(range, secondsOf(chosen.stepNs), request);
  const view = wholeView(store, request.width);
  return shoot({
    ticks,
    fps: request.fps,
    projector: new ReplayProjector(connection, store, watcher, new Surveyor(connection, store, () => true)),
    stage: new Stage(store, { theme: request.dark ? DARK : LIGHT, layers: FIRST_LAYERS, follows: false }, view),
    encoder: await encoderFor(request.format, view, request.fps),
    progress: (done, all) => (document.title = `film ${Math.floor((100 * done) / all)} %`),
  });
}

async function until(what: string, is: () => boolean, connection: Connection): Promise<void> {
  const begun = performance.now();
  while (!is()) {
    if (performance.now() - begun > MOST_MS) throw new Error(`${what} has not arrived (${connection.link.state})`);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
}

async function fail(why: string): Promise<void> {
  try {
    await fetch(failurePath(location.search, location.origin), { method: "POST", body: why });
  } catch {
    // The title says it, too.
  }
  document.title = `film failed: ${why}`;
}
