/**
 * Small helpers to make elements. What comes from a server or a brain gets into the page through `textContent` and
 * attributes alone, so that it can never be markup.
 */

/** What an element can be given. */
export interface Properties {
  class?: string;
  text?: string;
  title?: string;
  type?: string;
  value?: string;
  id?: string;
  /** `data-testid`: what tests find it by. */
  test?: string;
  role?: string;
  /** `aria-label`: what it is to those who do not see it. */
  label?: string;
  hidden?: boolean;
  disabled?: boolean;
  /** Called when it is clicked. */
  click?: (event: MouseEvent) => void;
  attributes?: Record<string, string>;
}

/** Makes an element. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  const attributes: Record<string, string | undefined> = {
    class: properties.class,
    title: properties.title,
    type: properties.type,
    id: properties.id,
    role: properties.role,
    "data-testid": properties.test,
    "aria-label": properties.label,
    ...properties.attributes,
  };
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined) element.setAttribute(name, value);
  }
  if (properties.text !== undefined) element.textContent = properties.text;
  if (properties.value !== undefined) (element as HTMLElement & { value: string }).value = properties.value;
  if (properties.hidden) element.hidden = true;
  if (properties.disabled) (element as HTMLElement & { disabled: boolean }).disabled = true;
  if (properties.click) element.addEventListener("click", properties.click as (event: Event) => void);
  element.append(...children);
  return element;
}

/** A button with a text and a tooltip. */
export function button(text: string, title: string, click: () => void, more: Properties = {}): HTMLButtonElement {
  return el("button", { type: "button", text, title, click, ...more });
}

/** An element of the page that must be there. */
export function find<E extends HTMLElement = HTMLElement>(id: string): E {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element #${id}`);
  return element as E;
}

/** Sets a text only if it differs, so that nothing is laid out again for nothing. */
export function setText(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Whether a class is on an element. */
export function setClass(element: HTMLElement, name: string, on: boolean): void {
  if (element.classList.contains(name) !== on) element.classList.toggle(name, on);
}

/** Tells of a button whether it is pressed in. */
export function setPressed(element: HTMLElement, on: boolean): void {
  const text = on ? "true" : "false";
  if (element.getAttribute("aria-pressed") !== text) element.setAttribute("aria-pressed", text);
}

/** Gives people a file. */
export function download(bytes: Uint8Array, type: string, name: string): void {
  const address = URL.createObjectURL(new Blob([bytes as Uint8Array<ArrayBuffer>], { type }));
  el("a", { attributes: { href: address, download: name } }).click();
  // The browser has begun to read it by then.
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Calls back at once, or when so much time has passed since the last time. */
export class Throttle {
  private last_ms = -Infinity;
  private timer = 0;

  constructor(
    private readonly wait_ms: number,
    private readonly work: () => void,
  ) {}

  /** Asks for it soon, or now. */
  ask(now = false): void {
    const left_ms = now ? 0 : this.last_ms + this.wait_ms - performance.now();
    if (left_ms <= 0) return this.run();
    if (this.timer === 0) this.timer = window.setTimeout(() => this.run(), left_ms);
  }

  private run(): void {
    clearTimeout(this.timer);
    this.timer = 0;
    this.last_ms = performance.now();
    this.work();
  }
}

/** A drawing surface in device pixels for a canvas that is so large in CSS pixels. */
export function surface(canvas: HTMLCanvasElement, width: number, height: number): CanvasRenderingContext2D {
  const ratio = window.devicePixelRatio || 1;
  const [wide, high] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = canvas.getContext("2d");
  if (!context) throw new Error("this browser cannot draw on a canvas");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return context;
}
