//! Quantities in words, in the units in which they are handy numbers.

/// A number with at most three decimals and no trailing zeros.
pub fn handy(number: f64) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A span in nanoseconds, in a handy unit.
pub fn duration(ns: f64) -> String {
    match ns.abs() {
        size if size < 1e3 => format!("{ns:.0} ns"),
        size if size < 1e6 => format!("{} µs", handy(ns / 1e3)),
        size if size < 1e9 => format!("{} ms", handy(ns / 1e6)),
        _ => format!("{} s", handy(ns / 1e9)),
    }
}

/// A length in metres, in a handy unit.
pub fn length(metres: f64) -> String {
    match metres.abs() {
        size if size >= 10_000.0 => format!("{} km", handy(metres / 1e3)),
        size if size >= 100.0 => format!("{metres:.0} m"),
        size if size >= 0.01 || size == 0.0 => format!("{} m", handy(metres)),
        size if size >= 1e-5 => format!("{} mm", handy(metres * 1e3)),
        _ => format!("{} µm", handy(metres * 1e6)),
    }
}

/// A number of things, with the plural of their name.
pub fn count(number: usize, one: &str) -> String {
    format!("{number} {one}{}", if number == 1 { "" } else { "s" })
}

/// Stands where there is no number.
pub const NOTHING: &str = "—";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_a_unit_that_suits_them() {
        assert_eq!(duration(999.0), "999 ns");
        assert_eq!(duration(20e6), "20 ms");
        assert_eq!(duration(19_791_667.0), "19.792 ms");
        assert_eq!(duration(-1_500.0), "-1.5 µs");
    }

    #[test]
    fn lengths_have_a_unit_that_suits_them() {
        assert_eq!(
            [0.0275, 0.005, 3.0, 100.4, 25e3].map(length),
            ["0.028 m", "5 mm", "3 m", "100 m", "25 km"]
        );
    }

    #[test]
    fn things_are_counted_in_the_plural() {
        assert_eq!(count(1, "turn") + &count(0, "turn"), "1 turn0 turns");
    }
}
