//! The frames of a servo's signal: a pulse at each multiple of the frame's length, 20 ms as a rule, whose
//! width is what was commanded when it began. A length of 0 stands for a servo that obeys at once.

use crate::time::SimTime;

/// The start of the frame that `now` is in.
pub(super) fn start(now: SimTime, frame_ns: u64) -> SimTime {
    SimTime::from_ns(now.as_ns() - now.as_ns().checked_rem(frame_ns).unwrap_or(0))
}

/// When a command that comes at `command` takes effect: at the start of the first frame not before it.
pub(super) fn takes_effect(command: SimTime, frame_ns: u64) -> SimTime {
    let begun = start(command, frame_ns);
    if begun == command { command } else { begun + frame_ns }
}

#[cfg(test)]
mod tests {
    use super::{start, takes_effect};
    use crate::time::SimTime;

    #[test]
    fn a_command_takes_effect_in_the_first_frame_that_begins_after_it() {
        let at = |ns| takes_effect(SimTime::from_ns(ns), 20).as_ns();
        assert_eq!([at(0), at(1), at(19), at(20), at(21)], [0, 20, 20, 20, 40]);
        assert_eq!(takes_effect(SimTime::from_ns(7), 0), SimTime::from_ns(7));
        assert_eq!(takes_effect(SimTime::NEVER, 20), SimTime::NEVER);
    }

    #[test]
    fn a_command_is_in_effect_when_it_came_before_the_present_frame() {
        for frame_ns in [0, 1, 7, 20] {
            for (command, now) in (0..60).flat_map(|command| (command..80).map(move |now| (command, now))) {
                let [command, now] = [command, now].map(SimTime::from_ns);
                let in_effect = takes_effect(command, frame_ns) <= now;
                assert_eq!(in_effect, command <= start(now, frame_ns), "{command:?} {now:?} {frame_ns}");
            }
        }
    }
}
