use std::vec::Vec;

use super::*;

const CLOCK: Clock = Clock::new(0);
const RECEIVER_AND_TRANSMITTER: u8 = RECEIVER_ON | TRANSMITTER_ON;

/// A USART with this divisor and these formats: UCSR0A, UCSR0C and the ninth bit.
fn usart(ubrr: u8, control_a: u8, control_c: u8) -> Usart {
    let mut usart = Usart::new(0);
    usart.write(Register::Baud, ubrr, 0);
    usart.write(Register::ControlA, control_a, 0);
    usart.write(Register::ControlC, control_c, 0);
    usart.write(Register::ControlB, RECEIVER_AND_TRANSMITTER, 0);
    usart
}

/// Does all events before this cycle; the characters that have begun.
fn run(usart: &mut Usart, until: u64) -> Vec<Sent> {
    let mut sent = Vec::new();
    loop {
        let next = usart.next_event(&CLOCK);
        if next >= until {
            return sent;
        }
        sent.extend(usart.event(next, &CLOCK));
    }
}

const EIGHT_N_1: u8 = 0x06;
const EIGHT_N_2: u8 = 0x0E;
const EIGHT_E_1: u8 = 0x26;

#[test]
fn characters_begin_and_end_right_to_the_cycle_with_each_divisor_and_format() {
    for ubrr in [103, 51, 16, 8] {
        for (double, samples) in [(0, 16), (DOUBLE_SPEED, 8)] {
            for (format, bits) in [(EIGHT_N_1, 10), (EIGHT_N_2, 11), (EIGHT_E_1, 11)] {
                let mut usart = usart(ubrr, double, format);
                let tick = u64::from(ubrr) + 1;
                // Three ticks and a cycle: the first tick after that is the fourth.
                let written = 3 * tick + 1;
                usart.write(Register::Data, 0x55, written);
                assert_eq!(usart.status() & EMPTY, 0);
                let sent = run(&mut usart, written + tick);
                assert_eq!((sent[0].start, sent[0].bit), (4 * tick, samples * tick));
                usart.write(Register::Data, 0xAA, written + tick);
                let end = 4 * tick + bits * samples * tick;
                let next = run(&mut usart, end + 1);
                assert_eq!(next[0].start, end, "the second character follows without a gap");
                assert_eq!(next[0].end(), end + bits * samples * tick);
                run(&mut usart, next[0].end());
                assert_eq!(usart.status() & SENT, 0);
                run(&mut usart, next[0].end() + 1);
                assert_eq!(usart.status() & (SENT | EMPTY), SENT | EMPTY);
            }
        }
    }
}

#[test]
fn a_character_that_finds_the_buffer_full_is_ignored() {
    let mut usart = usart(0, 0, EIGHT_N_1);
    for byte in [1, 2, 3] {
        usart.write(Register::Data, byte, 1);
        if byte == 1 {
            usart.event(1, &CLOCK);
        }
    }
    let sent = run(&mut usart, 1000);
    assert_eq!(sent.iter().map(|one| one.frame.data()).collect::<Vec<_>>(), [2]);
}

#[test]
fn frames_have_their_bits_in_the_order_of_the_line() {
    let levels =
        |frame: Frame| (0..u64::from(frame.bits())).map(|bit| u8::from(frame.level(bit))).collect::<Vec<_>>();
    assert_eq!(levels(Frame::byte(0x13)), [0, 1, 1, 0, 0, 1, 0, 0, 0, 1]);
    assert_eq!(levels(Frame::new(0x13, 5, Parity::Even, 2)), [0, 1, 1, 0, 0, 1, 1, 1, 1]);
    assert_eq!(levels(Frame::new(0x113, 9, Parity::Odd, 1)), [0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 1]);
}

/// UCSR0C for so many bits of data and parity together, and how many of them are data.
fn format(d: u8) -> (u8, u8, Parity) {
    let (parity, bits, setting) = if d == 9 { (Parity::Even, 0x20, 8) } else { (Parity::None, 0, d) };
    ((setting - 5) << 1 | bits, setting, parity)
}

/// Receives a character and the start bit of the next, and gives the status and the data. A bit has `cycles / bits` cycles;
/// the start bit begins `phase` cycles before a tick.
fn received(d: u8, double: bool, data: u16, (cycles, bits): (u64, u64), phase: u64) -> (u8, u8) {
    const TICK: u64 = 10;
    let (control_c, data_bits, parity) = format(d);
    let mut usart = usart(TICK as u8 - 1, if double { DOUBLE_SPEED } else { 0 }, control_c);
    let bit = BitLength::new(cycles as u32, bits as u32).unwrap();
    let start = 100 * TICK - phase;
    usart.put(0, Frame::new(data, data_bits, parity, 1), start, bit).unwrap();
    let next = start + bit.begin_of(u64::from(d) + 2);
    usart.put(0, Frame::new(0, data_bits, parity, 1), next, bit).unwrap();
    while usart.receiver.status() & RECEIVED == 0 {
        let next = usart.next_event(&CLOCK);
        assert_ne!(next, u64::MAX);
        usart.event(next, &CLOCK);
    }
    let status = usart.status() & (FRAME_ERROR | PARITY_ERROR);
    (status, usart.read(Register::Data))
}

/// Cases for D = 5 to 9 bits of data and parity, normal and double speed: D, double speed, samples of a bit S, first
/// and middle sample of the vote.
fn cases() -> impl Iterator<Item = (u8, bool, u64, u64, u64)> {
    (5..=9).flat_map(|d| [(d, false, 16, 8, 9), (d, true, 8, 4, 5)])
}

const PARTS: u64 = 1000;

#[test]
fn a_sender_within_the_limits_of_the_data_sheet_is_understood_at_each_phase() {
    for (d, double, s, first, middle) in cases() {
        let bits = u64::from(d);
        // A bit in ticks is S / R: with R_slow and with R_fast of the section Asynchronous Operational Range.
        let slow = (10 * PARTS * (s - 1 + bits * s + first), PARTS * (bits + 1));
        let fast = (10 * PARTS * ((bits + 1) * s + middle), PARTS * (bits + 2));
        for phase in 0..10 {
            for length in [slow, fast, (10 * s, 1)] {
                for data in [0x00, 0x15, 0x0A] {
                    let expected = (0, data as u8);
                    assert_eq!(
                        received(d, double, data, length, phase),
                        expected,
                        "D {d}, {s} samples, {length:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_sender_faster_than_r_fast_makes_frame_errors_at_the_worst_phase() {
    for (d, double, s, _, middle) in cases() {
        let bits = u64::from(d);
        let lengths = |ticks: u64| (10 * PARTS * ticks, PARTS * (bits + 2));
        let limit = (bits + 1) * s + middle;
        // Half a sample beyond the limit no phase is left at which the middle of the vote is high.
        let (cycles, parts) = lengths(limit);
        let beyond = (cycles - 2 * PARTS, parts);
        assert_eq!(received(d, double, 0x0A, beyond, 9).0 & FRAME_ERROR, FRAME_ERROR, "D {d}, {s} samples");
        assert_eq!(received(d, double, 0x0A, beyond, 0).0, 0, "D {d}, {s} samples: the best phase");
        assert_eq!(received(d, double, 0x0A, lengths(limit - 2), 0).0 & FRAME_ERROR, FRAME_ERROR);
    }
}

/// The data sheet's R_slow asks that the first sample of the vote is right. Two of three are enough, so the first errors come
/// one sample later.
#[test]
fn a_sender_slower_than_r_slow_by_one_sample_makes_frame_errors_at_the_worst_phase() {
    for (d, double, s, first, _) in cases() {
        let bits = u64::from(d);
        let length = |ticks: u64, more: u64| (10 * PARTS * ticks + more, PARTS * (bits + 1));
        let limit = s - 1 + bits * s + first;
        assert_eq!(received(d, double, 0, length(limit, 5 * PARTS), 0).0, 0, "D {d}, {s} samples");
        assert_eq!(received(d, double, 0, length(limit + 1, PARTS), 0).0, FRAME_ERROR, "D {d}, {s} samples");
        assert_eq!(
            received(d, double, 0, length(limit + 1, PARTS), 9).0,
            0,
            "D {d}, {s} samples: the best phase"
        );
    }
}

#[test]
fn errors_begin_where_the_data_sheet_says_as_the_senders_clock_is_swept() {
    // 8N1: with 16 samples from 95.36 % to 104.58 %, with 8 from 96.00 % to 103.90 %.
    for (double, slowest, fastest) in [(false, 9536, 10458), (true, 9600, 10390)] {
        let samples = if double { 8 } else { 16 };
        let errors: Vec<u64> = (9200..=10800)
            .filter(|rate| {
                (0..10).any(|phase| received(8, double, 0, (samples * 10 * 10_000, *rate), phase).0 != 0)
            })
            .collect();
        let last_slow = errors.iter().rev().find(|&&rate| rate < 10_000).unwrap();
        let first_fast = errors.iter().find(|&&rate| rate > 10_000).unwrap();
        assert!((first_fast - fastest) < 15, "{first_fast}");
        // One sample of 16 · 9 or 8 · 9 later than R_slow, see above.
        assert!(*last_slow < slowest && slowest - last_slow < 10_000 / samples / 9 + 5, "{last_slow}");
    }
}

#[test]
fn a_low_spike_of_less_than_half_a_bit_is_no_start_bit() {
    let mut usart = usart(9, 0, EIGHT_N_1);
    run(&mut usart, 1000);
    for (at, level) in [(1001, false), (1075, true)] {
        run(&mut usart, at);
        usart.set_pin(at, level);
    }
    run(&mut usart, 5000);
    assert_eq!(usart.status() & RECEIVED, 0);
    usart.set_pin(5000, false);
    run(&mut usart, 5090);
    usart.set_pin(5090, true);
    run(&mut usart, 10_000);
    assert_eq!((usart.status() & RECEIVED, usart.read(Register::Data)), (RECEIVED, 0xFF));
}

#[test]
fn a_line_that_stays_low_gives_one_character_with_a_frame_error() {
    let mut usart = usart(9, 0, EIGHT_N_1);
    run(&mut usart, 1000);
    usart.set_pin(1000, false);
    run(&mut usart, 100_000);
    assert_eq!(usart.status() & (RECEIVED | FRAME_ERROR | OVERRUN), RECEIVED | FRAME_ERROR);
    assert_eq!(usart.read(Register::Data), 0);
    assert_eq!(usart.status() & RECEIVED, 0);
}

#[test]
fn a_wrong_parity_is_told_with_its_character() {
    let mut usart = usart(9, 0, EIGHT_E_1);
    let bit = BitLength::new(160, 1).unwrap();
    usart.put(0, Frame::new(0x31, 8, Parity::Odd, 1), 1000, bit).unwrap();
    usart.put(0, Frame::new(0x31, 8, Parity::Even, 1), 3000, bit).unwrap();
    run(&mut usart, 10_000);
    assert_eq!(usart.status() & PARITY_ERROR, PARITY_ERROR);
    assert_eq!(usart.read(Register::Data), 0x31);
    assert_eq!(usart.status() & (RECEIVED | PARITY_ERROR), RECEIVED);
}

#[test]
fn two_characters_are_kept_a_third_waits_and_a_fourth_overruns_it() {
    let mut usart = usart(9, 0, EIGHT_N_1);
    let bit = BitLength::new(160, 1).unwrap();
    for byte in 1..=4 {
        usart.put(0, Frame::byte(byte), 1000 + 1600 * u64::from(byte), bit).unwrap();
    }
    run(&mut usart, 1000 + 1600 * 4);
    assert_eq!(usart.status() & OVERRUN, 0);
    run(&mut usart, 1000 + 1600 * 6);
    assert_eq!(usart.status() & OVERRUN, OVERRUN);
    let read: Vec<u8> = (0..3).map(|_| usart.read(Register::Data)).collect();
    assert_eq!(read, [1, 2, 4]);
    assert_eq!(usart.status() & (RECEIVED | OVERRUN), 0);
}

#[test]
fn nine_bits_have_the_ninth_in_ucsr0b() {
    let mut usart = usart(9, 0, EIGHT_N_1);
    usart.write(Register::ControlB, RECEIVER_AND_TRANSMITTER | NINE_BITS | 1, 0);
    usart.put(0, Frame::new(0x1A5, 9, Parity::None, 1), 1000, BitLength::new(160, 1).unwrap()).unwrap();
    usart.write(Register::Data, 0x5A, 10);
    let sent = run(&mut usart, 10_000);
    assert_eq!((sent[0].frame.data(), sent[0].frame.bits()), (0x15A, 11));
    assert_eq!(usart.read(Register::ControlB) & 2, 2);
    assert_eq!(usart.read(Register::Data), 0xA5);
}

#[test]
fn a_character_ends_if_the_program_makes_characters_shorter_while_it_comes() {
    for when in (1000..2680).step_by(40) {
        let mut usart = usart(9, 0, EIGHT_E_1);
        let bit = BitLength::new(160, 1).unwrap();
        usart.put(0, Frame::new(0x1FF, 9, Parity::Even, 2), 1000, bit).unwrap();
        usart.put(0, Frame::new(0x15, 5, Parity::None, 1), 4000, bit).unwrap();
        run(&mut usart, when);
        usart.write(Register::ControlC, 0, when);
        run(&mut usart, 6000);
        assert_eq!((usart.read(Register::Data), usart.read(Register::Data)), (0x1F, 0x15), "{when}");
    }
}

#[test]
fn in_multi_processor_mode_only_addresses_are_received() {
    let bit = BitLength::new(160, 1).unwrap();
    let mut usart = usart(9, MULTI_PROCESSOR, EIGHT_N_1);
    usart.write(Register::ControlB, RECEIVER_AND_TRANSMITTER | NINE_BITS, 0);
    for (at, data) in [(1000, 0x05), (3000, 0x105), (5000, 0x06), (7000, 0x07)] {
        usart.put(0, Frame::new(data, 9, Parity::None, 1), at, bit).unwrap();
    }
    run(&mut usart, 6900);
    assert_eq!((usart.read(Register::ControlB) & 2, usart.read(Register::Data)), (2, 0x05));
    assert_eq!(usart.status() & (RECEIVED | OVERRUN), 0);
    // The slave that is meant clears MPCM and takes the data.
    usart.write(Register::ControlA, 0, 6900);
    run(&mut usart, 10_000);
    assert_eq!((usart.read(Register::ControlB) & 2, usart.read(Register::Data)), (0, 0x07));
}

#[test]
fn in_multi_processor_mode_with_eight_bits_the_stop_bit_says_what_is_an_address() {
    let bit = BitLength::new(160, 1).unwrap();
    let mut usart = usart(9, MULTI_PROCESSOR, EIGHT_N_1);
    // The ninth bit is where the receiver has its stop bit.
    for (at, data) in [(1000, 0x05), (5000, 0x109)] {
        usart.put(0, Frame::new(data, 9, Parity::None, 1), at, bit).unwrap();
    }
    run(&mut usart, 10_000);
    assert_eq!((usart.status() & (RECEIVED | FRAME_ERROR), usart.read(Register::Data)), (RECEIVED, 0x09));
    assert_eq!(usart.status() & RECEIVED, 0);
}

#[test]
fn characters_that_would_overlap_or_are_too_many_are_refused() {
    let mut usart = usart(9, 0, EIGHT_N_1);
    let bit = BitLength::new(160, 1).unwrap();
    usart.put(0, Frame::byte(1), 1000, bit).unwrap();
    let occupied = usart.put(0, Frame::byte(1), 2599, bit);
    assert_eq!(occupied, Err(LineError::Occupied { start: 2599, free: 2600 }));
    for more in 1..16 {
        usart.put(0, Frame::byte(1), 1000 + 1600 * more, bit).unwrap();
    }
    assert_eq!(usart.put(0, Frame::byte(1), 100_000, bit), Err(LineError::Full));
}
