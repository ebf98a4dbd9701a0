/** Replays, recordings and films in a browser, before the mock server: `npm run build && npm run test:browser`. */
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import type { Download, Page } from "playwright-core";
import { beforeTheMock } from "./browser_kit";
import { MockReplay } from "./mock_replay";

const { options, shots, visit, open, mock } = beforeTheMock();

/** A page that looks at a recording that was opened in it. */
async function openReplay(
  recording: string,
  ...how: Parameters<typeof open> extends [string, ...infer More] ? More : never
) {
  const page = await open("#world=arena&robot=alice", ...how);
  if ((how[0]?.width ?? 1280) < 760) await page.click("#tabs [data-sheet=worlds]");
  await page.getByTestId(`recording-open-${recording}`).click();
  await page.getByTestId("replay-bar").waitFor();
  await page.waitForFunction(() => window.baudbotViewer.replayTick === 0);
  return page;
}

const at = (page: Page, tick: number) =>
  page.waitForFunction((tick) => window.baudbotViewer.tick === tick && window.baudbotViewer.replayTick === tick, tick);
const pixel = (page: Page) => page.evaluate(() => window.baudbotViewer.pixel ?? ([NaN, NaN] as const));
const text = async (page: Page, id: string) => (await page.getByTestId(id).textContent()) ?? "";

async function bytesOf(download: Download): Promise<Buffer> {
  return readFileSync(await download.path());
}

test("a replay is scrubbed with the mouse, and the robot is elsewhere", options, async () => {
  const page = await openReplay("run-1");
  const slider = page.getByTestId("replay-slider");
  const from = await pixel(page);
  const box = await slider.boundingBox();
  assert.ok(box);
  const y = box.y + box.height / 2;
  await page.mouse.move(box.x + 8, y);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2, y, { steps: 40 });
  // The time follows the finger at once, before the world has got there.
  assert.match(await text(page, "replay-time"), /^1[45]\.\d\d \/ 30\.00 s$/);
  await page.mouse.up();
  const value = Number(await slider.inputValue());
  assert.ok(Math.abs(value - 1500) < 30, `${value}`);
  await at(page, value);
  const to = await pixel(page);
  assert.ok(Math.hypot(to[0] - from[0], to[1] - from[1]) > 20, `${from} ${to}`);
  const world = [...mock().worlds.values()].find((world) => world instanceof MockReplay) as MockReplay;
  assert.ok(world.seeks <= 42, `${world.seeks} seeks for forty moves`);
  assert.match((await slider.getAttribute("aria-valuetext")) ?? "", / s/);
  assert.equal(await slider.getAttribute("role"), "slider");
  await page.close();
});

test("going back takes the trail back, and a leap draws no line", options, async () => {
  const page = await openReplay("run-1");
  await page.getByTestId("replay-play").click();
  await page.waitForFunction(() => window.baudbotViewer.tick > 200);
  await page.keyboard.press(" ");
  await page.waitForFunction(() => document.title.includes("paused"));
  const long = (await page.evaluate(() => window.baudbotViewer.trail)).length;
  await page.getByTestId("replay-slider").fill("60");
  await at(page, 60);
  const trail = await page.evaluate(() => window.baudbotViewer.trail);
  assert.ok(trail.length > 1 && trail.length < long, `${trail.length} of ${long}`);
  await page.close();
});

/** Pixels of the chart that have the colour of one of its lines. */
const inLines = (page: Page) =>
  page.locator(".chart-holder canvas").evaluate((element) => {
    const canvas = element as HTMLCanvasElement;
    const { data } = canvas.getContext("2d")!.getImageData(0, 0, canvas.width, canvas.height);
    const colors = [
      [0x00, 0x72, 0xb2],
      [0xd5, 0x5e, 0x00],
    ];
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
      if (colors.some((color) => color.every((value, j) => Math.abs(value - (data[i + j] ?? 0)) < 8))) count++;
    return count;
  });

test("after a seek the chart shows what is there, before anything is played", options, async () => {
  const page = await openReplay("run-1");
  await page.getByTestId("replay-slider").fill("1500");
  await at(page, 1500);
  await page.waitForTimeout(400);
  const dots = await inLines(page);
  assert.ok(dots >= 10 && dots < 200, `${dots} pixels: a dot for each value that is known, and no line`);
  await page.getByTestId("replay-slider").fill("900");
  await at(page, 900);
  await page.waitForTimeout(400);
  assert.ok((await inLines(page)) >= 10);
  if (shots) await page.screenshot({ path: `${shots}/replay-sought.png` });
  await page.close();
});

test("ticks and events are gone through with buttons, keys and a click", options, async () => {
  const page = await openReplay("run-1");
  await page.getByTestId("replay-next-event").click();
  const first = await page.waitForFunction(() => window.baudbotViewer.replayTick || 0);
  const tick = (await first.jsonValue()) as number;
  await at(page, tick);
  assert.notEqual(await text(page, "replay-event"), "");
  await page.keyboard.press(",");
  await at(page, tick - 1);
  assert.equal(await text(page, "replay-event"), "");
  await page.getByTestId("replay-back").click();
  await at(page, tick - 2);
  await page.getByTestId("replay-forward").click();
  await at(page, tick - 1);
  await page.keyboard.press(">");
  await at(page, tick);
  await page.getByTestId("replay-last").click();
  await at(page, 3000);
  await page.keyboard.press("<");
  await page.waitForFunction(() => (window.baudbotViewer.replayTick ?? 3000) < 3000);
  // The change by hand is at a third; its text is no markup.
  const marks = await page.getByTestId("replay-marks").boundingBox();
  assert.ok(marks);
  await page.mouse.click(marks.x + 8 + (marks.width - 16) / 3, marks.y + 9);
  await at(page, 1000);
  assert.match(await text(page, "replay-event"), /<b>hand<\/b>/);
  assert.match(await text(page, "replay-tip"), /10\.000 s/);
  await page.close();
});

test("what differs and what is cut off is told, on a telephone, too", options, async () => {
  const page = await openReplay("killed", { width: 390, height: 844 }, "dark");
  assert.match(await text(page, "replay-differs"), /tick 400/);
  assert.ok(await page.getByTestId("replay-cut-off").isVisible());
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(wide, 390);
  if (shots) await page.screenshot({ path: `${shots}/replay-phone.png` });
  await page.close();
});

test("a replay goes on as a live world", options, async () => {
  const page = await openReplay("run-1");
  assert.ok(await page.getByTestId("drive").isDisabled());
  assert.ok(!(await page.getByTestId("reset").isVisible()));
  await page.getByTestId("replay-slider").fill("700");
  await at(page, 700);
  await page.getByTestId("replay-fork").click();
  await page.getByTestId("replay-bar").waitFor({ state: "hidden" });
  assert.equal(await page.evaluate(() => window.baudbotViewer.replayTick), undefined);
  assert.ok(await page.getByTestId("reset").isVisible());
  await page.getByTestId("run").click();
  await page.waitForFunction(() => window.baudbotViewer.tick > 705);
  await page.getByTestId("drive").click();
  await page.getByTestId("pad").waitFor();
  await page.close();
});

test("a live world is recorded, and the recording is replayed", options, async () => {
  const page = await open("#world=second&robot=alice");
  await page.getByTestId("record-toggle").click();
  await page.waitForFunction(() => /B$/.test(document.querySelector("[data-testid=record-state]")?.textContent ?? ""));
  const recording = mock().worlds.get("second")?.recording;
  assert.ok(recording);
  recording.problem = "the disk is full";
  await page.waitForFunction(() => document.querySelector("[data-testid=record-state]")?.textContent?.includes("full"));
  await page.getByTestId("record-toggle").click();
  await page.getByTestId("record-state").waitFor({ state: "hidden" });
  await page.getByTestId("recording-open-second-1").click();
  await page.getByTestId("replay-bar").waitFor();
  await page.close();
});

test("a state is saved to a file, and a world is made from it", options, async () => {
  const page = await open("#world=second&robot=alice");
  await page.getByTestId("pause").click();
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByTestId("save-file").click()]);
  assert.match(download.suggestedFilename(), /^second-\d+\.mcap$/);
  const buffer = await bytesOf(download);
  assert.equal(buffer.subarray(1, 6).toString(), "MCAP0");
  await page.getByTestId("new-world").click();
  await page.getByTestId("open-file").setInputFiles({ name: "second.mcap", mimeType: "", buffer });
  await page.getByTestId("saved-state").waitFor();
  assert.ok(!(await page.getByTestId("scenario").isVisible()));
  await page.getByLabel("Name of the world").fill("again");
  await page.getByTestId("create").click();
  await page.waitForFunction(() => window.baudbotViewer.world === "again");
  await page.close();
});

test("a film is made in the page, as GIF and as WebM", options, async () => {
  const page = await openReplay("run-1");
  for (const [format, begin] of [
    ["gif", "GIF89a"],
    ["webm", "\x1aE\xdf\xa3"],
  ] as const) {
    await page.getByTestId("film-open").click();
    await page.getByTestId("film-format").selectOption(format);
    await page.getByTestId("film-from").fill("1");
    await page.getByTestId("film-to").fill("2");
    await page.getByTestId("film-width").fill("320");
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByTestId("film-make").click()]);
    const film = await bytesOf(download);
    assert.equal(film.subarray(0, begin.length).toString("latin1"), begin);
    assert.match(download.suggestedFilename(), new RegExp(`\\.${format}$`));
    if (shots) await download.saveAs(`${shots}/film.${format}`);
    await page.getByTestId("film-cancel").click();
  }
  await at(page, 0);
  await page.close();
});

test("a film is cancelled", options, async () => {
  const page = await openReplay("run-1");
  await page.getByTestId("film-open").click();
  await page.getByTestId("film-make").click();
  await page.waitForFunction(() => / of /.test(document.querySelector("[data-testid=film-state]")?.textContent ?? ""));
  await page.getByTestId("film-cancel").click();
  await at(page, 0);
  assert.equal(await text(page, "film-error"), "cancelled");
  await page.close();
});

/** Makes a film without anybody who looks; its title at the end. */
async function headless(query: string): Promise<string> {
  const page = await visit(query);
  await page.waitForFunction(() => /^film (done|failed)/.test(document.title));
  const title = await page.title();
  await page.close();
  return title;
}

test("the program has a film made and gets its bytes", options, async () => {
  const looking = await openReplay("run-1");
  const world = await looking.evaluate(() => window.baudbotViewer.world);
  await looking.close();
  const part = `world=${world}&from_s=1&to_s=2&width=400`;
  assert.equal(await headless(`?film=gif&${part}`), "film done");
  const gif = mock().posted.at(-1);
  assert.deepEqual([gif?.path, gif?.type, gif?.body.subarray(0, 6).toString()], ["/film", "image/gif", "GIF89a"]);
  assert.equal(await headless(`?film=webm&theme=dark&post=/other&${part}`), "film done");
  const film = mock().posted.at(-1);
  assert.deepEqual([film?.path, film?.type], ["/other", "video/webm"]);
  assert.ok(film);
  assert.equal(film.body.readUInt32BE(0), 0x1a45dfa3);
  assert.deepEqual(await played(film.body), { duration: 1.05, width: 400, at: 0.9 });
});

/** Plays a film where it has got a policy that lets it, and jumps into it. */
async function played(film: Buffer): Promise<object> {
  const page = await (await visit("")).context().newPage();
  const seen = await page.evaluate(async (bytes) => {
    const video = document.createElement("video");
    video.src = `data:video/webm;base64,${bytes}`;
    await new Promise((resolve, reject) => {
      video.onloadeddata = resolve;
      video.onerror = () => reject(new Error(video.error?.message));
    });
    video.currentTime = 0.9;
    await new Promise((resolve) => (video.onseeked = resolve));
    return { duration: video.duration, width: video.videoWidth, at: video.currentTime };
  }, film.toString("base64"));
  await page.context().close();
  return seen;
}

test("why there is no film is said", options, async () => {
  assert.equal(await headless("?film=gif&world=arena"), "film failed: world `arena` does not replay a recording");
  const failure = mock().posted.at(-1);
  assert.equal(failure?.path, "/film?failed=1");
  assert.match(failure?.body.toString() ?? "", /arena/);
  assert.match(await headless("?film=gif&post=//evil.example/film"), /^film failed: post/);
});
