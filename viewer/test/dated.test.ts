/** Files in the memory of the page have dates. */
import assert from "node:assert/strict";
import { test } from "node:test";
import { PreopenDirectory, wasi, type Inode } from "@bjorn3/browser_wasi_shim";
import { date } from "../src/alone/dated";

/** Where `filestat` of WASI has its times. */
const [SIZE, CHANGED] = [32, 48];

test("a file that was written to has the date of that, where WASI has it", async () => {
  const folder = new PreopenDirectory("/", new Map<string, Inode>());
  date(folder.dir);
  const write = wasi.RIGHTS_FD_WRITE;
  const { fd_obj } = folder.path_open(0, "run.mcap", wasi.OFLAGS_CREAT, BigInt(write), 0n, 0);
  assert.ok(fd_obj);
  await new Promise((resolve) => setTimeout(resolve, 20));
  const before_ms = Date.now();
  fd_obj.fd_write(new Uint8Array([1, 2, 3]));
  const { filestat } = folder.path_filestat_get(0, "run.mcap");
  assert.ok(filestat);
  const view = new DataView(new ArrayBuffer(64));
  filestat.write_bytes(view, 0);
  assert.equal(view.getBigUint64(SIZE, true), 3n);
  const changed_ms = Number(view.getBigUint64(CHANGED, true) / 1_000_000n);
  assert.ok(changed_ms >= before_ms && changed_ms <= Date.now(), `${changed_ms}`);
});
