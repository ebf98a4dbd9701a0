import { defineConfig } from "vite";

// Fixed names and no hashes: dist/ is committed, and a build of the same sources must give the same bytes.
export default defineConfig({
  base: "./",
  build: {
    target: "es2022",
    modulePreload: false,
    sourcemap: false,
    cssCodeSplit: false,
    reportCompressedSize: false,
    rolldownOptions: {
      output: {
        postBanner:
          "/* With uPlot, (c) Leon Sorokin, and gifenc, (c) Matt DesLauriers, MIT, and @bufbuild/protobuf, Apache-2.0 and BSD-3-Clause: see viewer/LICENSES.md */",
        entryFileNames: "viewer.js",
        assetFileNames: "viewer[extname]",
        codeSplitting: false,
      },
    },
  },
});
