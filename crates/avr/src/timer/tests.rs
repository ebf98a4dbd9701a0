use std::vec::Vec;

use super::*;

const NO_DIVISION: u8 = 1;
const DIVIDE_BY_64: u8 = 3;

/// A timer with these control registers, whose compare values and top are these from the start.
fn timer(which: Which, control: [u8; 2], compare: [u16; 2], capture: u16) -> Timer {
    let mut timer = Timer::new(which, 0);
    timer.control = [control[0], control[1]];
    (timer.compare, timer.buffer, timer.capture) = (compare, compare, capture);
    timer.write(Register::ControlA, control[0]);
    timer
}

/// Cycles at which the flags rise, with the flag; they are cleared at once.
fn flags(timer: &mut Timer, until: u64) -> Vec<(u64, u8)> {
    let mut found = Vec::new();
    for now in timer.at + 1..=until {
        timer.advance(now);
        let flags = timer.flags();
        for flag in [OVERFLOW, MATCH_A, MATCH_B, CAPTURE].into_iter().filter(|flag| flags & flag != 0) {
            found.push((now, flag));
        }
        timer.write(Register::Flags, flags);
    }
    found
}

/// Cycles at which an output changes, with its level.
fn edges(timer: &mut Timer, channel: usize, until: u64) -> Vec<(u64, bool)> {
    let mut found = Vec::new();
    let mut last = timer.outputs()[channel];
    for now in timer.at + 1..=until {
        timer.advance(now);
        let level = timer.outputs()[channel];
        if level != last {
            found.push((now, level.unwrap()));
            last = level;
        }
    }
    found
}

#[test]
fn a_normal_timer_overflows_after_max_and_matches_after_its_compare_value() {
    let mut timer = timer(Which::T0, [0, NO_DIVISION], [10, 255], 0);
    assert_eq!(
        flags(&mut timer, 512),
        [(11, MATCH_A), (256, OVERFLOW), (256, MATCH_B), (267, MATCH_A), (512, OVERFLOW), (512, MATCH_B)]
    );
}

#[test]
fn a_prescaled_timer_ticks_with_the_multiples_of_its_division() {
    let mut timer = timer(Which::T0, [0, DIVIDE_BY_64], [2, 99], 0);
    timer.advance(63);
    assert_eq!(timer.read(Register::Count), 0);
    timer.advance(64);
    assert_eq!(timer.read(Register::Count), 1);
    assert_eq!(flags(&mut timer, 200), [(192, MATCH_A)]);
}

#[test]
fn ctc_returns_after_the_compare_value_and_does_not_overflow() {
    let mut timer = timer(Which::T0, [2, NO_DIVISION], [9, 4], 0);
    assert_eq!(flags(&mut timer, 20), [(5, MATCH_B), (10, MATCH_A), (15, MATCH_B), (20, MATCH_A)]);
}

#[test]
fn toggling_in_ctc_makes_a_square_wave() {
    let mut timer = timer(Which::T1, [0x40, 0x08 | NO_DIVISION], [99, 0], 0);
    assert_eq!(edges(&mut timer, 0, 400), [(100, true), (200, false), (300, true), (400, false)]);
    assert_eq!(timer.shape(0), Some((100, 200)));
}

#[test]
fn fast_pwm_is_high_for_one_tick_more_than_the_compare_value() {
    let mut timer = timer(Which::T0, [0x83, NO_DIVISION], [63, 0], 0);
    timer.advance(256);
    assert_eq!(edges(&mut timer, 0, 768)[..], [(320, false), (512, true), (576, false), (768, true)]);
    assert_eq!(timer.shape(0), Some((64, 256)));
}

#[test]
fn phase_correct_pwm_is_high_for_twice_its_compare_value_around_bottom() {
    let mut timer = timer(Which::T0, [0x81, NO_DIVISION], [100, 0], 0);
    timer.advance(510);
    assert_eq!(edges(&mut timer, 0, 1530)[..], [(611, false), (921, true), (1121, false), (1431, true)]);
    assert_eq!(timer.shape(0), Some((200, 510)));
}

#[test]
fn phase_correct_pwm_is_constant_at_both_ends() {
    for (compare, level) in [(0, false), (255, true)] {
        let mut timer = timer(Which::T0, [0x81, NO_DIVISION], [compare, 0], 0);
        timer.advance(1020);
        assert_eq!(edges(&mut timer, 0, 3000), []);
        assert_eq!(timer.outputs()[0], Some(level));
    }
}

#[test]
fn shapes_say_what_edges_show_in_each_mode_of_timer_1() {
    for waveform in [1u8, 5, 8, 9, 10, 11, 14, 15] {
        for com in [2u8, 3] {
            let control = [com << 4 | waveform & 3, (waveform & 0x0C) << 1 | 2];
            let mut timer = timer(Which::T1, control, [200, 77], 180);
            let (high, period) = timer.shape(1).unwrap();
            timer.advance(4 * period);
            let mut measured = 0;
            for now in 4 * period + 1..=6 * period {
                timer.advance(now);
                measured += u64::from(timer.outputs()[1] == Some(true));
            }
            assert_eq!((measured, period), (2 * high, period), "mode {waveform}, COM {com}");
        }
    }
}

#[test]
fn a_buffered_compare_value_is_taken_at_bottom_top_or_at_once_as_the_mode_says() {
    // Mode, cycle of the update with a top of 255.
    for (waveform, taken) in [(3, 256), (1, 255), (0, 100)] {
        let mut timer = timer(Which::T0, [waveform, NO_DIVISION], [10, 0], 0);
        timer.advance(100);
        timer.write(Register::CompareA, 20);
        assert_eq!(timer.read(Register::CompareA), 20);
        for now in 100..=300 {
            timer.advance(now);
            assert_eq!(timer.compare[0], if now < taken { 10 } else { 20 }, "mode {waveform}, cycle {now}");
        }
    }
}

#[test]
fn a_write_to_the_counter_blocks_the_match_of_the_next_tick() {
    let mut timer = timer(Which::T0, [0, NO_DIVISION], [10, 0], 0);
    timer.advance(5);
    timer.write(Register::Count, 10);
    timer.advance(20);
    assert_eq!((timer.flags() & MATCH_A, timer.read(Register::Count)), (0, 25));
}

#[test]
fn sixteen_bits_are_read_and_written_at_once_by_the_low_byte() {
    let mut timer = timer(Which::T1, [0, NO_DIVISION], [0, 0], 0);
    timer.write(Register::CountHigh, 0x12);
    timer.write(Register::Count, 0xFF);
    assert_eq!(timer.read(Register::Count), 0xFF);
    timer.advance(1);
    assert_eq!(timer.read(Register::CountHigh), 0x12);
    assert_eq!((timer.read(Register::Count), timer.read(Register::CountHigh)), (0x00, 0x13));
}

#[test]
fn an_edge_captures_and_the_noise_canceller_waits_for_four_cycles() {
    let mut timer = timer(Which::T1, [0, CAPTURE_RISING | NO_DIVISION], [0, 0], 0);
    timer.capture_edge(100, false);
    assert_eq!(timer.flags() & CAPTURE, 0);
    timer.capture_edge(200, true);
    assert_eq!((timer.flags() & CAPTURE, timer.capture), (CAPTURE, 200));
    timer.write(Register::Flags, 0xFF);
    timer.write(Register::ControlB, NOISE_CANCELLER | CAPTURE_RISING | NO_DIVISION);
    timer.capture_edge(300, true);
    timer.capture_edge(303, false);
    timer.capture_edge(310, true);
    assert_eq!(timer.next_event(), 314);
    timer.advance(320);
    assert_eq!((timer.flags() & CAPTURE, timer.capture), (CAPTURE, 314));
}

#[test]
fn edges_at_tn_are_counted() {
    for (select, rising) in [(6, false), (7, true)] {
        let mut timer = timer(Which::T0, [0, select], [0, 0], 0);
        for at in 0..10 {
            timer.clock_edge(10 * at, at % 2 == 0);
        }
        let _ = rising;
        assert_eq!(timer.read(Register::Count), 5);
    }
}

#[test]
fn a_prescaler_that_is_reset_or_held_begins_again() {
    let mut timer = timer(Which::T0, [0, DIVIDE_BY_64], [99, 99], 0);
    timer.reset_prescaler(60, false);
    timer.advance(123);
    assert_eq!(timer.read(Register::Count), 0);
    timer.advance(124);
    assert_eq!(timer.read(Register::Count), 1);
    timer.reset_prescaler(200, true);
    timer.advance(10_000);
    assert_eq!(timer.read(Register::Count), 2);
    timer.reset_prescaler(10_000, false);
    timer.advance(10_064);
    assert_eq!(timer.read(Register::Count), 3);
}

proptest::proptest! {
    /// However far a timer is advanced at once, it is as if it had been stepped, and its events do not come late.
    #[test]
    fn a_leap_is_the_same_as_single_steps(
        which in 0..3usize, control_a: u8, control_b in 0..32u8, compare: [u16; 2], capture in 1..2000u16,
        count: u16, small: bool, far in 1..70_000u64, watched in 0..4u8,
    ) {
        let which = [Which::T0, Which::T1, Which::T2][which];
        let most = if which != Which::T1 { 0xFF } else if small { 0x7F } else { 0xFFFF };
        let mut leaping = timer(which, [control_a, control_b], compare.map(|value| value & most), capture);
        leaping.count = count & most;
        leaping.write(Register::CompareB, 17);
        leaping.mask = leaping.possible_flags();
        leaping.watch(watched, 0);
        let mut stepping = leaping.clone();
        let event = leaping.next_event();
        let before = (stepping.flags(), stepping.outputs());
        for now in 1..=far {
            stepping.advance(now);
            if now < event {
                let outputs = stepping.outputs();
                for channel in (0..2).filter(|channel| watched >> channel & 1 == 1) {
                    proptest::prop_assert_eq!(outputs[channel], before.1[channel], "an edge at {} before {}", now, event);
                }
                proptest::prop_assert_eq!(stepping.flags(), before.0, "a flag at {} before {}", now, event);
            }
        }
        leaping.advance(far);
        proptest::prop_assert_eq!(leaping, stepping);
    }
}
