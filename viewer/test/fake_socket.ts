import { create, fromBinary, toBinary } from "@bufbuild/protobuf";
import {
  PageRequestSchema,
  PageResponseSchema,
  type PageRequest,
  type PageResponse,
} from "../src/gen/baudbot/v1/page_pb";
import { Connection, type Socket } from "../src/net/connection";

/** A socket whose other end is the test. */
export class FakeSocket {
  binaryType = "";
  readyState = 1;
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((event: { data: ArrayBuffer }) => void) | null = null;
  sent: Uint8Array[] = [];
  send(bytes: Uint8Array): void {
    this.sent.push(bytes);
  }
  close(): void {}
  /** What was asked for, in its order. */
  requests(): PageRequest[] {
    return this.sent.map((bytes) => fromBinary(PageRequestSchema, bytes));
  }
  hear(call: number, response: PageResponse["response"]): void {
    const bytes = toBinary(PageResponseSchema, create(PageResponseSchema, { call, response }));
    this.onmessage?.({ data: bytes.slice().buffer as ArrayBuffer });
  }
}

/** A connection that is open. */
export function connected(): { connection: Connection; socket: FakeSocket } {
  const socket = new FakeSocket();
  const connection = new Connection(() => socket as unknown as Socket);
  connection.open();
  socket.onopen?.();
  return { connection, socket };
}
