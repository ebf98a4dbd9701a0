//! The end of what each chip sends, for people.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use baudbot_sim::model::RobotSpec;
use baudbot_sim::{SimTime, World};

use super::Listener;

/// The last bytes of chips. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Tails(Arc<Mutex<Vec<Tail>>>);

/// The last bytes of a chip.
struct Tail {
    robot: usize,
    listener: Listener,
    bytes: VecDeque<u8>,
}

impl Tails {
    /// The tails of all robots with chips; their worlds must [keep the bytes](World::keep_tape).
    pub(crate) fn new(specs: &[RobotSpec]) -> Self {
        let chips = (0..specs.len()).filter(|&robot| specs[robot].chip.is_some());
        let tail = |robot| Tail { robot, listener: Listener::default(), bytes: VecDeque::new() };
        Self(Arc::new(Mutex::new(chips.map(tail).collect())))
    }

    /// Whether there is no robot with a chip.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_empty()
    }

    /// Keeps what has come since the last call.
    pub(crate) fn look(&self, world: &World) {
        for Tail { robot, listener, bytes } in
            self.0.lock().unwrap_or_else(PoisonError::into_inner).iter_mut()
        {
            listener.look(world, *robot, SimTime::ZERO);
            bytes.extend(&listener.bytes);
            bytes.drain(..bytes.len().saturating_sub(KEPT));
        }
    }

    /// The last line that a robot's chip has sent, if that is text.
    pub(crate) fn last_line(&self, robot: usize) -> Option<String> {
        let mut tails = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let tail = tails.iter_mut().find(|tail| tail.robot == robot)?;
        last_line(tail.bytes.make_contiguous())
    }
}

/// The last whole line of a text, or the beginning of its only one. Lines without anything in them are none.
fn last_line(bytes: &[u8]) -> Option<String> {
    let ended = bytes.iter().rposition(|byte| matches!(byte, b'\n' | b'\r'));
    let bytes = ended.map_or(bytes, |end| &bytes[..end]);
    // The first character may have begun before.
    let begin = bytes.iter().take(4).position(|byte| byte & 0xC0 != 0x80)?;
    let text = str::from_utf8(&bytes[begin..]).ok()?;
    if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
        return None;
    }
    let mut lines = text.split(['\n', '\r']).map(str::trim_end);
    lines.rfind(|line| !line.is_empty()).map(str::to_owned)
}

/// Bytes of each chip. Of a line that is longer the end is shown.
const KEPT: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_of_a_text_is_the_last_that_is_whole() {
        for (bytes, line) in [
            (&b"left 1\r\nright 2\r\nle"[..], Some("right 2")),
            (b"left 1\r\n\r\n", Some("left 1")),
            (b"no end of line", Some("no end of line")),
            ("12 °C\n".as_bytes(), Some("12 °C")),
            (b"", None),
            (b"\r\n", None),
        ] {
            assert_eq!(last_line(bytes).as_deref(), line, "{bytes:?}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_have_no_last_line() {
        assert_eq!(last_line(&[0xA5, 0x5A, 3, b'\n', b'a', b'\n']), None);
        assert_eq!(last_line(b"\x1b[2Jred\n"), None);
    }

    #[test]
    fn a_text_that_is_longer_than_what_is_kept_may_begin_within_a_character() {
        let mut text = "°".repeat(KEPT).into_bytes();
        text.extend(b"\nat last\n");
        let kept = &text[text.len() - KEPT..];
        assert_eq!(kept[0] & 0xC0, 0x80, "a character was cut");
        assert_eq!(last_line(kept).as_deref(), Some("at last"));
    }
}
