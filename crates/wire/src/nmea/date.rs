//! The calendar of a receiver whose run has no date of its own.

/// The date so many days after 1 January 2016: day from 1, month from 1, and the last two digits of the year.
///
/// A run begins on that day, so that the same run always has the same bytes. The day is one that programs take as it is:
/// gpsd takes two digits from 80 on as 1980 to 1999 and all others as a year of this century (`merge_ddmmyy` in its
/// `driver_nmea0183.c`, 3.22), and refuses none for its age.
pub const fn date_after(days: u32) -> (u8, u8, u8) {
    let (mut days, mut year) = (days % DAYS_OF_400_YEARS, 2016);
    while days >= days_of_year(year) {
        days -= days_of_year(year);
        year += 1;
    }
    let mut month = 1;
    while days >= days_of_month(month, year) {
        days -= days_of_month(month, year);
        month += 1;
    }
    (days as u8 + 1, month, (year % 100) as u8)
}

const fn is_leap(year: u32) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

const fn days_of_year(year: u32) -> u32 {
    if is_leap(year) { 366 } else { 365 }
}

const fn days_of_month(month: u8, year: u32) -> u32 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// The days after which the calendar repeats.
const DAYS_OF_400_YEARS: u32 = 146_097;

#[cfg(test)]
mod tests {
    use super::date_after;

    #[test]
    fn days_have_their_dates() {
        let dates =
            [(0, (1, 1, 16)), (59, (29, 2, 16)), (60, (1, 3, 16)), (365, (31, 12, 16)), (366, (1, 1, 17))];
        for (days, date) in dates {
            assert_eq!(date_after(days), date, "{days}");
        }
        assert_eq!(date_after(366 + 3 * 365), (1, 1, 20));
        assert_eq!(date_after(u32::MAX).1.clamp(1, 12), date_after(u32::MAX).1);
    }
}
