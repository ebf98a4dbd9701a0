//! Names for worlds on servers that others use, too.

use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};

/// The kind of work and a random id: no other work has this name, on whatever host it is.
pub fn unique_name(kind: &str) -> String {
    format!("{kind}-{}", random_id())
}

/// 16 hexadecimal digits.
pub(crate) fn random_id() -> String {
    // The keys of the hash are random, so the hash of nothing is, too.
    format!("{:016x}", RandomState::new().build_hasher().finish())
}

/// Whether it may come from `random_id`.
pub(crate) fn is_id(text: &str) -> bool {
    text.len() == ID_LEN && is_start_of_id(text)
}

/// Whether it may be the first part of what comes from `random_id`.
pub(crate) fn is_start_of_id(text: &str) -> bool {
    text.len() <= ID_LEN && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

const ID_LEN: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_names_are_the_same_and_servers_take_them() {
        let names: std::collections::BTreeSet<_> = (0..100).map(|_| unique_name("find")).collect();
        assert_eq!(names.len(), 100);
        for name in names {
            let id = name.strip_prefix("find-").expect(&name);
            assert!(is_id(id), "{name}");
            // The name has at most 64 bytes with the number of a run.
            assert!(format!("sweep-{id}-{}", u64::MAX).len() <= 64, "{name}");
        }
    }
}
