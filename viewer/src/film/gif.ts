/** A GIF of pictures of which each changes little of the one before. */
import { applyPalette, GIFEncoder, quantize } from "gifenc/dist/gifenc.esm.js";
import type { Encoder } from "./film";

/** Colours of a picture besides the one that means "as before". */
const COLORS = 255;
const CLEAR = 255;
/** More pixels tell no more of the colours. */
const SAMPLE = 120_000;

export class GifEncoder implements Encoder {
  private readonly stream = GIFEncoder({ initialCapacity: 1 << 20 });
  private before: Uint32Array | undefined;
  private count = 0;

  constructor(
    private readonly width: number,
    private readonly height: number,
    private readonly fps: number,
  ) {}

  async add(canvas: HTMLCanvasElement): Promise<void> {
    const context = canvas.getContext("2d");
    if (!context) throw new Error("this browser cannot draw on a canvas");
    this.addPixels(context.getImageData(0, 0, this.width, this.height).data);
    // The page is to stay alive meanwhile.
    await new Promise((resolve) => setTimeout(resolve));
  }

  finish(): Uint8Array {
    this.stream.finish();
    return this.stream.bytes();
  }

  /** A picture, as bytes of red, green, blue and opacity. */
  addPixels(data: Uint8ClampedArray): void {
    const now = new Uint32Array(data.buffer, data.byteOffset, data.length / 4);
    const places = changed(this.before, now);
    const pixels = Uint32Array.from(places, (place) => now[place] ?? 0);
    const palette = places.length > 0 ? quantize(sampled(pixels), COLORS) : [];
    while (palette.length <= CLEAR) palette.push([0, 0, 0]);
    const colors = applyPalette(bytesOf(pixels), palette.slice(0, COLORS));
    const picture = new Uint8Array(now.length).fill(CLEAR);
    places.forEach((place, i) => (picture[place] = colors[i] ?? CLEAR));
    const delay = this.delay();
    // Nothing is cleared before the next picture, which leaves out what stays.
    const options = { palette, delay, transparent: true, transparentIndex: CLEAR, dispose: 1 };
    this.stream.writeFrame(picture, this.width, this.height, options);
    this.before = now.slice();
    this.count++;
  }

  /** In milliseconds. It is rounded to hundredths of a second so that the sum is right. */
  private delay(): number {
    const at = (k: number) => Math.round((100 * k) / this.fps);
    return 10 * (at(this.count + 1) - at(this.count));
  }
}

/** Where a picture differs from the one before. */
function changed(before: Uint32Array | undefined, now: Uint32Array): Uint32Array {
  const places = new Uint32Array(now.length);
  let count = 0;
  for (let i = 0; i < now.length; i++) {
    if (!before || before[i] !== now[i]) places[count++] = i;
  }
  return places.subarray(0, count);
}

function sampled(pixels: Uint32Array): Uint8Array {
  const every = Math.ceil(pixels.length / SAMPLE);
  return bytesOf(every > 1 ? pixels.filter((_, i) => i % every === 0) : pixels);
}

function bytesOf(pixels: Uint32Array): Uint8Array {
  return new Uint8Array(pixels.buffer, pixels.byteOffset, pixels.byteLength);
}
