/** The map of covered cells in a browser, before the mock server: `npm run build && npm run test:browser`. */
import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { beforeTheMock } from "./browser_kit";
import { MockReplay } from "./mock_replay";

const { options, shots, open, mock } = beforeTheMock();

type Color = [number, number, number];

/** Places where no robot goes and nothing else is drawn; what is marked there is in their names. */
const COVERED: [number, number] = [-2.23, 1.67];
const SENSED: [number, number] = [-1.23, 1.67];
const NEITHER: [number, number] = [-0.73, 1.67];

/** The colours of the arena at the three places. */
const colors = (page: Page) =>
  page.getByTestId("arena-canvas").evaluate(
    (element, places) => {
      const canvas = element as HTMLCanvasElement;
      return places.map(([x_m, y_m]) => {
        const [x, y] = window.baudbotViewer.pixelAt(x_m!, y_m!);
        const ratio = canvas.width / canvas.clientWidth;
        return [
          ...canvas
            .getContext("2d")!
            .getImageData(x * ratio, y * ratio, 1, 1)
            .data.slice(0, 3),
        ] as Color;
      });
    },
    [COVERED, SENSED, NEITHER],
  );

const away = (a: Color = [0, 0, 0], b: Color = [0, 0, 0]) => Math.hypot(...a.map((level, i) => level - (b[i] ?? 0)));

/** Waits until the arena shows what the layer is to show. */
async function shows(page: Page, isOn: boolean): Promise<void> {
  const begun = Date.now();
  for (;;) {
    const [covered, sensed, neither] = await colors(page);
    const tints = [away(covered, neither), away(sensed, neither)] as const;
    const done = isOn ? tints[1] > 8 && tints[0] > 1.5 * tints[1] : tints[0] === 0 && tints[1] === 0;
    if (done) return;
    assert.ok(Date.now() - begun < 20_000, JSON.stringify([covered, sensed, neither]));
    await page.waitForTimeout(100);
  }
}

/** A world that stands, with something marked where no robot goes. */
function prepare(): void {
  const { floor, bodies } = mock().worlds.get("arena")!;
  // The robots stay in the other half of the room.
  for (const body of bodies) body.brain = "";
  bodies.forEach((body, i) => Object.assign(body, { left: 0, right: 0, x_m: i - 0.5, y_m: -1.2 }));
  floor.clear();
  floor.mark(floor.covered, ...COVERED, 0.2);
  floor.mark(floor.sensed, ...SENSED, 0.2);
}

for (const theme of ["light", "dark"] as const)
  test(`cells that are covered are tinted, those that are sensed less, where it is ${theme}`, options, async () => {
    prepare();
    const page = await open("#world=arena&robot=carol", undefined, theme);
    await shows(page, true);
    if (shots) await page.screenshot({ path: `${shots}/coverage-${theme}.png` });
    await page.keyboard.press("c");
    await shows(page, false);
    assert.equal(await page.getByTestId("layer-coverage").getAttribute("aria-pressed"), "false");
    await page.getByTestId("layer-coverage").click();
    await shows(page, true);
    await page.close();
  });

test("what becomes covered is seen soon, and a reset takes it away", options, async () => {
  prepare();
  const { floor } = mock().worlds.get("arena")!;
  floor.clear();
  const page = await open("#world=arena&robot=carol");
  await page.waitForFunction(() => window.baudbotViewer.coverageTick !== undefined);
  await shows(page, false);
  prepare();
  await shows(page, true);
  await page.getByTestId("reset").click();
  await shows(page, false);
  await page.close();
});

test("a world that counts nothing is not asked", options, async () => {
  const world = mock().worlds.get("second")!;
  const page = await open("#world=second&robot=carol");
  await page.waitForTimeout(1500);
  assert.equal(world.mapsAsked, 0);
  assert.equal(await page.evaluate(() => window.baudbotViewer.coverageTick), undefined);
  await page.close();
});

test("a replay that is scrubbed shows the map of its tick, and a film one of each picture", options, async () => {
  const page = await open("#world=arena&robot=carol");
  await page.getByTestId("recording-open-run-1").click();
  await page.getByTestId("replay-bar").waitFor();
  for (const tick of [1500, 20]) {
    await page.getByTestId("replay-slider").fill(String(tick));
    await page.waitForFunction((tick) => window.baudbotViewer.coverageTick === tick, tick);
  }
  const world = [...mock().worlds.values()].find((world) => world instanceof MockReplay)!;
  const before = world.mapsAsked;
  await page.getByTestId("film-open").click();
  await page.getByTestId("film-from").fill("1");
  await page.getByTestId("film-to").fill("1.45");
  await page.getByTestId("film-width").fill("320");
  await Promise.all([page.waitForEvent("download"), page.getByTestId("film-make").click()]);
  // One for each of ten pictures, and one when the world is back where it was.
  const asked = world.mapsAsked - before;
  assert.ok(asked >= 10 && asked <= 12, `${asked}`);
  await page.close();
});
