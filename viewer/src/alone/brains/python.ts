/** Brains in Python, by Pyodide, which is loaded when the first one is wanted. */
import type { Step } from "./javascript";
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
baudbot.kind = None
_brains = {}


def _step(turn):
    brain = _brains.get(turn.robot) or _brains.setdefault(turn.robot, baudbot.kind())
    command = brain.step(Turn(turn))
    return None if command is None else (command.left, command.right)
`;

/** An import that stays one, so that the same script is a module and none. */
const load = new Function("address", "return import(address)") as (address: string) => Promise<unknown>;

/** What the script of Pyodide exports. */
interface Script {
  loadPyodide(options: object): Promise<Pyodide>;
}

/** What is used of Pyodide. */
interface Pyodide {
  runPython(code: string, options?: { filename?: string; globals?: Proxy }): unknown;
  globals: { get(name: string): Proxy };
}
type Proxy = { (turn: BrainTurn): undefined | { toJs(): [number, number]; destroy(): void } };

/** The brain that a text hands to `baudbot.main`. */
export async function stepOfPython(code: string, folder: string, say: (text: string) => void): Promise<Step> {
  const { loadPyodide } = (await load(`${folder}pyodide.mjs`)) as Script;
  const python: Pyodide = await loadPyodide({ indexURL: folder, stdout: say, stderr: say });
  python.runPython(PACKAGE);
  python.runPython(code, { filename: "brain.py" });
  if (python.runPython("baudbot.kind is None")) throw new Error("no brain was given to baudbot.main");
  const step = python.globals.get("_step");
  return (turn): Answer | undefined => {
    const signals = step(turn);
    if (!signals) return undefined;
    const [left, right] = signals.toJs();
    signals.destroy();
    return { left, right };
  };
}
