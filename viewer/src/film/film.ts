/** Makes a film: takes the world from tick to tick, draws each, and hands the pictures to an encoder. */
import type { View } from "../arena/view";
import { GifEncoder } from "./gif";
import type { Stage } from "./stage";
import { WebmEncoder } from "./webm";

export type Format = "gif" | "webm";

/** Makes a file of pictures, which come one after the other. */
export interface Encoder {
  /** Takes what is on the canvas as the next picture. */
  add(canvas: HTMLCanvasElement): Promise<void> | void;
  finish(): Promise<Uint8Array> | Uint8Array;
  /** It is not wanted any more. */
  close?(): void;
}

/** What takes a world to a tick, and is back when its frame has come. */
export interface Projector {
  show(tick: bigint): Promise<void>;
}

export interface Shooting {
  ticks: readonly bigint[];
  fps: number;
  projector: Projector;
  stage: Stage;
  encoder: Encoder;
  signal?: AbortSignal;
  progress?: (done: number, all: number) => void;
}

/** The film's bytes. */
export async function shoot({
  ticks,
  fps,
  projector,
  stage,
  encoder,
  signal,
  progress,
}: Shooting): Promise<Uint8Array> {
  const restore = stage.begin(ticks);
  try {
    for (const [k, tick] of ticks.entries()) {
      signal?.throwIfAborted();
      stage.setTime(k / fps);
      await projector.show(tick);
      stage.draw();
      await encoder.add(stage.canvas);
      progress?.(k + 1, ticks.length);
    }
    return await encoder.finish();
  } catch (error) {
    encoder.close?.();
    throw error;
  } finally {
    restore();
  }
}

export async function encoderFor(format: Format, { width, height }: View, fps: number): Promise<Encoder> {
  return format === "gif" ? new GifEncoder(width, height, fps) : WebmEncoder.open(width, height, fps);
}

export const TYPES: Record<Format, string> = { gif: "image/gif", webm: "video/webm" };

/** Whether this browser encodes video; a page that came over an open line from elsewhere may not. */
export function hasVideo(): boolean {
  return typeof VideoEncoder === "function";
}
