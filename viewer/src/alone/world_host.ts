/** The server that the page has in itself: a worker with the world's program. */
import type { Host } from "../host";
import type { Socket } from "../net/connection";
import type { FromWorld, ToWorld } from "./messages";
import type { Parts } from "./parts";
import { PortSocket } from "./port_socket";

/** A scenario, preset or brain, for lists. */
export interface Named {
  name: string;
  about: string;
}

export interface Catalogue {
  scenarios: Named[];
  brains: (Named & { parameters: string[] })[];
  presets: (Named & { kind: string })[];
}

type Over = Extract<FromWorld, { kind: "over" }>;

export class WorldHost implements Host {
  /** A brain of the repertoire does not drive any more. */
  over: (over: Over) => void = () => {};
  /** Nothing goes on. */
  failed: (error: string) => void = () => {};
  private readonly worker: Worker;
  private readonly answers = new Map<number, { resolve(result: unknown): void; reject(error: Error): void }>();
  private last = 0;
  private lastPort = 0;

  constructor(parts: Parts) {
    this.worker = new Worker(parts.world);
    this.worker.onmessage = ({ data }: MessageEvent<FromWorld>) => this.hear(data);
    this.worker.onerror = ({ message }) => this.failed(message || "the worker of the world could not be loaded");
    parts.wasm().then(
      (wasm) => this.tell({ kind: "begin", wasm }, [wasm]),
      (error: unknown) => this.failed(String(error)),
    );
  }

  connect(): Socket {
    const { port, close } = this.port();
    return new PortSocket(port, close);
  }

  /** A port for calls of another client, and what is to be called when that is gone. */
  port(): { port: MessagePort; close: () => void } {
    const { port1, port2 } = new MessageChannel();
    const number = ++this.lastPort;
    this.tell({ kind: "connect", number, port: port1 }, [port1]);
    return { port: port2, close: () => this.tell({ kind: "close", number }) };
  }

  recording(name: string): Promise<Uint8Array> {
    return this.answer((id) => ({ kind: "recording", id, name }));
  }

  /** Which scenarios, brains and presets there are. */
  catalogue(): Promise<Catalogue> {
    return this.order({ catalogue: {} });
  }

  /** The text of a scenario. */
  scenario(name: string): Promise<string> {
    return this.order({ scenario: name });
  }

  /** The text of a brain of the repertoire, if it is described in TOML. */
  brain(name: string): Promise<string | null> {
    return this.order({ brain: name });
  }

  /** Lets a brain of the repertoire, or one that is described in TOML, drive robots. */
  attach(world: string, robots: string[], brain: { brain: string } | { text: string }): Promise<{ brain: string }> {
    return this.order({ attach: { world, robots, ...brain } });
  }

  private order<T>(order: unknown): Promise<T> {
    return this.answer((id) => ({ kind: "order", id, order }));
  }

  private answer<T>(message: (id: number) => ToWorld): Promise<T> {
    const id = ++this.last;
    return new Promise<T>((resolve, reject) => {
      this.answers.set(id, { resolve: (result) => resolve(result as T), reject });
      this.tell(message(id));
    });
  }

  private hear(said: FromWorld): void {
    if (said.kind === "over") return this.over(said);
    if (said.kind === "failed") return this.failed(said.error);
    const waiting = this.answers.get(said.id);
    this.answers.delete(said.id);
    if (said.error === undefined) waiting?.resolve(said.result);
    else waiting?.reject(new Error(said.error));
  }

  private tell(what: ToWorld, transfer: Transferable[] = []): void {
    this.worker.postMessage(what, transfer);
  }
}
