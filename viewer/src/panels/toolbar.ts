/** Buttons on the arena: what it shows of the world, and which layers. */
import { button, el, setPressed } from "../dom";
import type { Arena } from "../arena/arena";
import type { Hands } from "../arena/hands";
import type { Layers } from "../arena/scene";

const LAYERS: [keyof Layers, string, string][] = [
  ["rays", "Rays", "Rays and readings of the selected robot's sensors (r)"],
  ["ghost", "Ghost", "Dead reckoning from the selected robot's wheel sensors (g)"],
  ["belief", "Belief", "What the selected robot's brain publishes (b)"],
  ["allBeliefs", "All", "Beliefs of all robots, not only of the selected one"],
  ["trails", "Trails", "Trails of robots"],
  ["names", "Names", "Names of robots"],
  ["fields", "Fields", "Scalar fields, such as a scent"],
  [
    "coverage",
    "Coverage",
    "Floor that bodies have covered and, in a paler colour, that sensors have reached, if this is measured (c)",
  ],
];

export class Toolbar {
  readonly element: HTMLElement;
  private readonly layers = new Map<keyof Layers, HTMLElement>();
  private readonly follow: HTMLButtonElement;
  private readonly move: HTMLButtonElement;

  constructor(
    private readonly arena: Arena,
    private readonly hands: Hands,
    help: () => void,
    theme: () => void,
  ) {
    this.follow = button("Follow", "Keep the selected robot centred (f)", () => arena.setFollows(!arena.follows), {
      test: "follow",
    });
    this.move = button(
      "Move",
      "Drag robots and movable things; the wheel turns what is held (m)",
      () => this.toggleMove(),
      { test: "move" },
    );
    const layers = LAYERS.map(([layer, text, title]) => {
      const made = button(text, title, () => arena.toggle(layer), { test: `layer-${layer}` });
      this.layers.set(layer, made);
      return made;
    });
    const group = (...children: Node[]) => el("div", { class: "group" }, ...children);
    this.element = el(
      "div",
      { class: "toolbar", role: "toolbar", label: "View" },
      group(
        button("−", "Zoom out (−)", () => arena.zoom(1 / 1.4), { label: "Zoom out" }),
        button("+", "Zoom in (+)", () => arena.zoom(1.4), { label: "Zoom in" }),
        button("Fit", "Show everything (0)", () => arena.fit(), { test: "fit" }),
        this.follow,
      ),
      group(...layers),
      group(this.move),
      group(
        button("◐", "Dark or light (t)", theme, { test: "theme", label: "Theme" }),
        button("?", "Keys (?)", help, { label: "Help" }),
      ),
    );
    this.refresh();
  }

  toggleMove(): void {
    if (this.move.disabled) return;
    this.hands.moves = !this.hands.moves;
    if (!this.hands.moves) this.hands.drop();
    this.refresh();
  }

  /** In a replay nothing is carried elsewhere. */
  allowMove(on: boolean): void {
    if (this.move.disabled === !on) return;
    this.hands.moves &&= on;
    this.move.disabled = !on;
    this.refresh();
  }

  refresh(): void {
    for (const [layer, element] of this.layers) setPressed(element, this.arena.layers[layer]);
    setPressed(this.follow, this.arena.follows);
    setPressed(this.move, this.hands.moves);
    this.arena.canvas.classList.toggle("moving", this.hands.moves);
  }
}
