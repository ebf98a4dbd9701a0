/** The overlay that tells the keys. */
import { button, el } from "../dom";

const KEYS: [string, string][] = [
  ["space", "pause or run"],
  [".", "one step"],
  [",", "one step back, in a replay"],
  ["< >", "previous or next event, in a replay"],
  ["+ −", "zoom in, zoom out (mouse wheel, two fingers)"],
  ["arrows", "pan (drag)"],
  ["0", "show all"],
  ["f", "follow the selected robot"],
  ["[ ]", "previous or next robot (or click one)"],
  ["r g b c", "rays, ghost (dead reckoning), belief, coverage"],
  ["m", "move robots and things by hand; the wheel turns them"],
  ["d", "drive: WASD or arrows, gamepad, pad"],
  ["y", "bytes of a cable, with their meaning"],
  ["t", "dark or light"],
  ["?", "this help"],
  ["Escape", "close, let go, stop driving"],
];

const COLOURS =
  "Purple is what a brain believes. A dashed grey outline is dead reckoning, computed by this page from wheel " +
  "readings that reached the brain. Everything else is the truth, which no brain sees.";

export function helpDialog(): HTMLDialogElement {
  const keys = el(
    "dl",
    { class: "keys" },
    ...KEYS.flatMap(([key, text]) => [el("dt", {}, el("kbd", { text: key })), el("dd", { text })]),
  );
  const dialog = el(
    "dialog",
    { class: "help", label: "Help", test: "help" },
    el("h2", { text: "Keys" }),
    keys,
    el("p", { class: "hint", text: COLOURS }),
  );
  dialog.append(
    el(
      "div",
      { class: "dialog-row end" },
      button("Close", "Close (Escape)", () => dialog.close()),
    ),
  );
  return dialog;
}
