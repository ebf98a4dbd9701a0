/** A browser before the mock server, for the tests of a file. Needs a Chromium: in CHROMIUM, or where Debian has it. */
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { after, before } from "node:test";
import { chromium, type Browser, type Page } from "playwright-core";
import { serve, type Mock } from "./mock";

const PROGRAM = process.env.CHROMIUM ?? "/usr/bin/chromium";

export function beforeTheMock() {
  const options = { skip: existsSync(PROGRAM) ? false : `there is no browser at ${PROGRAM}`, timeout: 60_000 };
  let browser: Browser;
  let mock: Mock;

  before(async () => {
    if (options.skip) return;
    mock = await serve(0, 3);
    browser = await chromium.launch({ executablePath: PROGRAM, args: ["--no-sandbox"] });
  });

  after(async () => {
    await browser?.close();
    mock?.stop();
  });

  /** A page that fails the test if anything is refused by its policy or thrown in it. */
  async function visit(path: string, size = { width: 1280, height: 800 }, colorScheme: "light" | "dark" = "light") {
    const page = await (await browser.newContext({ viewport: size, colorScheme })).newPage();
    page.on("console", (message) => message.type() === "error" && assert.fail(message.text()));
    page.on("pageerror", (error) => assert.fail(error));
    await page.goto(`http://127.0.0.1:${mock.port}/${path}`);
    return page;
  }

  /** The same, when frames have come. */
  async function open(...how: Parameters<typeof visit>): Promise<Page> {
    const page = await visit(...how);
    await page.waitForFunction(() => window.baudbotViewer?.frames > 5);
    return page;
  }

  return { options, shots: process.env.SHOTS, visit, open, mock: () => mock };
}
