//! The serial protocol between a robot's microcontroller and its brain.
//!
//! The simulated microcontroller, the server's laptop end of the cable and the client library all use this crate,
//! and it is small enough for a real microcontroller: no standard library, no allocation, no panic on any input.
//!
//! # From bytes to meaning
//!
//! 1. **Bytes** come one at a time, some of them altered, some not at all.
//! 2. [`frame`] finds the **frames** in them: where a payload begins and ends, and whether it arrived whole.
//! 3. [`message`] gives a payload its **meaning**: readings, a command, or a request for readings.
//! 4. [`encoding`] turns the bytes of each value into a number, and [`clock`] those of a time into an instant.
//!
//! The content of a message, its order and its sizes are a [`Layout`] that both ends have beforehand. [`bare`] is an
//! alternative to all this: values and nothing else, as the lecture notes count them. [`khepera`] is another: lines
//! of text, as a real robot speaks them.
//!
//! [`Protocol`] is the table of all that a robot can speak, and [`Agreement`] writes and reads the messages of any of them, for
//! those to whom it does not matter which.
//!
//! Apart from these stand the formats of sensors that have a wire of their own: [`scip`], a laser range finder;
//! [`nmea`], a satellite navigation receiver; [`line_image`], a line camera. Each message is written into the caller's
//! buffer and read from the bytes of one whole message. [`port`] finds their messages among bytes as they come, and turns
//! them into the values of a reading.
//!
//! [`meaning`] says in words what the bytes of any of these cables are, for people who look at one.
//!
//! # A frame of readings
//!
//! | bytes | meaning | part of |
//! |---|---|---|
//! | 1 | COBS code byte (more of them in frames over 256 bytes, and in place of zeros) | frame |
//! | 1 | 0x11: version 1, readings | message |
//! | 1 | sequence number | message |
//! | 2 | time of the frame, unit 100 µs | message |
//! | ⌈n/8⌉ | which of the n sensors are in the frame | message |
//! | per sensor | its age, unit 100 µs (if agreed), and its components | message |
//! | 2 | CRC-16/IBM-3740 of the message | frame |
//! | 1 | 0x00, the delimiter | frame |
//!
//! So k fresh sensors with v bytes of values cost 8 + ⌈n/8⌉ + k + v bytes with ages, k less without; a command of v
//! bytes of values costs 6 + v. Beyond 252 bytes of message, each 254 may cost one byte more.
//!
//! # Example
//!
//! ```
//! use baudbot_wire::{Decoder, Encoding, Layout, Message, Sample, frame, write_readings};
//!
//! // Two infra-red sensors of 8 bits, and a pair of wheel encoders.
//! let infrared = Encoding::Level { bits: 8, min: 0.0, max: 255.0 };
//! let counter = Encoding::Counter { bits: 16 };
//! let motor = Encoding::Signed { bits: 8, limit: 1.0 };
//! let layout = Layout {
//!     components: &[infrared, infrared, counter, counter],
//!     counts: &[1, 1, 2],
//!     motors: &[motor, motor],
//!     ages: true,
//! };
//! layout.check()?;
//!
//! // The microcontroller has new samples of the second infra-red sensor and of the encoders.
//! let fresh = |sensor| match sensor {
//!     1 => Some(Sample { age_100us: 3, values: &[17.0] }),
//!     2 => Some(Sample { age_100us: 0, values: &[-2.0, 700.0] }),
//!     _ => None,
//! };
//! let mut payload = [0; frame::MAX_PAYLOAD];
//! let len = write_readings(&layout, 0, 1234, fresh, &mut payload)?;
//! let mut wire = [0; frame::MAX_FRAME];
//! let len = frame::encode(&payload[..len], &mut wire)?;
//! assert_eq!(len, 8 + 1 + 2 + 5);
//!
//! // The brain gets it byte by byte.
//! let mut decoder = Decoder::new();
//! let mut arrived = Vec::new();
//! for &byte in &wire[..len] {
//!     let Some(payload) = decoder.push(byte) else { continue };
//!     if let Message::Readings(readings) = Message::parse(payload?, &layout)? {
//!         assert_eq!(readings.time_100us, 1234);
//!         arrived.extend(readings.entries().map(|entry| (entry.sensor, entry.values.collect())));
//!     }
//! }
//! assert_eq!(arrived, [(1, vec![17.0]), (2, vec![-2.0, 700.0])]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![no_std]

#[cfg(feature = "alloc")]
extern crate alloc;

#[cfg(test)]
extern crate std;

pub mod asercom;
pub mod bare;
pub mod clock;
pub mod codec;
pub mod create;
pub mod encoding;
pub mod error;
pub mod frame;
pub mod khepera;
pub mod layout;
pub mod line_image;
pub mod lines;
pub mod meaning;
pub mod message;
pub mod nmea;
pub mod port;
pub mod protocol;
pub mod scip;
pub mod values;

mod buffer;
#[cfg(feature = "alloc")]
mod wire_layout;

pub use bare::BareDecoder;
pub use clock::{age_100us, unwrap_time, wrap_time};
pub use encoding::Encoding;
pub use error::{LayoutError, NoRoom, WriteError};
pub use frame::{Decoder, FrameError};
pub use layout::Layout;
pub use message::{
    Command, Entry, Message, MessageError, Readings, Sample, poll, write_command, write_readings,
};
pub use protocol::{Agreement, Protocol, Uplink};
pub use values::{Values, write_values};
#[cfg(feature = "alloc")]
pub use wire_layout::WireLayout;
