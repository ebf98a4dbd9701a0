/** The world's program (the crate `page`): a server, its worlds and brains in WebAssembly, with files in memory. */
import { ConsoleStdout, Directory, File, Inode, PreopenDirectory, WASI } from "@bjorn3/browser_wasi_shim";
import { date } from "./dated";

/** What the program exports (`viewer/page/src/abi.rs`). */
interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  baudbot_begin(): number;
  baudbot_room(bytes: number): number;
  baudbot_take(port: number): void;
  baudbot_close(port: number): void;
  baudbot_turn(at_most_ms: number): number;
  baudbot_next(): number;
  baudbot_bytes(): number;
  baudbot_port(): number;
}

/** The port of orders; all others are of clients. */
export const ORDERS = 0;

export class Engine {
  private constructor(
    private readonly exports: Exports,
    private readonly recordings: Directory,
  ) {}

  /** Begins with a server without worlds. `say` is told what the program writes for people, such as why it panics. */
  static async begin(wasm: BufferSource, say: (line: string) => void): Promise<Engine> {
    const recordings = new Directory(new Map<string, Inode>());
    const folders = new PreopenDirectory("/", new Map<string, Inode>([["recordings", recordings]]));
    date(folders.dir);
    const out = () => ConsoleStdout.lineBuffered(say);
    const wasi = new WASI([], [], [out(), out(), out(), folders], { debug: false });
    const { instance } = await WebAssembly.instantiate(wasm, {
      wasi_snapshot_preview1: { ...wasi.wasiImport, poll_oneoff },
    });
    const exports = instance.exports as unknown as Exports;
    wasi.initialize({ exports } as never);
    // The program never sleeps: what it asks for while it would is over at once.
    function poll_oneoff(_subscriptions: number, events: number, count: number, happened: number): number {
      new Uint8Array(exports.memory.buffer, events, 32 * count).fill(0);
      new DataView(exports.memory.buffer).setUint32(happened, count, true);
      return 0;
    }
    if (!exports.baudbot_begin()) throw new Error("the world's program did not start");
    return new Engine(exports, recordings);
  }

  /** Takes a message from a port. */
  take(port: number, message: Uint8Array): void {
    const at = this.exports.baudbot_room(message.length);
    new Uint8Array(this.exports.memory.buffer, at, message.length).set(message);
    this.exports.baudbot_take(port);
  }

  /** The client at this port is gone. */
  close(port: number): void {
    this.exports.baudbot_close(port);
  }

  /** Works for so long at most. Whether there is more to do at once. */
  turn(at_most_ms: number): boolean {
    return this.exports.baudbot_turn(at_most_ms) !== 0;
  }

  /** The messages that go out, each with its port. */
  *messages(): Generator<[port: number, message: Uint8Array<ArrayBuffer>]> {
    for (;;) {
      const length = this.exports.baudbot_next();
      if (length === 0) return;
      const bytes = new Uint8Array(this.exports.memory.buffer, this.exports.baudbot_bytes(), length);
      yield [this.exports.baudbot_port(), bytes.slice()];
    }
  }

  /** The file of a recording. */
  recording(name: string): Uint8Array | undefined {
    const file = this.recordings.contents.get(`${name}.mcap`);
    return file instanceof File ? file.data : undefined;
  }
}
