//! Time on the wire: a 16-bit count of 100 µs, which wraps every 6.5536 s, and ages of the same unit in one byte.

/// The unit of time on the wire, in nanoseconds.
pub const UNIT_NS: u64 = 100_000;

/// The code on the wire for an instant of the microcontroller's clock, in nanoseconds.
pub const fn wrap_time(at_ns: u64) -> u16 {
    (at_ns / UNIT_NS) as u16
}

/// The code on the wire for an age in nanoseconds: whole units, at most 255, which means 25.5 ms or longer.
pub const fn age_100us(age_ns: u64) -> u8 {
    let units = age_ns / UNIT_NS;
    if units > 255 { 255 } else { units as u8 }
}

/// The latest instant, in nanoseconds, whose time on the wire is `time_100us` and which is not after `now_ns`; 0 if
/// there is none.
///
/// Both times are the microcontroller's clock, of which the receiver has only an estimate. An instant up to one unit
/// after `now_ns` therefore counts as not after it: taking it for one of 6.5 s ago would be a far greater error. Its
/// price is that an instant of 65,535 whole units ago, which has the same time on the wire, is taken for that one.
pub const fn unwrap_time(time_100us: u16, now_ns: u64) -> u64 {
    let latest = now_ns / UNIT_NS + 1;
    let before = (latest as u16).wrapping_sub(time_100us);
    latest.saturating_sub(before as u64).saturating_mul(UNIT_NS)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TURN_NS: u64 = 65_536 * UNIT_NS;

    proptest! {
        // No longer ago than 65,534 units: within one unit more it may be 65,535 from the one count to the other.
        #[test]
        fn an_instant_of_the_last_turn_comes_back(at_ns in 0..u64::MAX / 2, age_ns in 0..=TURN_NS - 2 * UNIT_NS) {
            prop_assert_eq!(unwrap_time(wrap_time(at_ns), at_ns + age_ns), at_ns - at_ns % UNIT_NS);
        }

        #[test]
        fn a_sender_one_unit_ahead_is_not_taken_for_one_a_turn_behind(at_ns in UNIT_NS..u64::MAX / 2) {
            prop_assert_eq!(unwrap_time(wrap_time(at_ns), at_ns - UNIT_NS), at_ns - at_ns % UNIT_NS);
        }

        #[test]
        fn nothing_overflows(time: u16, now_ns: u64) {
            prop_assert!(unwrap_time(time, now_ns) <= now_ns.saturating_add(UNIT_NS));
        }
    }

    #[test]
    fn the_oldest_instant_of_a_turn_is_taken_for_one_a_unit_ahead() {
        let at_ns = 7 * UNIT_NS;
        let now_ns = |units_later: u64| at_ns + units_later * UNIT_NS;
        assert_eq!(unwrap_time(wrap_time(at_ns), now_ns(65_534)), at_ns);
        assert_eq!(unwrap_time(wrap_time(at_ns), now_ns(65_535)), now_ns(65_536));
    }

    #[test]
    fn before_the_first_turn_there_is_nothing_before_zero() {
        assert_eq!(unwrap_time(60_000, 5 * UNIT_NS), 0);
        assert_eq!(unwrap_time(3, 5 * UNIT_NS), 3 * UNIT_NS);
    }

    #[test]
    fn ages_saturate() {
        assert_eq!((age_100us(99_999), age_100us(100_000), age_100us(u64::MAX)), (0, 1, 255));
    }
}
