/** The page that has the world in it: PART says which of its three scripts is made. `build-page` makes all of them. */
import { readFileSync } from "node:fs";
import { defineConfig } from "vite";

const { devDependencies } = JSON.parse(readFileSync(new URL("package.json", import.meta.url), "utf8"));
const WORKERS: Record<string, string> = {
  "world-worker": "src/alone/world_worker.ts",
  "brain-worker": "src/alone/brains/brain_worker.ts",
};
const part = process.env.PART ?? "page";
const worker = WORKERS[part];

export default defineConfig({
  base: "./",
  define: { __PYODIDE__: JSON.stringify(devDependencies.pyodide) },
  build: {
    target: "es2022",
    modulePreload: false,
    cssCodeSplit: false,
    reportCompressedSize: false,
    emptyOutDir: worker === undefined,
    rolldownOptions: {
      input: worker ?? "page.html",
      output: {
        format: worker ? "iife" : "es",
        postBanner: "/* With work of others: see THIRD-PARTY-NOTICES.txt */",
        entryFileNames: worker ? `${part}.js` : "page.js",
        assetFileNames: "page[extname]",
        codeSplitting: false,
      },
    },
  },
});
