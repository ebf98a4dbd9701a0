//! Numbers in the replies of robots.

/// The numbers in a reply, in their order: `n,12,-3.5` has 12 and −3.5. Digits that belong to a word, as in `ir0`, are none.
pub(super) fn numbers(reply: &str) -> Vec<f64> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+' | '_');
    let words =
        reply.split(|c| !is_part(c)).filter(|word| word.starts_with(|c: char| !c.is_ascii_alphabetic()));
    words.filter_map(|word| word.parse().ok()).filter(|number: &f64| number.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_found_between_words() {
        assert_eq!(numbers("n,12,-3.5\r"), [12.0, -3.5]);
        assert_eq!(numbers("distance: 1e3 mm, ir0 = 7"), [1000.0, 7.0]);
        assert_eq!(numbers("left=4 right=5; nan inf --"), [4.0, 5.0]);
        assert_eq!(numbers("h,007,+2"), [7.0, 2.0]);
        assert!(numbers("d").is_empty());
    }
}
