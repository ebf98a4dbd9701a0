/**
 * One socket to the server, on which many calls are under way. When it breaks, all calls fail, and it is opened again
 * after a while that grows.
 *
 * Methods are called by their descriptors, which the contract generates: there is no list of calls here.
 */
import {
  create,
  fromBinary,
  toBinary,
  type DescMessage,
  type DescMethod,
  type DescMethodUnary,
  type MessageInitShape,
  type MessageShape,
} from "@bufbuild/protobuf";
import { CloseCallSchema, PageRequestSchema, PageResponseSchema } from "../gen/baudbot/v1/page_pb";

/** A method that takes such requests. */
type Method<I extends DescMessage> = DescMethod & { input: I };

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
  /** A response of the method, serialised. */
  message(bytes: Uint8Array): void;
  /** The server has a further request of the call. */
  taken?(): void;
  /** The call is over; without an error it was closed. */
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

export class Connection {
  link: Link = { state: "connecting" };
  /** Called when `link` has changed. */
  changed: () => void = () => {};
  /** Wall-clock time spent with messages that came, in milliseconds; whoever measures sets it back. */
  busy_ms = 0;
  private socket: Socket | undefined;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private lastCall = 0;
  private wait_ms = FIRST_WAIT_MS;
  private readonly calls = new Map<number, Listener>();

  constructor(private readonly connect: () => Socket) {}

  open(): void {
    clearTimeout(this.retry);
    if (this.socket) return;
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

  /** Begins a call; the listener hears what becomes of it. Returns the call's number. */
  begin<I extends DescMessage>(method: Method<I>, request: MessageInitShape<I>, listener: Listener): number {
    const call = this.nextCall();
    this.calls.set(call, listener);
    const name = `${method.parent.typeName}/${method.name}`;
    const value = { method: name, request: bytesOf(method.input, request) };
    if (!this.send(call, { case: "begin", value })) {
      this.calls.delete(call);
      queueMicrotask(() => listener.over(new CallError("UNAVAILABLE", "not connected to the server")));
    }
    return call;
  }

  /** Sends a further request on the stream of a call; `false` if it could not be sent. */
  next<I extends DescMessage>(call: number, method: Method<I>, request: MessageInitShape<I>): boolean {
    return this.send(call, { case: "next", value: bytesOf(method.input, request) });
  }

  /** Ends a stream. Nothing more is heard of it, though the server may still answer. */
  end(call: number): void {
    this.send(call, { case: "close", value: create(CloseCallSchema) });
    this.calls.delete(call);
  }

  private send(call: number, request: MessageInitShape<typeof PageRequestSchema>["request"]): boolean {
    if (this.link.state !== "open" || !this.socket || !this.calls.has(call)) return false;
    this.socket.send(toBinary(PageRequestSchema, create(PageRequestSchema, { call, request })));
    return true;
  }

  private nextCall(): number {
    do this.lastCall = (this.lastCall % 0xffff_ffff) + 1;
    while (this.calls.has(this.lastCall));
    return this.lastCall;
  }

  private receive(data: ArrayBuffer): void {
    const begun = performance.now();
    try {
      const { call, response } = fromBinary(PageResponseSchema, new Uint8Array(data));
      const listener = this.calls.get(call);
      if (!listener) return;
      if (response.case === "message") return listener.message(response.value);
      if (response.case === "taken") return listener.taken?.();
      this.calls.delete(call);
      listener.over(
        response.case === "failure" ? new CallError(response.value.code, response.value.message) : undefined,
      );
    } finally {
      this.busy_ms += performance.now() - begun;
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
    this.retry = setTimeout(() => this.open(), wait_ms);
  }

  private set(link: Link): void {
    this.link = link;
    this.changed();
  }
}

/** Calls a method that has a single response. */
export function ask<I extends DescMessage, O extends DescMessage>(
  connection: Connection,
  method: DescMethodUnary<I, O>,
  request: MessageInitShape<I>,
): Promise<MessageShape<O>> {
  return new Promise((resolve, reject) => {
    const call = connection.begin(method, request, {
      message(bytes) {
        connection.forget(call);
        resolve(fromBinary(method.output, bytes));
      },
      over: (error) => reject(error ?? new CallError("CANCELLED", "the server closed the call")),
    });
  });
}

function bytesOf<I extends DescMessage>(schema: I, message: MessageInitShape<I>): Uint8Array {
  return toBinary(schema, create(schema, message));
}
