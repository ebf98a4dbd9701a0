/** What a control cycle of a scenario costs, part by part. */
import { button, el, setText } from "../dom";
import type { BudgetSpan, RobotBudget } from "../gen/baudbot/v1/budget_pb";
import { ControlService } from "../gen/baudbot/v1/control_pb";
import { ask, type Connection } from "../net/connection";

export class BudgetView {
  readonly element: HTMLElement;
  private readonly tables = el("div", { test: "budget" });
  private readonly error = el("p", { class: "error", role: "alert" });

  constructor(
    private readonly connection: Connection,
    private readonly toml: () => string,
  ) {
    const compute = button("Compute", "Compute the budget of each robot", () => void this.compute(), {
      test: "budget-compute",
    });
    this.element = el("div", {}, compute, this.error, this.tables);
  }

  clear(): void {
    this.tables.replaceChildren();
    setText(this.error, "");
  }

  private async compute(): Promise<void> {
    this.clear();
    try {
      const scenario = { case: "scenarioToml" as const, value: this.toml() };
      const { robots } = await ask(this.connection, ControlService.method.getBudget, { scenario });
      this.tables.replaceChildren(...robots.flatMap(tableOf));
    } catch (error) {
      setText(this.error, error instanceof Error ? error.message : String(error));
    }
  }
}

function tableOf({ robot, rows, total, deadlineNs, bottleneck, remedies }: RobotBudget): HTMLElement[] {
  const row = (name: string, span: BudgetSpan | undefined) =>
    el(
      "tr",
      {},
      el("th", { text: name, attributes: { scope: "row" } }),
      ...[span?.bestNs, span?.typicalNs, span?.worstNs].map((ns) => el("td", { text: ms(ns) })),
    );
  const head = ["part", "best", "typical", "worst"].map((text) => el("th", { text, attributes: { scope: "col" } }));
  return [
    el(
      "table",
      { class: "budget" },
      el("caption", { text: `${robot}, within ${ms(deadlineNs)}` }),
      el("thead", {}, el("tr", {}, ...head)),
      el("tbody", {}, ...rows.map(({ part, span }) => row(part, span)), row("whole cycle", total)),
    ),
    el("p", { class: "small", text: [bottleneck, ...remedies.map(({ what }) => what)].filter(Boolean).join("\n") }),
  ];
}

function ms(ns: bigint | undefined): string {
  return ns === undefined ? "–" : `${(Number(ns) / 1e6).toFixed(3)} ms`;
}
