/** Puts encoded pictures of a video into a file: WebM, which is Matroska (RFC 9559) with VP8 or VP9. */

export interface Picture {
  data: Uint8Array;
  time_ms: number;
  /** It can be shown without those before. */
  isKey: boolean;
}

export interface Video {
  codec: "V_VP8" | "V_VP9";
  width: number;
  height: number;
  duration_ms: number;
  pictures: readonly Picture[];
}

type Content = Uint8Array | Content[];

/** The file. A cluster begins at each key picture, so that players can jump there. */
export function webm(video: Video): Uint8Array {
  const info = element(0x1549a966, [
    unsigned(0x2ad7b1, 1_000_000),
    element(0x4489, float(video.duration_ms)),
    text(0x4d80, "baudbot"),
    text(0x5741, "baudbot"),
  ]);
  const clusters = split(video.pictures).map(cluster);
  // Places in the file have a fixed length, so that the cues are as long before they are known as after.
  const cues = (places: number[]) =>
    element(
      0x1c53bb6b,
      clusters.map(({ time_ms }, i) => cue(time_ms, places[i] ?? 0)),
    );
  const head = [info, tracks(video)];
  let place = lengthOf(head) + cues([]).length;
  const places = clusters.map(({ bytes }) => (place += bytes.length) - bytes.length);
  const segment = element(0x18538067, [...head, cues(places), clusters.map(({ bytes }) => bytes)]);
  return joined([header(), segment]);
}

function header(): Uint8Array {
  const numbers: [number, number][] = [
    [0x4286, 1],
    [0x42f7, 1],
    [0x42f2, 4],
    [0x42f3, 8],
    [0x4287, 4],
    [0x4285, 2],
  ];
  return element(0x1a45dfa3, [...numbers.map(([id, value]) => unsigned(id, value)), text(0x4282, "webm")]);
}

function tracks({ codec, width, height }: Video): Uint8Array {
  const entry = [
    unsigned(0xd7, 1),
    unsigned(0x73c5, 1),
    unsigned(0x9c, 0),
    unsigned(0x83, 1),
    text(0x86, codec),
    element(0xe0, [unsigned(0xb0, width), unsigned(0xba, height)]),
  ];
  return element(0x1654ae6b, element(0xae, entry));
}

function split(pictures: readonly Picture[]): Picture[][] {
  const groups: Picture[][] = [];
  for (const picture of pictures) {
    if (picture.isKey || groups.length === 0) groups.push([]);
    groups.at(-1)?.push(picture);
  }
  return groups;
}

function cluster(pictures: Picture[]): { time_ms: number; bytes: Uint8Array } {
  const time_ms = Math.round(pictures[0]?.time_ms ?? 0);
  const blocks = pictures.map((picture) => {
    const head = new DataView(new ArrayBuffer(4));
    head.setUint8(0, 0x81); // track 1
    head.setInt16(1, Math.round(picture.time_ms) - time_ms);
    head.setUint8(3, picture.isKey ? 0x80 : 0);
    return element(0xa3, [new Uint8Array(head.buffer), picture.data]);
  });
  return { time_ms, bytes: element(0x1f43b675, [unsigned(0xe7, time_ms), ...blocks]) };
}

function cue(time_ms: number, place: number): Uint8Array {
  return element(0xbb, [unsigned(0xb3, time_ms), element(0xb7, [unsigned(0xf7, 1), unsigned(0xf1, place)])]);
}

/** An element: its number, its length in eight bytes, its content. */
function element(id: number, content: Content): Uint8Array {
  const bytes = joined(content);
  const length = new DataView(new ArrayBuffer(8));
  length.setBigUint64(0, BigInt(bytes.length) | (1n << 56n));
  return joined([idBytes(id), new Uint8Array(length.buffer), bytes]);
}

function idBytes(id: number): Uint8Array {
  const count = id > 0xffffff ? 4 : id > 0xffff ? 3 : id > 0xff ? 2 : 1;
  return Uint8Array.from({ length: count }, (_, i) => (id >>> (8 * (count - 1 - i))) & 255);
}

/** A whole number, always in eight bytes. */
function unsigned(id: number, value: number): Uint8Array {
  const view = new DataView(new ArrayBuffer(8));
  view.setBigUint64(0, BigInt(value));
  return element(id, new Uint8Array(view.buffer));
}

function float(value: number): Uint8Array {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value);
  return new Uint8Array(view.buffer);
}

function text(id: number, value: string): Uint8Array {
  return element(id, new TextEncoder().encode(value));
}

function lengthOf(content: Content): number {
  return content instanceof Uint8Array ? content.length : content.reduce((sum, part) => sum + lengthOf(part), 0);
}

function joined(content: Content): Uint8Array {
  if (content instanceof Uint8Array) return content;
  const whole = new Uint8Array(lengthOf(content));
  let at = 0;
  const put = (part: Content): void => {
    if (!(part instanceof Uint8Array)) return part.forEach(put);
    whole.set(part, at);
    at += part.length;
  };
  put(content);
  return whole;
}
