/** Sets of cells of the floor, told as lengths of runs: so many that are not in the set, so many that are, and so on. */

/** Sets the cells that are in a set. */
export function fillRuns(cells: Uint32Array, runs: readonly number[], value: number): void {
  let at = 0;
  runs.forEach((run, i) => {
    if (i % 2 === 1) cells.fill(value, at, at + run);
    at += run;
  });
}
