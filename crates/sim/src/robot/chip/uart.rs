//! The cable between a chip's UART and the laptop's.

use baudbot_avr::usart::{Frame, Parity};
use baudbot_board::far_end::{Receiver, Settings};

use super::ChipState;
use crate::link::{Line, Link};
use crate::time::SimTime;

/// The UART at the laptop's end of a cable.
pub(super) fn receiver(link: &Link) -> Receiver {
    Receiver::new(settings(link))
}

/// The settings of the UART.
pub(super) fn settings(link: &Link) -> Settings {
    match link {
        Link::Uart(uart) => Settings::of_cable(uart.baud, u32::from(uart.bits_per_character)),
        // Scenario files refuse chips on other cables.
        Link::Ideal | Link::Usb(_) | Link::Onboard => Settings::new_8n1(9600),
    }
}

/// A byte as the laptop sends it.
fn frame(settings: &Settings, byte: u8) -> Frame {
    Frame::new(u16::from(byte), settings.data_bits, Parity::None, settings.stop_bits)
}

impl ChipState {
    /// The time for which the chip may run on, when a character may make a program write as soon as it has come: less than half a bit of
    /// a character that it is sending, and less than a character if it sends none.
    pub(super) fn slice_ns(&self, now: SimTime, character_ns: u64) -> u64 {
        let (near_ns, usual_ns) = (character_ns / 32, character_ns * 9 / 10);
        let over_ns = self.laptop.free_ns() + near_ns;
        if over_ns <= now.as_ns() {
            return usual_ns;
        }
        (over_ns - now.as_ns()).saturating_sub(2 * near_ns).clamp(near_ns, usual_ns)
    }

    /// Puts characters on the line to the chip whose start bits have come. Returns when the next one comes.
    pub(super) fn hear(&mut self, link: &Link, downlink: &mut Line) -> SimTime {
        let settings = settings(link);
        let character_ns = link.burst_ns(1);
        loop {
            let arrival = downlink.arrival(link);
            if arrival == SimTime::NEVER {
                return arrival;
            }
            let start = SimTime::from_ns(arrival.as_ns().saturating_sub(character_ns));
            if start > self.now() {
                return start;
            }
            let Some((_, byte)) = downlink.take(link, arrival) else { return SimTime::NEVER };
            // The chip may have run ahead by a little.
            if start + character_ns / (2 * settings.bits()) < self.held_until() {
                downlink.counters.lost_bytes += 1;
                continue;
            }
            let local = self.local(start).max(self.board.now_ns());
            // One that begins within the last one, as its rate was changed by hand, is lost; so are bits shorter than a cycle.
            if self.board.receive(frame(&settings, byte), local, settings.baud).is_err() {
                downlink.counters.lost_bytes += 1;
            }
        }
    }

    /// Puts the chip's characters on the line, and those that the laptop's UART reads of it on their way. Returns when
    /// characters were on the line, and how many.
    pub(super) fn speak(&mut self, link: &Link, uplink: &mut Line) -> Option<(SimTime, SimTime, u32)> {
        let mut spoken: Option<(SimTime, SimTime, u32)> = None;
        let offset = self.world(0).as_ns();
        let expected_ns = settings(link).character_ns() as f64;
        let mut is_off = false;
        for sent in self.board.sent() {
            let (from_ns, until_ns) = (offset + sent.start_ns, offset + sent.end_ns);
            self.laptop.hear_frame(&sent.frame, (from_ns, until_ns));
            let (from, until) = (SimTime::from_ns(from_ns), SimTime::from_ns(until_ns));
            let bits = f64::from(sent.frame.bits()) / settings(link).bits() as f64;
            is_off |= ((until_ns - from_ns) as f64 / (bits * expected_ns) - 1.0).abs() > UNREADABLE;
            let (from, _, count) = spoken.unwrap_or((from, until, 0));
            spoken = Some((from, until, count + 1));
        }
        if is_off {
            self.board.warn_of_rate();
        }
        self.laptop.idle(self.now().as_ns());
        while let Some(read) = self.laptop.read() {
            uplink.counters.corrupted_bytes += u64::from(read.error.is_some());
            uplink.send_at(link, SimTime::from_ns(read.at_ns), read.byte);
        }
        spoken
    }
}

/// A rate that is off by more than this is misread: the stop bit of a character of ten bits is sampled half a bit too early or
/// late.
const UNREADABLE: f64 = 0.055;
