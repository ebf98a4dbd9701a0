/** The floor of the mock's room as cells, and which of them its robots have covered and sensed. */
import { create } from "@bufbuild/protobuf";
import { GetCoverageResponseSchema, type GetCoverageResponse } from "../src/gen/baudbot/v1/observe_pb";
import { ROOM } from "./mock_scene";

const CELL_M = 0.1;
const COLUMNS = Math.round((2 * ROOM.x_m) / CELL_M);
const ROWS = Math.round((2 * ROOM.y_m) / CELL_M);

/** How far a robot of the mock senses the floor. */
export const SENSED_M = 0.5;

export class MockFloor {
  readonly covered = new Set<number>();
  readonly sensed = new Set<number>();

  clear(): void {
    this.covered.clear();
    this.sensed.clear();
  }

  /** Puts the cells into a set whose middle is in a disc. */
  mark(set: Set<number>, x_m: number, y_m: number, radius_m: number): void {
    const place = (at_m: number, side_m: number) => Math.floor((at_m + side_m) / CELL_M);
    for (let row = place(y_m - radius_m, ROOM.y_m); row <= place(y_m + radius_m, ROOM.y_m); row++)
      for (let column = place(x_m - radius_m, ROOM.x_m); column <= place(x_m + radius_m, ROOM.x_m); column++) {
        const isThere = row >= 0 && row < ROWS && column >= 0 && column < COLUMNS;
        const [dx, dy] = [(column + 0.5) * CELL_M - ROOM.x_m - x_m, (row + 0.5) * CELL_M - ROOM.y_m - y_m];
        if (isThere && Math.hypot(dx, dy) < radius_m) set.add(row * COLUMNS + column);
      }
  }

  get score(): { covered: number; sensed: number } {
    return { covered: this.covered.size / (COLUMNS * ROWS), sensed: this.sensed.size / (COLUMNS * ROWS) };
  }

  map(tick: bigint): GetCoverageResponse {
    return create(GetCoverageResponseSchema, {
      tick,
      cellM: CELL_M,
      xM: -ROOM.x_m,
      yM: -ROOM.y_m,
      columns: COLUMNS,
      rows: ROWS,
      free: [0, COLUMNS * ROWS],
      covered: runsOf(this.covered),
      sensed: runsOf(this.sensed),
    });
  }
}

/** Lengths of runs, beginning with cells that are not in the set. */
function runsOf(set: ReadonlySet<number>): number[] {
  const runs = [0];
  for (let cell = 0; cell < COLUMNS * ROWS; cell++) {
    const isIn = runs.length % 2 === 0;
    if (set.has(cell) !== isIn) runs.push(0);
    runs.push((runs.pop() ?? 0) + 1);
  }
  return runs;
}
