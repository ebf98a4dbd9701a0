//! Dates in files and for people: RFC 3339, in whole seconds.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// A text that is not a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be a date from 1970 to 9999 with its time and offset, such as 2027-01-31T12:00:00Z")]
pub struct BadDate;

/// The last second that has a date, since 1970: the end of the year 9999.
const LAST_S: u64 = 253_402_300_799;

/// Reads a date.
///
/// # Errors
/// If it is none, or before 1970.
pub fn parse(text: &str) -> Result<SystemTime, BadDate> {
    let date = OffsetDateTime::parse(text, &Rfc3339).map_err(|_| BadDate)?;
    let seconds = u64::try_from(date.unix_timestamp()).map_err(|_| BadDate)?;
    Ok(UNIX_EPOCH + Duration::from_secs(seconds.min(LAST_S)))
}

/// The date in UTC, such as `2027-01-31T12:00:00Z`. What is before 1970 or after 9999 is shown as these ends.
pub fn print(at: SystemTime) -> String {
    of(at).format(&Rfc3339).expect("years up to 9999 have a date in RFC 3339")
}

/// The same second as a value of the crate `time`.
pub(crate) fn of(at: SystemTime) -> OffsetDateTime {
    let seconds = at.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()).min(LAST_S);
    OffsetDateTime::from_unix_timestamp(seconds.cast_signed()).expect("it is within the years of the crate")
}

/// The beginning of its second: what a file keeps of it.
#[cfg(feature = "files")]
pub(crate) fn whole(at: SystemTime) -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(of(at).unix_timestamp().cast_unsigned())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn dates_are_those_of_rfc_3339() {
        let at = |seconds| UNIX_EPOCH + Duration::from_secs(seconds);
        assert_eq!(print(at(0)), "1970-01-01T00:00:00Z");
        // date --utc --date @1801396800
        assert_eq!(print(at(1_801_396_800)), "2027-01-31T12:00:00Z");
        assert_eq!(parse("2027-01-31T12:00:00Z"), Ok(at(1_801_396_800)));
        assert_eq!(parse("2027-01-31T13:30:00.75+01:30"), Ok(at(1_801_396_800)));
        assert_eq!(print(at(u64::MAX / 4)), "9999-12-31T23:59:59Z");
        assert_eq!(print(at(0) - Duration::from_secs(9)), "1970-01-01T00:00:00Z");
        for wrong in ["", "2027-01-31", "2027-01-31T12:00:00", "2027-02-30T12:00:00Z", "1969-12-31T23:59:59Z"]
        {
            assert_eq!(parse(wrong), Err(BadDate), "{wrong}");
        }
        assert_eq!(parse("9999-12-31T23:59:59-23:59"), Ok(at(LAST_S)));
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read_again(seconds in 0..=LAST_S, nanoseconds in 0..1_000_000_000_u32) {
            let at = UNIX_EPOCH + Duration::new(seconds, nanoseconds);
            prop_assert_eq!(parse(&print(at)), Ok(UNIX_EPOCH + Duration::from_secs(seconds)));
            prop_assert_eq!(parse(&print(at)), Ok(whole(at)));
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in ".*", near in "[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:.]{8,12}[+-][0-9]{2}:[0-9]{2}") {
            let _ = (parse(&text), parse(&near));
        }
    }
}
