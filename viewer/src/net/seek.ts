/**
 * Takes a world to the tick that is wished for. One call is under way at a time; of the wishes that come meanwhile the
 * newest wins, and the others are never asked for.
 */
export class SeekQueue {
  /** Where the world is on its way to. */
  wished: bigint | undefined;
  private work: Promise<void> | undefined;

  constructor(
    private readonly seek: (tick: bigint) => Promise<void>,
    /** Told once of each call that failed. */
    private readonly failed: (error: unknown) => void = () => {},
  ) {}

  /** Settles when nothing is wished for any more. */
  want(tick: bigint): Promise<void> {
    this.wished = tick;
    this.work ??= this.run().finally(() => (this.work = undefined));
    return this.work;
  }

  /** Nothing is wished for; what is under way is not called back. */
  drop(): void {
    this.wished = undefined;
  }

  private async run(): Promise<void> {
    while (this.wished !== undefined) {
      const tick = this.wished;
      await this.seek(tick).catch(this.failed);
      // A newer wish outlives a call that failed.
      if (this.wished === tick) this.wished = undefined;
    }
  }
}
