/** The dialog that asks for a token, if the server wants one. */
import { button, el, setText } from "../dom";
import { showToken } from "../net/session";

export class TokenDialog {
  readonly element: HTMLDialogElement;
  private readonly token = el("input", {
    type: "password",
    label: "Token",
    test: "token",
    attributes: { autocomplete: "current-password", spellcheck: "false", size: "52" },
  });
  private readonly error = el("p", { class: "error", role: "alert", test: "token-error" });

  /** `entered` is called when a token was taken. */
  constructor(private readonly entered: () => void) {
    const enter = button("Enter", "Show the token to the server", () => {}, { type: "submit", class: "primary" });
    const form = el(
      "form",
      {},
      el("h2", { text: "This server requires a token" }),
      el("p", { text: "Its operator makes one with `baudbot token new`, or gives you a link." }),
      el("label", {}, "Token ", this.token),
      this.error,
      el("div", { class: "dialog-row end" }, enter),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.enter();
    });
    this.element = el("dialog", { class: "token", test: "token-dialog" }, form);
  }

  show(problem = ""): void {
    setText(this.error, problem);
    if (!this.element.open) this.element.showModal();
  }

  private async enter(): Promise<void> {
    const problem = await showToken(this.token.value.trim());
    setText(this.error, problem);
    if (problem !== "") return;
    this.token.value = "";
    this.element.close();
    this.entered();
  }
}
