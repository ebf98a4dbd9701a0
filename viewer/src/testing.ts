/** What tests of the page may look at; nothing in it can be changed. */
import type { Arena } from "./arena/arena";
import { toPixel } from "./arena/view";
import { poseOf } from "./model/motion";
import type { Pose } from "./model/pose";
import type { Store } from "./model/store";
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
  /** Where that is on the canvas, in CSS pixels. */
  readonly pixel: [number, number] | undefined;
  /** Its dead reckoning. */
  readonly ghost: Pose | undefined;
  readonly framesPerSecond: number;
  readonly lastError: string;
}

declare global {
  interface Window {
    baudbotViewer: ViewerForTests;
  }
}

export function exposeForTests(store: Store, arena: Arena, watcher: Watcher): void {
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
      const at = pose();
      return at && toPixel(arena.view, at.x_m, at.y_m);
    },
    get ghost() {
      return store.record?.ghost?.pose;
    },
    get framesPerSecond() {
      return watcher.frames_per_s;
    },
    get lastError() {
      return store.lastError;
    },
  };
  window.baudbotViewer = Object.freeze(exposed);
}
