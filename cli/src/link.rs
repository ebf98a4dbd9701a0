//! A link in words and numbers.

use baudbot_plot::quantity::{count, duration, handy};
use baudbot_sim::link::{Adapter, Frames, Link, Uart, Usb};

/// The link's kind in the word of the scenario file.
pub(crate) fn kind(link: &Link) -> &'static str {
    match link {
        Link::Ideal => "ideal",
        Link::Onboard => "onboard",
        Link::Uart(_) => "uart",
        Link::Usb(_) => "usb",
    }
}

/// The capacity of a line; `None` if it is ideal.
pub(crate) fn bytes_per_second(link: &Link) -> Option<f64> {
    match link {
        Link::Ideal | Link::Onboard => None,
        Link::Uart(uart) => Some(f64::from(uart.baud) / f64::from(uart.bits_per_character)),
        Link::Usb(usb) => Some(f64::from(usb.bytes_per_frame) / usb.frame_ns as f64 * 1e9),
    }
}

/// The time of so many bytes on the wire, in nanoseconds, without waiting for a frame to begin; `None` if it is ideal.
pub(crate) fn transfer_ns(link: &Link, bytes: usize) -> Option<f64> {
    match link {
        Link::Ideal | Link::Onboard | Link::Uart(_) => {
            bytes_per_second(link).map(|rate| bytes as f64 / rate * 1e9)
        }
        Link::Usb(usb) => Some((bytes.div_ceil(usb.bytes_per_frame as usize) as u64 * usb.frame_ns) as f64),
    }
}

/// The link in words.
pub(crate) fn text(link: &Link) -> String {
    match link {
        Link::Ideal => "ideal: no time, no loss".to_owned(),
        Link::Onboard => "none: the brain is the microcontroller's program".to_owned(),
        Link::Uart(uart) => {
            let mut parts = vec![wire(link, uart)];
            if uart.byte_error_rate != 0.0 {
                parts.push(format!("a byte is wrong with probability {}", uart.byte_error_rate));
            }
            parts.extend(uart.turnaround_ns.map(half_duplex));
            parts.extend(adapter(&uart.adapter));
            parts.extend(outages(uart.outages.len()));
            parts.join(", ")
        }
        Link::Usb(usb) => {
            let mut parts = vec![frames(usb)];
            parts.extend(outages(usb.outages.len()));
            parts.join(", ")
        }
    }
}

fn wire(link: &Link, uart: &Uart) -> String {
    let rate = handy(bytes_per_second(link).unwrap_or(0.0));
    format!("{} baud, {} bits a character: {rate} bytes/s", uart.baud, uart.bits_per_character)
}

fn frames(usb: &Usb) -> String {
    format!("USB: frames of {}, {} bytes each", duration(usb.frame_ns as f64), usb.bytes_per_frame)
}

fn half_duplex(turnaround_ns: u64) -> String {
    match turnaround_ns {
        0 => "half duplex".to_owned(),
        ns => format!("half duplex, {} to turn around", duration(ns as f64)),
    }
}

fn adapter(adapter: &Adapter) -> Option<String> {
    match adapter {
        Adapter::None => None,
        Adapter::Cdc(frames) => {
            let ms = duration(frames.frame_ns as f64);
            Some(format!("USB adapter with frames of {ms}{}", on_usb(frames)))
        }
        Adapter::Ftdi(ftdi) => Some(format!(
            "USB adapter with packets of {} bytes and a latency timer of {}: at most {} exchanges/s of shorter messages{}",
            ftdi.packet_bytes,
            duration(ftdi.latency_ns as f64),
            handy(1e9 / ftdi.latency_ns as f64),
            on_usb(&ftdi.frames)
        )),
        Adapter::Bluetooth(radio) => Some(format!(
            "radio with packets of {} bytes that take {} ± {}, and {} more with probability {}",
            radio.packet_bytes,
            duration(radio.latency_ns as f64),
            duration(radio.spread_ns as f64),
            duration(radio.burst_ns as f64),
            radio.burst_probability
        )),
    }
}

/// The chip's additions to the frames of the bus.
fn on_usb(frames: &Frames) -> String {
    let parts = [
        (frames.extra > 0).then(|| format!("{} more up", count(frames.extra as usize, "frame"))),
        (frames.jitter_ns > 0).then(|| format!("a jitter of {} up", duration(frames.jitter_ns as f64))),
        frames.down_ns.map(|ns| format!("{} down", duration(ns as f64))),
    ];
    parts.into_iter().flatten().map(|part| format!(", {part}")).collect()
}

fn outages(n: usize) -> Option<String> {
    (n > 0).then(|| format!("out {}", count(n, "time")))
}

#[cfg(test)]
mod tests {

    use super::*;

    fn link(toml: &str) -> Link {
        let robot = "[[robots]]\nname = \"a\"\nbody = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, \
                     wheel_radius_m = 0.1 }\nlink = ";
        baudbot_scenario::parse(&format!("{robot}{toml}")).unwrap().robots[0].link.clone()
    }

    #[test]
    fn each_part_is_named() {
        let text = |toml: &str| text(&link(toml));
        assert_eq!(text("{ kind = \"usb\" }"), "USB: frames of 1 ms, 1216 bytes each");
        let uart = "{ kind = \"uart\", baud = 115200, byte_error_rate = 0.1, half_duplex = true, \
                    turnaround_us = 50, outages = [{ from_s = 1, for_s = 2 }], adapter = { kind = \"ftdi\" } }";
        assert_eq!(
            text(uart),
            "115200 baud, 10 bits a character: 11520 bytes/s, a byte is wrong with probability 0.1, half duplex, \
             50 µs to turn around, USB adapter with packets of 62 bytes and a latency timer of 16 ms: at most \
             62.5 exchanges/s of shorter messages, out 1 time"
        );
        let radio = "{ kind = \"uart\", baud = 9600, adapter = { kind = \"bluetooth\" } }";
        assert!(text(radio).ends_with(
            "radio with packets of 330 bytes that take 30 ms ± 10 ms, and 100 ms more with probability 0.02"
        ));
        let cdc = "{ kind = \"uart\", baud = 9600, adapter = { kind = \"cdc\" } }";
        assert!(text(cdc).ends_with("960 bytes/s, USB adapter with frames of 1 ms"));
        let ch340 = "{ kind = \"uart\", baud = 9600, adapter = { preset = \"ch340\" } }";
        assert!(text(ch340).ends_with(
            "960 bytes/s, USB adapter with frames of 1 ms, 1 frame more up, a jitter of 90 µs up, 43 µs down"
        ));
    }

    #[test]
    fn usb_takes_whole_frames() {
        let usb = link("{ kind = \"usb\", bytes_per_frame = 64 }");
        assert_eq!(bytes_per_second(&usb), Some(64_000.0));
        assert_eq!([64, 65].map(|bytes| transfer_ns(&usb, bytes)), [Some(1e6), Some(2e6)]);
        assert_eq!(transfer_ns(&Link::Ideal, 64), None);
    }
}
