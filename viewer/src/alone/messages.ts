/** What the page and its workers say to each other, beside the calls that go through ports. */

/** To the worker that has the world. */
export type ToWorld =
  | { kind: "begin"; wasm: ArrayBuffer }
  /** A client with this number and a port for its calls (`page.proto`), whose messages are bytes. */
  | { kind: "connect"; number: number; port: MessagePort }
  /** That client is gone. */
  | { kind: "close"; number: number }
  | { kind: "order"; id: number; order: unknown }
  | { kind: "recording"; id: number; name: string };

/** From it. */
export type FromWorld =
  | { kind: "answer"; id: number; result?: unknown; error?: string }
  /** A brain of the repertoire does not drive any more. */
  | { kind: "over"; world: string; robots: string[]; brain: string; error: string | null }
  /** Nothing goes on. */
  | { kind: "failed"; error: string };

/** To a worker that has a brain of the user's own. */
export interface ToBrain {
  port: MessagePort;
  world: string;
  robots: string[];
  language: "javascript" | "python";
  code: string;
  /** The name under which people see the brain. */
  name: string;
  /** Where Pyodide is. */
  pyodide: string;
}

/** From it. */
export type FromBrain =
  /** It loads what it needs. */
  | { kind: "loading"; what: string }
  /** It holds its robots. */
  | { kind: "drives" }
  /** What it printed. */
  | { kind: "said"; text: string }
  /** It does not drive any more. */
  | { kind: "over"; error?: string };
