//! Names that are like a name.

/// Names, the most similar to `name` first: those that need the fewest letters to be added, removed or replaced.
pub fn nearest_first<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut known: Vec<_> = known.collect();
    known.sort_by_key(|candidate| strsim::levenshtein(name, candidate));
    known
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_need_the_fewest_changes_come_first() {
        let found = nearest_first("abd", ["sitting", "abcdef", "bc", "abc", "abd"].into_iter());
        assert_eq!(found, ["abd", "abc", "bc", "abcdef", "sitting"]);
        assert_eq!(nearest_first("", ["abc", "ab"].into_iter()), ["ab", "abc"]);
    }
}
