//! The order in which people look for names: `cell-2` before `cell-10`. Worlds, JSON and tables have the plain order of names.

/// The things in the natural order of their names.
pub(crate) fn sorted<T>(things: impl IntoIterator<Item = T>, name: impl Fn(&T) -> &str) -> Vec<T> {
    let mut things: Vec<_> = things.into_iter().collect();
    things.sort_by(|one, other| alphanumeric_sort::compare_str(name(one), name(other)));
    things
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let names = ["cell-10", "cell-2", "cell-1", "a"];
        assert_eq!(sorted(names, |name| name), ["a", "cell-1", "cell-2", "cell-10"]);
    }
}
