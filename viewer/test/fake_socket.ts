import { Connection, type Socket } from "../src/net/connection";
import { requestFrom, responseTo, type Reply } from "./calls";

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
  requests(): ReturnType<typeof requestFrom>[] {
    return this.sent.map(requestFrom);
  }
  hear(call: number, reply: Reply): void {
    this.onmessage?.({ data: responseTo(call, reply).slice().buffer as ArrayBuffer });
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
