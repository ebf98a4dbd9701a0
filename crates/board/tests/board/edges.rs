//! The record of a logic analyser on the pins.

use std::f64::consts::TAU;

use baudbot_avr::usart::Frame;
use baudbot_avr::{Pin, Port};
use baudbot_board::{
    Board, BridgeKind, By, Channels, Decay, Edge, Encoder, Kind, Level, Pull, Reflectance, RoundsOver, Seen,
    Switch, Voltage, Wheel, Wiring,
};

use crate::board::asm::{Asm, data, io};
use crate::board::state::{restless, world_at};
use crate::board::world::{MS, World, board, board_with_file};

const MOTOR: Kind = Kind::Bridge(BridgeKind::Directed { decay: Decay::Brake, drop_v: 0.1 });

fn pin(port: Port, bit: u8) -> Pin {
    Pin::new(port, bit).unwrap()
}

fn edges(board: &Board) -> Vec<Edge> {
    let (lost, edges) = board.edges().unwrap().since(0);
    assert_eq!(lost, 0);
    edges.copied().collect()
}

/// The levels of a pin, the first one of all among them.
fn levels(board: &Board, of: Pin) -> Vec<(u64, Level, By)> {
    let of_pin = |edge: Edge| match edge.seen {
        Seen::Level { pin, level, by } if pin == of => Some((edge.at_ns, level, by)),
        Seen::Level { .. }
        | Seen::Converted { .. }
        | Seen::Sends(_)
        | Seen::Receives(_)
        | Seen::Round(_)
        | Seen::Shape { .. } => None,
    };
    edges(board).into_iter().filter_map(of_pin).collect()
}

#[test]
fn an_analyser_changes_no_bit_and_is_not_saved() {
    let mut plain = restless();
    let mut watched = restless();
    watched.keep_edges(Some(0));
    for step in 0..60 {
        for board in [&mut plain, &mut watched] {
            board.run_until((step + 1) * MS, &mut world_at(step));
        }
        assert_eq!(
            postcard::to_allocvec(&plain).unwrap(),
            postcard::to_allocvec(&watched).unwrap(),
            "step {step}"
        );
        assert!(plain == watched, "step {step}");
    }
    assert!(watched.edges().unwrap().total() > 100);
    assert!(plain.edges().is_none());
    let loaded: Board = postcard::from_bytes(&postcard::to_allocvec(&watched).unwrap()).unwrap();
    assert!(loaded.edges().is_none());
    watched.keep_edges(None);
    assert!(watched.edges().is_none());
}

#[test]
fn edges_are_in_the_order_of_time() {
    let mut board = restless();
    board.keep_edges(Some(7));
    for step in 0..60 {
        board.run_until((step + 1) * MS, &mut world_at(step));
    }
    let instants: Vec<u64> = edges(&board).iter().map(|edge| edge.at_ns).collect();
    assert!(instants.is_sorted());
    assert_eq!(instants[0], 7, "the first levels of all");
}

#[test]
fn a_signal_that_is_told_by_its_shape_has_its_frequency_and_duty() {
    let mut program = Asm::new();
    // Fast PWM on OC0A by 64: high for 64 of 256 counts.
    program.sbi(io::DDRD, 6).store(data::OCR0A, 63).store(data::TCCR0A, 0x83).store(data::TCCR0B, 3).stay();
    let wiring =
        Wiring::builder().part("left", MOTOR).connect("6", "left.pwm").connect("VCC", "left.direction");
    let mut board = board(&program, wiring);
    board.keep_edges(Some(0));
    let mut world = World::default();
    for step in 1..=20 {
        board.run_until(step * MS, &mut world);
    }
    // A world that is loaded has no analyser; one that is fitted again goes on with the shape.
    let mut loaded: Board = postcard::from_bytes(&postcard::to_allocvec(&board).unwrap()).unwrap();
    loaded.keep_edges(Some(0));
    loaded.run_until(40 * MS, &mut world);
    for board in [&board, &loaded] {
        let drawn: Vec<_> =
            levels(board, pin(Port::D, 6)).into_iter().filter(|&(_, _, by)| by == By::Shape).collect();
        assert!(drawn.len() >= 36, "{drawn:?}");
        for pair in drawn.windows(2) {
            let (from, level, _) = pair[0];
            assert_eq!(pair[1].0 - from, if level == Level::High { 256_000 } else { 768_000 }, "{pair:?}");
            assert_ne!(pair[1].1, level);
        }
    }
}

#[test]
fn edges_of_a_program_are_at_their_cycles() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 5);
    let again = program.here();
    // 2 cycles of SBI or CBI, 4 * 100 of the pause and its own, RJMP 2.
    program.sbi(io::PIND, 0).sbi(io::PINB, 5).delay(100).rjmp(again);
    let mut board = board(&program, Wiring::builder());
    board.keep_edges(Some(0));
    board.run_until(2 * MS, &mut World::default());
    let seen = levels(&board, pin(Port::B, 5));
    assert_eq!((seen[0].1, seen[1].1, seen[2].1), (Level::Open, Level::Low, Level::High));
    let distances: Vec<u64> = seen[2..].windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    assert!(distances.len() > 60);
    assert!(distances.iter().all(|&ns| ns.abs_diff(distances[0]) <= 1), "{distances:?}");
    assert!(seen.iter().all(|&(_, _, by)| by == By::Chip));
}

/// The bytes that levels mean, by the middles of their bits.
fn decode(levels: &[(u64, Level, By)], bit_ns: u64, until_ns: u64) -> Vec<u8> {
    let at = |ns: u64| levels.iter().take_while(|level| level.0 <= ns).last().unwrap().1 == Level::High;
    let (mut bytes, mut now) = (Vec::new(), levels[0].0);
    while let Some(start) =
        levels.iter().find(|level| level.0 >= now && level.1 == Level::Low && level.2 == By::Character)
        && start.0 + 10 * bit_ns <= until_ns
    {
        let middle = |bit: u64| at(start.0 + bit_ns * bit + bit_ns / 2);
        bytes.push((0..8).fold(0, |byte, bit| byte | u8::from(middle(bit + 1)) << bit));
        assert!(middle(9), "a stop bit");
        now = start.0 + bit_ns * 19 / 2;
    }
    bytes
}

#[test]
fn characters_are_bits_on_their_pins() {
    let mut board = board_with_file("echo_9600.hex", Wiring::builder());
    board.keep_edges(Some(0));
    let mut world = World::default();
    board.run_until(MS, &mut world);
    for byte in b'a'..=b'z' {
        board.receive(Frame::byte(byte), board.now_ns(), 9600).unwrap();
        board.run_until(board.now_ns() + 2 * MS, &mut world);
    }
    board.run_until(board.now_ns() + 3 * MS, &mut world);
    let [received, sent] = [0, 1].map(|bit| levels(&board, pin(Port::D, bit)));
    assert_eq!(decode(&received, 104_167, board.now_ns()), (b'a'..=b'z').collect::<Vec<_>>());
    assert_eq!(decode(&sent, 104_000, board.now_ns()), (b'b'..=b'{').collect::<Vec<_>>());
    let begun = |edge: &Edge| match edge.seen {
        Seen::Sends(Some(frame)) => Some(frame.data() as u8),
        Seen::Level { .. }
        | Seen::Converted { .. }
        | Seen::Sends(None)
        | Seen::Receives(_)
        | Seen::Round(_)
        | Seen::Shape { .. } => None,
    };
    assert_eq!(edges(&board).iter().filter_map(begun).collect::<Vec<_>>(), (b'b'..=b'{').collect::<Vec<_>>());
    let ends = |edge: &&Edge| matches!(edge.seen, Seen::Sends(None));
    assert_eq!(edges(&board).iter().filter(ends).count(), 26);
}

#[test]
fn a_reset_breaks_a_character_off() {
    let mut board = board_with_file("echo_9600.hex", Wiring::builder());
    board.keep_edges(Some(0));
    let mut world = World::default();
    board.run_until(MS, &mut world);
    board.receive(Frame::byte(b'a'), MS, 9600).unwrap();
    // The chip answers in the stop bit of what came, and is at its second bit.
    board.run_until(MS + 1_200_000, &mut world);
    assert_eq!(levels(&board, pin(Port::D, 1)).last().unwrap().1, Level::Low);
    board.reset();
    board.keep_edges(Some(5 * MS));
    board.run_until(MS + 1_300_000, &mut world);
    let seen = levels(&board, pin(Port::D, 1));
    let reset = seen.iter().rposition(|&(_, level, _)| level == Level::Open).unwrap();
    assert!(seen[reset].0 < 3 * MS, "by the origin before: {seen:?}");
    assert!(seen[reset + 1..].iter().all(|&(_, _, by)| by == By::Chip), "{seen:?}");
    assert!(matches!(
        edges(&board).iter().rfind(|edge| matches!(edge.seen, Seen::Sends(_))).unwrap().seen,
        Seen::Sends(None)
    ));
}

#[test]
fn parts_are_seen_at_their_instants() {
    let mut program = Asm::new();
    program.stay();
    let encoder = Encoder { channels: Channels::Single, counts_per_turn: 100 };
    let wiring = Wiring::builder().part("wheel", Kind::Encoder(encoder)).connect("2", "wheel");
    let mut board = board(&program, wiring);
    board.keep_edges(Some(0));
    // A turn in a second.
    for step in 0..200 {
        let wheel = Wheel { angle_rad: TAU * step as f64 / 1000.0, rate_rad_s: TAU };
        board.run_until((step + 1) * MS, &mut World { wheel, ..World::default() });
    }
    let seen: Vec<_> =
        levels(&board, pin(Port::D, 2)).into_iter().filter(|&(_, _, by)| by == By::Part).collect();
    assert!(seen.len() > 15, "{seen:?}");
    let distances: Vec<u64> = seen[1..].windows(2).map(|pair| pair[1].0 - pair[0].0).collect();
    assert!(distances.iter().all(|ns| ns.abs_diff(distances[0]) < 200), "{distances:?}");
}

#[test]
fn wires_are_low_high_open_or_shorted() {
    let mut program = Asm::new();
    // Pin 7 is an output that is high, and low from then on; 6 has its pull-up; 5 is not connected; A1 charges a
    // capacitor.
    program.sbi(io::DDRD, 7).sbi(io::PORTD, 7).sbi(io::PORTD, 6).sbi(io::DDRC, 1).sbi(io::PORTC, 1);
    program.delay(8000).cbi(io::PORTD, 7).stay();
    let wiring = Wiring::builder()
        .part("whisker", Kind::Switch(Switch { pull: Pull::External, bounce_us: 0, seed: 3 }))
        .part("line", Kind::Reflectance(Reflectance))
        .connect("7", "whisker")
        .connect("A1", "line");
    let mut board = board(&program, wiring);
    board.keep_edges(Some(0));
    let mut world = World { pressed: true, discharge_ns: 1000, ..World::default() };
    board.run_until(MS, &mut world);
    let last = |board: &Board, pin| levels(board, pin).last().unwrap().1;
    let now = |board: &Board| {
        [(Port::D, 7), (Port::D, 6), (Port::D, 5), (Port::C, 1)]
            .map(|(port, bit)| last(board, pin(port, bit)))
    };
    assert_eq!(now(&board), [Level::Short, Level::High, Level::Open, Level::High]);
    // Low on both sides, and then released: the resistor yields.
    board.run_until(5 * MS, &mut world);
    assert_eq!(last(&board, pin(Port::D, 7)), Level::Low);
    world.pressed = false;
    board.run_until(6 * MS, &mut world);
    assert_eq!(last(&board, pin(Port::D, 7)), Level::Low);
}

#[test]
fn conversions_have_their_channel_and_result() {
    let mut program = Asm::new();
    program.store(data::ADMUX, 0x42).store(data::ADCSRA, 0xC7).stay();
    let wiring =
        Wiring::builder().part("light", Kind::Voltage(Voltage { ratio: 0.5 })).connect("A2", "light");
    let mut board = board(&program, wiring);
    board.keep_edges(Some(0));
    board.run_until(MS, &mut World { volts: 5.0, ..World::default() });
    let conversions: Vec<_> =
        edges(&board).into_iter().filter(|edge| matches!(edge.seen, Seen::Converted { .. })).collect();
    let [Edge { at_ns, seen }] = conversions[..] else { panic!("{conversions:?}") };
    assert_eq!(seen, Seen::Converted { channel: 2, result: 512 });
    // The first sample is 13.5 cycles of 8 µs behind its start.
    assert!(at_ns.abs_diff(108_000) < 10_000, "{at_ns}");
}

#[test]
fn rounds_of_the_main_loop_are_edges_at_their_cycles() {
    let mut program = Asm::new();
    program.sbi(io::DDRB, 5);
    let again = program.here();
    program.sbi(io::PINB, 5).delay(300).rjmp(again);
    let mut board = board(&program, Wiring::builder());
    board.keep_edges(Some(0));
    board.run_until(10 * MS, &mut World::default());
    let moved: Vec<u64> = levels(&board, pin(Port::B, 5)).iter().skip(3).map(|level| level.0).collect();
    let begun: Vec<u64> = edges(&board)
        .iter()
        .filter(|edge| matches!(edge.seen, Seen::Round(_)))
        .map(|edge| edge.at_ns)
        .collect();
    assert!(begun.len() > 60, "{}", begun.len());
    // `SBI` inverts the pin in two cycles of 62.5 ns; the first jump back has made the loop, and the second ends a round of it.
    for (begun, moved) in begun.iter().zip(&moved[1..]) {
        assert!(moved - begun == 125, "{begun} {moved}");
    }
    assert!(begun.windows(2).all(|pair| pair[1] - pair[0] > 62_500));
    let over = rounds_over(&board);
    for (pair, over) in begun.windows(2).zip(&over[1..]) {
        assert_eq!((over.short, over.since_ns), (0, pair[0]), "{over:?}");
        // Both instants are rounded down to nanoseconds.
        assert!((over.cycles * 125 / 2).abs_diff(pair[1] - pair[0]) <= 1, "{over:?}");
    }
    let rounds = board.rounds().unwrap();
    assert!(over.iter().all(|over| over.head == rounds.head()));
    assert_eq!((rounds.count(), rounds.least()), (begun.len() as u64, rounds.most()));
    assert_eq!(board.share_asleep(), Some(0.0));
    board.keep_rounds(false);
    assert_eq!((board.rounds(), board.share_asleep()), (None, None));
}

fn rounds_over(board: &Board) -> Vec<RoundsOver> {
    let over = |edge: Edge| if let Seen::Round(over) = edge.seen { Some(over) } else { None };
    edges(board).into_iter().filter_map(over).collect()
}

#[test]
fn short_rounds_leave_room_for_other_edges() {
    let mut program = Asm::new();
    program.stay();
    let mut board = board(&program, Wiring::builder());
    board.keep_edges(Some(0));
    board.run_until(10 * MS, &mut World::default());
    let begun = edges(&board).iter().filter(|edge| matches!(edge.seen, Seen::Round(_))).count();
    assert!((150..=160).contains(&begun), "{begun} of 80,000 rounds are drawn");
    let rounds = board.rounds().unwrap();
    assert!(rounds.most() == 2 && rounds.count() > 79_000, "{rounds:?}");
    let over = rounds_over(&board);
    let told: u64 = over.iter().map(|over| u64::from(over.short) + 1).sum();
    assert!(rounds.count() - told < 500, "the last ones are not told yet: {told} of {}", rounds.count());
    assert!(over.iter().all(|over| over.cycles == 2 && over.short_cycles == 2 * over.short), "{over:?}");
}
