//! A radio in the cable's place, such as Bluetooth's serial port profile: a UART ends in a module on the robot,
//! and the air leads on to the laptop.
//!
//! Each way, the radio that is idle takes what has come to it, up to `packet_bytes`, and delivers that after a
//! random latency: uniform within `latency_ns` ± `spread_ns`, and with `burst_probability` `burst_ns` more.
//! Then it is idle again. So bytes stay in order, and those that come meanwhile wait for each other.
//!
//! A radio does not know what a message is: an idle one goes with the first byte of it, and the rest follows in the
//! next packet. So a short message takes two latencies, and one that came while the radio was busy one.
//!
//! The numbers come from streams of their own (`robot/link:up:radio`), two for each packet, so that a radio
//! changes no byte error. Typical are 20 to 40 ms and now and then more than 100 (a guess, of modules such as
//! the e-puck's LMX9820A).
//!
//! *Deviations.* Nothing is lost in the air, as Bluetooth sends again; that is what the bursts stand for. A
//! module holds as many bytes for the laptop as the laptop's driver (`laptop_buffer_bytes`), and more are lost:
//! there is no flow control on the UART.

use crate::random::Stream;

/// A radio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bluetooth {
    /// Mean latency of a packet, in nanoseconds.
    pub latency_ns: u64,
    /// Half the range of latencies, in nanoseconds.
    pub spread_ns: u64,
    /// Probability that a packet is held up.
    pub burst_probability: f64,
    /// The length of such a burst, in nanoseconds.
    pub burst_ns: u64,
    /// Most bytes of a packet.
    pub packet_bytes: u32,
}

impl Bluetooth {
    pub(super) fn draw(&self, chance: &mut Stream) -> u64 {
        let shift = chance.uniform() * 2.0 * self.spread_ns as f64;
        let burst_ns = if chance.uniform() < self.burst_probability { self.burst_ns } else { 0 };
        self.latency_ns - self.spread_ns + shift as u64 + burst_ns
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;
    use alloc::vec::Vec;

    use super::*;
    use crate::link::latencies::Latencies;
    use crate::link::properties::{delivered, down, line, uart, with_adapter};
    use crate::link::{Adapter, Link};
    use crate::statistics::{SAMPLES, assert_distributed, assert_rate, uniform};
    use crate::time::SimTime;

    const MS: u64 = 1_000_000;

    fn radio(spread_ms: u64, burst_probability: f64) -> Bluetooth {
        let (latency_ns, spread_ns) = (30 * MS, spread_ms * MS);
        Bluetooth { latency_ns, spread_ns, burst_probability, burst_ns: 100 * MS, packet_bytes: 3 }
    }

    /// A character takes 0.1 ms, a packet 30 ms.
    fn link() -> Link {
        with_adapter(uart(100_000, 10), Adapter::Bluetooth(radio(0, 0.0)))
    }

    #[test]
    fn what_comes_while_the_radio_is_busy_goes_with_the_next_packet() {
        let link = link();
        let mut line = line(&link);
        line.send(&link, SimTime::from_ns(MS), &[1, 2, 3, 4, 5]);
        line.send(&link, SimTime::from_ns(200 * MS), &[6]);
        // At 1.1 ms there is one byte, at 31.1 ms four more: three of them go, and then the last.
        let expected = [
            (31_100_000, vec![1]),
            (61_100_000, vec![2, 3, 4]),
            (91_100_000, vec![5]),
            (230_100_000, vec![6]),
        ];
        assert_eq!(delivered(&mut line, &link, 1000 * MS), expected);
    }

    #[test]
    fn downwards_the_radio_comes_first_and_then_the_wire() {
        let link = link();
        let mut line = down(&link);
        line.send(&link, SimTime::from_ns(MS), &[1, 2, 3, 4]);
        line.send(&link, SimTime::from_ns(2 * MS), &[5]);
        line.send(&link, SimTime::from_ns(40 * MS), &[6]);
        // Three at 31 ms, then those of 1 and 2 ms at 61 ms, then that of 40 ms at 91 ms.
        let expected = [31_100_000, 31_200_000, 31_300_000, 61_100_000, 61_200_000, 91_100_000];
        let at = delivered(&mut line, &link, 1000 * MS).into_iter().map(|(at, _)| at);
        assert!(at.eq(expected));
    }

    #[test]
    fn latencies_are_spread_evenly_and_sometimes_held_up() {
        let radio = Adapter::Bluetooth(radio(10, 0.2));
        let mut latencies = Latencies::new(&radio, Stream::new(1, "test"));
        let drawn: Vec<_> = (0..SAMPLES).map(|_| latencies.take(&radio)).collect();
        let held_up = |ns: u64| ns >= 100 * MS;
        assert_rate(drawn.iter().filter(|&&ns| held_up(ns)).count() as u64, SAMPLES as u64, 0.2);
        let plain = |ns: u64| if held_up(ns) { ns - 100 * MS } else { ns };
        let mut plain_ms: Vec<_> = drawn.iter().map(|&ns| plain(ns) as f64 / MS as f64).collect();
        assert_distributed(&mut plain_ms, |scale| uniform(30.0 - 10.0 * scale, 30.0 + 10.0 * scale));
    }

    #[test]
    fn a_radio_that_cannot_keep_up_loses_bytes_and_grows_no_further() {
        let link = link();
        let mut line = line(&link);
        let mut taken = 0;
        for i in 0..1000 {
            let now = SimTime::from_ns(i * MS);
            line.send(&link, now, &[0; 10]);
            taken += delivered(&mut line, &link, i * MS).iter().map(|(_, bytes)| bytes.len()).sum::<usize>();
        }
        assert_eq!(line.in_flight.len(), link.laptop_buffer());
        let lost = line.counters.overrun_bytes as usize;
        assert_eq!(taken + lost + line.in_flight.len(), 10_000);
        assert_eq!(line.counters.bytes as usize, taken + lost);
    }
}
