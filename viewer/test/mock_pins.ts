/** What is on the pins of the mock's carol: a motor by PWM, a direction, a switch that floats, the ADC, a line of text, and the main loop. */
import type { MessageInitShape } from "@bufbuild/protobuf";
import {
  PinEventKind as K,
  PinSignalKind as S,
  type PinEventSchema,
  type PinSignalSchema,
} from "../src/gen/baudbot/v1/observe_pb";
import { STEP_NS } from "./mock_scene";

export const PINS: MessageInitShape<typeof PinSignalSchema>[] = [
  { signal: "D7", kind: S.PIN, on: ["sensors.whisker"] },
  { signal: "D8", kind: S.PIN, on: ["motors.left.direction"] },
  { signal: "D9", kind: S.PIN, on: ["motors.left.pwm"] },
  { signal: "adc0", kind: S.ADC, on: ["sensors.ir"] },
  { signal: "uart sent", kind: S.SENT },
  { signal: "main loop", kind: S.MAIN_LOOP },
];

const CHARACTER_NS = 1_040_000n;
const LINE = [..."512 7\n"].map((character) => character.charCodeAt(0));

/** The events of each tick from one to another. */
export function pinEvents(since: bigint, until: bigint): MessageInitShape<typeof PinEventSchema>[] {
  const ticks = Array.from({ length: Number(until - since) }, (_, i) => since + BigInt(i));
  return ticks.flatMap((tick) => {
    const at = (us: number) => tick * STEP_NS + BigInt(us) * 1000n;
    const duty = tick % 16n < 8n ? 7n : 2n;
    return [
      { signal: 0, atNs: at(0), kind: [K.OPEN, K.HIGH, K.SHORT, K.LOW][Number(tick % 4n)] },
      { signal: 1, atNs: at(0), kind: tick % 2n === 0n ? K.HIGH : K.LOW },
      {
        signal: 2,
        atNs: at(0),
        kind: K.PULSES,
        untilNs: at(10_000),
        pulses: 78,
        highNs: (duty * STEP_NS) / 10n,
        even: true,
      },
      { signal: 3, atNs: at(2000), kind: K.NUMBER, number: Number((tick * 37n) % 1024n) },
      { signal: 5, atNs: at(0), kind: K.SHORT_ROUNDS, untilNs: at(4000), rounds: 800, cycles: 64_000n },
      { signal: 5, atNs: at(4000), kind: K.ROUND, untilNs: at(10_000), rounds: 1, cycles: 96_000n },
      ...LINE.map((number, i) => ({ signal: 4, atNs: at(1000) + BigInt(i) * CHARACTER_NS, kind: K.NUMBER, number })),
      { signal: 4, atNs: at(1000) + BigInt(LINE.length) * CHARACTER_NS, kind: K.OVER },
    ];
  });
}
