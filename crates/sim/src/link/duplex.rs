//! Half duplex: both directions share one wire, as on RS-485 with two leads or on a bus of servos.
//!
//! A burst that has begun goes on until all bytes are over that asked for the wire before its end and before the
//! other side did. Then the other side may begin, `turnaround_ns` after its last byte.
//!
//! *Choices.* The notes know no such wire, so these are ours.
//!
//! - The microcontroller asks for the wire when it begins to frame, the laptop when its bytes are at the wire.
//!   The side that asked first sends first; of two at the same instant, the microcontroller.
//! - Both receive each other, so bytes never collide. A robot that talks all the time keeps the wire only as long as
//!   its transmitter is never empty.
//! - The laptop's bytes are written ahead of time if a brain declares that it thinks, so they are put on the wire
//!   only when the time has come ([`Line::settle`]); until then, all that is said of them is a forecast.

use super::{Line, Link};
use crate::time::SimTime;

impl Line {
    /// The microcontroller asks for the wire at `now`: `self` is its line, `other` the laptop's.
    pub fn claim_wire(&mut self, link: &Link, now: SimTime, other: &mut Self) {
        let Some(turnaround_ns) = link.turnaround_ns() else { return };
        other.settle_asked(link, now);
        if let Some(transport_path) = &mut self.transport_path {
            transport_path.blocked_until = other.transmission.over(turnaround_ns);
        }
    }

    /// The microcontroller has put its bytes on the wire: `self` is the laptop's line, `other` its own.
    pub fn leave_wire_to(&mut self, link: &Link, other: &Self) {
        let Some(turnaround_ns) = link.turnaround_ns() else { return };
        if let Some(transport_path) = &mut self.transport_path {
            transport_path.blocked_until = other.transmission.over(turnaround_ns);
        }
    }

    /// Puts those of the laptop's bytes on the wire that asked for it before `now`: they come before those of a side that
    /// asks now, even if they have to wait for what is on the wire.
    fn settle_asked(&mut self, link: &Link, now: SimTime) {
        let Some(transport_path) = &mut self.transport_path else { return };
        while let Some((ready, byte)) = transport_path.asking.pop_front_if(|(ready, _)| *ready < now) {
            self.in_flight
                .push_back((self.transmission.put(link, ready.max(transport_path.blocked_until)), byte));
        }
    }

    /// Puts those of the laptop's bytes on the wire that have got it before `now`.
    pub(super) fn settle(&mut self, link: &Link, now: SimTime) {
        let Some(transport_path) = &mut self.transport_path else { return };
        while let Some((ready, byte)) = transport_path.asking.front() {
            let begin = (*ready).max(transport_path.blocked_until);
            let goes_on = begin <= self.transmission.end();
            if *ready >= now || (begin >= now && !goes_on) {
                return;
            }
            self.in_flight.push_back((self.transmission.put(link, begin), *byte));
            transport_path.asking.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::link::properties::{delivered, down, half_duplex, line};

    const MS: u64 = 1_000_000;

    fn at(tenths_of_ms: u64) -> SimTime {
        SimTime::from_ns(tenths_of_ms * MS / 10)
    }

    struct Wire {
        link: Link,
        up: Line,
        down: Line,
    }

    impl Wire {
        /// A character takes 1 ms, turning around 0.5 ms.
        fn new() -> Self {
            let link = half_duplex(10_000, MS / 2);
            Self { up: line(&link), down: down(&link), link }
        }

        /// The microcontroller frames from one instant to the other.
        fn readings(&mut self, from: SimTime, closed: SimTime, bytes: &[u8]) {
            self.up.claim_wire(&self.link, from, &mut self.down);
            self.up.send(&self.link, closed, bytes);
            self.down.leave_wire_to(&self.link, &self.up);
        }

        fn write(&mut self, now: SimTime, bytes: &[u8]) {
            self.down.send(&self.link, now, bytes);
        }

        fn arrivals(&mut self) -> [Vec<u64>; 2] {
            [&mut self.up, &mut self.down].map(|line| {
                let delivered = delivered(line, &self.link, 1000 * MS);
                delivered.into_iter().map(|(at, _)| at * 10 / MS).collect()
            })
        }
    }

    #[test]
    fn an_answer_waits_for_the_question_and_the_turnaround() {
        let mut wire = Wire::new();
        wire.write(at(0), &[1, 2]);
        assert_eq!(wire.down.arrival(&wire.link), at(10));
        wire.readings(at(12), at(12), &[3, 4]);
        wire.write(at(13), &[5]);
        assert_eq!(wire.down.waiting(&wire.link, at(13)), 2);
        assert_eq!(wire.arrivals(), [vec![35, 45], vec![10, 20, 60]]);
    }

    #[test]
    fn the_first_message_waits_for_nobody() {
        let mut wire = Wire::new();
        wire.readings(at(0), at(3), &[1]);
        assert_eq!(wire.arrivals(), [vec![13], vec![]]);
    }

    #[test]
    fn a_brain_that_thinks_keeps_the_wire_free_until_it_speaks() {
        let mut wire = Wire::new();
        // Written at 0, for 5 ms; the readings of 2 ms are over at 4 ms.
        wire.write(at(50), &[1, 2]);
        assert_eq!(wire.down.arrival(&wire.link), at(60));
        wire.readings(at(20), at(20), &[3, 4]);
        assert_eq!(wire.down.arrival(&wire.link), at(60));
        // The readings of 4.6 ms are not over at 5 ms, and the brain has to wait.
        wire.readings(at(46), at(48), &[5]);
        assert_eq!(wire.down.arrival(&wire.link), at(73));
        assert_eq!(wire.arrivals(), [vec![30, 40, 58], vec![73, 83]]);
    }

    #[test]
    fn a_robot_that_speaks_again_before_it_is_done_does_not_shut_the_laptop_out() {
        let mut wire = Wire::new();
        wire.readings(at(0), at(0), &[1, 2, 3]);
        wire.write(at(10), &[9]);
        // Both ask again while the first message is on the wire, after the laptop did.
        wire.readings(at(20), at(20), &[4, 5]);
        wire.readings(at(25), at(25), &[6]);
        assert_eq!(wire.arrivals(), [vec![10, 20, 30, 60, 70, 80], vec![45]]);
    }

    #[test]
    fn who_asks_during_a_burst_waits_for_its_end_and_for_those_who_asked_before() {
        let mut wire = Wire::new();
        wire.write(at(0), &[1, 2, 3]);
        wire.write(at(10), &[4]);
        // Asks at 1.5 ms, between the laptop's second and third write.
        wire.readings(at(15), at(18), &[5]);
        wire.write(at(20), &[6]);
        assert_eq!(wire.arrivals(), [vec![55], vec![10, 20, 30, 40, 70]]);
    }
}
