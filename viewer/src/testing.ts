/** What tests of the page may look at; nothing in it can be changed. */
import type { Arena } from "./arena/arena";
import { toPixel } from "./arena/view";
import { poseOf } from "./model/motion";
import type { Pose } from "./model/pose";
import type { Store } from "./model/store";
import type { Replayer } from "./net/replayer";
import type { Watcher } from "./net/watcher";

export interface ViewerForTests {
  /** Frames that came from the server. */
  readonly frames: number;
  /** Pictures of the arena that were drawn. */
  readonly drawn: number;
  readonly tick: number;
  readonly world: string;
  readonly robot: string;
  /** The chosen robot's true pose. */
  readonly pose: Pose | undefined;
  /** Where that robot is drawn on the canvas, in CSS pixels: behind its pose while it moves there. */
  readonly pixel: [number, number] | undefined;
  /** Its dead reckoning. */
  readonly ghost: Pose | undefined;
  readonly framesPerSecond: number;
  /** Where a replay is or is on its way to; undefined if the world is live. */
  readonly replayTick: number | undefined;
  /** The chosen robot's trail, in metres. */
  readonly trail: [number, number][];
  readonly lastError: string;
  /** The tick of the map of covered cells that is shown, if one is. */
  readonly coverageTick: number | undefined;
  /** Where a place in the world is on the canvas, in CSS pixels. */
  pixelAt(x_m: number, y_m: number): [number, number];
}

declare global {
  interface Window {
    baudbotViewer: ViewerForTests;
  }
}

interface Parts {
  store: Store;
  arena: Arena;
  watcher: Watcher;
  replayer: Replayer;
}

export function exposeForTests({ store, arena, watcher, replayer }: Parts): void {
  const pose = () => store.frame && poseOf(store.frame.poses, store.robotIndex);
  const exposed: ViewerForTests = {
    get frames() {
      return store.frames;
    },
    get drawn() {
      return arena.drawn;
    },
    get tick() {
      return Number(store.frame?.tick ?? 0n);
    },
    get world() {
      return store.world;
    },
    get robot() {
      return store.robot;
    },
    get pose() {
      return pose();
    },
    get pixel() {
      const { poses } = arena.scene();
      const at = poses && poseOf(poses, store.robotIndex);
      return at && toPixel(arena.view, at.x_m, at.y_m);
    },
    get ghost() {
      return store.record?.ghost?.pose;
    },
    get framesPerSecond() {
      return watcher.frames_per_s;
    },
    get replayTick() {
      return replayer.isOn ? Number(replayer.tick) : undefined;
    },
    get trail() {
      const trail = store.trails.all[store.robotIndex];
      return Array.from({ length: trail?.length ?? 0 }, (_, i) => trail?.at(i) ?? ([NaN, NaN] as [number, number]));
    },
    get lastError() {
      return store.lastError;
    },
    get coverageTick() {
      return store.coverage && Number(store.coverage.tick);
    },
    pixelAt: (x_m, y_m) => toPixel(arena.view, x_m, y_m),
  };
  window.baudbotViewer = Object.freeze(exposed);
}
