/**
 * A WebM through the browser's own encoder. Each picture is given its time, so that the film has the right speed
 * however long the pictures took to make, which MediaRecorder, on the wall clock, cannot do.
 */
import type { Encoder } from "./film";
import { webm, type Picture, type Video } from "./matroska";

/** Seconds from one picture that can be jumped to to the next. */
const KEY_S = 4;
const BITS_PER_PIXEL = 0.18;
/** Pictures that wait for the encoder, at most. */
const MOST_WAITING = 4;

const CODECS: [string, Video["codec"]][] = [
  ["vp09.00.41.08", "V_VP9"],
  ["vp8", "V_VP8"],
];

export class WebmEncoder implements Encoder {
  private readonly encoder: VideoEncoder;
  private readonly pictures: Picture[] = [];
  private count = 0;
  private failure: unknown;

  private constructor(
    private readonly config: VideoEncoderConfig,
    private readonly codec: Video["codec"],
    private readonly fps: number,
  ) {
    this.encoder = new VideoEncoder({
      output: (chunk) => this.take(chunk),
      error: (error) => (this.failure = error),
    });
    this.encoder.configure(config);
  }

  static async open(width: number, height: number, fps: number): Promise<WebmEncoder> {
    if (typeof VideoEncoder !== "function")
      throw new Error("this browser cannot encode video for this page (only on localhost or over https); choose GIF");
    const bitrate = Math.round(BITS_PER_PIXEL * width * height * fps);
    for (const [name, codec] of CODECS) {
      const config: VideoEncoderConfig = { codec: name, width, height, bitrate, framerate: fps };
      const { supported } = await VideoEncoder.isConfigSupported(config);
      if (supported) return new WebmEncoder(config, codec, fps);
    }
    throw new Error("this browser can encode neither VP9 nor VP8; choose GIF");
  }

  async add(canvas: HTMLCanvasElement): Promise<void> {
    const at = (k: number) => Math.round((1e6 * k) / this.fps);
    const timestamp = at(this.count);
    const frame = new VideoFrame(canvas, { timestamp, duration: at(this.count + 1) - timestamp });
    this.encoder.encode(frame, { keyFrame: this.count % Math.round(KEY_S * this.fps) === 0 });
    frame.close();
    this.count++;
    while (this.encoder.encodeQueueSize > MOST_WAITING) await new Promise((resolve) => setTimeout(resolve, 2));
    if (this.failure) throw this.failure;
  }

  async finish(): Promise<Uint8Array> {
    await this.encoder.flush();
    if (this.failure) throw this.failure;
    this.close();
    const { width, height } = this.config;
    const duration_ms = (1000 * this.count) / this.fps;
    return webm({ codec: this.codec, width, height, duration_ms, pictures: this.pictures });
  }

  close(): void {
    if (this.encoder.state !== "closed") this.encoder.close();
  }

  private take(chunk: EncodedVideoChunk): void {
    const data = new Uint8Array(chunk.byteLength);
    chunk.copyTo(data);
    this.pictures.push({ data, time_ms: chunk.timestamp / 1000, isKey: chunk.type === "key" });
  }
}
