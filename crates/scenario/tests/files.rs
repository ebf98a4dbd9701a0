//! Bad scenarios: each is refused with the path of what is wrong, and how.

use crate::common::{ARSIM, BODY, KHEPERA, WANDER, refusal};
use baudbot_geometry::Point;
use baudbot_scenario::Override;
use baudbot_sim::movable::MovableShape;
use baudbot_sim::scenario::Scenario;
use baudbot_sim::surroundings::Region;

fn robot(more: &str) -> String {
    format!("[[robots]]\nname = \"r\"\n{BODY}\n{more}")
}

#[track_caller]
fn refused(toml: &str, path: &str, problem: &str) {
    let message = refusal(toml);
    assert!(message.starts_with(&format!("{path}: ")), "expected path `{path}` in: {message}");
    assert!(message.contains(problem), "expected `{problem}` in: {message}");
}

#[test]
fn the_scenarios_of_the_project_are_sound() {
    for toml in [ARSIM, WANDER, KHEPERA] {
        baudbot_scenario::parse(toml).unwrap();
    }
}

#[test]
fn sensors_stay_in_the_order_of_the_file() {
    let toml = robot(
        "[robots.sensors.z]\nkind = \"compass\"\n[robots.sensors.m]\nkind = \"compass\"\n\
         [robots.sensors.a]\nkind = \"compass\"",
    );
    let change = Override::parse("robots.r.sensors.b={ kind = \"compass\" }").unwrap();
    let scenario = baudbot_scenario::parse_with(&toml, &[change]).unwrap();
    let names: Vec<_> = scenario.robots[0].sensors.iter().map(|sensor| sensor.name.as_str()).collect();
    assert_eq!(names, ["z", "m", "a", "b"]);
}

#[test]
fn a_program_that_is_none_is_told_in_words_of_ours() {
    for program in ["3", "[1]", "{ x = 1 }", "{ hex = 3 }"] {
        let toml = robot(&format!("microcontroller = {{ program = {program} }}"));
        refused(
            &toml,
            "robots[0].microcontroller.program",
            "must be the name of a file, or a table with `hex`",
        );
    }
}

#[test]
fn unknown_keys_name_their_path_and_those_that_exist() {
    refused("stepms = 10.0", "stepms", "unknown field `stepms`, expected one of");
    refused(
        &robot("start = { x_cm = 20.0 }"),
        "robots[0].start.x_cm",
        "unknown field `x_cm`, expected one of `x_m`",
    );
    let ir = "kind = \"ir\"\nbearing_rad = 0.0\nrays = 3\nopening_rad = 0.5\nc1_m2 = 0.03\nc2 = 0.1\nrange_cm = 100";
    refused(
        &robot(&format!("[robots.sensors.front]\n{ir}")),
        "robots[0].sensors.front.range_cm",
        "unknown field `range_cm`",
    );
    refused(
        &robot("link = { kind = \"can\" }"),
        "robots[0].link.kind",
        "must be one of `ideal`, `onboard`, `uart`, `usb`, is `can`",
    );
}

#[test]
fn wrong_types_name_their_path() {
    refused("step_ms = \"ten\"", "step_ms", "must be a number, is \"ten\"");
    refused(&robot("start = { x_m = true }"), "robots[0].start.x_m", "must be a number, is true");
    refused("noise = 0", "noise", "must be true or false, is 0");
    let sensor = "[robots.sensors.c]\nkind = \"compass\"\nperiod_ms = \"fast\"";
    refused(&robot(sensor), "robots[0].sensors.c.period_ms", "must be a number, is \"fast\"");
}

#[test]
fn numbers_that_make_no_sense_name_their_path_and_value() {
    let negative = robot("").replace("radius_m = 0.2", "radius_m = -0.2");
    refused(&negative, "robots[0].body.radius_m", "must be positive, is -0.2");
    refused(
        &robot("").replace("mass_kg = 3.0", "mass_kg = nan"),
        "robots[0].body.mass_kg",
        "must be positive, is NaN",
    );
    refused(&robot("start = { x_m = inf }"), "robots[0].start.x_m", "must be a finite number, is inf");
    refused("step_ms = 0.0", "step_ms", "must be between 0.01 and 1000");
    refused(
        "step_ms = 10.0\nsubsteps = 7",
        "substeps",
        "7 substeps do not divide 10 ms into whole nanoseconds; 5 or 8 do",
    );
    refused("substeps = 0", "substeps", "must be between 1 and 10000, is 0");
    refused("end = { after_s = -1.0 }", "end.after_s", "must be between 0");
    let sensor = |more| robot(&format!("[robots.sensors.c]\nkind = \"compass\"\n{more}"));
    refused(&sensor("bits = 33"), "robots[0].sensors.c.bits", "must be between 1 and 32, is 33");
    refused(&sensor("sigma_rad = -0.1"), "robots[0].sensors.c.sigma_rad", "must not be negative, is -0.1");
    refused(&sensor("period_ms = 0.0"), "robots[0].sensors.c.period_ms", "must be between 0.01");
    refused("seed = -1", "seed", "must be a whole number of 0 or more, is -1");
}

#[test]
fn a_device_without_a_kind_may_be_meant_for_another() {
    let lamp = |more: &str| {
        robot(&format!("[robots.actuators]\nlamp = {{ kind = \"lamp\", intensity_cd = 1.0 }}\n{more}"))
    };
    let meant = "missing field `kind`, which a new actuator needs; did you mean `lamp`?";
    refused(&lamp("lmap = { intensity_cd = 2.0 }"), "robots[0].actuators.lmap", meant);
    refused(&lamp("siren = { loudness = 2.0 }"), "robots[0].actuators.siren", "missing field `kind`");
    let sensors = "[robots.sensors]\ncompass = { kind = \"compass\" }\ncompas = { bits = 8 }\n";
    refused(&robot(sensors), "robots[0].sensors.compas", "which a new sensor needs; did you mean `compass`?");
    let misspelt = "[robots.sensors.compass]\nkinds = \"compass\"\n";
    refused(&robot(misspelt), "robots[0].sensors.compass.kinds", "did you mean `kind`?");
    let other = "[robots.sensors]\nleft = { kind = \"compass\" }\nodometer = { bits = 8 }\n";
    refused(&robot(other), "robots[0].sensors.odometer", "missing field `kind`");
}

#[test]
fn a_misspelt_preset_is_recognised() {
    refused("[[robots]]\npresets = \"khepera-1\"", "robots[0].presets", "did you mean `preset`?");
    let link = "[[robots]]\npreset = \"khepera-1\"\n[robots.link]\npreste = \"uart-9600\"\n";
    refused(link, "robots[0].link.preste", "did you mean `preset`?");
}

#[test]
fn links_and_firmwares_that_make_no_sense_say_how() {
    refused(&robot("link = { kind = \"uart\" }"), "robots[0].link.baud", "a uart needs its baud rate");
    refused(&robot("link = { baud = 9600 }"), "robots[0].link.baud", "did you mean kind = \"uart\"?");
    let link = "link = { kind = \"uart\", baud = 9600, bits_per_character = 9 }";
    refused(
        &robot(link),
        "robots[0].link.bits_per_character",
        "must be 8 (as the notes count), 10 (8N1) or 11, is 9",
    );
    refused(
        &robot("firmware = { mode = \"poll\", period_ms = 20.0 }"),
        "robots[0].firmware.period_ms",
        "no period",
    );
    refused(
        &robot("firmware = { protocol = \"bare\", ages = true }"),
        "robots[0].firmware.ages",
        "carries no ages",
    );
    let motors = "motors = { signal_bits = 8, unlimited_signals = true }";
    refused(&robot(motors), "robots[0].motors.unlimited_signals", "needs signals without `signal_bits`");
}

#[test]
fn fields_of_another_link_or_adapter_are_refused_by_name() {
    let link = |fields: &str, path: &str, problem: &str| {
        refused(&robot(&format!("link = {{ {fields} }}")), &format!("robots[0].link.{path}"), problem);
    };
    link("outages = []", "outages", "an ideal link has none; did you mean kind = \"uart\"?");
    link("frame_ms = 1", "frame_ms", "an ideal link has none; did you mean kind = \"usb\"?");
    link("kind = \"usb\", baud = 9600", "baud", "a usb link has none; did you mean kind = \"uart\"?");
    link("kind = \"usb\", half_duplex = true", "half_duplex", "a usb link has none");
    link("kind = \"usb\", adapter = { kind = \"cdc\" }", "adapter", "a usb link has none");
    link("kind = \"usb\", laptop_buffer_bytes = 2", "laptop_buffer_bytes", "must hold the longest message");
    let uart = |fields: &str, path: &str, problem: &str| {
        link(&format!("kind = \"uart\", baud = 9600, {fields}"), path, problem);
    };
    uart("bytes_per_frame = 64", "bytes_per_frame", "a uart has no frames; did you mean kind = \"usb\"");
    uart("turnaround_us = 10.0", "turnaround_us", "only with half_duplex = true");
    uart("half_duplex = true, turnaround_us = -1", "turnaround_us", "must be between 0 and 1000000, is -1");
    uart("adapter = { latency_ms = 16 }", "adapter", "missing field `kind`");
    let adapter = |fields: &str, path: &str, problem: &str| {
        uart(&format!("adapter = {{ kind = {fields} }}"), &format!("adapter.{path}"), problem);
    };
    adapter("\"usb\"", "kind", "must be one of `ftdi`, `cdc`, `bluetooth`, is `usb`");
    adapter("\"ftdi\", latency_ms = 0.5", "latency_ms", "must be between 1 and 255, is 0.5");
    adapter("\"ftdi\", latency_ms = 256", "latency_ms", "must be between 1 and 255, is 256");
    adapter("\"ftdi\", latency_ms = -1", "latency_ms", "must be between 1 and 255, is -1");
    adapter("\"ftdi\", packet_bytes = 0", "packet_bytes", "must be between 1 and 510, is 0");
    adapter("\"ftdi\", packet_bytes = 4097", "packet_bytes", "must be between 1 and 510, is 4097");
    adapter("\"bluetooth\", packet_bytes = 0", "packet_bytes", "must be between 1 and 4096, is 0");
    adapter("\"bluetooth\", latency_ms = -1", "latency_ms", "must be between 0 and 10000, is -1");
    adapter("\"ftdi\", burst_ms = 1", "burst_ms", "only a radio has that");
    adapter("\"cdc\", latency_ms = 1", "latency_ms", "no latency timer; did you mean kind = \"ftdi\"?");
    adapter("\"bluetooth\", frame_ms = 1", "frame_ms", "a radio has no USB frames");
    adapter("\"bluetooth\", spread_ms = 31", "spread_ms", "must be between 0 and 30, is 31");
    adapter("\"bluetooth\", burst_probability = 2", "burst_probability", "must be between 0 and 1, is 2");
    let fast = "kind = \"uart\", baud = 50000000, adapter = { kind = \"ftdi\" }";
    link(fast, "adapter", "19 packets of 62 bytes a frame keep up with 11780000 baud, not with 50000000");
}

#[test]
fn outages_are_finite_and_in_their_order() {
    let outages = |windows: &str, path: &str, problem: &str| {
        let link = format!("link = {{ kind = \"usb\", outages = [{windows}] }}");
        refused(&robot(&link), &format!("robots[0].link.outages{path}"), problem);
    };
    outages("{ from_s = -1.0, for_s = 1.0 }", "[0].from_s", "must be between 0 and 100000000, is -1");
    outages("{ from_s = 1.0, for_s = inf }", "[0].for_s", "must be between 0 and 100000000, is inf");
    outages("{ from_s = nan, for_s = 1.0 }", "[0].from_s", "is NaN");
    outages("{ from_s = 1.0 }", "[0]", "missing field `for_s`");
    let two = "{ from_s = 1.0, for_s = 1.0 }, { from_s = 1.5, for_s = 1.0 }";
    outages(two, "[1].from_s", "must not be before the end of the previous outage, is 1.5");
    let link = "{ kind = \"usb\", outages = [{ from_s = 1, for_s = 1 }, { from_s = 2, for_s = 1 }] }";
    baudbot_scenario::parse(&robot(&format!("link = {link}"))).unwrap();
}

#[test]
fn the_silence_of_a_bare_message_is_longer_than_an_adapter_holds_bytes() {
    let bare = |gap: &str| {
        robot(&format!(
            "firmware = {{ protocol = \"bare\", mode = \"poll\"{gap} }}\n\
             link = {{ kind = \"uart\", baud = 10000, adapter = {{ kind = \"ftdi\" }} }}"
        ))
    };
    let problem = "must be longer than the longest pause within a message on this link, 18 ms, is 17.5";
    refused(&bare(", gap_ms = 17.5"), "robots[0].firmware.gap_ms", problem);
    let scenario = baudbot_scenario::parse(&bare("")).unwrap();
    let protocol = scenario.robots[0].firmware.protocol;
    assert_eq!(protocol, baudbot_sim::firmware::Protocol::Bare { gap_ns: 37_000_000 });
}

#[test]
fn a_robot_that_stands_in_something_is_refused() {
    let arsim = |start: &str| ARSIM.replace("x_m = -0.2\ny_m = 0.0", start);
    refused(&arsim("x_m = -0.8\ny_m = 0.8"), "robots[0].start", "stands in `obstacle_1`");
    refused(&arsim("x_m = -1.7\ny_m = 0.0"), "robots[0].start", "stands in `wall_left`");
    // Wholly inside a solid obstacle, which ARSim's own check does not see.
    let house = ARSIM.replace(
        "[[-0.9, 0.9], [-0.9, 0.7], [-0.7, 0.7], [-0.7, 0.9]]",
        "[[-9, 9], [-9, 5], [-5, 5], [-5, 9]]",
    );
    let inside = house.replace("x_m = -0.2\ny_m = 0.0", "x_m = -7.0\ny_m = 7.0");
    refused(&inside, "robots[0].start", "stands in `obstacle_1`");
    let two = format!("{}\n{}", robot("start = { x_m = 0.3 }"), robot("").replace("\"r\"", "\"s\""));
    refused(&two, "robots[1].start", "stands in robots[0] (`r`)");
}

#[test]
fn names_are_unique_and_fit_into_paths() {
    let two = format!("{}\n{}", robot(""), robot("start = { x_m = 5.0 }"));
    refused(&two, "robots[1].name", "`r` is taken");
    refused(&robot("").replace("\"r\"", "\"my robot\""), "robots[0].name", "must be 1 to 64 letters");
    let shapes = "[[arena.polygons]]\nname = \"w\"\npoints_m = [[0, 0], [1, 0], [0, 1]]\n[[arena.circles]]\nname = \"w\"\nx_m = 5\ny_m = 5\nradius_m = 1";
    refused(shapes, "arena.circles[0].name", "`w` is taken");
    let twice = robot("[robots.sensors.a]\nkind = \"compass\"\n[robots.sensors.a]\nkind = \"compass\"");
    assert!(refusal(&twice).contains("duplicate key"), "{}", refusal(&twice));
}

#[test]
fn a_scenarios_name_is_on_one_line_and_no_error_quotes_what_a_terminal_obeys() {
    refused("name = \"a\\nb\"", "name", r"must be on one line and without control characters, is `a\nb`");
    for hostile in ["\\u001b[2J", "\\u009b31m", "\\u202etxt", "\\r", "\\u0007"] {
        for toml in [
            format!("name = \"{hostile}\""),
            format!("[[robots]]\nname = \"{hostile}\""),
            format!("\"{hostile}\" = 1"),
            format!("collision = \"{hostile}\""),
            format!("[arena]\n\"{hostile}\".x = 1"),
            format!("[[robots]]\nname = \"r\"\npreset = \"{hostile}\""),
            // Not TOML at all: the line is shown with the error.
            format!("step_ms = {} 1", hostile.replace("\\u001b", "\u{1b}").replace("\\u202e", "\u{202e}")),
        ] {
            let shown = refusal(&toml);
            let is_shown = |c: char| baudbot_fields::printable::is_printable(c) || c == '\n';
            assert!(shown.chars().all(is_shown), "{toml}: {shown:?}");
        }
    }
}

#[test]
fn polygons_need_an_inside() {
    for (points, problem) in [
        ("[[0, 0], [1, 1]]", "at least 3 corners in different places; this one has 2"),
        ("[[0, 0], [1, 1], [1, 1], [0, 0]]", "at least 3 corners in different places; this one has 2"),
        ("[[0, 0], [0.1, 0.3], [0.2, 0.6], [0.3, 0.9]]", "all corners are on one line"),
        ("[[0, 0], [4, 0], [2, 0], [2, 2], [0, 2]]", "at (4, 0) the outline turns back along its own side"),
        ("[[0, 0], [2, 1], [4, 0], [4, 2], [2, 1], [0, 2]]", "touches itself at (2, 1)"),
        (
            "[[0, 0], [1, 1], [1, 0], [0, 1]]",
            "crosses itself: its side from (0, 0) to (1, 1) crosses that from (1, 0) to (0, 1)",
        ),
    ] {
        refused(&polygon(points), "arena.polygons[0].points_m", problem);
        refused(&body(points), "robots[0].body.outline_m", problem);
        refused(&zone(points), "arena.zones[0].points_m", problem);
        refused(&movable(points), "arena.movables[0].outline_m", problem);
    }
    refused(
        &format!("{}\nsolid = false", polygon("[[1, 1], [1, 1]]")),
        "arena.polygons[0].points_m",
        "has 1",
    );
    refused(
        &polygon("[[0, 0], [1, nan], [1, 0]]"),
        "arena.polygons[0].points_m[1].y",
        "must be a finite number",
    );
}

/// Touching is no collision, and 1.0 − 0.8 is less than 0.2 in binary numbers.
#[test]
fn what_touches_stands_free_whatever_its_numbers_round_to() {
    let room = "[[arena.polygons]]\nname = \"room\"\nsolid = false\npoints_m = [[-1, -1], [1, -1], [1, 1], [-1, 1]]\n";
    let round = |r: &str, x: &str, y: &str| {
        let body =
            format!("body = {{ radius_m = {r}, mass_kg = 3, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}");
        let name = format!("x{x}y{y}").replace('.', "_");
        format!("[[robots]]\nname = \"{name}\"\nstart = {{ x_m = {x}, y_m = {y} }}\n{body}\n")
    };
    let thing = |kind: &str, more: &str, x: &str| {
        let name = format!("t{x}").replace('.', "_");
        format!("[[arena.{kind}]]\nname = \"{name}\"\nx_m = {x}\ny_m = 0\n{more}\n")
    };
    let stands = |toml: &str| {
        baudbot_scenario::parse(&format!("substeps = 100\n{toml}"))
            .unwrap_or_else(|error| panic!("{error}\n{toml}"));
    };
    for i in 1..50 {
        let (r, x) = (format!("0.{i:02}"), format!("0.{:02}", 100 - i));
        // In two corners, at a pillar, and at each other.
        stands(&format!("{room}{}{}", round(&r, &x, &x), round(&r, &format!("-{x}"), &format!("-{x}"))));
        let pillar = format!("[[arena.circles]]\nname = \"p\"\nx_m = 0\ny_m = 0\nradius_m = {x}\n");
        stands(&format!("{pillar}{}", round(&r, "1.0", "0")));
        stands(&format!(
            "{}{}",
            round(&r, "0.1", "0"),
            round(&r, &format!("{}", 0.1 + f64::from(2 * i) / 100.0), "0")
        ));
        let square = format!("[[-{r}, -{r}], [{r}, -{r}], [{r}, {r}], [-{r}, {r}]]");
        let body = format!(
            "body = {{ outline_m = {square}, half_track_m = 0.01, mass_kg = 3, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}"
        );
        stands(&format!(
            "{room}[[robots]]\nname = \"r\"\nstart = {{ x_m = {x}, y_m = -{x}, heading_rad = 1.5707963267948966 }}\n{body}\n"
        ));
        // Things that are pushed, and those that wander.
        let pushed = "mass_kg = 1\nfriction = 0.3";
        stands(&format!(
            "{room}{}{}",
            thing("movables", &format!("radius_m = {r}\n{pushed}"), &x),
            thing("movables", &format!("outline_m = {square}\n{pushed}"), &format!("-{x}"))
        ));
        let wanders = "wander = { speed_m_s = 0.1, turn_s = 1.0 }";
        stands(&format!("{room}{}", thing("movers", &format!("radius_m = {r}\n{wanders}"), &x)));
    }
    // A micrometre is more than rounding.
    let deep = format!("substeps = 100\n{room}{}", round("0.2", "0.800001", "0"));
    refused(&deep, "robots[0].start", "stands in `room`");
}

/// Corners are repeated and straight as GeoJSON, WKT and Shapely write rings, and as programs cut sides into pieces.
#[test]
fn repeated_and_straight_corners_change_nothing() {
    let plain = "[[-0.3, -0.3], [0.6, -0.3], [0.6, 0.3], [-0.3, 0.3]]";
    let scenario =
        |toml: &str| -> Scenario { baudbot_scenario::parse(toml).unwrap_or_else(|e| panic!("{toml}: {e}")) };
    let corners = |points: &str| -> [Vec<Point>; 5] {
        let hollow = polygon(points) + "\nsolid = false";
        let arena = |toml: &str| scenario(toml).arena.polygons()[0].points.clone();
        let zone = match scenario(&zone(points)).surroundings.zones[0].region.clone() {
            Region::Polygon(corners) => corners,
            Region::Disc(_) => panic!("a disc"),
        };
        let MovableShape::Box { outline } = scenario(&movable(points)).movables[0].shape.clone() else {
            panic!("a ball")
        };
        let body = scenario(&body(points)).robots[0].outline.clone();
        [arena(&polygon(points)), arena(&hollow), zone, outline, body]
    };
    let expected = corners(plain);
    for same in [
        "[[-0.3, -0.3], [0.6, -0.3], [0.6, 0.3], [-0.3, 0.3], [-0.3, -0.3]]",
        "[[-0.3, -0.3], [0.6, -0.3], [0.6, -0.3], [0.6, 0.3], [-0.3, 0.3], [-0.3, -0.3], [-0.3, -0.3]]",
        "[[-0.3, -0.3], [0.6, -0.3], [0.6, 0.30000000000000004], [0.6, 0.3], [-0.3, 0.3]]",
    ] {
        for (found, expected) in corners(same).iter().zip(&expected) {
            assert_eq!(found.len(), expected.len(), "{same}");
            let apart = found.iter().zip(expected).map(|(a, b)| (a - b).norm());
            assert!(apart.fold(0.0, f64::max) < 1e-15, "{same}: {found:?}");
        }
    }
    let straight = "[[-0.3, -0.3], [0.1, -0.3], [0.6, -0.3], [0.6, 0.3], [0.1, 0.3], [-0.3, 0.3]]";
    assert!(corners(straight).iter().all(|corners| corners.len() == 6));
}

fn polygon(points: &str) -> String {
    format!("[[arena.polygons]]\nname = \"w\"\npoints_m = {points}")
}

fn zone(points: &str) -> String {
    format!("[[arena.zones]]\nname = \"z\"\ngoal = true\npoints_m = {points}")
}

fn movable(points: &str) -> String {
    format!(
        "[[arena.movables]]\nname = \"m\"\nx_m = 0\ny_m = 0\nmass_kg = 1\nfriction = 0.3\noutline_m = {points}"
    )
}

fn body(points: &str) -> String {
    format!(
        "[[robots]]\nname = \"r\"\nbody = {{ outline_m = {points}, half_track_m = 0.1, wheel_radius_m = 0.05, mass_kg = 3, inertia_kg_m2 = 0.2 }}"
    )
}

#[test]
fn text_that_is_no_toml_names_line_and_column() {
    let message = refusal("step_ms = 10.0\n[[robots\n");
    assert!(message.contains("line 2"), "{message}");
}

#[test]
fn too_much_is_refused_before_it_is_read() {
    let long = "#".repeat(17 << 20);
    assert_eq!(refusal(&long), "the scenario has 17825792 bytes, the limit is 16777216");
    let mut many = robot("");
    for i in 0..80 {
        many += &format!("\n[robots.sensors.o{i}]\nkind = \"odometer\"");
    }
    refused(&many, "robots[0].sensors", "the limit is 512");
}

#[test]
fn overrides_reach_any_field_by_name_and_by_index() {
    let parse = |changes: &[&str]| {
        let changes: Vec<_> = changes.iter().map(|text| Override::parse(text).unwrap()).collect();
        baudbot_scenario::parse_with(ARSIM, &changes)
    };
    for path in ["robots.robot.start.x_m", "robots.0.start.x_m", "robots[0].start.x_m"] {
        let scenario = parse(&[&format!("{path}=0.5")]).unwrap();
        assert_eq!(scenario.robots[0].start.pose.position.x, 0.5);
    }
    assert!(!parse(&["noise=false"]).unwrap().noise);
    assert!(parse(&["collision=stop-robot", "robots.robot.link={ kind = \"uart\", baud = 9600 }"]).is_ok());
    let refused = |change: &str| parse(&[change]).unwrap_err().to_string();
    assert_eq!(refused("robots.bob.start.x_m=1"), "robots.bob: there is no such element; there are: robot");
    assert!(refused("robots.robot.start.z_m=1").starts_with("robots[0].start.z_m: unknown field `z_m`"));
    assert!(
        refused("robots.robot.body.radius_m=-1")
            .starts_with("robots[0].body.radius_m: must be positive, is -1")
    );
    assert!(refused("step_ms.x=1").starts_with("step_ms: is a float, it has no field `x`"));
    assert!(Override::parse("noise").unwrap_err().to_string().contains("an override is PATH=VALUE"));
    assert!(Override::parse("robots..x=1").unwrap_err().to_string().contains("empty part"));
    let large = Override::parse("seed=9223372036854775808").unwrap_err().to_string();
    assert!(
        large.starts_with("seed: must be between -9223372036854775808 and 9223372036854775807"),
        "{large}"
    );
}

#[test]
fn an_override_with_an_endless_path_is_refused() {
    let path = vec!["a"; 200_000].join(".");
    let message = Override::parse(&format!("{path}=1")).unwrap_err().to_string();
    assert!(message.contains("the path has 200000 parts"), "{message}");
}

#[test]
fn places_and_sizes_beyond_any_arena_are_refused() {
    let circle =
        |radius: &str| format!("[[arena.circles]]\nname = \"c\"\nx_m = 0\ny_m = 0\nradius_m = {radius}");
    refused(&circle("1e308"), "arena.circles[0].radius_m", "must be between");
    let wall = "[[arena.polygons]]\nname = \"w\"\nsolid = false\npoints_m = [[0, 0], [1e155, 0]]";
    refused(wall, "arena.polygons[0].points_m[1].x", "must be between");
    let far = "[robots.sensors.s]\nkind = \"ir\"\nmount = { x_m = 5.0, y_m = 0.0, heading_rad = 0.0 }\n\
               rays = 1\nopening_rad = 0.0\nrange_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1";
    refused(&robot(far), "robots[0].sensors.s.mount.x_m", "must be between -0.4 and 0.4, is 5");
    let noisy = "[robots.sensors.o]\nkind = \"odometer\"\nsigma_m = 1e308";
    refused(&robot(noisy), "robots[0].sensors.o.sigma_m", "must be between 0 and 1000");
}

#[test]
fn an_unknown_field_of_a_sensor_is_answered_with_what_all_sensors_have() {
    let typo = "[robots.sensors.c]\nkind = \"compass\"\nperiod = 10";
    refused(&robot(typo), "robots[0].sensors.c.period", "; all sensors have `kind`, `period_ms`,");
    let deeper = "[robots.sensors.c]\nkind = \"compass\"\nnoise = { sigma = 1.0 }";
    assert!(!refusal(&robot(deeper)).contains("all sensors"));
}

#[test]
fn an_error_in_a_very_long_line_does_not_repeat_it() {
    let message = refusal(&format!("x = {}", "[".repeat(100_000)));
    assert!(
        message.starts_with("TOML parse error at line 1, column ") && message.len() < 1000,
        "{message:.200}"
    );
    assert!(refusal("x = [1").contains("x = [1"));
}

#[test]
fn no_field_and_no_speaker_is_so_strong_that_readings_are_infinite() {
    let field = "[[arena.fields]]\nname = \"f\"\nbackground = 1e308\nslope_per_m = [1e308, 0.0]";
    refused(&robot(field), "arena.fields[0].background", "must be between");
    refused(
        &robot(&field.replace("background = 1e308", "")),
        "arena.fields[0].slope_per_m[0]",
        "must be between",
    );
    let horn = "[robots.actuators.horn]\nkind = \"speaker\"\nlevel = 1e308";
    refused(&robot(horn), "robots[0].actuators.horn.level", "must be between");
}

#[test]
fn samples_in_a_file_are_for_who_reads_files() {
    let file = "[robots.sensors.i]\nkind = \"ir\"\nbearing_rad = 0\nrays = 1\nopening_rad = 0.0\n\
                range_m = 1.0\nlookup = \"samples.csv\"";
    refused(&robot(file), "robots[0].sensors.i.lookup", "only the program that reads scenario files");
}

#[test]
fn steps_that_would_blow_up_are_refused_with_the_substeps_that_would_not() {
    let long = format!("step_ms = 1000.0\n{}", robot(""));
    refused(&long, "robots[0].body", "set substeps to 11 or more");
    baudbot_scenario::parse(&format!("step_ms = 1000.0\nsubsteps = 20\n{}", robot(""))).unwrap();
    let light = robot("").replace("inertia_kg_m2 = 0.2", "inertia_kg_m2 = 1e-5");
    refused(&light, "robots[0].body", "would blow up");
    let weightless = robot("").replace("inertia_kg_m2 = 0.2", "inertia_kg_m2 = 1e-300");
    refused(&weightless, "robots[0].body", "the 10000 substeps that there can be are too few");
}

#[test]
fn a_sensor_that_would_take_for_ever_is_refused() {
    let sensor = "[robots.sensors.s]\nkind = \"ir\"\nbearing_rad = 0\nperiod_ms = 0.01\nrays = 10000\n\
                  opening_rad = 1.0\nrange_m = 1.0\nc1_m2 = 0.03\nc2 = 0.1";
    refused(&robot(sensor), "robots[0].sensors.s.rays", "casts 10000000 rays a tick, the limit is 100000");
}

#[test]
fn a_cable_that_no_message_gets_through_is_refused() {
    let link = |more: &str| {
        format!("link = {{ kind = \"uart\", baud = 9600{more} }}\n[robots.sensors.c]\nkind = \"compass\"")
    };
    refused(
        &robot(&link(", laptop_buffer_bytes = 8")),
        "robots[0].link.laptop_buffer_bytes",
        "must hold the longest message",
    );
    let bare = format!("firmware = {{ protocol = \"bare\", gap_ms = 1.0 }}\n{}", link(""));
    refused(&robot(&bare), "robots[0].firmware.gap_ms", "must be longer than a character on this link");
}

#[test]
fn ends_that_cannot_come_or_have_come_already_are_refused() {
    let end = |field: &str| format!("[end]\n{field}\n{}", robot(""));
    refused(&end("collisions = 0"), "end.collisions", "must be at least 1, is 0");
    refused(&end("all_goals = true"), "end.all_goals", "no zone of the arena has goal = true");
    refused(&end("battery_empty = true"), "end.battery_empty", "no robot has a battery");
    let goal = "[[arena.zones]]\nname = \"there\"\nx_m = 1.0\ny_m = 1.0\nradius_m = 0.1\ngoal = true\n";
    baudbot_scenario::parse(&format!("{}{goal}", end("collisions = 1\nall_goals = true"))).unwrap();
}

#[test]
fn a_brain_on_board_has_no_cable_and_a_port_is_one() {
    baudbot_scenario::parse(&robot("link = { kind = \"onboard\" }")).unwrap();
    let baud = "link = { kind = \"onboard\", baud = 9600 }";
    refused(
        &robot(baud),
        "robots[0].link.baud",
        "there is no link: the brain is the microcontroller's program",
    );
    let laser = "[robots.sensors.l]\nkind = \"laser\"\nbearing_rad = 0.0\nopening_rad = 1.0\nrays = 300\nrange_m = 4.0";
    let port = "port = { link = { kind = \"onboard\" } }";
    refused(&robot(&format!("{laser}\n{port}")), "robots[0].sensors.l.port.link.kind", "a port is a cable");
    refused(&robot(&format!("{laser}\nbits = 8")), "robots[0].sensors.l", "has 300 values");
}

#[test]
fn noise_that_is_given_twice_is_refused() {
    let compass = "[robots.sensors.c]\nkind = \"compass\"\nsigma_rad = 0.1\nnoise = { additive = 0.1 }";
    refused(&robot(compass), "robots[0].sensors.c.sigma_rad", "is short for noise.additive");
}

#[test]
fn a_thing_that_is_pushed_is_the_same_whichever_way_round_its_corners_are_given() {
    let outline = |corners: &str| {
        let thing = format!(
            "[[arena.movables]]\nname = \"t\"\noutline_m = [{corners}]\nx_m = 2\ny_m = 1\nmass_kg = 1\nfriction = 0.1\n"
        );
        baudbot_scenario::parse(&(robot("") + &thing)).unwrap().movables.remove(0)
    };
    let counter_clockwise = outline("[0, 0], [0.6, 0], [0, 0.3]");
    assert_eq!(outline("[0, 0.3], [0.6, 0], [0, 0]"), counter_clockwise);
    assert_eq!(counter_clockwise.start.position, Point::new(2.2, 1.1));
}

#[test]
fn serial_ports_are_read_from_the_links_of_a_robot_and_of_its_sensors() {
    let cable = |port: &str| format!("{{ kind = \"uart\", baud = 9600, serial_port = {port} }}");
    let laser =
        "[robots.sensors.l]\nkind = \"laser\"\nbearing_rad = 0.0\nopening_rad = 1.0\nrays = 3\nrange_m = 4.0";
    let with = |own: &str, of_laser: &str| {
        robot(&format!("link = {}\n{laser}\nport = {{ link = {} }}", cable(own), cable(of_laser)))
    };
    let scenario = baudbot_scenario::parse(&with("\"pty:a.tty\"", "[\"tcp:10940\", \"unix:b\"]")).unwrap();
    let found: Vec<_> = scenario
        .serial_ports
        .iter()
        .map(|port| (port.sensor.as_deref(), port.endpoint.to_string()))
        .collect();
    let expected = [(None, "pty:a.tty"), (Some("l"), "tcp:127.0.0.1:10940"), (Some("l"), "unix:b")];
    assert_eq!(found, expected.map(|(sensor, text)| (sensor, text.to_owned())));
    assert!(scenario.serial_ports.iter().all(|port| port.robot == scenario.robots[0].name));
    assert_eq!(baudbot_scenario::parse(&with("[]", "[]")).unwrap().serial_ports, []);

    refused(&with("\"com:3\"", "[]"), "robots[0].link.serial_port", "`com` is not a kind of port");
    refused(&with("7", "[]"), "robots[0].link.serial_port", "must be a text such as");
    let at = "robots[0].sensors.l.port.link.serial_port[1]";
    refused(&with("[]", "[\"pty:a\", \"tcp:x\"]"), at, "`x` is not an address");
    let many = format!("[{}]", "\"tcp:0\",".repeat(9));
    refused(&with(&many, "[]"), "robots[0].link.serial_port", "there are 9, the limit is 8");
    let onboard = "link = { kind = \"onboard\", serial_port = \"pty:a\" }";
    refused(&robot(onboard), "robots[0].link.serial_port", "there is no link");
    let two = format!("starts = [{{}}, {{ x_m = 5 }}]\nlink = {}", cable("\"pty:a\""));
    refused(&robot(&two), "robots[0].link.serial_port", "this table describes 2");
}
