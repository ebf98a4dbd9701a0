/** Puts the page's parts together: `tsx pack-page.ts FOLDER WASM`, after its scripts are in FOLDER/site. See build-page. */
import { createHash } from "node:crypto";
import { cpSync, mkdirSync, readFileSync, renameSync, rmSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { compress, init } from "@bokuweb/zstd-wasm";

/** What Pyodide loads, of its package. */
const PYODIDE = ["pyodide.mjs", "pyodide.asm.mjs", "pyodide.asm.wasm", "pyodide-lock.json", "python_stdlib.zip"];
/** What is loaded before a brain in Python is wanted. */
const OWN = ["index.html", "page.js", "page.css", "world-worker.js", "brain-worker.js", "baudbot.wasm.zst"];
/** The level of Zstandard that packs most. */
const MOST = 22;

const [out, wasm] = process.argv.slice(2);
if (!out || !wasm) throw new Error("usage: tsx pack-page.ts FOLDER WASM");
const site = join(out, "site");
const read = (name: string) => readFileSync(join(site, name), "utf8");

renameSync(join(site, "page.html"), join(site, "index.html"));
await init();
const program = compress(readFileSync(wasm), MOST);
writeFileSync(join(site, "baudbot.wasm.zst"), program);
rmSync(join(site, "pyodide"), { recursive: true, force: true });
mkdirSync(join(site, "pyodide"));
for (const name of PYODIDE) cpSync(join("node_modules/pyodide", name), join(site, "pyodide", name));

// What the policy allows in one file is this very script.
const own = script("page.js");
const hash = createHash("sha256").update(own).digest("base64");
// The replacements are functions: in a text `$&` would mean something.
const single = read("index.html")
  .replace("script-src 'self'", () => `script-src 'sha256-${hash}'`)
  .replace(/<link rel="stylesheet"[^>]*>/, () => `<style>${read("page.css")}</style>`)
  .replace(/<script type="module"[^>]*><\/script>/, () => "")
  .replace(
    "</body>",
    () =>
      `<script type="text/plain" id="world-worker">${script("world-worker.js")}</script>\n` +
      `<script type="text/plain" id="brain-worker">${script("brain-worker.js")}</script>\n` +
      `<script type="text/plain" id="world-wasm">${Buffer.from(program).toString("base64")}</script>\n` +
      `<script type="module">${own}</script>\n</body>`,
  );
writeFileSync(join(out, "baudbot.html"), single);

const packed = OWN.map((name) => gzipSync(readFileSync(join(site, name)), { level: 9 }).length);
const kb = (bytes: number) => `${(bytes / 1000).toFixed(0)} kB`;
OWN.forEach((name, i) => console.log(`${kb(packed[i]!).padStart(8)}  ${name}, by gzip`));
console.log(`${kb(packed.reduce((sum, bytes) => sum + bytes)).padStart(8)}  all of ${site} but Pyodide, by gzip`);
console.log(`${kb(gzipSync(single, { level: 9 }).length).padStart(8)}  ${join(out, "baudbot.html")}, by gzip`);

/** A script as it may stand in a page: it does not end its element. */
function script(name: string): string {
  return read(name).replaceAll(/<(\/script|!--)/gi, "\\x3C$1");
}
