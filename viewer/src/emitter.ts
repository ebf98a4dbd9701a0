/** Tells those who want to know that something happened. */
export class Emitter<Events extends Record<string, unknown>> {
  private readonly listeners = new Map<keyof Events, Set<(event: never) => void>>();

  /** Calls back at each such event; what is returned ends that. */
  on<K extends keyof Events>(kind: K, listener: (event: Events[K]) => void): () => void {
    const all = this.listeners.get(kind) ?? new Set();
    this.listeners.set(kind, all);
    all.add(listener as (event: never) => void);
    return () => all.delete(listener as (event: never) => void);
  }

  emit<K extends keyof Events>(kind: K, event: Events[K]): void {
    for (const listener of this.listeners.get(kind) ?? []) {
      (listener as (event: Events[K]) => void)(event);
    }
  }
}
