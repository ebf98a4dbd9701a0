/** The parts of the page that are loaded by themselves: in the page, if it is a single file, or else beside it. */

export interface Parts {
  /** Addresses of the workers' scripts. */
  world: string;
  brain: string;
  /** The brain's as a module. */
  module: string;
  /** The world's program, packed. */
  wasm(): Promise<ArrayBuffer>;
  /** The folder of Pyodide. */
  pyodide: string;
}

declare const __PYODIDE__: string;

export function parts(): Parts {
  const [world, brain, wasm] = ["world-worker", "brain-worker", "world-wasm"].map((id) => document.getElementById(id));
  if (world && brain && wasm) {
    return {
      world: addressOf(world.textContent),
      brain: addressOf(brain.textContent),
      module: `data:text/javascript;charset=utf-8,${encodeURIComponent(brain.textContent)}`,
      wasm: async () => bytesOf(wasm.textContent),
      // A file has no folder beside it; this one is the package's at npm.
      pyodide: `https://cdn.jsdelivr.net/npm/pyodide@${__PYODIDE__}/`,
    };
  }
  const beside = (name: string) => new URL(name, document.baseURI).href;
  return {
    world: beside("world-worker.js"),
    brain: beside("brain-worker.js"),
    module: beside("brain-worker.js"),
    wasm: async () => {
      const response = await fetch(beside("baudbot.wasm.zst"));
      if (!response.ok) throw new Error(`baudbot.wasm.zst: ${response.status} ${response.statusText}`);
      return response.arrayBuffer();
    },
    pyodide: beside("pyodide/"),
  };
}

function addressOf(script: string): string {
  return URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
}

/** What is in base64. */
function bytesOf(text: string): ArrayBuffer {
  return Uint8Array.from(atob(text.trim()), (character) => character.charCodeAt(0)).buffer;
}
