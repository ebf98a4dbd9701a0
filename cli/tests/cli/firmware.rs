//! Programs of the user's own on a robot's microcontroller, by the command line: what is refused, and what a bad program does.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cli::{baudbot, good, place};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// A robot with motors on its pins.
const ROBOT: &str = "name = \"firmware\"\n[[robots]]\nname = \"r\"\n\
    body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n";

const CABLE: &str = "link = { preset = \"uart-9600\" }\n";

fn scenario(name: &str, text: &str) -> PathBuf {
    let path = place(&format!("firmware-{name}.toml"));
    fs::write(&path, text).unwrap();
    path
}

/// A file with this in it.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = place(&format!("firmware-{name}"));
    fs::write(&path, bytes).unwrap();
    path
}

/// Intel HEX of some instructions from address 0 on.
fn hex(words: &[u16]) -> Vec<u8> {
    let data: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let mut text = String::new();
    for (at, chunk) in (0_u16..).step_by(16).zip(data.chunks(16)) {
        let mut record = vec![chunk.len() as u8, (at >> 8) as u8, at as u8, 0];
        record.extend(chunk);
        let sum = record.iter().fold(0_u8, |sum, &byte| sum.wrapping_add(byte));
        record.push(sum.wrapping_neg());
        let digits: Vec<_> = record.iter().map(|byte| format!("{byte:02X}")).collect();
        text += &format!(":{}\n", digits.concat());
    }
    (text + ":00000001FF\n").into_bytes()
}

/// The error of a run that is refused.
fn refused(scenario: &Path, firmware: &str) -> String {
    let (code, _, err) = baudbot(&["run", scenario.to_str().unwrap(), "--firmware", firmware]);
    assert_eq!(code, 2, "{err}");
    assert!(err.starts_with("error: "), "{err}");
    err
}

/// The report of a run with these instructions on its robot.
fn ran(name: &str, words: &[u16], seconds: &str) -> Value {
    let robot = scenario(name, &format!("{ROBOT}{CABLE}pins.13 = \"leds.builtin\"\n"));
    let program = file(&format!("{name}.hex"), &hex(words));
    let firmware = format!("r={}", program.display());
    let text =
        good(&["run", robot.to_str().unwrap(), "--firmware", &firmware, "--seconds", seconds, "--json"]);
    let summary: Value = serde_json::from_str(&text).unwrap();
    summary["robots"][0].clone()
}

fn warned(robot: &Value, problem: &str) -> u64 {
    let warnings = robot["chip"]["warnings"].as_array().unwrap();
    let found = warnings.iter().find(|warning| warning["problem"].as_str().unwrap().contains(problem));
    found.unwrap_or_else(|| panic!("{problem}: {robot}"))["count"].as_u64().unwrap()
}

#[test]
fn a_file_that_is_no_program_is_refused_by_its_name_and_line() {
    let robot = scenario("files", &format!("{ROBOT}{CABLE}"));
    let mut damaged = hex(&[0x0000; 20]);
    damaged[20] = b'7';
    let beyond = b":020000040001F9\n:0200000000FFFF\n:00000001FF\n".to_vec();
    for (name, bytes, expected) in [
        ("damaged.hex", damaged, "line 1: the checksum is"),
        ("cut.hex", hex(&[0x0000; 20])[..60].to_vec(), "line 2: "),
        ("empty.hex", Vec::new(), "there is nothing in it for the flash"),
        ("nothing.hex", b":00000001FF\n".to_vec(), "there is nothing in it for the flash"),
        ("text.hex", b"hello\n".to_vec(), "line 1: a record begins with a colon"),
        ("beyond.hex", beyond, "byte 0x10000 is beyond the flash"),
        ("own.elf", fs::read(env!("CARGO_BIN_EXE_baudbot")).unwrap()[..4096].to_vec(), "own.elf"),
    ] {
        let path = file(name, &bytes);
        let said = refused(&robot, &format!("r={}", path.display()));
        assert!(said.contains(name) && said.contains(expected), "{said}");
    }
    for (firmware, expected) in [
        ("r=/no/such/file.hex", "there is no such file"),
        ("r=/tmp", "is not a file"),
        ("alone.hex", "write ROBOT=FILE"),
        ("=x.hex", "write ROBOT=FILE"),
    ] {
        assert!(refused(&robot, firmware).contains(expected), "{firmware}");
    }
    let good = file("good.hex", &hex(&[0xCFFF]));
    let said = refused(&robot, &format!("other={}", good.display()));
    assert!(said.contains("robots.other: there is no such element; there are: r"), "{said}");
}

#[test]
fn a_program_that_is_too_large_for_its_chip_is_refused_where_the_chip_is_known() {
    let large = file("large.hex", &hex(&[0x0000; 5000]));
    let chip = "microcontroller.chip = \"atmega88pa\"\n";
    let robot = scenario("large", &format!("{ROBOT}{CABLE}{chip}"));
    let said = refused(&robot, &format!("r={}", large.display()));
    assert!(
        said.contains("robots[0].microcontroller.program") && said.contains("firmware-large.hex"),
        "{said}"
    );
    assert!(said.contains("ATmega88PA") || said.contains("atmega88pa"), "{said}");
}

#[test]
fn cables_and_brains_that_a_program_cannot_have_are_refused() {
    let program = file("loop.hex", &hex(&[0xCFFF]));
    let firmware = format!("r={}", program.display());
    for (name, link, expected) in [
        ("ideal", "", "robots[0].link: must be a serial cable"),
        ("usb", "link = { kind = \"usb\" }\n", "robots[0].link: must be a serial cable"),
        ("onboard", "link = { kind = \"onboard\" }\n", "robots[0].link: must be a serial cable"),
        (
            "notes",
            "link = { kind = \"uart\", baud = 9600, bits_per_character = 8 }\n",
            "robots[0].link.bits_per_character: must be 10 (8N1) or 11",
        ),
        (
            "shared",
            "link = { kind = \"uart\", baud = 9600, bits_per_character = 10, half_duplex = true }\n",
            "robots[0].link.half_duplex: must be false",
        ),
        (
            "khepera",
            "link = { preset = \"uart-9600\" }\nfirmware = { protocol = \"khepera\" }\nmotors = { signal_bits = 8 }\n",
            "robots[0].firmware.protocol",
        ),
    ] {
        let said = refused(&scenario(name, &format!("{ROBOT}{link}")), &firmware);
        assert!(said.contains(expected), "{name}: {said}");
    }
    let robot = scenario("brain", &format!("{ROBOT}{CABLE}"));
    let (code, _, err) = baudbot(&[
        "run",
        robot.to_str().unwrap(),
        "--firmware",
        &firmware,
        "--brain",
        "avoid",
        "--seconds",
        "1",
    ]);
    assert!(code == 2 && err.contains("runs a program of its own"), "{err}");
}

#[test]
fn wires_that_nobody_would_make_are_refused_by_their_pin() {
    let sensors = "sensors.ir = { kind = \"ir\", bearing_rad = 0.0, rays = 5, opening_rad = 0.5, range_m = 1.0, \
                   c1_m2 = 0.03, c2 = 0.1, bits = 8 }\nsensors.whisker = { preset = \"whisker\" }\n";
    for (name, pins, expected) in [
        ("unknown-pin", "99 = \"leds.x\"", "99"),
        ("unknown-sensor", "A0 = \"sensors.nose\"", "the robot has no sensor `nose`; there are ir, whisker"),
        ("unknown-thing", "A0 = \"wheels.left\"", "is not something that a pin can be connected to"),
        ("no-adc", "9 = \"sensors.ir\"", "PB1"),
        ("two-outputs", "2 = [\"sensors.whisker\", \"encoders.left.a\"]", "encoders"),
        ("open", "9 = \"motors.left.pwm\"", "direction"),
        ("terminal", "9 = \"motors.left.speed\"", "motors.left"),
        ("wheel", "9 = \"motors.middle.pwm\"", "`middle` is not a wheel"),
        ("option", "A0 = { to = \"sensors.ir\", colour = 3 }", "unknown field `colour`"),
        ("number", "A0 = 3", "must be a text, a list, or a table with `to`, is 3"),
        (
            "meaningless-option",
            "A0 = { to = \"sensors.ir\", pull = \"external\" }",
            "robots[0].pins.A0.pull: does not apply to `sensors.ir`, which has the options volts_at_0, volts_per_unit, divider and \
             threshold_v",
        ),
        (
            "comparator-option",
            "2 = { to = \"sensors.ir\", threshold_v = 2.0, divider = 0.5 }",
            "robots[0].pins.2.divider: does not apply to `sensors.ir`, which has the options volts_at_0, volts_per_unit, threshold_v, \
             hysteresis_v and low_when",
        ),
        (
            "a-fifth-channel",
            "5 = [\"motors.left.latch\", { to = \"motors.left.pwm\", channel = 5 }]",
            "robots[0].pins.5[1].channel: must be 1 to 4, is 5",
        ),
        ("no-adc-for-a-potentiometer", "5 = \"potentiometers.speed\"", "PD5"),
        (
            "one-option",
            "5 = { to = \"sensors.whisker\", divider = 0.5 }",
            "robots[0].pins.5.divider: does not apply to `sensors.whisker`, which has the option pull",
        ),
        (
            "no-options",
            "5 = [\"leds.a\", { to = \"buzzers.b\", lit_by = \"low\" }]",
            "robots[0].pins.5[1].lit_by: does not apply to `buzzers.b`, which has no options",
        ),
        ("crystal", "PB6 = \"leds.x\"", "robots[0].pins.PB6: is a pin of the clock source"),
        ("reset", "PC6 = \"leds.x\"", "robots[0].pins.PC6: is the reset pin"),
    ] {
        let robot = scenario(name, &format!("{ROBOT}{CABLE}{sensors}[robots.pins]\n{pins}\n"));
        let (code, _, err) = baudbot(&["check", robot.to_str().unwrap()]);
        assert!(code == 2 && err.contains("robots[0].pins") && err.contains(expected), "{name}: {err}");
    }
}

#[test]
fn only_a_control_on_a_pin_can_be_operated() {
    let operation = "[[robots.operations]]\nat_s = 1.0\ncontrol = \"buttons.stop\"\n";
    let begins = "robots[0].operations[0].control: no pin has the control `buttons.stop`";
    for (name, pins, rest) in [
        ("another-control", "pins.5 = \"buttons.start\"\n", "there are buttons.start"),
        ("no-controls", "", "connect it: pins.2 = \"buttons.start\""),
    ] {
        let robot = scenario(name, &format!("{ROBOT}{CABLE}{pins}{operation}"));
        let (code, _, err) = baudbot(&["check", robot.to_str().unwrap()]);
        assert!(code == 2 && err.contains(&format!("{begins}; {rest}")), "{name}: {err}");
    }
    let many = operation.repeat(1001);
    let robot = scenario("operations", &format!("{ROBOT}{CABLE}pins.5 = \"buttons.stop\"\n{many}"));
    let (code, _, err) = baudbot(&["check", robot.to_str().unwrap()]);
    assert!(code == 2 && err.contains("robots[0].operations: has 1001 operations; at most 1000"), "{err}");
}

#[test]
fn pins_of_the_crystal_and_of_the_reset_are_free_if_the_fuses_say_so() {
    let fuses = "microcontroller.fuses = [0xe2, 0x59, 0xff]\n";
    let pins = "PB6 = \"leds.a\"\nPB7 = \"leds.b\"\nPC6 = \"leds.c\"\n";
    let robot = scenario("free-pins", &format!("{ROBOT}{CABLE}{fuses}[robots.pins]\n{pins}"));
    good(&["check", robot.to_str().unwrap()]);
}

#[test]
fn bad_programs_are_told_of_and_the_world_goes_on() {
    // 0x0001 is no instruction.
    let illegal = ran("illegal", &[0x0001, 0xCFFE], "0.1");
    assert!(warned(&illegal, "is not an instruction") > 0);
    // WDTCSR: change enabled, then reset after 16 ms; and a loop that does not feed it.
    let bitten = ran("bitten", &[0xE118, 0x9310, 0x0060, 0xE018, 0x9310, 0x0060, 0xCFFF], "2");
    assert!(warned(&bitten, "watchdog") > 5, "{bitten}");
    assert!(bitten["chip"]["watchdog_resets"].as_u64().unwrap() > 5);
    // push r0 for ever.
    let stack = ran("stack", &[0x920F, 0xCFFE], "0.1");
    assert!(warned(&stack, "beyond the memory") > 0 || stack["chip"]["stack_bytes"].as_u64().unwrap() > 2000);
    // UBRR0 = 8 on a cable of 9600 baud, and characters one behind the other.
    let fast = ran("fast", &[0xE008, 0x9300, 0x00C4, 0x9300, 0x00C1, 0x9300, 0x00C6, 0xCFFD], "0.1");
    assert!(warned(&fast, "baud rate") > 0);
    // Power-down for ever: nothing is wrong, and nothing is done.
    let asleep = ran("asleep", &[0xE005, 0xBF03, 0x9588, 0xCFFE], "1");
    assert!(asleep["chip"]["cycles"].as_u64().unwrap() < 1000, "{asleep}");
    assert_eq!(asleep["chip"]["warnings"].as_array().unwrap().len(), 0);
}

#[test]
fn a_run_says_how_long_the_rounds_of_the_main_loop_were() {
    let robot = format!("{ROOT}/catalogue/scenarios/firmware.toml");
    let summary: Value = serde_json::from_str(&good(&["run", &robot, "--seconds", "2", "--json"])).unwrap();
    let rounds = &summary["robots"][0]["chip"]["rounds"];
    // The program reads the time in eleven cycles, measures five voltages each 20 ms, and writes a line each 100 ms.
    assert_eq!(rounds["least_cycles"], 11, "{rounds}");
    let cycles = summary["robots"][0]["chip"]["cycles"].as_f64().unwrap();
    let all = rounds["count"].as_f64().unwrap() * rounds["mean_cycles"].as_f64().unwrap();
    assert!(all < cycles && all > 0.95 * cycles, "{all} of {cycles} cycles: {rounds}");
    let most_ms = rounds["most_ms"].as_f64().unwrap();
    assert!((most_ms - rounds["most_cycles"].as_f64().unwrap() / 16e3).abs() < 1e-9, "{rounds}");
    let text = good(&["run", &robot, "--seconds", "1"]);
    assert!(text.contains("main loop") && text.contains("rounds of 11 cycles at least"), "{text}");
    // The program sleeps for good in its first round.
    let asleep = ran("asleep-for-good", &[0xE005, 0xBF03, 0x9588, 0xCFFE], "1");
    assert!(asleep["chip"].get("rounds").is_none(), "{asleep}");
    assert!(asleep["chip"]["asleep_percent"].as_f64().unwrap() > 99.0, "{asleep}");
}

#[test]
fn check_lists_the_pins_and_draws_them() {
    let robot = format!("{ROOT}/catalogue/scenarios/firmware.toml");
    let text = good(&["check", &robot]);
    for expected in
        ["ATmega328P at 16 MHz", "A0 (PC0)", "sensors.ir_left", "motors.left.pwm", "its own language"]
    {
        assert!(text.to_lowercase().contains(&expected.to_lowercase()), "{expected}: {text}");
    }
    let picture = good(&["check", &robot, "--svg", "-"]);
    assert!(picture.contains(">motors.left.pwm<") && picture.contains(">A0<"), "no pins in the picture");
}

#[test]
fn programs_are_varied_by_a_sweep_under_the_names_of_their_files() {
    // Sends `A`, or twice: sts UCSR0B, TXEN0; sts UDR0, r17.
    let sends = |times: usize| {
        let start = [0xE008, 0x9300, 0x00C1, 0xE411];
        let ends = [0xCFFF];
        hex(&[&start[..], &[0x9310, 0x00C6].repeat(times), &ends].concat())
    };
    let [once, twice] = [("once.hex", 1), ("twice.hex", 2)].map(|(name, times)| file(name, &sends(times)));
    let names = [&once, &twice].map(|path| path.file_name().unwrap().to_str().unwrap());
    let robot = scenario("swept", &format!("{ROBOT}{CABLE}pins.13 = \"leds.builtin\"\n"));
    let text = |programs: [&str; 2]| {
        format!(
            "name = \"programs\"\nscenario = {robot:?}\nbrain = \"none\"\nseconds = 0.1\nseeds = 1\n[[fields]]\nlabel = \"program\"\n\
             field = \"robots.r.microcontroller.program\"\nvalues = {programs:?}\n"
        )
    };
    let experiment = file("swept-experiment.toml", text(names).as_bytes());
    let out = place("firmware-swept");
    let _ = fs::remove_dir_all(&out);
    good(&["sweep", experiment.to_str().unwrap(), "--out", out.to_str().unwrap(), "--quiet"]);
    let table = fs::read_to_string(out.join("rows.csv")).unwrap();
    let rows: Vec<_> = table.lines().skip(1).collect();
    assert_eq!(rows.len(), 2, "{table}");
    for (row, program) in rows.into_iter().zip([&once, &twice]) {
        let firmware = format!("r={}", program.display());
        let run = ["run", robot.to_str().unwrap(), "--firmware", &firmware, "--seconds", "0.1", "--json"];
        let summary: Value = serde_json::from_str(&good(&run)).unwrap();
        let [name, hash] =
            [program.file_name().unwrap().to_str(), summary["state_hash"].as_str()].map(Option::unwrap);
        assert!(row.contains(name) && row.contains(hash), "{name} {hash}: {row}");
    }
    let experiment = file("swept-wrong.toml", text([names[0], "no.hex"]).as_bytes());
    let (code, _, err) = baudbot(&["sweep", experiment.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(code == 2 && err.contains("fields[0]") && err.contains("no.hex: there is no such file"), "{err}");
}

#[test]
fn a_project_for_a_microcontroller_is_what_its_readme_says() {
    for (language, sketch) in [("arduino", "rover.ino"), ("c", "rover.c")] {
        let folder = place(&format!("firmware-{language}")).join("rover");
        let _ = fs::remove_dir_all(&folder);
        good(&["new", "firmware", folder.to_str().unwrap(), "--lang", language]);
        let readme = fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(readme.contains(sketch) && !readme.contains('{'), "{readme}");
        assert!(folder.join(sketch).is_file());
        let makefile = fs::read_to_string(folder.join("Makefile")).unwrap();
        assert!(makefile.contains("NAME = rover") && !makefile.contains("{name}"), "{makefile}");
        // The error for a program that is not built yet names the file.
        let (code, _, err) = baudbot(&["run", folder.join("robot.toml").to_str().unwrap()]);
        assert!(code == 2 && err.contains("rover.hex: there is no such file"), "{err}");
        let (code, _, err) = baudbot(&["new", "firmware", folder.to_str().unwrap()]);
        assert!(code == 2 && err.contains("already exists"), "{err}");
    }
}
