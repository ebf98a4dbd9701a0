/** The worker that has the world: it lets the world's program work in turns, and carries messages to and fro. */
import { Engine, ORDERS } from "./engine";
import type { FromWorld, ToWorld } from "./messages";
import { unpack } from "./unpack";

/** The longest turn: others wait so long until they are heard. */
const TURN_MS = 8;
/** When it is looked whether a timer is due, if there is nothing to do. */
const REST_MS = 4;

const ports = new Map<number, MessagePort>();
let engine: Engine | undefined;
/** What came before the program had begun. */
let early: ((engine: Engine) => void)[] = [];
let rest: ReturnType<typeof setTimeout> | undefined;
let isUnderWay = false;
/** How a worker has its next turn after all that waits has been heard. */
const next = new MessageChannel();

next.port1.onmessage = () => {
  isUnderWay = false;
  attempt(work);
};

onmessage = ({ data }: MessageEvent<ToWorld>) => {
  if (data.kind === "begin") return void begin(data.wasm);
  if (data.kind === "connect") return connect(data.number, data.port);
  if (data.kind === "close") return close(data.number);
  if (data.kind === "order")
    return put(ORDERS, new TextEncoder().encode(JSON.stringify({ id: data.id, order: data.order })));
  whenThere((engine) => {
    const result = engine.recording(data.name);
    const answer = result ? { result } : { error: `there is no recording ${data.name}` };
    tell({ kind: "answer", id: data.id, ...answer });
  });
};

async function begin(packed: ArrayBuffer): Promise<void> {
  try {
    engine = await Engine.begin(unpack(packed), (line) => console.error(line));
    for (const does of early) does(engine);
    early = [];
    wake();
  } catch (error) {
    tell({ kind: "failed", error: String(error) });
  }
}

function connect(number: number, port: MessagePort): void {
  ports.set(number, port);
  port.onmessage = ({ data }: MessageEvent<ArrayBuffer>) => put(number, new Uint8Array(data));
}

function close(number: number): void {
  ports.get(number)?.close();
  ports.delete(number);
  whenThere((engine) => engine.close(number));
}

function put(port: number, message: Uint8Array): void {
  whenThere((engine) => engine.take(port, message));
}

function whenThere(does: (engine: Engine) => void): void {
  if (!engine) return void early.push(does);
  attempt(() => does(engine!));
  wake();
}

function wake(): void {
  clearTimeout(rest);
  if (isUnderWay) return;
  isUnderWay = true;
  next.port2.postMessage(0);
}

function work(): void {
  if (!engine) return;
  const hasMore = engine.turn(TURN_MS);
  for (const [port, message] of engine.messages()) {
    if (port === ORDERS) hear(JSON.parse(new TextDecoder().decode(message)));
    else ports.get(port)?.postMessage(message.buffer, [message.buffer]);
  }
  if (hasMore) wake();
  else rest = setTimeout(wake, REST_MS);
}

/** An answer to an order, or that a brain does not drive any more (`viewer/page/src/orders.rs`). */
function hear(said: {
  id: number;
  result?: unknown;
  error?: string;
  over?: Extract<FromWorld, { kind: "over" }>;
}): void {
  if (said.over) tell({ ...said.over, kind: "over" });
  else tell({ kind: "answer", id: said.id, result: said.result, error: said.error });
}

/** A program that has panicked is not to be called again. */
function attempt(does: () => void): void {
  try {
    does();
  } catch (error) {
    engine = undefined;
    tell({ kind: "failed", error: String(error) });
  }
}

function tell(what: FromWorld): void {
  postMessage(what);
}
