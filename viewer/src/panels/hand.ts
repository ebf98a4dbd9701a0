/** What people can do to the chosen robot by hand: its cable, its baud rate, its brain. */
import { create } from "@bufbuild/protobuf";
import { button, el, setPressed, setText } from "../dom";
import { DetachBrainSchema, PullCableSchema, SetBaudSchema } from "../gen/baudbot/v1/control_pb";
import type { Store } from "../model/store";
import type { Drive } from "../net/drive";
import type { Orders } from "../net/orders";

export class HandSection {
  readonly element: HTMLElement;
  private readonly cable: HTMLButtonElement;
  private readonly baud = el("input", {
    type: "number",
    label: "Baud rate",
    title: "Baud rate of the cable",
    attributes: { min: "50", step: "1", list: "bauds" },
  });
  private readonly detach: HTMLButtonElement;
  private readonly restart: HTMLButtonElement;
  private readonly drive: HTMLButtonElement;
  private readonly set: HTMLButtonElement;

  constructor(
    private readonly store: Store,
    private readonly orders: Orders,
    private readonly driver: Drive,
  ) {
    this.cable = button(
      "Pull cable",
      "Pull the cable between the robot and its brain, or plug it in",
      () => void this.pull(),
      { test: "cable" },
    );
    this.detach = button("Detach brain", "Detach the robot's brain", () => void this.throwOff(false), {
      test: "detach",
    });
    this.restart = button(
      "Restart brain",
      "Detach the robot's brain and have its program restart it; a program that cannot do this simply leaves",
      () => void this.throwOff(true),
      { test: "restart" },
    );
    this.drive = button(
      "Drive",
      "Drive it yourself: WASD, arrows, a gamepad's left stick, or the pad (d)",
      () => this.driver.toggle(),
      { test: "drive", class: "primary" },
    );
    const bauds = el("datalist", { id: "bauds" });
    for (const rate of [1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200])
      bauds.append(el("option", { value: String(rate) }));
    this.set = button("Set", "Set this baud rate at both ends of the cable", () => void this.setBaud());
    this.element = el(
      "div",
      { class: "hand" },
      this.drive,
      this.cable,
      this.detach,
      this.restart,
      el("span", { class: "joined" }, this.baud, this.set),
      bauds,
    );
    this.baud.addEventListener("keydown", (event) => event.key === "Enter" && void this.setBaud());
    driver.on("changed", () => this.refresh());
  }

  /** Another robot. */
  reset(): void {
    this.baud.value = String(this.store.record?.description.baud ?? "");
    this.baud.disabled = this.store.record?.description.baud === undefined;
    this.refresh();
  }

  refresh(): void {
    this.takeBaud();
    const isPulled = this.isPulled;
    setText(this.cable, isPulled ? "Plug cable in" : "Pull cable");
    setPressed(this.cable, isPulled);
    const drives = this.driver.state !== "off";
    setText(this.drive, drives ? "Stop driving" : "Drive");
    setPressed(this.drive, drives);
    const isReplay = this.store.status?.replay !== undefined;
    this.drive.disabled = this.cable.disabled = this.set.disabled = isReplay;
    this.detach.disabled = isReplay || !(this.store.record?.now?.detail?.attached ?? false);
    this.restart.disabled = this.detach.disabled;
  }

  private get isPulled(): boolean {
    return this.store.record?.now?.detail?.cablePulled ?? false;
  }

  /** Somebody else may have set another baud rate, or reset the world. */
  private takeBaud(): void {
    const { record } = this.store;
    const baud = record?.now?.detail?.baud;
    if (!record || baud === undefined || baud === record.description.baud) return;
    // Shares of the baud rate are of the new one from now on.
    record.description.baud = baud;
    this.store.emit("robot", undefined);
  }

  private async pull(): Promise<void> {
    const { robot } = this.store;
    const pulled = !this.isPulled;
    await this.orders.intervene({ case: "pullCable", value: create(PullCableSchema, { robot, pulled }) });
  }

  private async setBaud(): Promise<void> {
    const [{ robot }, baud] = [this.store, Number(this.baud.value)];
    if (!Number.isInteger(baud) || baud <= 0)
      return this.store.note("The baud rate must be a positive whole number.", "error");
    const done = await this.orders.intervene({ case: "setBaud", value: create(SetBaudSchema, { robot, baud }) });
    if (done) this.store.note(`${robot}'s cable now runs at ${baud} baud.`);
  }

  private async throwOff(restart: boolean): Promise<void> {
    const { robot } = this.store;
    await this.orders.intervene({ case: "detachBrain", value: create(DetachBrainSchema, { robot, restart }) });
  }
}
