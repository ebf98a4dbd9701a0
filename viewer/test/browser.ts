/**
 * The page that was built, in a browser, before the mock server: `npm run build && npm run test:browser`. Needs a
 * Chromium: in CHROMIUM, or where Debian has it. With SHOTS it leaves pictures in that folder.
 */
import assert from "node:assert/strict";
import { test } from "node:test";
import type { Page } from "playwright-core";
import { beforeTheMock } from "./browser_kit";
import { other, settled } from "./settled";

const { options, shots, open, mock } = beforeTheMock();

const state = (page: Page) =>
  page.evaluate(() => {
    const { tick, robot, world, pose, pixel, lastError, frames } = window.baudbotViewer;
    return { tick, robot, world, pose, pixel, lastError, frames, title: document.title };
  });

const pixels = async (page: Page) => (await state(page)).pixel ?? [NaN, NaN];

async function drag(page: Page, by: [number, number]): Promise<void> {
  const box = await page.getByTestId("arena-canvas").boundingBox();
  const [x, y] = await pixels(page);
  assert.ok(box);
  await page.mouse.move(box.x + x, box.y + y);
  await page.mouse.down();
  await page.mouse.move(box.x + x + by[0], box.y + y + by[1], { steps: 4 });
  await page.mouse.up();
}

test("what the address chooses is shown, and its readings have ages", options, async () => {
  const page = await open("#world=second&robot=bob");
  const { world, robot, title } = await state(page);
  assert.deepEqual([world, robot, title], ["second", "bob", "second: running – baudbot"]);
  await page.waitForFunction(() =>
    /ms/.test(document.querySelector("[data-testid=sensor-age-laser]")?.textContent ?? ""),
  );
  if (shots) await page.screenshot({ path: `${shots}/bob-light.png` });
  await page.close();
});

test("the pins of a chip are in the timing diagram until they are put away", options, async () => {
  const page = await open("#world=arena&robot=carol", { width: 1280, height: 900 });
  const canvas = page.getByTestId("timing-canvas");
  const height = async () => (await canvas.boundingBox())?.height ?? 0;
  const pins = page.getByTestId("pins");
  await page.waitForFunction(() => document.querySelector(".verdict")?.textContent === "a program of its own");
  const asked = async () => mock().worlds.get("arena")!.pinsAsked;
  assert.ok(await asked());
  const full = await settled(height);
  if (shots) await page.screenshot({ path: `${shots}/pins-light.png` });
  await pins.click();
  await other(true, asked, "they are sent for nobody");
  await page.waitForFunction(
    (full) => document.querySelector("[data-testid=timing-canvas]")!.getBoundingClientRect().height !== full,
    full,
  );
  await pins.click();
  await other(false, asked, "they are not asked for again");
  await page.close();
  if (!shots) return;
  const dark = await open("#world=arena&robot=carol", { width: 1280, height: 900 }, "dark");
  await dark.waitForTimeout(1500);
  await dark.screenshot({ path: `${shots}/pins-dark.png` });
  await dark.close();
});

test("a world is paused, stepped and run", options, async () => {
  const page = await open("#world=arena&robot=carol");
  await page.getByTestId("pause").click();
  await page.waitForFunction(() => document.title.includes("paused"));
  const before = { tick: await settled(async () => (await state(page)).tick) };
  await page.getByTestId("step-10").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick === tick + 10, before.tick);
  await page.keyboard.press(".");
  await page.waitForFunction((tick) => window.baudbotViewer.tick === tick + 11, before.tick);
  await page.getByTestId("run").click();
  await page.waitForFunction((tick) => window.baudbotViewer.tick > tick + 30, before.tick);
  await page.close();
});

test("a robot is carried elsewhere, but not into a wall", options, async () => {
  // The others stand where they began: none of them drives into the hand.
  const world = mock().worlds.get("arena")!;
  world.reset();
  world.bodies.forEach((body) => (body.brain = ""));
  const page = await open("#world=arena&robot=carol");
  await page.getByTestId("move").click();
  const [x, y] = await pixels(page);
  await drag(page, [40, -30]);
  await page.waitForFunction(
    ([x, y]) =>
      Math.hypot((window.baudbotViewer.pixel?.[0] ?? 0) - x! - 40, (window.baudbotViewer.pixel?.[1] ?? 0) - y! + 30) <
      2,
    [x, y],
  );
  await drag(page, [-600, 0]);
  await page.waitForFunction(() => window.baudbotViewer.lastError.includes("touch a wall"));
  assert.ok(Math.abs((await pixels(page))[0] - x - 40) < 2, "it is where it was");
  await page.close();
  world.reset();
});

test("a robot is driven, and stands when it is let go", options, async () => {
  const page = await open("#world=second&robot=carol");
  const from = (await state(page)).pose;
  await page.getByTestId("drive").click();
  await page.getByTestId("arena-canvas").focus();
  await page.keyboard.down("w");
  await page.waitForFunction((from) => {
    const to = window.baudbotViewer.pose;
    return from && to && Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) > 0.05;
  }, from);
  await page.keyboard.up("w");
  await page.keyboard.press("Escape");
  await page.waitForFunction(() => document.querySelector<HTMLElement>("[data-testid=pad]")?.hidden);
  await settled(async () => (await state(page)).pose, 500);
  await page.close();
});

test(
  "a robot stands when its driver looks elsewhere with a finger on the pad, until the pad is touched again",
  options,
  async () => {
    const page = await open("#world=second&robot=carol");
    await page.getByTestId("drive").click();
    const box = await page.getByLabel("Drive pad").boundingBox();
    assert.ok(box);
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const pose = async () => (await state(page)).pose;
    const push = async () => {
      const from = await pose();
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + 20, y - 30);
      await page.waitForFunction((from) => {
        const to = window.baudbotViewer.pose;
        return from && to && Math.hypot(to.x_m - from.x_m, to.y_m - from.y_m) > 0.02;
      }, from);
    };
    await push();
    await page.evaluate(() => window.dispatchEvent(new Event("blur")));
    await page.mouse.move(x - 20, y - 30);
    await settled(pose, 700);
    assert.ok(await page.getByTestId("pad").isVisible(), "the page still holds it");
    await page.mouse.up();
    await push();
    await page.mouse.up();
    await settled(pose, 700);
    await page.keyboard.press("Escape");
    await page.close();
  },
);

test("who holds a robot is told", options, async () => {
  const page = await open("#world=second&robot=alice");
  await page.getByTestId("drive").click();
  await page.waitForFunction(() => window.baudbotViewer.lastError.includes("holds `alice`"));
  await page.close();
});

test("a brain is restarted, and thrown off", options, async () => {
  const page = await open("#world=second&robot=bob");
  const body = () => mock().worlds.get("second")!.bodies[1]!;
  const restart = page.getByTestId("restart");
  assert.match((await restart.getAttribute("title")) ?? "", /cannot do this simply leaves/);
  await restart.click();
  while (body().restarts === 0) await page.waitForTimeout(50);
  assert.equal(body().brain, "avoid");
  await page.getByTestId("detach").click();
  // Of a robot without a brain there is none to start over.
  await page.waitForFunction(() => document.querySelector<HTMLButtonElement>("[data-testid=restart]")?.disabled);
  assert.deepEqual([body().restarts, body().brain], [1, ""]);
  body().brain = "avoid";
  await page.close();
});

test("what is wrong with a scenario is marked in its line, and what a brain says is no markup", options, async () => {
  const page = await open("#world=arena&robot=alice", undefined, "dark");
  await page.waitForFunction(() =>
    document.querySelector("[data-testid=robot-panel]")?.textContent?.includes("explore"),
  );
  assert.equal(await page.locator("[data-testid=robot-panel] b").count(), 0);
  await page.getByTestId("new-world").click();
  await page.getByTestId("scenario").fill("name = 'x'\n# so far so good\nWRONG = 1\n");
  await page.getByTestId("create").click();
  await page.waitForSelector(".gutter .marked");
  assert.equal(await page.locator(".gutter .marked").textContent(), "3");
  assert.match((await page.locator("dialog [data-testid=error]").textContent()) ?? "", /line 3/);
  await page.close();
});

test("the bytes of a cable are shown with their meaning while somebody looks", options, async () => {
  const page = await open("#world=arena&robot=alice");
  assert.ok(!(await page.getByTestId("cable-panel").isVisible()));
  await page.getByTestId("bytes").click();
  const rows = page.getByTestId("cable-rows").locator("li");
  await rows.nth(2).waitFor();
  const [question, answer] = [await rows.nth(0).innerText(), await rows.nth(1).innerText()];
  assert.match(question, /↓\s+4e 0d\s+N: ask proximity/);
  assert.match(answer, /↑\s+6e 2c 31 32 2c 30 0d 0a\s+n: proximity 12 0\s+20.5 ms/);
  assert.equal(await page.getByTestId("cable-state").innerText(), "2 missed");
  if (shots) await page.screenshot({ path: `${shots}/cable.png` });
  await page.getByTestId("cable-direction").selectOption("up");
  assert.ok(!(await rows.nth(0).isVisible()) && (await rows.nth(1).isVisible()));
  await page.getByTestId("cable-clear").click();
  assert.equal(await rows.count(), 0);
  await page.keyboard.press("y");
  assert.ok(!(await page.getByTestId("cable-panel").isVisible()));
  await page.close();
});

test("on a telephone panels are shown one at a time", options, async () => {
  const page = await open("#world=second&robot=bob", { width: 390, height: 844 }, "dark");
  assert.ok(await page.getByTestId("robot-panel").isVisible());
  assert.ok(!(await page.getByTestId("timing-canvas").isVisible()));
  await page.click("#tabs [data-sheet=timing]");
  assert.ok(await page.getByTestId("timing-canvas").isVisible());
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.equal(wide, 390, "nothing is wider than the screen");
  if (shots) await page.screenshot({ path: `${shots}/phone-dark.png` });
  await page.close();
});

/** Places in the panel that are over each other, and texts that are cut; nothing if all can be read. */
const unreadable = (page: Page) =>
  page.evaluate(() => {
    const problems: string[] = [];
    for (const sensor of document.querySelectorAll(".sensor")) {
      const parts = [...sensor.querySelectorAll(".label, .number, .age, .missed, .sensor-name, .kind, canvas, .track")];
      const seen = parts.filter((part) => part.getClientRects().length > 0 && part.getBoundingClientRect().width > 0);
      const boxes = seen.map((part) => {
        // Of a text, what it takes: it may be longer than its element.
        const range = document.createRange();
        range.selectNodeContents(part);
        return part.tagName === "CANVAS" || part.className === "track"
          ? part.getBoundingClientRect()
          : range.getBoundingClientRect();
      });
      seen.forEach((part, i) => {
        if (part.tagName !== "CANVAS" && part.scrollWidth > part.clientWidth + 1 && part.clientWidth > 0)
          problems.push(`${part.textContent} is cut`);
        const right = sensor.getBoundingClientRect().right;
        if (boxes[i]!.right > right + 1) problems.push(`${part.textContent} is wider than the panel`);
        boxes.slice(i + 1).forEach((other, j) => {
          const wide = Math.min(boxes[i]!.right, other.right) - Math.max(boxes[i]!.left, other.left);
          const high = Math.min(boxes[i]!.bottom, other.bottom) - Math.max(boxes[i]!.top, other.top);
          if (wide > 1 && high > 2)
            problems.push(`${part.className} ${part.textContent} over ${seen[i + 1 + j]!.className}`);
        });
      });
    }
    return problems;
  });

test("at a slow cable each sensor's name, value, age and count have their places", options, async () => {
  const world = mock().worlds.get("second")!;
  world.missed = 12_345n;
  for (const [width, height] of [
    [1280, 800],
    [1920, 1080],
    [1000, 700],
    [390, 844],
  ] as const) {
    const page = await open("#world=second&robot=alice", { width, height });
    await page.waitForFunction(() => document.querySelector(".missed")?.textContent?.includes("missed"));
    await page.waitForFunction(() => / (ms|s)$/.test(document.querySelector(".age")?.textContent ?? ""));
    assert.deepEqual(await unreadable(page), [], `${width} pixels`);
    await page.close();
  }
  world.missed = 0n;
});
