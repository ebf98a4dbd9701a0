import assert from "node:assert/strict";
import { test } from "node:test";
import { GifEncoder } from "../src/film/gif";
import { webm } from "../src/film/matroska";
import { even, planFilm } from "../src/film/plan";
import { failurePath, readFilmRequest } from "../src/film/request";

const RANGE = { first: 100n, last: 400n };
const HERE = "http://127.0.0.1:7401";

test("a film has a picture of each of its instants", () => {
  const all = planFilm(RANGE, 0.01, { speed: 1, fps: 20 });
  assert.deepEqual([all.length, all[0], all[1], all.at(-1)], [61, 100n, 105n, 400n]);
  const part = planFilm(RANGE, 0.01, { from_s: 2, to_s: 3, speed: 2, fps: 10 });
  assert.deepEqual(part, [200n, 220n, 240n, 260n, 280n, 300n]);
  assert.deepEqual(planFilm(RANGE, 0.01, { from_s: 3, to_s: 3, speed: 1, fps: 20 }), [300n]);
  assert.equal(planFilm(RANGE, 0.01, { from_s: -5, to_s: 99, speed: 1, fps: 20 }).length, 61);
  assert.deepEqual([even(801), even(0)], [802, 2]);
});

test("what is no film is said in words", () => {
  assert.throws(() => planFilm(RANGE, 0.01, { speed: 0, fps: 20 }), /speed/);
  assert.throws(() => planFilm(RANGE, 0.01, { speed: 1, fps: 200 }), /fps/);
  assert.throws(() => planFilm(RANGE, 0.01, { from_s: 3, to_s: 2, speed: 1, fps: 20 }), /to_s/);
  assert.throws(() => planFilm({ first: 0n, last: 10n ** 9n }, 0.01, { speed: 1, fps: 20 }), /room/);
});

test("an address asks for a film, and films go to this server only", () => {
  assert.equal(readFilmRequest("", HERE), undefined);
  assert.deepEqual(readFilmRequest("?film=gif&world=w&from_s=1&to_s=2.5&speed=4&fps=10&width=640&theme=dark", HERE), {
    format: "gif",
    world: "w",
    robot: "",
    from_s: 1,
    to_s: 2.5,
    speed: 4,
    fps: 10,
    width: 640,
    dark: true,
    post: "/film",
  });
  for (const post of ["http://evil.example/film", "//evil.example/film", "film", "/\\evil.example"])
    assert.throws(() => readFilmRequest(`?film=gif&post=${encodeURIComponent(post)}`, HERE), /post/, post);
  assert.throws(() => readFilmRequest("?film=avi", HERE), /film/);
  assert.throws(() => readFilmRequest("?film=gif&fps=x", HERE), /fps/);
  assert.equal(failurePath("?film=gif&post=//evil.example/x", HERE), "/film?failed=1");
  assert.equal(failurePath("?film=gif&post=/other", HERE), "/other?failed=1");
});

/** Delays of a GIF's pictures, in hundredths of a second. */
function delays(bytes: Uint8Array): number[] {
  const found: number[] = [];
  for (let i = 0; i + 7 < bytes.length; i++)
    if (bytes[i] === 0x21 && bytes[i + 1] === 0xf9 && bytes[i + 2] === 4 && bytes[i + 7] === 0)
      found.push((bytes[i + 4] ?? 0) + 256 * (bytes[i + 5] ?? 0));
  return found;
}

test("a GIF has the right length, and little of what stays as it was", () => {
  const gif = new GifEncoder(40, 30, 30);
  const picture = (at: number) => {
    const pixels = new Uint8ClampedArray(40 * 30 * 4).fill(255);
    pixels.set([200, 0, 0, 255], 4 * at);
    return pixels;
  };
  for (const at of [0, 1, 1, 1199, 5, 6]) gif.addPixels(picture(at));
  const bytes = gif.finish();
  assert.equal(new TextDecoder().decode(bytes.subarray(0, 6)), "GIF89a");
  assert.deepEqual(delays(bytes), [3, 4, 3, 3, 4, 3]);
  assert.equal(bytes.at(-1), 0x3b);
});

test("a WebM has its pictures in clusters, and cues that lead to them", () => {
  const picture = (k: number) => ({ data: Uint8Array.of(k, k, k), time_ms: 50 * k, isKey: k % 2 === 0 });
  const pictures = [0, 1, 2, 3].map(picture);
  const bytes = webm({ codec: "V_VP9", width: 64, height: 48, duration_ms: 200, pictures });
  const view = new DataView(bytes.buffer);
  assert.equal(view.getUint32(0), 0x1a45dfa3);
  const text = new TextDecoder("latin1").decode(bytes);
  assert.ok(text.includes("webm") && text.includes("V_VP9"));
  const segment = text.indexOf("\x18\x53\x80\x67") + 12;
  const clusters = [...text.matchAll(/\x1f\x43\xb6\x75/g)].map((found) => found.index);
  assert.equal(clusters.length, 2);
  const cues = [...text.matchAll(/\xf1\x01\x00{6}\x08/g)].map((found) => Number(view.getBigUint64(found.index + 9)));
  assert.deepEqual(
    cues.map((place) => segment + place),
    clusters,
  );
});
