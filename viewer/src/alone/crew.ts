/** The brains of the page: which ones drive, and how they are begun and ended. */
import { Emitter } from "../emitter";
import type { FromBrain, ToBrain } from "./messages";
import type { Parts } from "./parts";
import type { WorldHost } from "./world_host";

/** A brain that somebody has chosen. */
export type Choice =
  | { kind: "none" }
  | { kind: "repertoire"; brain: string }
  | { kind: "toml"; text: string }
  | { kind: "javascript" | "python"; text: string };

/** A brain in a worker of its own. */
interface Own {
  worker: Worker;
  /** Lets its robots go. */
  close: () => void;
  world: string;
  robots: string[];
  name: string;
}

export class Crew extends Emitter<{ changed: void }> {
  /** What brains said last, and why they ended. */
  readonly log: string[] = [];
  private readonly own = new Set<Own>();

  constructor(
    private readonly host: WorldHost,
    private readonly parts: Parts,
  ) {
    super();
    host.over = ({ brain, robots, error }) => {
      if (error) this.say(`${brain} no longer drives ${robots.join(", ")}: ${error}`);
    };
  }

  /** Lets a brain drive robots. */
  async begin(choice: Choice, world: string, robots: string[]): Promise<void> {
    this.end(world, robots);
    if (choice.kind === "none") return;
    if (choice.kind === "repertoire") await this.host.attach(world, robots, { brain: choice.brain });
    else if (choice.kind === "toml") await this.host.attach(world, robots, { text: choice.text });
    else await this.beginOwn(choice.kind, choice.text, world, robots);
    this.emit("changed", undefined);
  }

  /** Ends brains in workers that drive one of these robots. */
  end(world: string, robots: string[]): void {
    for (const own of this.own) {
      if (own.world === world && own.robots.some((robot) => robots.includes(robot))) this.drop(own);
    }
    this.emit("changed", undefined);
  }

  /** Ends all brains in workers, such as one in an endless loop. */
  endAll(): void {
    for (const own of this.own) this.drop(own);
    this.emit("changed", undefined);
  }

  /** The brains in workers, for people. */
  names(): string[] {
    return [...this.own].map(({ name, robots, world }) => `${name} drives ${robots.join(", ")} of ${world}`);
  }

  private beginOwn(language: ToBrain["language"], code: string, world: string, robots: string[]): Promise<void> {
    const { port, close } = this.host.port();
    const name = language === "javascript" ? "JavaScript brain" : "Python brain";
    const own: Own = { worker: this.worker(language), close, world, robots, name };
    this.own.add(own);
    const { pyodide } = this.parts;
    return new Promise((resolve, reject) => {
      const over = (error: string) => {
        this.dismiss(own);
        if (error) this.say(`${name}: ${error}`);
        reject(new Error(error || "the brain has ended"));
        this.emit("changed", undefined);
      };
      own.worker.onerror = ({ message }) => over(message);
      own.worker.onmessage = ({ data }: MessageEvent<FromBrain>) => {
        if (data.kind === "drives") resolve();
        else if (data.kind === "over") over(data.error ?? "");
        else this.say(data.kind === "loading" ? `Loading ${data.what}…` : data.text);
      };
      const task: ToBrain = { port, world, robots, language, code, name, pyodide };
      own.worker.postMessage(task, [port]);
    });
  }

  private drop(own: Own): void {
    if (!this.own.has(own)) return;
    this.dismiss(own);
    this.say(`${own.name} was ended.`);
  }

  /** Pyodide wants a module, which a browser does not load from a page on a disk by the address of a blob. */
  private worker(language: ToBrain["language"]): Worker {
    const { brain, module } = this.parts;
    return language === "python" ? new Worker(module, { type: "module" }) : new Worker(brain);
  }

  private dismiss(own: Own): void {
    this.own.delete(own);
    own.worker.terminate();
    own.close();
  }

  private say(text: string): void {
    this.log.push(text);
    this.log.splice(0, this.log.length - 200);
    this.emit("changed", undefined);
  }
}
