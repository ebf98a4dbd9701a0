//! The properties of every line, whatever is sent when; and the lines that tests are made with.

use alloc::vec;
use alloc::vec::Vec;

use proptest::prelude::*;

use super::{Adapter, Bluetooth, Frames, Ftdi, Line, Link, Message, Outage, Uart, Usb};
use crate::time::SimTime;

pub(super) fn uart(baud: u32, bits_per_character: u8) -> Link {
    Link::Uart(Uart {
        baud,
        bits_per_character,
        receive_depth: 64,
        transmit_depth: 64,
        laptop_buffer_bytes: 4096,
        byte_error_rate: 0.0,
        adapter: Adapter::None,
        turnaround_ns: None,
        outages: vec![],
        cuts: vec![],
        error_bursts: vec![],
    })
}

pub(super) fn with_adapter(mut link: Link, to: Adapter) -> Link {
    if let Link::Uart(Uart { adapter, .. }) = &mut link {
        *adapter = to;
    }
    link
}

pub(super) fn half_duplex(baud: u32, to_ns: u64) -> Link {
    let mut link = uart(baud, 10);
    if let Link::Uart(Uart { turnaround_ns, .. }) = &mut link {
        *turnaround_ns = Some(to_ns);
    }
    link
}

pub(super) fn usb(bytes_per_frame: u32) -> Link {
    Link::Usb(Usb {
        frame_ns: 1_000_000,
        bytes_per_frame,
        laptop_buffer_bytes: 4096,
        outages: vec![],
        cuts: vec![],
    })
}

fn with_outages(mut link: Link, windows: &[(u64, u64)]) -> Link {
    let window = |&(from, until)| Outage { from: SimTime::from_ns(from), until: SimTime::from_ns(until) };
    if let Link::Uart(Uart { outages, .. }) | Link::Usb(Usb { outages, .. }) = &mut link {
        *outages = windows.iter().map(window).collect();
    }
    link
}

pub(super) fn line(link: &Link) -> Line {
    Line::up(link, 1, &["test"])
}

pub(super) fn down(link: &Link) -> Line {
    Line::down(link, 1, &["test"])
}

/// The bytes that are delivered until `now`, by instants.
pub(super) fn delivered(line: &mut Line, link: &Link, now: u64) -> Vec<(u64, Vec<u8>)> {
    let mut packets: Vec<(u64, Vec<u8>)> = Vec::new();
    while let Some((at, byte)) = line.take(link, SimTime::from_ns(now)) {
        match packets.last_mut().filter(|(last, _)| *last == at.as_ns()) {
            Some((_, bytes)) => bytes.push(byte),
            None => packets.push((at.as_ns(), vec![byte])),
        }
    }
    packets
}

#[test]
fn what_would_arrive_in_an_outage_is_lost_and_counted() {
    // A character takes 0.1 ms: the third and the fourth arrive at 0.3 and 0.4 ms.
    let link = with_outages(uart(100_000, 10), &[(300_000, 400_001)]);
    for line in [Line::up, Line::down] {
        let mut line = line(&link, 1, &["test"]);
        line.send(&link, SimTime::ZERO, &[1, 2, 3, 4, 5]);
        assert_eq!(line.waiting(&link, SimTime::from_ns(250_000)), 3, "the driver knows of no outage");
        let delivered: Vec<u8> = delivered(&mut line, &link, 1_000_000).concat_bytes();
        assert_eq!(delivered, [1, 2, 5]);
        assert_eq!((line.counters.bytes, line.counters.lost_bytes), (5, 2));
    }
}

#[test]
fn the_age_of_a_message_is_known_behind_an_outage() {
    let link = with_outages(uart(100_000, 10), &[(150_000, 750_000)]);
    let mut line = line(&link);
    for i in 0..4 {
        let now = SimTime::from_ns(i * 500_000);
        let message = Message { sampled: vec![(0, now)], ..Message::default() };
        line.send_message(&link, now, &[i as u8; 5], message);
    }
    // The first lost its end and the second its beginning, but not its end.
    let mut found = Vec::new();
    while let Some((at, byte)) = line.take(&link, SimTime::from_ns(9_000_000)) {
        if let Some([(0, sampled)]) = line.message().as_ref().map(|message| &message.sampled[..]) {
            found.push((byte, at.as_ns(), sampled.as_ns()));
        }
    }
    assert_eq!(found, [(1, 1_000_000, 500_000), (2, 1_500_000, 1_000_000), (3, 2_000_000, 1_500_000)]);
    assert_eq!(line.counters.lost_bytes, 6);
}

#[test]
fn a_receiver_that_is_busy_overruns_with_bytes_that_came_and_not_with_lost_ones() {
    let mut link = with_outages(uart(100_000, 10), &[(150_000, 350_000)]);
    if let Link::Uart(uart) = &mut link {
        uart.receive_depth = 2;
    }
    let mut line = down(&link);
    line.send(&link, SimTime::ZERO, &[1, 2, 3, 4, 5, 6]);
    line.overrun(&link, SimTime::from_ns(500_000));
    assert_eq!((line.counters.lost_bytes, line.counters.overrun_bytes), (2, 1));
    assert_eq!(delivered(&mut line, &link, 1_000_000).concat_bytes(), [1, 4, 6]);
}

trait Concat {
    fn concat_bytes(self) -> Vec<u8>;
}

impl Concat for Vec<(u64, Vec<u8>)> {
    fn concat_bytes(self) -> Vec<u8> {
        self.into_iter().flat_map(|(_, bytes)| bytes).collect()
    }
}

/// The frames of the bus alone, or of a chip that adds to them, with a jitter of more than a frame, too.
fn frames() -> impl Strategy<Value = Frames> {
    let jitter_ns = prop_oneof![Just(0), 0_u64..300_000, 0_u64..3_000_000];
    let down_ns = prop::option::of(0_u64..2_000_000);
    let own = (0_u32..4, jitter_ns, down_ns).prop_map(|(extra, jitter_ns, down_ns)| Frames {
        frame_ns: 1_000_000,
        extra,
        jitter_ns,
        down_ns,
    });
    prop_oneof![Just(Frames::of(1_000_000)), own]
}

fn adapters() -> impl Strategy<Value = Adapter> {
    let ms = |range: core::ops::Range<u64>| range.prop_map(|ms| ms * 1_000_000);
    let ftdi = (ms(1..20), 1_u32..70, frames()).prop_map(|(latency_ns, packet_bytes, frames)| {
        Adapter::Ftdi(Ftdi { latency_ns, packet_bytes, frames })
    });
    let bluetooth = (ms(0..40), 0.0..1.0, 0.0..1.0, ms(0..100), 1_u32..70);
    let bluetooth = bluetooth.prop_map(|(latency_ns, spread, burst_probability, burst_ns, packet_bytes)| {
        let spread_ns = (latency_ns as f64 * spread) as u64;
        Adapter::Bluetooth(Bluetooth { latency_ns, spread_ns, burst_probability, burst_ns, packet_bytes })
    });
    prop_oneof![Just(Adapter::None), frames().prop_map(Adapter::Cdc), ftdi, bluetooth]
}

fn links() -> impl Strategy<Value = Link> {
    let uart =
        (1200_u32..600_000, adapters()).prop_map(|(baud, adapter)| with_adapter(uart(baud, 10), adapter));
    let link = prop_oneof![4 => uart, 1 => (1_u32..2000).prop_map(usb), 1 => Just(Link::Ideal)];
    let windows = prop::collection::vec((0_u64..20_000_000, 0_u64..20_000_000), 0..4);
    (link, windows).prop_map(|(link, windows)| {
        let mut from = 0;
        let mut apart = Vec::new();
        for (pause, length) in windows {
            apart.push((from + pause, from + pause + length));
            from += pause + length;
        }
        with_outages(link, &apart)
    })
}

/// Sends, each so long after the one before, and so many bytes.
fn sends() -> impl Strategy<Value = Vec<(u64, usize)>> {
    prop::collection::vec((prop_oneof![Just(0), 0_u64..30_000_000], 0_usize..90), 1..20)
}

/// Runs a line: sends when it is time, takes what is there before each send and at each of these pauses, and
/// looks at the next arrival so many times each time. Says what was delivered when.
fn run(link: &Link, line: &mut Line, sends: &[(u64, usize)], pauses: &[u64], looks: usize) -> Vec<(u64, u8)> {
    let mut now = 0;
    let mut number = 0_u8;
    let mut found = Vec::new();
    let mut take = |line: &mut Line, until: u64| {
        for _ in 0..looks {
            line.arrival(link);
        }
        while line.arrival(link).as_ns() <= until {
            let forecast = line.arrival(link);
            let taken = line.take(link, SimTime::from_ns(until));
            let (at, byte) = taken.expect("what has arrived can be taken");
            assert_eq!(at, forecast);
            found.push((at.as_ns(), byte));
        }
        assert!(line.take(link, SimTime::from_ns(until)).is_none());
    };
    for &(wait, count) in sends {
        for pause in pauses.iter().filter(|pause| (now..now + wait).contains(pause)) {
            take(line, *pause);
        }
        now += wait;
        let bytes: Vec<u8> = (0..count).map(|i| number.wrapping_add(i as u8)).collect();
        number = number.wrapping_add(count as u8);
        line.send(link, SimTime::from_ns(now), &bytes);
    }
    take(line, u64::MAX / 2);
    found
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn bytes_arrive_in_order_not_too_early_and_none_is_lost_that_is_not_counted(
        link in links(), sends in sends(), upwards in any::<bool>(),
    ) {
        let new = if upwards { line } else { down };
        let mut line = new(&link);
        let found = run(&link, &mut line, &sends, &[], 1);
        let total: usize = sends.iter().map(|(_, count)| count).sum();
        let lost = line.counters.lost_bytes as usize;
        prop_assert_eq!(found.len() + lost, total);
        prop_assert_eq!(line.counters.bytes as usize, total);
        prop_assert!(found.is_sorted_by_key(|(at, _)| *at));
        if link.outages().is_empty() {
            prop_assert!(found.iter().enumerate().all(|(i, (_, byte))| *byte == i as u8));
            // The wire alone, without adapter.
            let plain = with_adapter(link.clone(), Adapter::None);
            let wire = run(&plain, &mut new(&plain), &sends, &[], 1);
            prop_assert!(found.iter().zip(&wire).all(|(found, wire)| found.0 >= wire.0));
        }
    }

    #[test]
    fn looking_often_and_stopping_anywhere_changes_nothing(
        link in links(), sends in sends(), upwards in any::<bool>(),
        pauses in prop::collection::vec(0_u64..200_000_000, 0..50),
    ) {
        let new = if upwards { line } else { down };
        let (mut one, mut other) = (new(&link), new(&link));
        let at_once = run(&link, &mut one, &sends, &[], 0);
        let mut pauses = pauses;
        pauses.sort_unstable();
        prop_assert_eq!(&run(&link, &mut other, &sends, &pauses, 3), &at_once);
        // A snapshot may be taken at any time.
        let saved = postcard::to_allocvec(&one).unwrap();
        prop_assert_eq!(saved, postcard::to_allocvec(&other).unwrap());
    }

    #[test]
    fn a_packet_is_no_longer_than_it_may_be(
        adapter in adapters(), baud in 1200_u32..600_000, sends in sends(),
    ) {
        let link = with_adapter(uart(baud, 10), adapter);
        let most = match adapter {
            // Bytes over these adapters can meet at a frame's boundary, a character apart or a frame.
            Adapter::None | Adapter::Cdc(_) => usize::MAX,
            // Jitter can bring several together.
            Adapter::Ftdi(ftdi) if ftdi.frames.jitter_ns > 0 => usize::MAX,
            Adapter::Ftdi(ftdi) => {
                let a_frame = u64::from(baud) / 10_000 + 1;
                (a_frame as usize).max(1) + ftdi.packet_bytes as usize
            }
            Adapter::Bluetooth(radio) if radio.latency_ns == radio.spread_ns => usize::MAX,
            Adapter::Bluetooth(radio) => radio.packet_bytes as usize,
        };
        let mut line = line(&link);
        let found = run(&link, &mut line, &sends, &[], 1);
        for packet in found.chunk_by(|a, b| a.0 == b.0) {
            prop_assert!(packet.len() <= most, "{} bytes at {}", packet.len(), packet[0].0);
        }
    }

    /// The latency timer again, as a clock that runs instant by instant.
    #[test]
    fn the_latency_timer_is_a_clock(
        latency_ms in 1_u64..20, packet_bytes in 1_u32..70, baud in 1200_u32..600_000, sends in sends(),
    ) {
        let latency_ns = latency_ms * 1_000_000;
        let adapter = Adapter::Ftdi(Ftdi { latency_ns, packet_bytes, frames: Frames::of(1_000_000) });
        let link = uart(baud, 10);
        let chip = run(&link, &mut line(&link), &sends, &[], 1);
        let (mut expiry, mut held, mut expected) = (latency_ns, Vec::new(), Vec::new());
        let mut chip = chip.into_iter().peekable();
        while chip.peek().is_some() || !held.is_empty() {
            let byte = chip.next_if(|(at, _)| *at <= expiry);
            let now = byte.map_or(expiry, |(at, _)| at);
            held.extend(byte);
            if byte.is_none() || held.len() == packet_bytes as usize {
                let at = now.div_ceil(1_000_000) * 1_000_000;
                expected.extend(held.drain(..).map(|(_, byte)| (at, byte)));
                expiry = now + latency_ns;
            }
        }
        let link = with_adapter(link, adapter);
        prop_assert_eq!(run(&link, &mut line(&link), &sends, &[], 1), expected);
    }

    #[test]
    fn on_a_shared_wire_bytes_never_meet(
        baud in 1200_u32..600_000, turnaround_ns in 0_u64..3_000_000,
        sends in prop::collection::vec((0_u64..20_000_000, 0_u64..1_000_000, 1_usize..40, any::<bool>()), 1..30),
    ) {
        let link = half_duplex(baud, turnaround_ns);
        let (mut up, mut down) = (line(&link), down(&link));
        let (mut now, mut closed_before) = (0, 0);
        let mut total = [0, 0];
        for (wait, framing_ns, count, upwards) in sends {
            now += wait;
            total[usize::from(upwards)] += count;
            let bytes = vec![0; count];
            if upwards {
                now = now.max(closed_before);
                closed_before = now + framing_ns;
                up.claim_wire(&link, SimTime::from_ns(now), &mut down);
                up.send(&link, SimTime::from_ns(closed_before), &bytes);
                down.leave_wire_to(&link, &up);
            } else {
                down.send(&link, SimTime::from_ns(now), &bytes);
            }
        }
        let character_ns = 10_000_000_000 / u64::from(baud);
        let mut bytes: Vec<(u64, bool)> = Vec::new();
        for (line, upwards) in [(&mut up, true), (&mut down, false)] {
            let found = run(&link, line, &[], &[], 1);
            prop_assert_eq!(found.len(), total[usize::from(upwards)]);
            bytes.extend(found.iter().map(|(at, _)| (*at, upwards)));
        }
        bytes.sort_unstable();
        for pair in bytes.windows(2) {
            let turn_ns = if pair[0].1 == pair[1].1 { 0 } else { turnaround_ns };
            prop_assert!(pair[1].0 - pair[0].0 >= character_ns + turn_ns, "{:?}", pair);
        }
    }
}
