/** What the page is at home with: the server that it came from, or one that it has in itself (`alone/`). */
import type { Socket } from "./net/connection";

export interface Host {
  /** A new socket to the server. */
  connect(): Socket;
  /** The file of a recording, where the page has it. */
  recording?(name: string): Promise<Uint8Array>;
}

/** That of this page. Another one is put in its place before the page begins. */
export let host: Host = {
  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    return new WebSocket(`${scheme}://${location.host}/page`);
  },
};

export function setHost(other: Host): void {
  host = other;
}
