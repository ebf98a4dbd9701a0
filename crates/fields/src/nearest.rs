//! Suggestions of names that a user may have meant.

use alloc::vec;
use alloc::vec::Vec;

/// Longest name that is compared with others, in characters; a longer one is not mistyped.
const MAX_CHARACTERS: usize = 64;

/// Most names that are listed.
const MAX_NAMES: usize = 4;

/// The things with the name in theirs, or else those with the fewest edits between, if these are at most half of it.
pub fn nearest<T>(name: &str, all: impl Iterator<Item = T>, name_of: impl Fn(&T) -> &str) -> Vec<T> {
    let name: Vec<char> = name.chars().take(MAX_CHARACTERS + 1).map(|c| c.to_ascii_lowercase()).collect();
    if name.len() > MAX_CHARACTERS {
        return Vec::new();
    }
    let distances: Vec<_> = all.map(|one| (distance(&name, name_of(&one)), one)).collect();
    let Some(least) = distances.iter().map(|(distance, _)| *distance).min() else { return Vec::new() };
    if least > name.len() / 2 + 1 {
        return Vec::new();
    }
    let those = distances.into_iter().filter(|(distance, _)| *distance == least).map(|(_, one)| one);
    those.take(MAX_NAMES).collect()
}

/// The distance of a name from another: 0 if it contains that, else Levenshtein's.
fn distance(name: &[char], other: &str) -> usize {
    if name.len() >= 3 && other.chars().collect::<Vec<_>>().windows(name.len()).any(|part| part == name) {
        return 0;
    }
    edits(name, other)
}

/// Levenshtein's distance: how many characters must be inserted, deleted or changed to make one name of another.
pub fn edits(name: &[char], other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, &a) in name.iter().enumerate() {
        let mut next = vec![i + 1; other.len() + 1];
        for (j, &b) in other.iter().enumerate() {
            next[j + 1] = (row[j] + usize::from(a != b)).min(row[j + 1] + 1).min(next[j] + 1);
        }
        row = next;
    }
    row[other.len()]
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::distance;

    #[test]
    fn distances_are_levenshteins() {
        let chars = |text: &str| text.chars().collect::<Vec<_>>();
        for (a, b, expected) in [("", "", 0), ("abc", "abd", 1), ("kitten", "sitting", 3), ("", "abc", 3)] {
            assert_eq!(distance(&chars(a), b), expected, "{a} {b}");
        }
    }
}
