//! An e-puck that is asked by letters, in text and in bytes: a program at its serial port, a brain of messages, any bytes.

use std::f64::consts::TAU;

use baudbot_sim::model::PortUse;
use baudbot_sim::{Input, Intervention, World};

use crate::common::{command, refusal, world};

/// An e-puck on a cable that heads for a wall 0.3 m before it, without noise.
fn e_puck(more: &str) -> World {
    world(&format!(
        "step_ms = 1.0\nnoise = false\n[[arena.polygons]]\nname = \"wall\"\n\
         points_m = [[0.3, -1.0], [0.4, -1.0], [0.4, 1.0], [0.3, 1.0]]\n\
         [[robots]]\nname = \"e\"\npreset = \"e-puck\"\nlink = {{ preset = \"uart-115200\" }}\n{more}"
    ))
}

/// A program that has opened the serial port.
struct Program {
    world: World,
    ticks: u64,
}

impl Program {
    fn open(mut world: World) -> Self {
        world.intervene(&Intervention::OpenPort { robot: "e".into(), port_use: PortUse::Open }).unwrap();
        Self { world, ticks: 0 }
    }

    /// Writes these bytes, and waits for so many in answer, or for so many ticks.
    fn ask(&mut self, said: &[u8], bytes: usize, ticks: u64) -> Vec<u8> {
        let mut heard = Vec::new();
        for tick in 0..ticks {
            let turn = self.world.begin()[0];
            heard.extend_from_slice(self.world.robot(0).unread());
            self.world.finish(&[Input { robot: 0, at: turn.at, bytes: if tick == 0 { said } else { &[] } }]);
            self.ticks += 1;
            if bytes > 0 && heard.len() >= bytes {
                break;
            }
        }
        heard
    }

    /// The line that answers a line.
    fn line(&mut self, said: &str) -> String {
        let mut heard = self.ask(said.as_bytes(), 1, 100);
        while !heard.ends_with(b"\n") {
            assert!(self.ticks < 60_000, "{:?}", String::from_utf8_lossy(&heard));
            heard.extend(self.ask(b"", 1, 100));
        }
        String::from_utf8(heard).unwrap()
    }

    /// The numbers of an answer.
    fn numbers(&mut self, said: &str) -> Vec<i16> {
        self.line(said).trim_end().split(',').skip(1).map(|number| number.parse().unwrap()).collect()
    }
}

#[test]
fn a_program_drives_an_e_puck_to_a_wall_and_reads_its_sensors() {
    let mut program = Program::open(e_puck(""));
    program.ask(b"", 0, 30);
    assert_eq!(program.numbers("N\r").len(), 8);
    assert_eq!(program.line("D,300,300\r"), "d\r\n");
    // The table of its sensors ends at 70 mm.
    while program.numbers("N\r")[0] < 400 {
        assert!(program.ticks < 30_000, "it sees no wall");
    }
    assert_eq!(program.line("s\r\n"), "s\r\n");
    assert_eq!(program.line("E\r"), "e,300,300\r\n");
    program.ask(b"", 0, 100);
    let steps = program.numbers("Q\r");
    let counters = program.world.robot(0).counters();
    let asked_m = f64::from(steps[0]) / 1000.0 * TAU * 0.0205;
    // The rotors lose some steps while they start.
    let lost_m = asked_m - counters.distance_m;
    assert!(steps[0] == steps[1] && lost_m.abs() < 0.004, "{steps:?} and {}", counters.distance_m);
    assert!((0.2..0.3).contains(&counters.distance_m), "{}", counters.distance_m);
    assert_eq!(program.world.robot(0).signals().left, 0.0);

    // In bytes: the same numbers at once.
    let near = program.numbers("N\r");
    let heard = program.ask(&[b'N'.wrapping_neg(), b'Q'.wrapping_neg(), 0], 20, 100);
    let (words, _) = heard.as_chunks();
    let words: Vec<_> = words.iter().copied().map(i16::from_le_bytes).collect();
    assert_eq!(words, [near, steps].concat());
    let drive = [b'D'.wrapping_neg(), 44, 1, 0xd4, 0xfe, b'E'.wrapping_neg(), 0];
    assert_eq!(program.ask(&drive, 4, 100), [44, 1, 0xd4, 0xfe]);
    program.ask(b"", 0, 300);
    assert!(program.world.robot(0).motion().turn_rate_rad_s < -1.0, "{:?}", program.world.robot(0).motion());
    assert!(program.ask(b"K\r", 87, 100).ends_with(b"k, Calibration finished\r\n"));
    assert_eq!(program.ask(b"P,0,-1\rS\r", 6, 100), b"p\r\ns\r\n");
    assert_eq!(program.line("z\r"), "z,Command not found\r\n");
    let robot = program.world.robot(0);
    assert_eq!((robot.downlink().bad_messages, robot.downlink().overrun_bytes), (1, 0));
}

#[test]
fn what_is_written_at_once_is_answered_one_by_one() {
    for more in ["", "microcontroller = { obeying_us = 900.0 }\n"] {
        let mut program = Program::open(e_puck(more));
        let said = b"D,1,2\rE\rC\rD,3\rE\rP,9,9\rX\rQ\r";
        let heard = String::from_utf8(program.ask(said, 0, 600)).unwrap();
        assert_eq!(
            heard, "d\r\ne,1,2\r\nc,3\r\nd\r\ne,3,2\r\np\r\nz,Command not found\r\nq,9,9\r\n",
            "{more}"
        );
    }
}

#[test]
fn a_brain_of_messages_drives_and_has_readings_of_its_proximity_sensors_and_steps() {
    let mut world = e_puck("sensors.compass = { kind = \"compass\", bits = 10, period_ms = 10 }\n");
    let mut readable = [0; 10];
    let mut speaks = true;
    for _ in 0..3000 {
        let turn = world.begin()[0];
        let robot = world.robot(0);
        let said = command(robot.spec(), 0.3, 0.3);
        assert_eq!(said, b"D,300,300\rQ\rN\r");
        let names: Vec<_> = robot.spec().sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        assert_eq!((names.len(), names.contains(&"compass")), (10, true));
        for (name, (reading, count)) in names.iter().zip(robot.readings().iter().zip(&mut readable)) {
            assert!(*name != "compass" || !reading.readable, "it has no letter");
            *count += u64::from(reading.readable);
            speaks |= reading.readable;
        }
        world.finish(&[Input { robot: 0, at: turn.at, bytes: if speaks { &said } else { &[] } }]);
        speaks = false;
    }
    let robot = world.robot(0);
    let least = readable.iter().filter(|count| **count > 0).min().unwrap();
    assert!(readable.iter().filter(|count| **count > 0).count() == 9 && *least > 300, "{readable:?}");
    let steps = robot.readings().iter().find(|reading| reading.values.len() == 2).unwrap();
    assert!(steps.values[0] > 500.0 && steps.values[0] == steps.values[1], "{steps:?}");
    assert_eq!((robot.uplink().bad_messages, robot.downlink().bad_messages), (0, 0));
    assert!(robot.commands() > 300, "{}", robot.commands());
}

#[test]
fn a_world_between_a_command_and_its_answer_can_be_kept_and_goes_on_alike() {
    let mut program = Program::open(e_puck(""));
    program.ask(b"D,100,50\rJ,0,20,20,4\rN\rQ", 0, 2);
    let saved = program.world.save();
    let loaded = World::load(program.world.origin().clone(), &saved, program.world.hash()).unwrap();
    let mut again = Program { world: loaded, ticks: 0 };
    let rest = program.ask(b"\rI\r", 0, 50);
    assert!(rest.ends_with(b"i,0,20,20,4,400\r\n"), "{:?}", String::from_utf8_lossy(&rest));
    assert_eq!(again.ask(b"\rI\r", 0, 50), rest);
    assert_eq!(program.world.hash(), again.world.hash());
}

#[test]
fn any_bytes_do_no_harm_and_what_is_kept_does_not_grow() {
    let mut program = Program::open(e_puck(""));
    let (mut state, mut largest) = (1_u32, 0);
    for tick in 0..400 {
        let said: Vec<u8> = (0..20)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let byte = (state >> 24) as u8;
                // Ends of lines and of letters are frequent.
                if byte & 7 == 0 { b"\r\0NQD"[usize::from(byte >> 3) % 5] } else { byte }
            })
            .collect();
        program.ask(&said, 0, 3);
        let saved = program.world.save().len();
        if tick < 200 {
            largest = largest.max(saved);
        }
        assert!(saved <= largest + 2048, "{saved} bytes after {largest} in tick {tick}");
    }
    // Zeros end letters and their data, and the end of a line the line.
    program.ask(&[0; 40], 0, 200);
    let heard = program.ask(b"\rC\r", 0, 200);
    assert!(heard.ends_with(b"c,3\r\n"), "{:?}", String::from_utf8_lossy(&heard));
}

#[test]
fn robots_that_it_cannot_speak_of_are_refused() {
    let toml = |more: &str| format!("[[robots]]\nname = \"e\"\npreset = \"e-puck\"\n{more}");
    for (more, problem) in [
        (
            "firmware.mode = \"stream\"",
            "robots[0].firmware.mode: must be \"poll\": the asercom protocol answers when asked; to stream, take \
             `protocol` = \"framed\"",
        ),
        ("firmware.ages = true", "robots[0].firmware.ages: the asercom protocol carries no ages"),
        (
            "actuators.lamp = { kind = \"lamp\", intensity_cd = 1.0 }",
            "robots[0].firmware.protocol: \"asercom\" has no command for actuators besides the wheels, and there are 1; \
             take another protocol, or leave them out",
        ),
        (
            "sensors.compass = { kind = \"compass\" }",
            "robots[0].firmware.protocol: \"asercom\" sends whole numbers; give sensor `compass` a number of `bits`",
        ),
        (
            "sensors.ir_0.bits = 16",
            "robots[0].firmware.protocol: \"asercom\" sends numbers of 16 bits; give sensor `ir_0` at most 15 `bits`",
        ),
        (
            "sensors.steps.bits = 32",
            "robots[0].firmware.protocol: \"asercom\" sends numbers of 16 bits; give sensor `steps` at most 16 `bits`",
        ),
    ] {
        assert_eq!(refusal(&toml(more)), problem);
    }
}
