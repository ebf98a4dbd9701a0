/** The world's program as it is loaded: packed by Zstandard, which sees far more of it at once than gzip does. Browsers do not unpack that by themselves. */
import { decompress } from "fzstd";

/** What a program begins with: `\0asm`. */
const PROGRAM = [0x00, 0x61, 0x73, 0x6d];

/** The program. A web server may have told the browser to unpack it already. */
export function unpack(loaded: ArrayBuffer): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(loaded);
  if (PROGRAM.every((byte, i) => bytes[i] === byte)) return bytes;
  return decompress(bytes) as Uint8Array<ArrayBuffer>;
}
