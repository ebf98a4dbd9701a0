/** Keeps a WatchCable open on one cable while somebody looks at it, and none otherwise. */
import { fromBinary } from "@bufbuild/protobuf";
import { ObserveService, WatchCableResponseSchema, type WatchCableResponse } from "../gen/baudbot/v1/observe_pb";
import type { CallError, Connection } from "./connection";

/** Which cable; without a sensor's name, that between the robot and its brain. */
export interface CableChoice {
  world: string;
  robot: string;
  sensor: string;
}

/** How it is: an error says why nothing comes. */
export type CableState = "off" | "asked" | "open" | Error;

export class CableWatch {
  state: CableState = "off";
  private call = 0;
  private choice: CableChoice | undefined;

  constructor(
    private readonly connection: Connection,
    private readonly take: (response: WatchCableResponse) => void,
    /** Called when `state` has changed. */
    private readonly changed: () => void,
  ) {}

  open(choice: CableChoice): void {
    this.end();
    this.choice = choice;
    this.state = "asked";
    const call = this.connection.begin(ObserveService.method.watchCable, choice, {
      message: (bytes) => call === this.call && this.hear(fromBinary(WatchCableResponseSchema, bytes)),
      over: (error) => this.over(call, error),
    });
    this.call = call;
    this.changed();
  }

  /** The connection is there again. */
  again(): void {
    if (this.choice && this.call === 0) this.open(this.choice);
  }

  close(): void {
    this.end();
    this.choice = undefined;
    this.state = "off";
    this.changed();
  }

  private end(): void {
    if (this.call !== 0) this.connection.end(this.call);
    this.call = 0;
  }

  private hear(response: WatchCableResponse): void {
    if (this.state !== "open") {
      this.state = "open";
      this.changed();
    }
    this.take(response);
  }

  private over(call: number, error?: CallError): void {
    if (call !== this.call) return;
    this.call = 0;
    this.state = error ?? new Error("the world is over");
    this.changed();
  }
}
