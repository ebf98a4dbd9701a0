import assert from "node:assert/strict";
import { test } from "node:test";
import { boundsOf, fitted, panned, toPixel, toWorld, zoomed, type View } from "../src/arena/view";

const view: View = { x_m: 1, y_m: -2, scale: 80, width: 800, height: 600 };

const near = (a: number, b: number, slack = 1e-9) => assert.ok(Math.abs(a - b) <= slack, `${a} is not ${b}`);

test("a place goes to a pixel and back", () => {
  assert.deepEqual(toPixel(view, 1, -2), [400, 300]);
  assert.deepEqual(toPixel(view, 2, -1), [480, 220]);
  const [x_m, y_m] = toWorld(view, ...toPixel(view, 0.3, 0.7));
  near(x_m, 0.3);
  near(y_m, 0.7);
});

test("what is under the mouse stays there when it zooms", () => {
  const before = toWorld(view, 123, 456);
  const after = toWorld(zoomed(view, 1.7, 123, 456), 123, 456);
  near(after[0], before[0]);
  near(after[1], before[1]);
});

test("the scale has limits", () => {
  assert.equal(zoomed(view, 1e-12, 0, 0).scale, 0.05);
  assert.equal(zoomed(view, 1e12, 0, 0).scale, 50_000);
});

test("a place moves with the hand", () => {
  const [x, y] = toPixel(panned(view, 30, -12), 0, 0);
  const [x0, y0] = toPixel(view, 0, 0);
  near(x - x0, 30);
  near(y - y0, -12);
});

test("all of a box is shown", () => {
  const bounds = boundsOf([
    { x_m: -2, y_m: -1 },
    { x_m: 3, y_m: 4, radius_m: 0.5 },
  ]);
  assert.deepEqual(bounds, { min_x_m: -2, min_y_m: -1, max_x_m: 3.5, max_y_m: 4.5 });
  const shown = fitted(view, bounds!);
  for (const [x_m, y_m] of [
    [-2, -1],
    [3.5, 4.5],
  ] as const) {
    const [x, y] = toPixel(shown, x_m, y_m);
    assert.ok(x >= 0 && x <= 800 && y >= 0 && y <= 600, `it is at ${x}, ${y}`);
  }
  assert.equal(boundsOf([]), undefined);
});
