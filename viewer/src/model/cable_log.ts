/** The newest of what was said on a cable, as rows. Older ones are forgotten. */
import { CableDirection, type CableItem, type WatchCableResponse } from "../gen/baudbot/v1/observe_pb";
import { fixed, numberOf } from "./units";

/** More rows are not kept. */
export const MOST_ROWS = 500;
/** Bytes of a row that are shown; of more, how many more there are. */
const MOST_HEX = 48;

export interface CableRow {
  /** Counts the rows, from 1. */
  number: number;
  isDown: boolean;
  /** Simulated instant of the last byte, in nanoseconds. */
  to_ns: number;
  hex: string;
  text: string;
  understood: boolean;
  /** How old its oldest reading was, in nanoseconds, if it says so. */
  age_ns: number | undefined;
}

export class CableLog {
  rows: CableRow[] = [];
  /** Items that the server has left out, as this page did not keep up. */
  missed = 0;
  /** Items that came while the list stood still. */
  passed = 0;
  private number = 0;
  private paused = false;

  get isPaused(): boolean {
    return this.paused;
  }

  /** While it stands still, what comes is only counted. */
  setPaused(on: boolean): void {
    this.paused = on;
    this.passed = 0;
  }

  take({ items, missedItems, restarted }: WatchCableResponse): void {
    this.missed = numberOf(missedItems);
    if (this.paused) {
      this.passed += items.length;
      return;
    }
    // What came before a reset is no past of what comes now.
    if (restarted) this.rows = [];
    const rows = items.slice(-MOST_ROWS).map((item) => rowOf(item, ++this.number));
    this.rows = [...this.rows, ...rows].slice(-MOST_ROWS);
  }

  clear(): void {
    this.rows = [];
    this.passed = 0;
  }

  /** Another cable. */
  reset(): void {
    this.clear();
    this.missed = 0;
  }
}

function rowOf(item: CableItem, number: number): CableRow {
  return {
    number,
    isDown: item.direction === CableDirection.DOWN,
    to_ns: numberOf(item.toNs),
    hex: hexOf(item.data, item.size),
    text: item.text,
    understood: item.understood,
    age_ns: item.ageNs === undefined ? undefined : numberOf(item.ageNs),
  };
}

/** Bytes as hexadecimal digits, and how many more there are. */
export function hexOf(data: Uint8Array, size: number): string {
  const shown = Array.from(data.subarray(0, MOST_HEX), (byte) => byte.toString(16).padStart(2, "0"));
  const more = size - shown.length;
  return more > 0 ? `${shown.join(" ")} + ${more}` : shown.join(" ");
}

/** The instant of a row, in milliseconds to the microsecond. */
export function instantOf(row: CableRow): string {
  return fixed(row.to_ns / 1e6, 3);
}
