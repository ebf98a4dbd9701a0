/**
 * What is used here of gifenc, which comes without types. The file is named so that Node takes the same one for tests.
 */
declare module "gifenc/dist/gifenc.esm.js" {
  type Palette = number[][];

  interface FrameOptions {
    palette: Palette;
    /** In milliseconds. */
    delay: number;
    transparent: boolean;
    transparentIndex: number;
    dispose: number;
  }

  interface Stream {
    writeFrame(index: Uint8Array, width: number, height: number, options: FrameOptions): void;
    finish(): void;
    bytes(): Uint8Array;
  }

  export function GIFEncoder(options?: { initialCapacity?: number }): Stream;
  export function quantize(rgba: Uint8Array, colors: number): Palette;
  export function applyPalette(rgba: Uint8Array, palette: Palette): Uint8Array;
}
