/**
 * What a picture of the viewer costs: `npm run measure:frames [-- ROBOTS…]`, by default with 100 and 2,000 robots.
 *
 * The world is of the program (BAUDBOT, or where `cargo build --release` puts it), in real time, before the page of `dist`; then of the page
 * that has the world in it (PAGE, or target/page), if that was built. For each it writes the processor time of the page's main thread and of all of the browser's
 * processes, both for each picture of the arena and in a second, over SECONDS (10); and the same while the world is paused.
 *
 * Needs a Chromium: in CHROMIUM, or where Debian has it. On a machine that does other work give it a program that starts a
 * Chromium with priority: processor time is more where caches are shared.
 */
import { spawn, type ChildProcess } from "node:child_process";
import { once } from "node:events";
import { existsSync } from "node:fs";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { createInterface } from "node:readline";
import { chromium, type Browser, type CDPSession, type Page } from "playwright-core";

const ROOT = new URL("../../", import.meta.url).pathname;
const PROGRAM = process.env.BAUDBOT ?? join(ROOT, "target/release/baudbot");
const BUILT = process.env.PAGE ?? join(ROOT, "target/page");
const BROWSER = process.env.CHROMIUM ?? "/usr/bin/chromium";
const SECONDS = Number(process.env.SECONDS ?? 10);
/** Until trails are as long as they get. */
const SETTLE_S = 30;
/** Until the last frames before a pause have been drawn. */
const STAND_S = 5;
/** Between two robots at the start, in metres. */
const APART_M = 0.8;

const given = process.argv.slice(2).map(Number);
const crowds = given.length > 0 ? given : [100, 2000];

/** So many small robots that wander in a dish. */
function crowd(robots: number): string {
  const side = Math.ceil(Math.sqrt(robots));
  const half_m = (side * APART_M) / 2 + 0.4;
  const starts = Array.from({ length: robots }, (_, i) => {
    const [x_m, y_m] = [i % side, Math.floor(i / side)].map((place) => (place - (side - 1) / 2) * APART_M);
    return `{ x_m = ${x_m!.toFixed(2)}, y_m = ${y_m!.toFixed(2)}, heading_rad = ${((i * 2.4) % 6.28).toFixed(2)} }`;
  });
  const [least, most] = [(-half_m).toFixed(2), half_m.toFixed(2)];
  return `name = "crowd"
step_ms = 20.0
substeps = 2
collision = "stop-robot"
arena.polygons = [{ name = "dish", solid = false, points_m = [[${least}, ${least}], [${most}, ${least}], [${most}, ${most}], [${least}, ${most}]] }]
[[robots]]
name = "cell"
starts = [${starts.join(", ")}]
body = { radius_m = 0.06, mass_kg = 0.3, inertia_kg_m2 = 0.0005, wheel_radius_m = 0.02, damping_n_s_m = 1.0, turn_damping_nm_s = 0.002 }
sensors.encoders = { kind = "encoders", counts_per_turn = 100, bits = 16, period_ms = 100.0 }
motors = { kind = "velocity", full_speed_m_s = 0.4, gain_n_s = 0.2, max_torque_nm = 0.05, signal_bits = 8 }
firmware = { protocol = "framed", mode = "stream", period_ms = 100.0 }
link = { kind = "uart", baud = 9600 }
`;
}

/** Processor time until now, in milliseconds, and pictures of the arena. */
interface Count {
  thread_ms: number;
  processes_ms: number;
  drawn: number;
  at_ms: number;
}

async function count(page: Page, session: CDPSession, system: CDPSession): Promise<Count> {
  const { metrics } = await session.send("Performance.getMetrics");
  const { processInfo } = await system.send("SystemInfo.getProcessInfo");
  const drawn = await page.evaluate(() => window.baudbotViewer.drawn);
  return {
    thread_ms: 1000 * (metrics.find(({ name }) => name === "TaskDuration")?.value ?? NaN),
    processes_ms: 1000 * processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0),
    drawn,
    at_ms: performance.now(),
  };
}

/** Measures for some seconds, and writes it. */
async function measure(what: string, browser: Browser, page: Page): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const system = await browser.newBrowserCDPSession();
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const before = await count(page, session, system);
  await new Promise((resolve) => setTimeout(resolve, 1000 * SECONDS));
  const after = await count(page, session, system);
  const drawn = after.drawn - before.drawn;
  const seconds = (after.at_ms - before.at_ms) / 1000;
  const each = (ms: number) => (drawn > 0 ? `${(ms / drawn).toFixed(2)} ms a picture` : "no pictures").padEnd(19);
  const [thread_ms, processes_ms] = [after.thread_ms - before.thread_ms, after.processes_ms - before.processes_ms];
  console.log(
    `${what.padEnd(34)} ${(drawn / seconds).toFixed(1).padStart(5)} pictures/s; main thread ${each(thread_ms)}, ` +
      `${(thread_ms / seconds).toFixed(0).padStart(4)} ms/s; all processes ${each(processes_ms)}, ` +
      `${(processes_ms / seconds).toFixed(0).padStart(4)} ms/s`,
  );
  await session.detach();
  await system.detach();
}

/** A page at this address, running and then paused. */
async function measureAll(what: string, begin: (page: Page) => Promise<void>): Promise<void> {
  const browser = await chromium.launch({ executablePath: BROWSER, args: ["--no-sandbox"] });
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
  page.on("pageerror", (error) => console.error(error));
  await begin(page);
  await page.waitForFunction(() => window.baudbotViewer?.frames > 20, undefined, { timeout: 120_000 });
  await new Promise((resolve) => setTimeout(resolve, 1000 * SETTLE_S));
  await measure(`${what}, running`, browser, page);
  if (process.env.SHOTS) await page.screenshot({ path: join(process.env.SHOTS, `${what.replace(/\W+/g, "-")}.png`) });
  if (process.env.PROFILE) await profile(page, join(process.env.PROFILE, `${what.replace(/\W+/g, "-")}.cpuprofile`));
  await page.getByTestId("pause").click();
  await new Promise((resolve) => setTimeout(resolve, 1000 * STAND_S));
  await measure(`${what}, paused`, browser, page);
  await browser.close();
}

/** What the main thread does for five seconds, for the developer tools. */
async function profile(page: Page, file: string): Promise<void> {
  const session = await page.context().newCDPSession(page);
  await session.send("Profiler.enable");
  await session.send("Profiler.start");
  await new Promise((resolve) => setTimeout(resolve, 5000));
  const { profile } = await session.send("Profiler.stop");
  await writeFile(file, JSON.stringify(profile));
  await session.detach();
}

/** A world of the program, with brains. */
async function overNetwork(robots: number, folder: string): Promise<void> {
  const file = join(folder, "crowd.toml");
  await writeFile(file, crowd(robots));
  const options = ["--brain", "wander", "--pace", "real-time", "--viewer", "127.0.0.1:0"];
  const program = spawn(PROGRAM, ["run", file, ...options], { stdio: ["ignore", "pipe", "pipe"] });
  try {
    const link = await linkOf(program);
    await measureAll(`${robots} robots over a network`, async (page) => {
      // As it is built now, and not as it was when the program was.
      await page.route(/\/viewer\.(js|css)$/, (route) =>
        route.fulfill({ path: join(ROOT, "viewer/dist", basename(new URL(route.request().url()).pathname)) }),
      );
      await page.goto(link);
    });
  } finally {
    program.kill("SIGINT");
    if (program.exitCode === null) await once(program, "exit");
  }
}

async function linkOf(program: ChildProcess): Promise<string> {
  for (const stream of [program.stdout!, program.stderr!]) stream.setEncoding("utf8");
  return new Promise((resolve, reject) => {
    const look = (line: string) => {
      const link = /open in a browser: (\S+)/.exec(line)?.[1];
      if (link) resolve(link);
    };
    for (const stream of [program.stdout!, program.stderr!]) createInterface({ input: stream }).on("line", look);
    program.once("exit", (code) => reject(new Error(`the program ended with ${code}`)));
  });
}

/** The page that has the world in it. */
async function alone(robots: number): Promise<void> {
  await measureAll(`${robots} robots in the page`, async (page) => {
    await page.goto(`file://${BUILT}/baudbot.html#empty`);
    await page.waitForFunction(() => document.querySelector<HTMLTextAreaElement>("[data-testid=scenario-text]")?.value);
    await page.getByTestId("open-start").click();
    const dialog = page.getByTestId("start");
    await dialog.locator("summary").first().waitFor();
    await page.evaluate(() =>
      document.querySelectorAll("dialog[open] details").forEach((part) => part.setAttribute("open", "")),
    );
    await dialog.getByTestId("scenario-text").fill(crowd(robots));
    await dialog.getByTestId("brain").selectOption(":wander");
    await dialog.getByTestId("pace-choice").selectOption("realTime");
    await dialog.getByTestId("start-run").click();
    await dialog.waitFor({ state: "hidden", timeout: 120_000 });
  });
}

const folder = await mkdtemp(join(tmpdir(), "baudbot-frames-"));
try {
  for (const robots of crowds) {
    await overNetwork(robots, folder);
    if (existsSync(join(BUILT, "baudbot.html"))) await alone(robots);
  }
} finally {
  await rm(folder, { recursive: true });
}
