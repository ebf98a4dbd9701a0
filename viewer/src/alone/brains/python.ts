/** Brains in Python, by Pyodide, which is loaded when the first one is wanted. */
import type { Make } from "./javascript";
import type { Answer, BrainTurn } from "./turn";

/** As much of the package `baudbot` as such a brain needs. Its brains are made for each robot. */
const PACKAGE = `
import sys, types

baudbot = types.ModuleType("baudbot")
sys.modules["baudbot"] = baudbot


class Command:
    def __init__(self, left, right):
        self.left, self.right = float(left), float(right)


class Turn:
    def __init__(self, turn):
        self._turn = turn
        self.robot, self.tick, self.time_s = turn.robot, turn.tick, turn.time_s

    def value(self, sensor, unread=None):
        value = self._turn.value(sensor)
        return unread if value is None else value

    def values(self, sensor):
        return self._turn.values(sensor).to_py()

    def is_new(self, sensor):
        return self._turn.isNew(sensor)


class Brain:
    def step(self, turn):
        raise NotImplementedError("a brain needs a method step(self, turn)")


def main(brain):
    baudbot.kind = brain


baudbot.Brain, baudbot.Command, baudbot.Turn, baudbot.main = Brain, Command, Turn, main
baudbot.drive = Command
_own = frozenset(sys.modules)


def _compiled(code):
    return compile(code, "brain.py", "exec")


def _make(code):
    """A run has new brains: of what the code, or a module that it has imported, kept from another one nothing is left."""
    for name in set(sys.modules) - _own:
        del sys.modules[name]
    baudbot.kind, brains = None, {}
    exec(code, {"__name__": "__main__", "__builtins__": __builtins__})
    if baudbot.kind is None:
        return None

    def step(turn):
        if turn.robot not in brains:
            brains[turn.robot] = baudbot.kind()
        command = brains[turn.robot].step(Turn(turn))
        return None if command is None else (command.left, command.right)

    return step
`;

/** An import that stays one, so that the same script is a module and none. */
const load = new Function("address", "return import(address)") as (address: string) => Promise<unknown>;

/** What the script of Pyodide exports. */
interface Script {
  loadPyodide(options: object): Promise<Pyodide>;
}

/** What is used of Pyodide. */
interface Pyodide {
  runPython(code: string): unknown;
  globals: { get(name: string): (code: unknown) => Proxy | undefined };
}
type Proxy = { (turn: BrainTurn): undefined | { toJs(): [number, number]; destroy(): void }; destroy(): void };

/** What makes the brain that a text hands to `baudbot.main`. */
export async function makerOfPython(code: string, folder: string, say: (text: string) => void): Promise<Make> {
  const { loadPyodide } = (await load(`${folder}pyodide.mjs`)) as Script;
  const python: Pyodide = await loadPyodide({ indexURL: folder, stdout: say, stderr: say });
  python.runPython(PACKAGE);
  const [compile, make] = [python.globals.get("_compiled"), python.globals.get("_make")];
  const compiled = compile(code);
  let former: Proxy | undefined;
  return () => {
    former?.destroy();
    const step = (former = make(compiled));
    if (!step) throw new Error("no brain was given to baudbot.main");
    return (turn): Answer | undefined => {
      const signals = step(turn);
      if (!signals) return undefined;
      const [left, right] = signals.toJs();
      signals.destroy();
      return { left, right };
    };
  };
}
