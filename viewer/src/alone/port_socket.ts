/** A socket whose other end is in a worker. */
import type { Socket } from "../net/connection";

export class PortSocket implements Pick<Socket, "send" | "close" | "readyState" | "binaryType"> {
  binaryType = "arraybuffer";
  readyState: 0 | 1 | 2 | 3 = 1;
  onopen: ((event: never) => void) | null = null;
  onclose: ((event: never) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;

  /** `gone` is called when it is closed. */
  constructor(
    private readonly port: MessagePort,
    private readonly gone: () => void = () => {},
  ) {
    port.onmessage = (event) => this.onmessage?.(event);
    // Whoever made it listens from now on.
    queueMicrotask(() => this.onopen?.({} as never));
  }

  send(bytes: string | ArrayBufferLike | Blob | ArrayBufferView): void {
    if (!(bytes instanceof Uint8Array)) throw new Error("only bytes go through a port");
    const copy = bytes.slice().buffer;
    this.port.postMessage(copy, [copy]);
  }

  close(): void {
    if (this.readyState !== 1) return;
    this.readyState = 3;
    this.port.close();
    this.gone();
    this.onclose?.({} as never);
  }
}
