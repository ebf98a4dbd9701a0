/**
 * One socket to the server, on which many calls are under way. When it breaks, all calls fail, and it is opened again
 * after a while that grows.
 */
import { create, toBinary } from "@bufbuild/protobuf";
import { CloseCallSchema, PageRequestSchema, type PageRequest, type PageResponse } from "../gen/baudbot/v1/page_pb";
import { decode, type Frame } from "./frames";

export type Request = PageRequest["request"];
export type Response = PageResponse["response"];

/** Why a call failed. */
export class CallError extends Error {
  constructor(
    /** Name of the gRPC status code, or `UNAVAILABLE` if there is no connection. */
    readonly code: string,
    message: string,
  ) {
    super(message);
  }
}

/** What becomes of a call. */
export interface Listener {
  response?(response: Response): void;
  frame?(frame: Frame): void;
  /** It is over; without an error it was closed. */
  over(error?: CallError): void;
}

/** How the connection is. */
export type Link = { state: "connecting" } | { state: "open" } | { state: "waiting"; retryAt: number };

/** The socket as far as it is needed here; tests have one of their own. */
export type Socket = Pick<WebSocket, "send" | "close" | "readyState"> & {
  binaryType: string;
  onopen: ((event: never) => void) | null;
  onclose: ((event: never) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
};

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 10_000;

/** To the server that the page came from. */
export function connectionHome(): Connection {
  const scheme = location.protocol === "https:" ? "wss" : "ws";
  return new Connection(() => new WebSocket(`${scheme}://${location.host}/page`));
}

export class Connection {
  link: Link = { state: "connecting" };
  /** Called when `link` has changed. */
  changed: () => void = () => {};
  /** Wall-clock time spent with messages that came, in milliseconds; whoever measures sets it back. */
  busy_ms = 0;
  private socket: Socket | undefined;
  private lastCall = 0;
  private wait_ms = FIRST_WAIT_MS;
  private readonly calls = new Map<number, Listener>();

  constructor(private readonly connect: () => Socket) {}

  open(): void {
    this.set({ state: "connecting" });
    const socket = this.connect();
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait_ms = FIRST_WAIT_MS;
      this.set({ state: "open" });
    };
    socket.onmessage = (event) => this.receive(event.data as ArrayBuffer);
    socket.onclose = () => this.broken();
    this.socket = socket;
  }

  /** Asks; the listener hears what becomes of it. Returns the call's number. */
  begin(request: Request, listener: Listener): number {
    const call = this.nextCall();
    this.calls.set(call, listener);
    if (!this.send(call, request)) {
      this.calls.delete(call);
      queueMicrotask(() => listener.over(new CallError("UNAVAILABLE", "not connected to the server")));
    }
    return call;
  }

  /** Says more on a call that is under way; `false` if it could not be said. */
  send(call: number, request: Request): boolean {
    if (this.link.state !== "open" || !this.socket || !this.calls.has(call)) return false;
    this.socket.send(toBinary(PageRequestSchema, create(PageRequestSchema, { call, request })));
    return true;
  }

  /** Ends a stream. Nothing more is heard of it, though the server may still answer. */
  end(call: number): void {
    this.send(call, { case: "close", value: create(CloseCallSchema) });
    this.calls.delete(call);
  }

  private nextCall(): number {
    do this.lastCall = (this.lastCall % 0xffff_ffff) + 1;
    while (this.calls.has(this.lastCall));
    return this.lastCall;
  }

  private receive(data: ArrayBuffer): void {
    const begun = performance.now();
    try {
      const incoming = decode(new Uint8Array(data));
      const listener = this.calls.get(incoming.call);
      if (!listener) return;
      if ("watch" in incoming) listener.frame?.(incoming.watch);
      else this.hear(incoming.call, listener, incoming.response);
    } finally {
      this.busy_ms += performance.now() - begun;
    }
  }

  private hear(call: number, listener: Listener, response: Response): void {
    if (response.case === "failure") {
      this.calls.delete(call);
      listener.over(new CallError(response.value.code, response.value.message));
    } else if (response.case === "closed") {
      this.calls.delete(call);
      listener.over();
    } else {
      listener.response?.(response);
    }
  }

  /** Forgets a call that has had its only answer. */
  forget(call: number): void {
    this.calls.delete(call);
  }

  private broken(): void {
    this.socket = undefined;
    const wait_ms = this.wait_ms;
    this.wait_ms = Math.min(2 * wait_ms, LONGEST_WAIT_MS);
    this.set({ state: "waiting", retryAt: Date.now() + wait_ms });
    const calls = [...this.calls.values()];
    this.calls.clear();
    for (const listener of calls) listener.over(new CallError("UNAVAILABLE", "the connection to the server is lost"));
    setTimeout(() => this.open(), wait_ms);
  }

  private set(link: Link): void {
    this.link = link;
    this.changed();
  }
}

/** Asks what has one answer. */
export function ask<C extends NonNullable<Response["case"]>>(
  connection: Connection,
  kind: C,
  request: Extract<Request, { case: C }>["value"],
): Promise<Extract<Response, { case: C }>["value"]> {
  return new Promise((resolve, reject) => {
    const call = connection.begin({ case: kind, value: request } as Request, {
      response(response) {
        connection.forget(call);
        if (response.case === kind) resolve(response.value as never);
        else reject(new CallError("INTERNAL", `the server answered ${String(response.case)} to ${kind}`));
      },
      over: (error) => reject(error ?? new CallError("CANCELLED", "the server closed the call")),
    });
  });
}
