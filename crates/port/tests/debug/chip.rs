//! The commands of a debugger for a chip.

use std::time::{Duration, Instant};

use super::client::Client;
use super::running::Running;

/// ldi r16, 0x12; ldi r17, 0x34; add r16, r17; sts 0x0100, r16; inc r18; sts 0x0101, r18; rjmp .-8
const PROGRAM: [u16; 9] = [0xE102, 0xE314, 0x0F01, 0x9300, 0x0100, 0x9523, 0x9320, 0x0101, 0xCFFC];

/// Byte addresses of three of its instructions.
const ADD: u32 = 4;
const STORE: u32 = 6;
const INC: u32 = 10;

#[test]
fn a_program_is_stopped_at_an_address_and_stepped_through() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    assert!(client.ask("?").starts_with("T05"));
    assert_eq!(client.pc(), 0);
    for kind in ["Z0", "Z1"] {
        assert_eq!(client.ask(&format!("{kind},{ADD:x},2")), "OK");
    }
    let stop = client.ask("c");
    assert!(stop.starts_with("T05") && stop.contains("swbreak"), "{stop}");
    assert_eq!((client.pc(), client.register(16), client.register(17)), (ADD, 0x12, 0x34));
    assert_eq!(client.register(33), 0x08FF, "SP");
    // A step leaves the breakpoint at which it begins.
    for (pc, r16, cycles) in [(STORE, 0x46, 1), (INC, 0x46, 2)] {
        let before = cycles_of(&mut client);
        assert_eq!(client.ask("s").get(1..3), Some("05"));
        assert_eq!((client.pc(), client.register(16)), (pc, r16));
        assert_eq!(cycles_of(&mut client) - before, cycles);
    }
    assert_eq!(client.memory(0x80_0100, 1), [0x46]);
    // All registers at once: r18 is 0, the flags are clear, then SP and PC.
    let all = client.ask("g");
    assert_eq!(all.len(), 78);
    assert_eq!(&all[32..38], "463400");
    assert_eq!(&all[64..], "00ff080a000000");
    running.stands();
}

fn cycles_of(client: &mut Client) -> u64 {
    let text = client.monitor("time");
    text.split(' ').nth_back(4).and_then(|number| number.parse().ok()).unwrap_or_else(|| panic!("{text}"))
}

#[test]
fn a_breakpoint_that_is_removed_does_not_stop() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    for kind in ["0", "1"] {
        assert_eq!(client.ask(&format!("Z{kind},{INC:x},2")), "OK");
        let stop = client.ask("c");
        assert!(stop.contains(if kind == "0" { "swbreak" } else { "hwbreak" }), "{stop}");
        assert_eq!(client.ask(&format!("z{kind},{INC:x},2")), "OK");
        assert_eq!(client.ask("s").get(1..3), Some("05"));
    }
    client.say("c");
    running.goes_on();
    // Breakpoints are in the flash, at instructions.
    client.interrupt();
    client.answer();
    for bad in ["Z0,3,2", "Z0,8000,2", "Z1,800100,2"] {
        assert_ne!(client.ask(bad), "OK", "{bad}");
    }
}

#[test]
fn registers_and_memories_are_written_and_the_program_goes_on_with_them() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    client.ask(&format!("Z0,{STORE:x},2"));
    client.ask("c");
    assert_eq!(client.ask("P10=aa"), "OK");
    assert_eq!(client.ask("P20=81"), "OK");
    assert_eq!(client.ask("P21=f007"), "OK");
    assert_eq!((client.register(16), client.register(32), client.register(33)), (0xAA, 0x81, 0x07F0));
    client.ask("s");
    assert_eq!(client.memory(0x80_0100, 1), [0xAA]);
    assert_eq!(client.ask("M8001fe,3:010203"), "OK");
    assert_eq!(client.memory(0x80_01FE, 4), [1, 2, 3, 0]);
    // dec r18 in place of inc r18, a byte at a time.
    assert_eq!(client.ask("M00000a,1:2a"), "OK");
    assert_eq!(client.memory(8, 4), [0x00, 0x01, 0x2A, 0x95]);
    client.ask("s");
    assert_eq!(client.register(18), 0xFF);
    assert_eq!(client.ask("M810010,2:beef"), "OK");
    assert_eq!(client.memory(0x81_000F, 4), [0xFF, 0xBE, 0xEF, 0xFF]);
    // A jump: back to the start.
    assert_eq!(client.ask("P22=00000000"), "OK");
    client.ask("s");
    assert_eq!((client.pc(), client.register(16)), (2, 0x12));
    let all = client.ask("g");
    assert_eq!(client.ask(&format!("G77{}", &all[2..])), "OK");
    assert_eq!((client.register(0), client.pc()), (0x77, 2));
    client.ask("D");
    let board = running.end();
    assert_eq!(board.chip().eeprom()[16..18], [0xBE, 0xEF]);
}

#[test]
fn memory_ends_where_it_ends() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    assert_eq!(client.memory(0x7FFE, 8).len(), 2, "flash");
    assert_eq!(client.memory(0x80_08FE, 8).len(), 2, "SRAM");
    assert_eq!(client.memory(0x81_03FE, 8).len(), 2, "EEPROM");
    for bad in [
        "m8000,1",
        "m800900,1",
        "m810400,1",
        "m820000,3",
        "mffffffff,2",
        "M7fff,2:0000",
        "M8008ff,2:0000",
        "M8103ff,2:0000",
        "M830000,1:00",
    ] {
        assert_eq!(client.ask(bad), "E0e", "{bad}");
    }
    assert_eq!(client.ask("m800100,0"), "", "nothing is asked for");
}

#[test]
fn a_watchpoint_stops_behind_the_instruction_that_writes() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    assert_eq!(client.ask("Z2,800101,1"), "OK");
    for value in 1..4 {
        let stop = client.ask("c");
        assert!(stop.contains("watch:800101"), "{stop}");
        assert_eq!((client.pc(), client.memory(0x80_0101, 1)), (16, vec![value]));
    }
    assert_eq!(client.ask("z2,800101,1"), "OK");
    client.say("c");
    running.goes_on();
    client.interrupt();
    client.answer();
    // Only writes, and only in the static memory.
    for bad in ["Z3,800101,1", "Z4,800101,1", "Z2,800025,1", "Z2,8008ff,2", "Z2,100,1"] {
        assert_ne!(client.ask(bad), "OK", "{bad}");
    }
}

#[test]
fn ctrl_c_stops_a_program_that_runs_and_one_that_sleeps() {
    // ldi r16, SM1 | SE; out SMCR, r16; sleep; rjmp .-4: power-down, for ever.
    let sleeps = [0xE005, 0xBF03, 0x9588, 0xCFFE];
    for program in [&PROGRAM[..], &sleeps[..]] {
        let running = Running::start(program);
        let mut client = Client::connect(running.address);
        running.stands();
        client.say("c");
        running.goes_on();
        client.interrupt();
        let stop = client.answer();
        assert!(stop.starts_with("S02") || stop.starts_with("T02"), "{stop}");
        running.stands();
        client.say("c");
        running.goes_on();
    }
}

#[test]
fn break_stops_as_a_breakpoint_does() {
    let running = Running::start(&[0x0000, 0x9598, 0xCFFD]);
    let mut client = Client::connect(running.address);
    for _ in 0..2 {
        assert_eq!(client.ask("c").get(1..3), Some("05"));
        assert_eq!(client.pc(), 4);
    }
}

#[test]
fn a_reset_begins_anew_and_time_goes_on() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    client.ask("Z0,a,2");
    client.ask("c");
    let before = cycles_of(&mut client);
    client.monitor("reset");
    assert_eq!((client.pc(), client.register(33)), (0, 0x08FF));
    client.ask("c");
    assert_eq!(client.pc(), INC);
    assert!(cycles_of(&mut client) > before);
    assert!(client.monitor("help").contains("monitor reset"));
}

#[test]
fn who_detaches_or_kills_or_is_gone_lets_the_chip_run_and_another_may_come() {
    let running = Running::start(&PROGRAM);
    for goodbye in ["D", "k", ""] {
        let mut client = Client::connect(running.address);
        running.stands();
        assert_eq!(client.ask("Z0,a,2"), "OK");
        match goodbye {
            "D" => assert_eq!(client.ask(goodbye), "OK"),
            "k" => client.say(goodbye),
            _ => {}
        }
        drop(client);
        // The debugger's breakpoints are gone with it.
        running.goes_on();
    }
}

#[test]
fn who_debugs_is_told_when_the_world_is_over() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    client.say("c");
    running.goes_on();
    running.end();
    assert_eq!(client.answer(), "W00");
}

#[test]
fn nobody_is_waited_for_when_the_program_is_to_end() {
    let running = Running::start(&PROGRAM);
    running.stands();
    let begun = Instant::now();
    running.give_up();
    running.goes_on();
    // The world stands about where it stood when the program ends: each millisecond takes ten.
    assert!(begun.elapsed() >= Duration::from_millis(90), "{:?}", begun.elapsed());

    let running = Running::start(&PROGRAM);
    let client = Client::connect(running.address);
    running.stands();
    running.give_up();
    running.goes_on();
    drop(client);
}

#[test]
fn garbage_ends_a_session_and_not_the_world() {
    let running = Running::start(&PROGRAM);
    let mut client = Client::connect(running.address);
    client.shout("m,,,");
    running.goes_on();
    Client::connect(running.address);
}
