//! Names that are like a name.

/// Names, those first that are most like `name`: that have the fewest letters to be put in, left out or changed.
pub fn nearest_first<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut known: Vec<_> = known.collect();
    known.sort_by_key(|candidate| distance(name, candidate));
    known
}

/// How many letters must be put in, left out or changed to make `b` of `a` (Levenshtein's distance).
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.chars().enumerate() {
            let changed = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.chars().count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        let found = [("", "abc"), ("abc", "abc"), ("abd", "abc"), ("bc", "abc"), ("kitten", "sitting")];
        assert_eq!(found.map(|(a, b)| distance(a, b)), [3, 0, 1, 1, 3]);
    }
}
