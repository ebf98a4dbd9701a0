/**
 * A server of a made-up world, to try the page without baudbot: `npm run mock -- --port 7410 --robots 3`. It serves
 * dist/ with the headers of the real one, and speaks the protocol of page.proto on /page.
 */
import { once } from "node:events";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { WebSocketServer, type WebSocket } from "ws";
import type { AttachRequest } from "../src/gen/baudbot/v1/brain_link_pb";
import { CableDirection, type WatchRequest } from "../src/gen/baudbot/v1/observe_pb";
import { WorldState } from "../src/gen/baudbot/v1/world_pb";
import { requestFrom, responseTo, type Asked, type Reply } from "./calls";
import { STEP_NS } from "./mock_scene";
import { files, MAGIC, MockReplay, type MockFile } from "./mock_replay";
import { MockWorld } from "./mock_world";

/** As strict as that of the real server. */
const CSP =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self' ws: wss:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
const TYPES: Record<string, string> = { html: "text/html", js: "text/javascript", css: "text/css" };

class Refusal extends Error {
  constructor(
    readonly code: string,
    message: string,
  ) {
    super(message);
  }
}

interface Watch {
  call: number;
  world: MockWorld;
  every: bigint;
  details: number[];
  pins: boolean;
  shown: bigint;
}

interface Attachment {
  call: number;
  world: MockWorld;
  robot: number;
  turn: bigint;
  /** It stands when its brain is gone. */
  stops: boolean;
}

/** One page. */
class Session {
  private watches: Watch[] = [];
  private attachments: Attachment[] = [];

  constructor(
    private readonly socket: WebSocket,
    private readonly worlds: Map<string, MockWorld>,
    private readonly files: Map<string, MockFile>,
  ) {
    socket.on("message", (data) => this.take(requestFrom(new Uint8Array(data as Buffer))));
    socket.on("close", () => this.attachments.forEach((one) => this.let_go(one)));
  }

  private reply(call: number, reply: Reply): void {
    this.socket.send(responseTo(call, reply));
  }

  private take({ call, request }: { call: number; request: Asked }): void {
    try {
      const reply = this.handle(call, request);
      if (reply) this.reply(call, reply);
    } catch (error) {
      const code = error instanceof Refusal ? error.code : "INTERNAL";
      this.reply(call, { case: "failure", value: { code, message: String((error as Error).message) } });
    }
  }

  private find(name: string): MockWorld {
    const world = this.worlds.get(name);
    if (!world) throw new Refusal("NOT_FOUND", `world: there is no world \`${name}\``);
    return world;
  }

  private handle(call: number, request: Asked): Reply | undefined {
    const answer = (kind: string, world?: MockWorld, more = {}) =>
      ({ case: kind, value: { status: world?.status(), ...more } }) as unknown as Reply;
    switch (request.case) {
      case "listWorlds":
        return {
          case: "listWorlds",
          value: { worlds: [...this.worlds.values()].map((world) => world.status()) },
        } as Reply;
      case "createWorld":
        return this.create(request.value.world, request.value.scenarioToml, request.value.savedMcap);
      case "listRecordings":
        return { case: "listRecordings", value: { recordings: [...this.files.values()] } } as unknown as Reply;
      case "openRecording":
        return this.open(request.value.recording, request.value.world);
      case "describeWorld":
        return { case: "describeWorld", value: this.find(request.value.world).description };
      case "getCoverage":
        return this.map(this.find(request.value.world));
      case "watch":
        return this.watch(call, this.find(request.value.world), request.value.everyTicks, request.value);
      case "watchCable":
        return this.watchCable(call, this.find(request.value.world));
      case "attach":
        return this.attach(call, request.value);
      case "close":
        return this.close(call);
      case "deleteWorld": {
        const world = this.find(request.value.world);
        this.worlds.delete(world.name);
        return answer("deleteWorld", world);
      }
      case "getBudget":
      case "getLimits":
        throw new Refusal("UNIMPLEMENTED", "the mock does not do that");
      default: {
        const world = this.find(request.value.world);
        return answer(request.case, world, this.change(world, request) ?? this.record(world, request));
      }
    }
  }

  private change(world: MockWorld, request: Asked): object | undefined {
    const refused = ["resetWorld", "snapshotWorld", "restoreWorld", "intervene", "startRecording"];
    if (isReplay(world) && refused.includes(request.case))
      throw new Refusal("FAILED_PRECONDITION", `world \`${world.name}\` replays a recording`);
    switch (request.case) {
      case "startWorld":
        world.state = WorldState.RUNNING;
        break;
      case "pauseWorld":
        world.state = WorldState.PAUSED;
        break;
      case "setPace":
        if (request.value.pace) world.pace = request.value.pace;
        world.state = request.value.pace?.kind.case === "stepped" ? WorldState.PAUSED : world.state;
        break;
      case "stepWorld":
        if (world.pace.kind.case !== "stepped")
          throw new Refusal("FAILED_PRECONDITION", "the world's pace is not stepped; set it with SetPace");
        for (let i = 0n; i < (request.value.ticks || 1n); i++) advance(world);
        break;
      case "resetWorld":
        world.reset();
        break;
      case "snapshotWorld": {
        const snapshot = BigInt(world.snapshots.size + 1);
        world.snapshots.set(snapshot, { tick: world.tick, bodies: structuredClone(world.bodies) });
        return { snapshot };
      }
      case "restoreWorld": {
        const kept = world.snapshots.get(request.value.snapshot);
        if (!kept) throw new Refusal("NOT_FOUND", "snapshot: not kept");
        [world.tick, world.bodies] = [kept.tick, structuredClone(kept.bodies)];
        break;
      }
      case "intervene":
        this.intervene(world, request.value.intervention);
        break;
      default:
        return undefined;
    }
    return {};
  }

  /** What has to do with recordings. */
  private record(world: MockWorld, request: Asked): object {
    switch (request.case) {
      case "saveWorld":
        return { savedMcap: Uint8Array.of(...MAGIC, 1, 2, 3), tick: world.tick };
      case "startRecording":
        if (world.recording) throw new Refusal("FAILED_PRECONDITION", "it is being recorded already");
        world.recording = { recording: `${world.name}-1`, bytes: 0n, ticks: 0n, problem: "" };
        return {};
      case "stopRecording": {
        const { recording } = world;
        world.recording = undefined;
        if (!recording) throw new Refusal("FAILED_PRECONDITION", "it is not being recorded");
        const last = recording.ticks > 200n ? recording.ticks : 200n;
        const modifiedUnixNs = BigInt(Date.now()) * 1_000_000n;
        this.files.set(recording.recording, { ...recording, modifiedUnixNs, last, differs: "", cutOff: false });
        return { recording };
      }
    }
    if (!isReplay(world)) throw new Refusal("FAILED_PRECONDITION", `world \`${world.name}\` replays no recording`);
    if (request.case === "describeReplay") return world.describeReplay();
    if (request.case === "forkReplay") world.fork();
    if (request.case === "seekReplay") {
      world.seek(request.value.tick);
      for (const session of sessions) session.leapt(world);
    }
    return {};
  }

  private open(recording: string, name: string): Reply {
    const file = this.files.get(recording);
    if (!file) throw new Refusal("NOT_FOUND", `recording: there is no \`${recording}\``);
    const world = new MockReplay(name || recording, file);
    if (this.worlds.has(world.name)) throw new Refusal("ALREADY_EXISTS", `world: \`${world.name}\` exists already`);
    this.worlds.set(world.name, world);
    return { case: "openRecording", value: { status: world.status() } } as Reply;
  }

  private intervene(world: MockWorld, what: Extract<Asked, { case: "intervene" }>["value"]["intervention"]): void {
    if (what.case === "placeThing")
      Object.assign(world.box, { xM: what.value.xM, yM: what.value.yM, headingRad: what.value.headingRad });
    if (what.case === undefined || what.case === "placeThing") return;
    const index = world.description.robots.findIndex(({ robot }) => robot === what.value.robot);
    const body = world.bodies[index];
    if (!body) throw new Refusal("NOT_FOUND", `robot: there is no robot \`${what.value.robot}\``);
    if (what.case === "placeRobot") {
      if (world.hits(what.value.xM, what.value.yM, 0.2))
        throw new Refusal("FAILED_PRECONDITION", `robot \`${what.value.robot}\` would touch a wall there`);
      Object.assign(body, { x_m: what.value.xM, y_m: what.value.yM, heading_rad: what.value.headingRad });
    }
    if (what.case === "pullCable") body.cable = !what.value.pulled;
    // The programs of made-up brains know how to begin them anew.
    if (what.case === "detachBrain" && what.value.restart) body.restarts++;
    else if (what.case === "detachBrain") body.brain = "";
  }

  private create(name: string, toml: string, saved: Uint8Array): Reply {
    if (saved.length > 0 && (toml !== "" || MAGIC.some((byte, i) => saved[i] !== byte)))
      throw new Refusal("INVALID_ARGUMENT", "saved_mcap: is no saved state");
    const wrong = toml.split("\n").findIndex((line) => line.includes("WRONG"));
    if (wrong >= 0)
      throw new Refusal("INVALID_ARGUMENT", `TOML parse error at line ${wrong + 1}, column 1\nWRONG is no key`);
    const world = new MockWorld(name || "mock", 3);
    if (this.worlds.has(world.name))
      throw new Refusal("ALREADY_EXISTS", `world: there is a world \`${world.name}\` already`);
    this.worlds.set(world.name, world);
    return { case: "createWorld", value: { status: world.status() } } as Reply;
  }

  private watch(call: number, world: MockWorld, every: bigint, wanted: WatchRequest): undefined {
    const details = wanted.details
      .map((name) => world.description.robots.findIndex(({ robot }) => robot === name))
      .filter((i) => i >= 0);
    const since = world.tick > 200n ? world.tick - 200n : 0n;
    world.pinsAsked = wanted.pins;
    this.reply(call, { case: "watch", value: world.frame(details, since, wanted.pins) });
    this.watches.push({ call, world, every: every || 5n, details, pins: wanted.pins, shown: world.tick });
  }

  /** An exchange that is over, and a line that nobody understands. */
  private watchCable(call: number, world: MockWorld): undefined {
    const ns = world.tick * 10_000_000n;
    const item = (direction: CableDirection, after_ms: bigint, line: string, text: string, ageNs?: bigint) => ({
      direction,
      fromNs: ns,
      toNs: ns + after_ms * 1_000_000n,
      data: new TextEncoder().encode(line),
      size: line.length,
      text,
      understood: !text.startsWith("not"),
      ageNs,
    });
    const { UP, DOWN } = CableDirection;
    const items = [
      item(DOWN, 2n, "N\r", "N: ask proximity"),
      item(UP, 9n, "n,12,0\r\n", "n: proximity 12 0", 20_500_000n),
      item(DOWN, 12n, "Q\r", "not understood (no command): 51 0d; Q"),
    ];
    this.reply(call, { case: "watchCable", value: { items, missedItems: 2n } });
  }

  private map(world: MockWorld): Reply {
    world.mapsAsked++;
    if (!world.counts) throw new Refusal("FAILED_PRECONDITION", `world: \`${world.name}\` counts no coverage`);
    return { case: "getCoverage", value: world.floor.map(world.tick) };
  }

  private attach(call: number, { request }: AttachRequest): undefined {
    if (request.case !== "hello") this.reply(call, { case: "taken" });
    else {
      const world = this.find(request.value.world);
      const robot = world.description.robots.findIndex((one) => one.robot === request.value.robots[0]);
      const body = world.bodies[robot];
      const description = world.description.robots[robot]?.description;
      if (isReplay(world)) throw new Refusal("FAILED_PRECONDITION", `world \`${world.name}\` replays a recording`);
      if (!body || !description) throw new Refusal("NOT_FOUND", "robots: no such robot");
      if (body.brain !== "")
        throw new Refusal(
          "ALREADY_EXISTS",
          `robots[0]: the brain \`${body.brain}\` holds \`${request.value.robots[0]}\``,
        );
      body.brain = request.value.brain;
      this.attachments.push({ call, world, robot, turn: 0n, stops: request.value.stopWhenGone });
      const lockstep = world.pace.kind.case === "lockstep" || world.pace.kind.case === "stepped";
      this.reply(call, {
        case: "attach",
        value: { response: { case: "welcome", value: { stepNs: STEP_NS, lockstep, robots: [description] } } },
      } as unknown as Reply);
    }
    const attachment = this.attachments.find((one) => one.call === call);
    const body = attachment?.world.bodies[attachment.robot];
    if (request.case !== "step" || !body) return;
    for (const { output } of request.value.robots) {
      if (output.case === "command" && body.cable)
        [body.left, body.right] = [output.value.leftSignal, output.value.rightSignal];
    }
  }

  private close(call: number): Reply {
    this.watches = this.watches.filter((watch) => watch.call !== call);
    for (const one of this.attachments.filter((one) => one.call === call)) this.let_go(one);
    this.attachments = this.attachments.filter((one) => one.call !== call);
    return { case: "closed" };
  }

  private let_go({ world, robot, stops }: Attachment): void {
    const body = world.bodies[robot];
    if (body) Object.assign(body, { brain: "", ...(stops && { left: 0, right: 0 }) });
  }

  /** After a seek: a frame at once, with what is known of the time before. */
  leapt(world: MockWorld): void {
    for (const watch of this.watches.filter((one) => one.world === world)) {
      const since = world.tick > 200n ? world.tick - 200n : 0n;
      this.reply(watch.call, { case: "watch", value: world.frame(watch.details, since, watch.pins) });
      watch.shown = world.tick;
    }
  }

  /** After a tick: frames and Turns. */
  ticked(world: MockWorld): void {
    for (const watch of this.watches) {
      if (watch.world !== world || (world.tick % watch.every !== 0n && world.tick > watch.shown)) continue;
      this.reply(watch.call, {
        case: "watch",
        value: world.frame(watch.details, watch.shown < world.tick ? watch.shown : 0n, watch.pins),
      });
      watch.shown = world.tick;
    }
    for (const attachment of this.attachments.filter((one) => one.world === world)) {
      attachment.turn++;
      const turn = {
        tick: world.tick,
        turn: attachment.turn,
        robots: [{ robot: 0, atNs: world.tick * STEP_NS, readings: [] }],
      };
      this.reply(attachment.call, {
        case: "attach",
        value: { response: { case: "turn", value: turn } },
      } as unknown as Reply);
    }
  }
}

const sessions = new Set<Session>();

function isReplay(world: MockWorld): world is MockReplay {
  return world instanceof MockReplay && world.isReplay;
}

function advance(world: MockWorld): void {
  world.step();
  for (const session of sessions) session.ticked(world);
}

const DIST = new URL("../dist/", import.meta.url);

/** A server that runs. */
export interface Mock {
  port: number;
  stop: () => void;
  worlds: Map<string, MockWorld>;
  /** What was posted, newest last. */
  posted: { path: string; type: string; body: Buffer }[];
}

/** Begins to serve, at port 0 wherever there is room. */
export async function serve(port: number, robots: number): Promise<Mock> {
  const worlds = new Map([
    ["arena", new MockWorld("arena", robots)],
    ["second", new MockWorld("second", 3, false)],
  ]);
  const folder = files();
  const posted: Mock["posted"] = [];
  const http = createServer((request, response) => {
    if (request.method === "POST") {
      const parts: Buffer[] = [];
      request.on("data", (part: Buffer) => parts.push(part));
      request.on("end", () => {
        const type = request.headers["content-type"] ?? "";
        posted.push({ path: request.url ?? "", type, body: Buffer.concat(parts) });
        response.writeHead(204).end();
      });
      return;
    }
    const path = (request.url ?? "/").split("?")[0] === "/" ? "index.html" : (request.url ?? "").slice(1);
    if (!/^(index\.html|viewer\.(js|css))$/.test(path)) return void response.writeHead(404).end();
    const type = TYPES[path.split(".").pop() ?? ""] ?? "";
    response
      .writeHead(200, { "content-type": `${type}; charset=utf-8`, "content-security-policy": CSP })
      .end(readFileSync(new URL(path, DIST)));
  });
  new WebSocketServer({ server: http, path: "/page" }).on("connection", (socket) => {
    const session = new Session(socket, worlds, folder);
    sessions.add(session);
    socket.on("close", () => sessions.delete(session));
  });
  const timer = setInterval(() => {
    for (const world of worlds.values())
      if (world.state === WorldState.RUNNING && world.pace.kind.case !== "stepped") advance(world);
  }, 10);
  http.listen(port, "127.0.0.1");
  await once(http, "listening");
  const stop = () => {
    clearInterval(timer);
    http.closeAllConnections();
    http.close();
  };
  return { port: (http.address() as AddressInfo).port, stop, worlds, posted };
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const option = (name: string, otherwise: number) =>
    Number(process.argv[process.argv.indexOf(`--${name}`) + 1] ?? 0) || otherwise;
  const wanted = process.argv.includes("--port") ? option("port", 7410) : 7410;
  const { port } = await serve(wanted, process.argv.includes("--robots") ? option("robots", 3) : 3);
  console.log(`http://127.0.0.1:${port}/`);
}
