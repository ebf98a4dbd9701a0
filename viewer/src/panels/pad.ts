/** What is over the arena while people drive: a pad for finger or mouse, and how strong full stick is. */
import { button, el, setText } from "../dom";
import type { Drive } from "../net/drive";
import { CENTRED } from "../model/stick";

/** Pixels from the pad's middle to full stick. */
const REACH = 44;

export class Pad {
  readonly element: HTMLElement;
  private readonly knob = el("div", { class: "knob" });
  private readonly text = el("p", { class: "small" });
  /** The last pointer that took the knob. */
  private finger = -1;

  constructor(private readonly drive: Drive) {
    const ring = el(
      "div",
      { class: "pad-ring", label: "Drive pad", role: "application", title: "Drag to drive" },
      this.knob,
    );
    const gain = el("input", {
      type: "range",
      label: "Strength",
      title: "Signal at full stick",
      attributes: { min: "0.1", max: "1", step: "0.05" },
    });
    gain.value = String(drive.gain);
    gain.addEventListener("input", () => (drive.gain = Number(gain.value)));
    const stop = button("Stop driving", "Stop the motors and let the robot go (Escape)", () => drive.stop(), {
      test: "drive-stop",
    });
    this.element = el(
      "div",
      { class: "pad", hidden: true, test: "pad" },
      ring,
      el("div", { class: "pad-side" }, this.text, gain, stop),
    );
    ring.addEventListener("pointerdown", (event) => {
      drive.wake();
      ring.setPointerCapture(event.pointerId);
      this.finger = event.pointerId;
      this.push(ring, event);
    });
    ring.addEventListener("pointermove", (event) => ring.hasPointerCapture(event.pointerId) && this.push(ring, event));
    for (const kind of ["pointerup", "pointercancel"] as const) ring.addEventListener(kind, () => this.centre());
    drive.on("changed", () => this.refresh());
    drive.on("rest", () => {
      if (ring.hasPointerCapture(this.finger)) ring.releasePointerCapture(this.finger);
      this.centre();
    });
  }

  private push(ring: HTMLElement, event: PointerEvent): void {
    const box = ring.getBoundingClientRect();
    const [dx, dy] = [event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2];
    const shrink = Math.min(1, REACH / Math.max(1, Math.hypot(dx, dy)));
    this.knob.style.transform = `translate(${dx * shrink}px, ${dy * shrink}px)`;
    this.drive.pad = { forward: (-dy * shrink) / REACH, left: (-dx * shrink) / REACH };
  }

  private centre(): void {
    this.knob.style.transform = "";
    this.drive.pad = CENTRED;
  }

  private refresh(): void {
    const { state } = this.drive;
    this.element.hidden = state === "off";
    if (state === "off") this.centre();
    const words = {
      off: "",
      asking: "asking for the robot…",
      driving: "WASD, arrows, gamepad, or drag",
    };
    setText(this.text, words[state]);
  }
}
