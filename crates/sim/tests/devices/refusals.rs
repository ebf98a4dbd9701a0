//! The errors of invalid devices: with the field and the number.

use crate::common::refusal;
use crate::devices::scene::{named, scene, with_sensor};

/// The error for a robot with the sensor `s`.
#[track_caller]
fn sensor(fields: &str, expected: &str) {
    refused(&with_sensor("", fields), &format!("robots[0].sensors.s{expected}"));
}

#[track_caller]
fn refused(toml: &str, expected: &str) {
    let message = refusal(toml);
    assert!(message.starts_with(expected), "expected `{expected}` in: {message}");
    assert!(!message.contains('\n'), "one line: {message}");
}

const IR: &str = "kind = \"ir\"\nbearing_rad = 0.0\nopening_rad = 0.5\nrays = 3\nrange_m = 1.0";
const LASER: &str = "kind = \"laser\"\nmount = {}\nopening_rad = 1.0\nrays = 5\nrange_m = 4.0";
const VOLTAGE: &str = "kind = \"ir-voltage\"\nbearing_rad = 0.0\nopening_rad = 0.1\nrays = 1\nrange_m = 1.0\nidle_v = 0.3\nsupply_v = 5.0";
const CAMERA: &str = "kind = \"line-camera\"\nmount = {}\nopening_rad = 1.0\nrange_m = 5.0";
const SONAR: &str = "kind = \"sonar\"\nbearing_rad = 0.0\nopening_rad = 0.5\nrays = 3\nmax_m = 3.0";

#[test]
fn a_clock_that_is_shorter_than_the_sweep() {
    let sweep = "sweep_ms = 80.0";
    sensor(
        &format!("{LASER}\n{sweep}\nclock = {{ period_ms = 50.0 }}"),
        ".clock.period_ms: a measurement takes up to 80 ms, but the next may begin after 50 ms",
    );
    sensor(
        &format!("{LASER}\n{sweep}\nclock = {{ period_ms = 90.0, spread_ms = 11.0 }}"),
        ".clock.period_ms: a measurement takes up to 80 ms, but the next may begin after 79 ms",
    );
    sensor(
        &format!("{LASER}\n{sweep}\nclock = {{ period_ms = 90.0, jitter_ms = 5.0, latency_ms = 6.0 }}"),
        ".clock.period_ms: a measurement takes up to 91 ms",
    );
    sensor(
        &format!("{LASER}\n{sweep}\nperiod_ms = 50.0"),
        ".period_ms: a measurement takes up to 80 ms, but the next may begin after 50 ms",
    );
    sensor(
        &format!("{VOLTAGE}\ncurve_m_v = [[0.1, 2.0], [0.8, 0.4]]\nclock = {{ period_ms = 0.0 }}"),
        ".clock.period_ms: must be between 0.01 and 10000000, is 0",
    );
    sensor(
        &format!(
            "{VOLTAGE}\ncurve_m_v = [[0.1, 2.0], [0.8, 0.4]]\nclock = {{ period_ms = 10.0, spread_ms = 9.5 }}"
        ),
        ".clock.spread_ms: must be between 0 and 9, is 9.5",
    );
}

#[test]
fn codes_of_an_infrared_sensor_that_do_not_fit_its_bits() {
    let ir = format!("{IR}\nc1_m2 = 0.03\nc2 = 0.1");
    sensor(&format!("{ir}\nconverter_bits = 8"), ".converter_bits: goes with `bits`, which is missing");
    sensor(&format!("{ir}\nfull_scale = 1000"), ".full_scale: goes with `bits`, which is missing");
    sensor(&format!("{ir}\nbits = 8\nconverter_bits = 9"), ".converter_bits: must be between 1 and 8, is 9");
    sensor(&format!("{ir}\nbits = 8\nfull_scale = 256"), ".full_scale: must be between 1 and 255, is 256");
    sensor(&format!("{ir}\nbits = 33\nfull_scale = 256"), ".bits: must be between 1 and 32, is 33");
}

#[test]
fn a_sonar_that_hears_a_wall_less_far_than_it_measures() {
    sensor(
        &format!("{SONAR}\nmin_m = 0.0\nwall_range_m = 2.9"),
        ".wall_range_m: must be between 3 and 1000000, is 2.9",
    );
}

#[test]
fn a_clock_for_what_the_processor_times_itself() {
    sensor(
        &format!("{SONAR}\nmin_m = 0.0\nclock = {{ period_ms = 50.0 }}"),
        ".clock: the processor itself times this sensor",
    );
}

#[test]
fn optical_flow_that_cannot_be() {
    let flow = "kind = \"optical-flow\"\nmount = {}\ncounts_per_m = 15748.0\nmax_speed_m_s = 1.0";
    sensor(&flow.replace("mount = {}\n", ""), ": needs either `bearing_rad`");
    sensor(&flow.replace("15748.0", "0.5"), ".counts_per_m: must be between 1 and 1000000, is 0.5");
    sensor(&flow.replace("= 1.0", "= 0.0"), ".max_speed_m_s: must be positive, is 0");
    sensor(&format!("{flow}\ngain_spread = -0.1"), ".gain_spread: must not be negative, is -0.1");
    sensor(&format!("{flow}\nsigma_m = nan"), ".sigma_m: must not be negative, is NaN");
    sensor(&format!("{flow}\nbits = 7"), ".bits: must be between 8 and 32, is 7");
    sensor(&format!("{flow}\nbits = 64"), ".bits: must be between 8 and 32, is 64");
    sensor(
        &format!("{flow}\nnoise = {{ additive = 0.1 }}"),
        ".noise: a sensor of kind `optical-flow` is digital",
    );
    sensor(&format!("{flow}\nclock = {{ period_ms = 10.0 }}"), ".clock: it counts from one read to the next");
}

#[test]
fn strain_gauges_and_beacons_that_cannot_be() {
    let gauge = "kind = \"strain-gauge\"\nopening_rad = 1.0\nrange_n = 100.0";
    sensor(&gauge.replace("100.0", "0.0"), ".range_n: must be positive, is 0");
    sensor(&format!("{gauge}\nbridge_mv_v = -1.0"), ".bridge_mv_v: must be positive, is -1");
    sensor(&format!("{gauge}\nbandwidth_hz = 0.0"), ".bandwidth_hz: must be positive, is 0");
    sensor(&format!("{gauge}\nmount = {{}}"), ": is a part of the rim");
    let beacons = "kind = \"ir-beacons\"\nmount = {}\nspots_m = [[0.0, 0.0], [0.5, 0.0]]\nceiling_m = 2.5\nopening_rad = 2.0";
    sensor(&beacons.replace("0.5", "0.005"), ".spots_m: must be two places at least 0.01 m apart");
    sensor(&beacons.replace(", [0.5, 0.0]", ""), ".spots_m: ");
    sensor(
        &format!("{beacons}\nheight_m = 2.5"),
        ".ceiling_m: must be above the sensor, which is 2.5 m high, is 2.5",
    );
    sensor(&format!("{beacons}\nsigma_rad = -0.1"), ".sigma_rad: must not be negative, is -0.1");
    sensor(
        &format!("{beacons}\nnoise = {{ additive = 0.1 }}"),
        ".noise: a sensor of kind `ir-beacons` is digital",
    );
}

#[test]
fn ports_of_the_wrong_kind() {
    let port = |fields: &str| format!("port = {{ link = {{ kind = \"ideal\" }}{fields} }}");
    sensor(
        &format!("kind = \"compass\"\n{}", port("")),
        ".port: a sensor of kind `compass` is read by the microcontroller",
    );
    sensor(
        &format!("{LASER}\nbits = 8\n{}", port("")),
        ".bits: what goes over a port of its own has its own form",
    );
    sensor(
        &format!("{LASER}\n{}", port(", sentences = \"rmc\"")),
        ".port.sentences: a sensor of kind `laser` has none",
    );
    sensor(&format!("{LASER}\n{}", port(", characters = 4")), ".port.characters: must be 2 or 3, is 4");
    sensor(
        &format!("{LASER}\n{}", port(", first_step = 9996")),
        ".port.first_step: must be between 0 and 9999, is 10000",
    );
    sensor(
        &format!("kind = \"gps\"\n{}", port(", characters = 2")),
        ".port.characters: a sensor of kind `gps` has none",
    );
    sensor(
        &format!("kind = \"gps\"\nsatellites = true\n{}", port(", sentences = \"rmc\"")),
        ".port.sentences: an RMC has no altitude",
    );
    sensor(
        &format!("{LASER}\nport = {{ link = {{ kind = \"uart\" }} }}"),
        ".port.link.baud: a uart needs its baud rate",
    );
    sensor(
        &format!("{LASER}\nport = {{ link = {{ kind = \"onboard\" }} }}"),
        ".port.link.kind: a port is a cable",
    );
}

#[test]
fn fields_that_are_not_there() {
    sensor(
        "kind = \"field\"\nfield = \"scent\"\nmount = {}",
        ".field: the arena has no field `scent`, it has none at all",
    );
    let fields = "[[arena.fields]]\nname = \"heat\"\n[[arena.fields]]\nname = \"smoke\"\n";
    refused(
        &with_sensor(fields, "kind = \"field\"\nfield = \"scent\"\nmount = {}"),
        "robots[0].sensors.s.field: the arena has no field `scent`; there are: heat, smoke",
    );
    refused(
        &with_sensor(fields, "kind = \"field\"\nfield = \"heat\"\nmount = {}\nbits = 8"),
        "robots[0].sensors.s.max: is needed with `bits`",
    );
    sensor("kind = \"microphone\"\nbits = 8", ".max: is needed with `bits`");
    sensor("kind = \"microphone\"\nband_hz = [800.0, 400.0]", ".band_hz: must increase, is 800 to 400");
    sensor("kind = \"microphone\"\nband_hz = [0.0, 400.0]", ".band_hz");
}

#[test]
fn infrared_sensors_of_no_model_or_of_two() {
    sensor(IR, ": needs exactly one of: `c1_m2` with `c2`, `lookup`, `ambient_saturation_lux`");
    sensor(&format!("{IR}\nc1_m2 = 0.03\nc2 = 0.1\nambient_saturation_lux = 5.0"), ": needs exactly one of");
    sensor(&format!("{IR}\nc1_m2 = 0.03"), ".c2: goes with c1_m2 and is missing");
    let table = "lookup = { distances_m = [0.1, 0.2], samples = [[[0.5]], [[]]] }";
    sensor(&format!("{IR}\n{table}"), ".lookup.samples[1][0]: a hole");
    sensor(
        &format!("{IR}\nc1_m2 = 0.03\nc2 = 0.1\n{}", table.replace("[[]]", "[[0.1]]")),
        ": needs exactly one of",
    );
    sensor(
        &format!("{IR}\nlookup = {{ distances_m = [0.2, 0.1], samples = [[[0.5]], [[0.1]]] }}"),
        ".lookup.distances_m[1]: must be above the one before, 0.2, is 0.1",
    );
    sensor(
        &format!("{IR}\nc1_m2 = 0.03\nc2 = 0.1\nsigma = 0.1\nnoise = {{ multiplicative = 0.1 }}"),
        ".sigma: is short for noise.multiplicative",
    );
}

#[test]
fn gauges_counters_and_switches() {
    sensor("kind = \"battery\"", ": the robot has no `battery` to gauge");
    for kind in [
        "encoders\"\ncounts_per_turn = 8",
        "whisker\"\nbearing_rad = 0.0\nlength_m = 0.1",
        "odometer\"",
        "gps\"",
        "bumper\"\nopening_rad = 1.0",
    ] {
        sensor(&format!("kind = \"{kind}\nnoise = {{ additive = 0.1 }}"), ".noise: a sensor of kind `");
    }
    sensor(
        "kind = \"encoders\"\ncounts_per_turn = 0",
        ".counts_per_turn: must be between 1 and 1000000, is 0",
    );
    sensor("kind = \"encoders\"\ncounts_per_turn = 8\nbits = 7", ".bits: must be between 8 and 32, is 7");
    sensor("kind = \"encoders\"\ncounts_per_turn = 8\nloss = 1.5", ".loss: must be between 0 and 1, is 1.5");
    sensor("kind = \"bumper\"\nopening_rad = 1.0\nmount = {}", ": is a part of the rim");
    sensor("kind = \"whisker\"\nlength_m = 0.1", ": needs either `bearing_rad`");
    sensor("kind = \"nose\"", ".kind: must be one of ");
}

#[test]
fn curves_and_ranges_that_make_no_sense() {
    sensor(
        &format!("{VOLTAGE}\ncurve_m_v = [[0.1, 2.0]]"),
        ".curve_m_v: needs at least 2 pairs of distance and voltage, has 1",
    );
    sensor(
        &format!("{VOLTAGE}\ncurve_m_v = [[0.1, 2.0], [0.1, 1.0]]"),
        ".curve_m_v[1]: distances must increase, 0.1 follows 0.1",
    );
    sensor(
        &format!("{VOLTAGE}\ncurve_m_v = [[0.1, 2.0], [nan, 1.0]]"),
        ".curve_m_v[1].distance: must not be negative, is NaN",
    );
    sensor(
        &VOLTAGE.replace("idle_v = 0.3", "idle_v = 5.3\ncurve_m_v = [[0.1, 2.0], [0.2, 1.0]]"),
        ".idle_v: must be between 0 and 5, is 5.3",
    );
    sensor(&format!("{SONAR}\nmin_m = 3.5"), ".min_m: must be between 0 and 3, is 3.5");
    sensor(&format!("{SONAR}\nmin_m = 0.0\ndetection = 1.1"), ".detection: must be between 0 and 1, is 1.1");
    sensor(&format!("{LASER}\nmin_m = 5.0"), ".min_m: must be between 0 and 4, is 5");
    let image = "kind = \"camera\"\nmount = {}\nrange_m = 5.0\ncolumns = 512";
    sensor(
        &format!("{image}\nrows = 4\nopening_rad = 3.2"),
        ".opening_rad: must be between 0.001 and 3, is 3.2",
    );
    sensor(&format!("{image}\nopening_rad = 1.0"), ": missing field `rows`");
    sensor(
        &format!("{image}\nrows = 257\nopening_rad = 1.0"),
        ".rows: 512 columns and 257 rows are more than 131072 pixels",
    );
    sensor(&format!("{CAMERA}\ncolumns = 5000"), ".columns: must be between 1 and 4096, is 5000");
    sensor(
        &format!("{CAMERA}\ncolumns = 4096\nrows = 1000"),
        ".rows: 4096 columns and 1000 rows are more than",
    );
    sensor(
        &format!("{CAMERA}\ncolumns = 4\nbackground = [0, 256, 0]"),
        ".background[1]: must be a whole number from 0 to 255, is 256",
    );
    sensor("kind = \"gyroscope\"\nrange_rad_s = 0.0", ".range_rad_s: must be positive, is 0");
    sensor("kind = \"light\"\nbearing_rad = 0.0\nrange_lux = inf", ".range_lux: must be positive, is inf");
    sensor("kind = \"compass\"\nperiod_ms = 0.0", ".period_ms: must be between 0.01 and 10000000, is 0");
}

#[test]
fn more_values_than_a_frame_holds() {
    for rays in [65, 128, 255] {
        let laser = LASER.replace("rays = 5", &format!("rays = {rays}"));
        let bytes = 4 + 1 + 1 + 8 * rays;
        refused(
            &with_sensor("", &laser),
            &format!("robots[0].sensors: a frame of all readings has {bytes} bytes, the limit is 512"),
        );
    }
    // With a byte a ray 300 fit, but a sensor of a frame has at most 255 values.
    for (rays, bits) in
        [(256, ""), (300, "bits = 8"), (500, "bits = 8"), (512, ""), (682, ""), (768, "bits = 8")]
    {
        let laser = LASER.replace("rays = 5", &format!("rays = {rays}\n{bits}"));
        refused(
            &with_sensor("", &laser),
            &format!(
                "robots[0].sensors.s: has {rays} values; without a `port` of its own a sensor has at most 255"
            ),
        );
    }
}

#[test]
fn turrets_that_are_not_there() {
    let laser = format!("{LASER}\nturret = \"head\"");
    sensor(&laser, ".turret: there is no turret `head` among the robot's actuators");
    let lamp = "[robots.actuators.head]\nkind = \"lamp\"\nintensity_cd = 1.0\n";
    refused(
        &scene("", "", &(lamp.to_string() + &named("s", &laser))),
        "robots[0].sensors.s.turret: there is no turret `head`",
    );
}

#[test]
fn actuators_and_batteries() {
    let actuator = |fields: &str| scene("", "", &format!("[robots.actuators.a]\n{fields}\n"));
    refused(&actuator("level = 1.0"), "robots[0].actuators.a: missing field `kind`");
    refused(
        &actuator("kind = \"turret\"\nmin_rad = 0.1\nmax_rad = 1.0\nrate_rad_s = 1.0"),
        "robots[0].actuators.a.min_rad: must be between",
    );
    refused(
        &actuator("kind = \"lamp\"\nintensity_cd = -1.0"),
        "robots[0].actuators.a.intensity_cd: must be positive, is -1",
    );
    refused(
        &actuator("kind = \"speaker\"\nlevel = 0.0"),
        "robots[0].actuators.a.level: must be positive, is 0",
    );
    refused(
        &actuator("kind = \"dispenser\"\nfield = \"scent\"\nrate_per_s = 1.0"),
        "robots[0].actuators.a.field: the arena has no field `scent` with a `trail`; there are: none",
    );
    let trail = |fields: &str| {
        scene(
            &format!(
                "[[arena.fields]]\nname = \"scent\"\ntrail = {{ corner_m = [0, 0], size_m = [10, 10], {fields} }}\n"
            ),
            "",
            "",
        )
    };
    refused(
        &trail("cell_m = 0.001"),
        "arena.fields[0].trail.cell_m: makes 10000 by 10000 cells, each 1 times a tick",
    );
    refused(
        &trail("diffusion_m2_s = 100.0"),
        "arena.fields[0].trail.cell_m: makes 200 by 200 cells, each 1600 times a tick",
    );
    refused(&trail("decay_s = 0.0"), "arena.fields[0].trail.decay_s: must be positive, is 0");
    let battery = |fields: &str| {
        scene("", &format!("battery = {{ nominal_v = 12.0, capacity_mah = 1000.0, {fields} }}"), "")
    };
    refused(
        &battery("capacity_a_share = [[1.0, 0.9], [0.5, 0.8]]"),
        "robots[0].battery.capacity_a_share[1]: currents must increase, 0.5 follows 1",
    );
    refused(
        &battery("capacity_a_share = [[1.0, 0.0]]"),
        "robots[0].battery.capacity_a_share[0].share: must be between 0.001 and 1, is 0",
    );
    let flat = scene("", "battery = { nominal_v = 1e-320, capacity_mah = 1000.0 }", "");
    refused(&flat, "robots[0].battery.nominal_v: must be between 0.001 and 1000000");
    refused(&battery("charge = 1.5"), "robots[0].battery.charge: must be between 0 and 1, is 1.5");
    refused(&battery("curve_share_v = []"), "robots[0].battery.curve_share_v: needs at least one pair");
    refused(
        &battery("curve_share_v = [[0.5, 1.0], [0.5, 1.1]]"),
        "robots[0].battery.curve_share_v[1]: shares must increase, 0.5 follows 0.5",
    );
    let many: String =
        (0..100).map(|i| format!("[robots.actuators.a{i}]\nkind = \"speaker\"\nlevel = 1.0\n")).collect();
    refused(&scene("", "", &many), "robots[0].actuators: a command has 818 bytes, the limit is 512");
}

#[test]
fn motors_that_cannot_be() {
    refused(
        &scene("", "motors = { kind = \"velocity\" }", ""),
        "robots[0].motors.kind: a velocity-regulated motor needs encoders",
    );
    refused(
        &scene("", "motors = { timeout_ms = 0.0 }", ""),
        "robots[0].motors.timeout_ms: must be between 0.01",
    );
}

#[test]
fn brains_and_their_processors() {
    let onboard = "link = { kind = \"onboard\" }\n";
    refused(
        &scene(
            "",
            &format!("{onboard}microcontroller = {{ ram_bytes = 32 }}\nbrain = {{ memory_bytes = 33 }}"),
            "",
        ),
        "robots[0].brain.memory_bytes: needs 33 bytes, but the microcontroller has 32 (ram_bytes)",
    );
    refused(
        &scene("", "brain = { operations = 10 }", ""),
        "robots[0].brain.operations: is for a brain that is the microcontroller's program",
    );
    refused(&scene("", "brain = { memory_bytes = 10 }", ""), "robots[0].brain.memory_bytes: is for a brain");
    refused(
        &scene("", &format!("{onboard}brain = {{ operations = 10 }}"), ""),
        "robots[0].brain.operations: needs microcontroller.operations_per_s",
    );
    refused(
        &scene(
            "",
            &format!(
                "{onboard}microcontroller = {{ operations_per_s = 1.0 }}\nbrain = {{ operations = 1, thinking_us = 1.0 }}"
            ),
            "",
        ),
        "robots[0].brain.operations: give either this or thinking_us",
    );
    refused(
        &scene("", "link = { kind = \"onboard\", baud = 9600 }", ""),
        "robots[0].link.baud: there is no link",
    );
    refused(
        &scene("", "link = { kind = \"ideal\", baud = 9600 }", ""),
        "robots[0].link.baud: an ideal link has none",
    );
}

fn top(toml: &str, expected: &str) {
    refused(&scene(toml, "", ""), expected);
}

#[test]
fn things_in_the_arena() {
    let mover = "[[arena.movers]]\nname = \"m\"\nx_m = 3.0\n";
    top(
        &format!("{mover}radius_m = 0.1\n"),
        "arena.movers[0]: needs exactly one of `stops`, `swing` and `wander`",
    );
    top(
        &format!("{mover}swing = {{ to_rad = 1.0, rate_rad_s = 1.0 }}\n"),
        "arena.movers[0]: needs either `radius_m`",
    );
    top(
        &format!("{mover}radius_m = 0.1\nstops = {{ points_m = [[0, 0]], speed_m_s = 1.0 }}\n"),
        "arena.movers[0].stops.points_m: needs at least 2 points, has 1",
    );
    top(
        &format!(
            "{mover}outline_m = [[0, 0], [1, 0], [0, 1]]\nwander = {{ speed_m_s = 1.0, turn_s = 1.0 }}\n"
        ),
        "arena.movers[0].outline_m: only a disc can wander",
    );
    top(
        &format!("{mover}radius_m = 0.1\nwander = {{ speed_m_s = 1e300, turn_s = 1.0 }}\n"),
        "arena.movers[0].wander.speed_m_s: must be between",
    );
    let stuck = format!(
        "{}{mover}radius_m = 0.2\nwander = {{ speed_m_s = 1.0, turn_s = 1.0 }}\n",
        crate::devices::scene::wall(3.1)
    );
    top(&stuck, "arena.movers[0]: `m` stands in `wall`, so it could never wander");
}

#[test]
fn things_to_push_zones_and_lights() {
    let movable = "[[arena.movables]]\nname = \"m\"\nx_m = 3.0\ny_m = 0.0\nfriction = 0.1\n";
    top(&format!("{movable}mass_kg = 1.0\n"), "arena.movables[0]: needs one of `radius_m`");
    top(
        &format!("{movable}mass_kg = 0.0\nradius_m = 0.1\n"),
        "arena.movables[0].mass_kg: must be positive, is 0",
    );
    top(
        &format!("{movable}mass_kg = 1.0\noutline_m = [[0, 0], [1, 0], [0.2, 0.2], [0, 1]]\n"),
        "arena.movables[0].outline_m: a thing that is pushed must be convex",
    );
    top(
        "[[arena.zones]]\nname = \"z\"\n",
        "arena.zones[0]: needs either `points_m`, or `x_m`, `y_m` and `radius_m`",
    );
    top(
        "[[arena.zones]]\nname = \"z\"\nx_m = 0.0\ny_m = 0.0\nradius_m = 1.0\nslip = 1.1\n",
        "arena.zones[0].slip: must be between 0 and 1, is 1.1",
    );
    top(
        "[[arena.lights]]\nname = \"l\"\nx_m = 0.0\ny_m = 0.0\nintensity_cd = 1.0\nlit_ms = 5.0\n",
        "arena.lights[0].lit_ms: needs `blink_ms`, the period",
    );
    top(
        "[[arena.circles]]\nname = \"m\"\nx_m = 9.0\ny_m = 0.0\nradius_m = 1.0\n[[arena.movers]]\nname = \"m\"\n",
        "arena.movers[0]",
    );
    top("[arena]\nlatitude_deg = 90.0\n", "arena.latitude_deg: must be between -89 and 89, is 90");
    top("[arena]\nmaps = [{ file = \"x\" }]\n", "arena.maps: refers to a file");
}

#[test]
fn ends_that_a_run_can_never_have_or_has_at_once() {
    top("[end]\nall_goals = true\n", "end.all_goals: no zone of the arena has goal = true");
    top("[end]\nbattery_empty = true\n", "end.battery_empty: no robot has a battery");
    top("[end]\ncollisions = 0\n", "end.collisions: must be at least 1");
    top("[end]\ncovered = 0.5\n", "metrics.cell_m: is missing");
    top("[metrics]\ncell_m = 0.1\n", "metrics.cell_m: ");
    let room = "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n[metrics]\ncell_m = 0.1\n";
    top(&format!("{room}[end]\nsensed = 0.5\n"), "metrics.sensed_by: is missing");
    top(&format!("{room}sensed_by = \"eye\"\n"), "metrics.sensed_by: no robot has a sensor `eye` with rays");
    let bumper =
        scene(&format!("{room}sensed_by = \"s\"\n"), "", &named("s", "kind = \"bumper\"\nopening_rad = 1.0"));
    refused(&bumper, "metrics.sensed_by: no robot has a sensor `s` with rays");
}

#[test]
fn a_step_counter_without_steppers() {
    sensor("kind = \"steps\"", ".kind: counts the steps of stepper motors; motors = { kind = \"stepper\" }");
}
