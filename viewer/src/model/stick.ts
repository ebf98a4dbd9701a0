/** From a stick, keys or a pad to the signals of two motors. */

/** How far a stick is pushed: forwards and to the left are positive, both in [-1, 1]. */
export interface Stick {
  forward: number;
  left: number;
}

export const CENTRED: Stick = { forward: 0, left: 0 };
/** A stick that nobody touches is hardly ever at zero. */
const DEAD = 0.12;
/** Turning at full speed would be too quick for a hand. */
const TURN = 0.6;

/** Signals of the left and the right motor, none larger than `limit`. */
export function signals(stick: Stick, gain: number, limit: number): { left: number; right: number } {
  const left = stick.forward - TURN * stick.left;
  const right = stick.forward + TURN * stick.left;
  const largest = Math.max(1, Math.abs(left), Math.abs(right));
  const scale = (gain * limit) / largest;
  return { left: left * scale, right: right * scale };
}

const KEYS: Record<string, Stick> = {
  w: { forward: 1, left: 0 },
  arrowup: { forward: 1, left: 0 },
  s: { forward: -1, left: 0 },
  arrowdown: { forward: -1, left: 0 },
  a: { forward: 0, left: 1 },
  arrowleft: { forward: 0, left: 1 },
  d: { forward: 0, left: -1 },
  arrowright: { forward: 0, left: -1 },
};

/** Whether a key drives. */
export function isDriveKey(key: string): boolean {
  return key.toLowerCase() in KEYS;
}

/** What the keys that are held down mean together. */
export function stickOfKeys(held: Iterable<string>): Stick {
  let [forward, left] = [0, 0];
  for (const key of new Set([...held].map((key) => KEYS[key.toLowerCase()]))) {
    forward += key?.forward ?? 0;
    left += key?.left ?? 0;
  }
  return { forward: clamp(forward), left: clamp(left) };
}

/** What a gamepad's left stick means; its axes go to the right and downwards. */
export function stickOfAxes(axes: readonly number[]): Stick {
  const live = (value = 0) => (Math.abs(value) < DEAD ? 0 : clamp(value));
  return { forward: -live(axes[1]) || 0, left: -live(axes[0]) || 0 };
}

function clamp(value: number): number {
  return Math.max(-1, Math.min(1, value));
}
