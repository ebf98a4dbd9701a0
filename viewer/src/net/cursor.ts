/**
 * Reads protobuf bytes where a frame of thousands of robots comes twenty times a second: making an object of each is
 * what takes long, so that is left until somebody looks at it.
 */
export class Cursor {
  private at = 0;
  private readonly view: DataView;

  constructor(private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  /** Where it is. */
  get offset(): number {
    return this.at;
  }

  get done(): boolean {
    return this.at >= this.bytes.length;
  }

  /** A whole number of up to 53 bits: a tag or a length. */
  varint(): number {
    let value = 0;
    for (let factor = 1; ; factor *= 128) {
      const byte = this.bytes[this.at++];
      if (byte === undefined || factor > 2 ** 63) throw new Error("the message is cut short");
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
  }

  double(): number {
    const value = this.view.getFloat64(this.at, true);
    this.at += 8;
    return value;
  }

  /** Bytes with their length before them. */
  chunk(): Uint8Array {
    const length = this.varint();
    const start = this.at;
    this.at += length;
    if (this.at > this.bytes.length) throw new Error("the message is cut short");
    return this.bytes.subarray(start, this.at);
  }

  /** Goes over a field of this wire type. */
  skip(wireType: number): void {
    if (wireType === 0) this.varint();
    else if (wireType === 1) this.at += 8;
    else if (wireType === 2) this.chunk();
    else if (wireType === 5) this.at += 4;
    else throw new Error(`no such wire type: ${wireType}`);
  }
}
