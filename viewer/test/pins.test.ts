import assert from "node:assert/strict";
import { test } from "node:test";
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import { RobotDescriptionSchema } from "../src/gen/baudbot/v1/brain_link_pb";
import {
  PinEventKind as K,
  PinEventSchema,
  PinSignalKind as S,
  PinSignalSchema,
  TimelineKind,
} from "../src/gen/baudbot/v1/observe_pb";
import { dutyOf, frequencyOf, PinLog } from "../src/model/pins";
import { lanes } from "../src/timing/layout";
import { partInWords, pinLanes, printable, pulsesInWords } from "../src/timing/pins";

const event = (signal: number, at_us: number, kind: K, more: MessageInitShape<typeof PinEventSchema> = {}) =>
  create(PinEventSchema, { signal, atNs: BigInt(at_us) * 1000n, kind, ...more });
const pulses = (signal: number, from_us: number, until_us: number, count: number, high_us: number, even = true) =>
  event(signal, from_us, K.PULSES, {
    untilNs: BigInt(until_us) * 1000n,
    pulses: count,
    highNs: BigInt(high_us) * 1000n,
    even,
  });
const SIGNALS = [
  { signal: "D1", kind: S.UART_PIN },
  { signal: "D8", kind: S.PIN, on: ["motors.left.direction"] },
  { signal: "D9", kind: S.PIN, on: ["motors.left.pwm"] },
  { signal: "D12", kind: S.PIN },
  { signal: "A0", kind: S.PIN, on: ["sensors.ir"] },
  { signal: "adc0", kind: S.ADC, on: ["sensors.ir"], pin: 4 },
  { signal: "uart sent", kind: S.SENT },
  { signal: "uart received", kind: S.RECEIVED },
  { signal: "main loop", kind: S.MAIN_LOOP },
].map((signal) => create(PinSignalSchema, signal));
const WINDOW = { from_ns: 0, until_ns: 30e6 };

function log(events: ReturnType<typeof event>[]): PinLog {
  const log = new PinLog();
  log.take(events, 0n, 30e6);
  return log;
}

const labels = (pins: PinLog) => pinLanes(SIGNALS, pins, WINDOW, 30e6, 30_000).map(({ label }) => label);

test("pins with something on them have lanes, and others while the program moves them", () => {
  const still = [event(1, 0, K.LOW), event(2, 0, K.LOW), event(3, 0, K.OPEN), event(4, 0, K.OPEN), event(0, 0, K.HIGH)];
  const wired = ["D8 motors.left.direction", "D9 motors.left.pwm", "adc0 sensors.ir"];
  assert.deepEqual(labels(log(still)), wired);
  const more = [...still, event(3, 5000, K.HIGH), event(0, 100, K.LOW), event(6, 9000, K.NUMBER, { number: 65 })];
  assert.deepEqual(labels(log(more)), [...wired.slice(0, 2), "D12", wired[2], "uart sent"]);
});

test("pulses that go on are one part with their duty and frequency", () => {
  const pins = log([pulses(2, 0, 1000, 100, 280), pulses(2, 1000, 2000, 100, 281), pulses(2, 2000, 3000, 100, 900)]);
  const [first, second] = pins.of(2);
  assert.equal(pins.of(2).length, 2);
  assert.deepEqual([dutyOf(first!), frequencyOf(first!)], [0.2805, 100_000]);
  assert.equal(pulsesInWords(first!), "28.1 %, 100 kHz");
  assert.equal(partInWords(second!), "100 pulses, 90 %, 100 kHz");
  assert.equal(pulsesInWords(log([pulses(2, 0, 9, 4, 3, false)]).of(2)[0]!), "4 × high");
});

test("characters have their text, together where each has no room of its own", () => {
  const text = [..."Hi\n"].flatMap((character, i) => [
    event(6, 1000 * i, K.NUMBER, { number: character.charCodeAt(0) }),
    event(6, 1000 * (i + 1), K.OVER),
  ]);
  const sent = (px_ns: number) =>
    pinLanes(SIGNALS, log(text), WINDOW, 30e6, px_ns)
      .find(({ label }) => label === "uart sent")!
      .bars.map((bar) => [bar.event.start_ns, bar.event.end_ns, bar.label]);
  assert.deepEqual(sent(30_000), [
    [0, 1e6, "H"],
    [1e6, 2e6, "i"],
    [2e6, 3e6, "\\n"],
  ]);
  assert.deepEqual(sent(300_000), [[0, 3e6, "Hi\\n"]]);
  assert.deepEqual([0x41, 0x07, 0x1ff].map(printable), ["A", "\\x07", "\\x1ff"]);
});

test("rounds of the main loop are bars, and short ones that follow on each other are one", () => {
  const rounds = (from_us: number, until_us: number, count: number, cycles: number, short: boolean) =>
    event(8, from_us, short ? K.SHORT_ROUNDS : K.ROUND, {
      untilNs: BigInt(until_us) * 1000n,
      rounds: count,
      cycles: BigInt(cycles),
    });
  const pins = log([
    rounds(0, 1000, 500, 16_000, true),
    rounds(1000, 2000, 500, 16_001, true),
    rounds(2000, 3000, 1, 16_000, false),
    rounds(3000, 5000, 1, 32_000, false),
  ]);
  const lane = pinLanes(SIGNALS, pins, WINDOW, 30e6, 30_000).find(({ label }) => label === "main loop");
  assert.deepEqual(
    lane?.bars.map((bar) => [bar.event.start_ns, bar.event.end_ns, bar.label, bar.tip]),
    [
      [0, 2e6, "1000 rounds", "1000 short rounds, 32 cycles on average"],
      [2e6, 3e6, "1.00 ms", "a round of 16000 cycles"],
      [3e6, 5e6, "2.00 ms", "a round of 32000 cycles"],
    ],
  );
  pins.cut(2.5e6);
  assert.equal(pins.of(8).length, 1, "the round was not over");
});

test("a result of the ADC is a mark with its number", () => {
  const pins = log([event(5, 100, K.NUMBER, { number: 512 }), event(5, 40_000, K.NUMBER, { number: 3 })]);
  const lane = pinLanes(SIGNALS, pins, WINDOW, 30e6, 30_000).find(({ label }) => label === "adc0 sensors.ir");
  assert.deepEqual(
    lane?.bars.map((bar) => [bar.event.start_ns, bar.event.end_ns, bar.label]),
    [[100_000, 100_000, "512"]],
  );
});

test("what is told again replaces what was known, and of what is missing nothing is known", () => {
  const pins = log([event(1, 0, K.LOW), event(1, 10, K.HIGH), event(1, 20, K.LOW)]);
  pins.cut(15_000);
  assert.deepEqual(
    pins.of(1).map((part) => part.kind),
    [K.LOW, K.HIGH],
  );
  pins.take([event(1, 5, K.SHORT), event(1, 18, K.OPEN)], 0n, 20_000);
  assert.deepEqual(
    pins.of(1).map((part) => [part.at_ns, part.kind]),
    [
      [0, K.LOW],
      [5000, K.SHORT],
      [18_000, K.OPEN],
    ],
  );
  pins.take([event(1, 40, K.HIGH)], 7n, 50_000);
  assert.deepEqual(
    pins
      .of(1)
      .map((part) => [part.at_ns, part.kind])
      .slice(-2),
    [
      [20_000, K.UNSPECIFIED],
      [40_000, K.HIGH],
    ],
  );
});

test("however long one looks, what is kept is bounded", () => {
  const pins = new PinLog();
  for (let i = 0; i < 30_000; i++) pins.take([event(1, i, i % 2 ? K.HIGH : K.LOW)], 0n, i * 1000);
  assert.ok(pins.of(1).length <= 8000, `${pins.of(1).length}`);
  assert.equal(pins.of(1).at(-1)?.at_ns, 29_999_000);
});

test("a robot with a program of its own has no lanes of steps that nobody knows", () => {
  const robot = create(RobotDescriptionSchema, { sensors: [{ sensor: "ir" }] });
  const up = { start_ns: 1e6, end_ns: 2e6, kind: TimelineKind.UP, part: undefined, bytes: 1 };
  const pins = pinLanes(SIGNALS, log([]), WINDOW, 30e6, 30_000);
  const made = lanes(robot, [up], WINDOW, undefined, undefined, pins).map(({ label }) => label);
  assert.deepEqual(made, ["ir", "D8 motors.left.direction", "D9 motors.left.pwm", "adc0 sensors.ir", "cable up"]);
});
