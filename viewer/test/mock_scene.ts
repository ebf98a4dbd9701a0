/** What the made-up world of the mock server is: a room with two boxes, a pillar, a zone, a lamp, a scent, a ball. */
import { create, type MessageInitShape } from "@bufbuild/protobuf";
import {
  ActuatorKind,
  MotorKind,
  PortFormat,
  SensorKind,
  type RobotDescriptionSchema,
  type SensorDescriptionSchema,
} from "../src/gen/baudbot/v1/brain_link_pb";
import { DescribeWorldResponseSchema, type DescribeWorldResponse } from "../src/gen/baudbot/v1/observe_pb";

export const STEP_NS = 10_000_000n;
export const ROOM = { x_m: 3, y_m: 2 };
export const PILLAR = { x_m: 1.4, y_m: 0.9, radius_m: 0.25 };
export const LASER = { rays: 61, opening_rad: 4.2, range_m: 4 };
export const IRS = [1.0472, 0.5236, 0, -0.5236, -1.0472];
export const WHEELS = { radius_m: 0.05, half_track_m: 0.12, counts: 500 };

type Sensor = MessageInitShape<typeof SensorDescriptionSchema>;

const level = (min: number, max: number) => ({ kind: { case: "level" as const, value: { bits: 8, min, max } } });
const counter = { kind: { case: "counter" as const, value: { bits: 16 } } };

const ENCODERS: Sensor = {
  sensor: "encoders",
  kind: SensorKind.ENCODERS,
  countsPerTurn: WHEELS.counts,
  periodNs: STEP_NS,
  components: ["left", "right"].map((name) => ({ name, unit: "1", encoding: counter })),
};

function irs(): Sensor[] {
  const names = ["ir_left", "ir_front_left", "ir_front", "ir_front_right", "ir_right"];
  return names.map((sensor, i) => ({
    sensor,
    kind: SensorKind.IR,
    periodNs: 2n * STEP_NS,
    rangeM: 1,
    mount: { xM: 0.2 * Math.cos(IRS[i] ?? 0), yM: 0.2 * Math.sin(IRS[i] ?? 0), headingRad: IRS[i] ?? 0 },
    components: [{ name: "", unit: "1", encoding: level(0, 1) }],
  }));
}

const SCANNER: Sensor = {
  sensor: "laser",
  kind: SensorKind.LASER,
  periodNs: 10n * STEP_NS,
  rangeM: LASER.range_m,
  mount: { xM: 0.05 },
  components: [{ name: "", unit: "m", count: LASER.rays, encoding: { kind: { case: "float64", value: {} } } }],
  port: { format: PortFormat.SCIP2, messageBytes: 200n },
};

const GPS: Sensor = {
  sensor: "compass",
  kind: SensorKind.COMPASS,
  periodNs: 5n * STEP_NS,
  components: [{ name: "", unit: "rad", encoding: level(-Math.PI, Math.PI) }],
};

function description(robot: string, sensors: Sensor[], baud: number): MessageInitShape<typeof RobotDescriptionSchema> {
  return {
    robot,
    radiusM: 0.2,
    halfTrackM: WHEELS.half_track_m,
    wheelRadiusM: WHEELS.radius_m,
    signalLimit: 1,
    sensors,
    baud,
    bitsPerCharacter: 10,
    motorKind: MotorKind.DC,
    firmware: { protocol: { case: "framed", value: { ages: false } }, periodNs: 20_000_000n },
    actuators: robot === "alice" ? [{ actuator: "turret", kind: ActuatorKind.TURRET, minRad: -1, maxRad: 1 }] : [],
  };
}

const WALL = { red: 128, green: 128, blue: 128 };
const corners = (x: number, y: number, w: number, h: number) =>
  [
    [x, y],
    [x + w, y],
    [x + w, y + h],
    [x, y + h],
  ].map(([xM, yM]) => ({ xM, yM }));

/** A robot of the crowd has two sensors only. */
function plain(i: number) {
  const name = `robot_${String(i).padStart(4, "0")}`;
  const look =
    i % 3 === 0 ? WALL : i % 3 === 1 ? { red: 40, green: 150, blue: 110 } : { red: 200, green: 120, blue: 40 };
  return {
    robot: name,
    radiusM: 0.06,
    look,
    deadlineNs: STEP_NS,
    description: { ...description(name, [ENCODERS], 9600), radiusM: 0.06 },
  };
}

export function describe(robots: number): DescribeWorldResponse {
  const named = [
    {
      robot: "alice",
      radiusM: 0.2,
      look: WALL,
      deadlineNs: STEP_NS,
      actuators: ["turret"],
      description: description("alice", [...irs(), ENCODERS], 9600),
    },
    {
      robot: "bob",
      radiusM: 0.2,
      look: { red: 40, green: 150, blue: 110 },
      deadlineNs: 2n * STEP_NS,
      description: description("bob", [...irs().slice(1, 4), SCANNER, ENCODERS, GPS], 38400),
    },
    {
      robot: "carol",
      radiusM: 0.18,
      outline: corners(-0.16, -0.13, 0.32, 0.26),
      look: { red: 200, green: 90, blue: 40 },
      deadlineNs: STEP_NS,
      description: description("carol", [ENCODERS, GPS], 115200),
    },
  ];
  const { x_m, y_m } = ROOM;
  return create(DescribeWorldResponseSchema, {
    scenario: "mock",
    description: "A made-up room with three robots, for tests of the page",
    stepNs: STEP_NS,
    polygons: [
      { name: "wall", points: corners(-x_m, -y_m, 2 * x_m, 2 * y_m), solid: false, closed: true, look: WALL },
      { name: "box_1", points: corners(-2.2, 1.0, 0.4, 0.4), solid: true, closed: true, look: WALL },
      {
        name: "box_2",
        points: corners(1.8, -1.4, 0.5, 0.3),
        solid: true,
        closed: true,
        look: { red: 30, green: 60, blue: 140 },
      },
      {
        name: "kerb",
        points: corners(-0.4, -1.9, 0.8, 0.25),
        solid: true,
        closed: true,
        look: { ...WALL, heightM: 0.05 },
      },
      {
        name: "white",
        points: corners(-2.8, -1.85, 0.3, 0.3),
        solid: true,
        closed: true,
        look: { red: 250, green: 250, blue: 245 },
      },
    ],
    circles: [
      {
        name: "pillar",
        center: { xM: PILLAR.x_m, yM: PILLAR.y_m },
        radiusM: PILLAR.radius_m,
        look: { red: 20, green: 22, blue: 30 },
      },
    ],
    robots: robots === 3 ? named : Array.from({ length: robots }, (_, i) => plain(i)),
    things: [
      { thing: "box", movable: true, outline: { points: corners(-0.12, -0.12, 0.24, 0.24) }, look: WALL },
      {
        thing: "door",
        movable: false,
        outline: { points: corners(0, -0.03, 0.7, 0.06) },
        look: { red: 150, green: 150, blue: 160 },
      },
    ],
    zones: [
      { zone: "goal", goal: true, outline: { center: { xM: 2.3, yM: 1.3 }, radiusM: 0.45 } },
      { zone: "dock", chargerW: 20, outline: { points: corners(-2.9, -0.4, 0.6, 0.8) } },
    ],
    lights: [
      { light: "lamp", position: { xM: -1.2, yM: -1.3 }, heightM: 1, intensityCd: 8 },
      {
        light: "beacon",
        position: { xM: 0.9, yM: 1.6 },
        intensityCd: 3,
        periodNs: 1_000_000_000n,
        litNs: 400_000_000n,
      },
    ],
    fields: [{ field: "scent", sources: [{ position: { xM: 2, yM: -0.3 }, strength: 3, widthM: 0.6 }] }],
  });
}
