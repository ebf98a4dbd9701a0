/** The newest values, and no more of them than there are places: a page that is open for a night does not grow. */
export class Ring {
  private readonly values: Float64Array;
  private head = 0;
  /** How many there are. */
  length = 0;

  constructor(readonly capacity: number) {
    this.values = new Float64Array(capacity);
  }

  push(value: number): void {
    this.values[this.head] = value;
    this.head = (this.head + 1) % this.capacity;
    this.length = Math.min(this.length + 1, this.capacity);
  }

  /** The i-th, 0 being the oldest; NaN if there is none. */
  at(i: number): number {
    if (i < 0 || i >= this.length) return NaN;
    return this.values[(this.head - this.length + i + this.capacity) % this.capacity] ?? NaN;
  }

  /** The newest; NaN if there is none. */
  last(): number {
    return this.at(this.length - 1);
  }

  /** Takes the newest away, so many of them. */
  drop(count: number): void {
    const gone = Math.min(count, this.length);
    this.head = (this.head - gone + this.capacity) % this.capacity;
    this.length -= gone;
  }
}

/** A row of a table. */
interface Row {
  time_s: number;
  values: Iterable<readonly [string, number]>;
}

/** Time series that share their instants. A series that appears later has NaN for what was before it. */
export class SeriesTable {
  private readonly columns = new Map<string, Float64Array>();
  private readonly times: Float64Array;
  private head = 0;
  length = 0;
  /** Rows that were cut off and will be again, the nearest last. */
  private later: Row[] = [];

  constructor(
    readonly capacity: number,
    readonly mostColumns: number,
  ) {
    this.times = new Float64Array(capacity);
  }

  /** The instant of the oldest row; 0 if there is none. */
  get first(): number {
    return this.length > 0 ? (this.times[(this.head - this.length + this.capacity) % this.capacity] ?? 0) : 0;
  }

  /**
   * A row of values. Beyond the most columns that are kept, new ones are left out. If the row before is farther away
   * than `near_s`, something was missed in between, and a row without values says so. What is known of the time in
   * between comes first.
   */
  push(time_s: number, values: Iterable<readonly [string, number]>, near_s = Infinity): void {
    let far_s = near_s;
    for (let next = this.later.at(-1); next && next.time_s <= time_s; next = this.later.at(-1)) {
      this.later.pop();
      if (next.time_s === time_s) break;
      this.follow(next, far_s);
      far_s = Infinity; // gaps between these are rows of their own
    }
    this.follow({ time_s, values }, near_s);
  }

  private follow(row: Row, near_s: number): void {
    const before_s = this.times[(this.head - 1 + this.capacity) % this.capacity] ?? 0;
    if (this.length > 0 && row.time_s - before_s > near_s)
      this.add({ time_s: (before_s + row.time_s) / 2, values: [] });
    this.add(row);
  }

  private add({ time_s, values }: Row): void {
    this.times[this.head] = time_s;
    for (const column of this.columns.values()) column[this.head] = NaN;
    for (const [key, value] of values) this.column(key)?.fill(value, this.head, this.head + 1);
    this.head = (this.head + 1) % this.capacity;
    this.length = Math.min(this.length + 1, this.capacity);
  }

  /** The newest rows of some series, the oldest first: instants, then values. */
  rows(keys: string[], most: number): Float64Array[] {
    const length = Math.min(most, this.length);
    return [this.times, ...keys.map((key) => this.columns.get(key))].map((column) => {
      const row = new Float64Array(length).fill(NaN);
      const start = this.head - length + this.capacity;
      if (column) for (let i = 0; i < length; i++) row[i] = column[(start + i) % this.capacity] ?? NaN;
      return row;
    });
  }

  /** Takes away what is not before an instant; in a replay that `comesAgain`, and is there when its time has come. */
  cut(time_s: number, comesAgain = false): void {
    if (!comesAgain) this.later = [];
    while (this.length > 0) {
      const last = (this.head - 1 + this.capacity) % this.capacity;
      const row_s = this.times[last] ?? -Infinity;
      if (row_s < time_s) break;
      if (comesAgain) this.later.push({ time_s: row_s, values: this.valuesAt(last) });
      this.head = last;
      this.length--;
    }
    this.later = this.later.slice(-this.capacity);
  }

  /** What will come is not what came: a replay goes on as a live world. */
  forgetLater(): void {
    this.later = [];
  }

  private valuesAt(place: number): [string, number][] {
    return [...this.columns].flatMap(([key, column]) => {
      const value = column[place] ?? NaN;
      return Number.isNaN(value) ? [] : [[key, value] as [string, number]];
    });
  }

  private column(key: string): Float64Array | undefined {
    const known = this.columns.get(key);
    if (known || this.columns.size >= this.mostColumns) return known;
    const made = new Float64Array(this.capacity).fill(NaN);
    this.columns.set(key, made);
    return made;
  }
}
