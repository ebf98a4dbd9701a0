/** What a page shows once it shows nothing else for a while, however slow the machine is. */
import assert from "node:assert/strict";
import { setTimeout as sleep } from "node:timers/promises";

/** Reads until the value has been the same for `quiet_ms`. */
export async function settled<T>(read: () => Promise<T>, quiet_ms = 1500): Promise<T> {
  const begun = Date.now();
  let [value, since] = [await read(), Date.now()];
  while (Date.now() - since < quiet_ms) {
    assert.ok(Date.now() - begun < 30_000, `it never rests: ${JSON.stringify(value)}`);
    await sleep(100);
    const now = await read();
    if (JSON.stringify(now) !== JSON.stringify(value)) [value, since] = [now, Date.now()];
  }
  return value;
}

/** Reads until the value is another. */
export async function other<T>(value: T, read: () => Promise<T>, why: string): Promise<void> {
  const begun = Date.now();
  while ((await read()) === value) {
    assert.ok(Date.now() - begun < 20_000, why);
    await sleep(100);
  }
}
