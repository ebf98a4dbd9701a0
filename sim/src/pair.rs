//! Two optional parts of a state in the form of one.
//!
//! States are serialised without names, so that a new field changes the bytes, and with them the fingerprint, of every
//! world. A [`Pair`] has the bytes of `Option<A>` as long as its second part is missing: a part that few worlds have
//! stands beside one that was there before it, and the other worlds keep their fingerprints.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Two parts of a state, each of which may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pair<A, B> {
    pub(crate) first: Option<A>,
    pub(crate) second: Option<B>,
}

/// What is written. The first two variants are those of an [`Option`].
#[derive(Serialize, Deserialize)]
enum Form<A, B> {
    Neither,
    First(A),
    Second(B),
    Both(A, B),
}

impl<A: Serialize, B: Serialize> Serialize for Pair<A, B> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let form = match (&self.first, &self.second) {
            (None, None) => Form::Neither,
            (Some(first), None) => Form::First(first),
            (None, Some(second)) => Form::Second(second),
            (Some(first), Some(second)) => Form::Both(first, second),
        };
        form.serialize(serializer)
    }
}

impl<'de, A: Deserialize<'de>, B: Deserialize<'de>> Deserialize<'de> for Pair<A, B> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match Form::deserialize(deserializer)? {
            Form::Neither => Self { first: None, second: None },
            Form::First(first) => Self { first: Some(first), second: None },
            Form::Second(second) => Self { first: None, second: Some(second) },
            Form::Both(first, second) => Self { first: Some(first), second: Some(second) },
        })
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::Pair;

    fn bytes(first: Option<u64>, second: Option<[f64; 2]>) -> Vec<u8> {
        let pair = Pair { first, second };
        let bytes = postcard::to_allocvec(&pair).unwrap();
        assert_eq!(postcard::from_bytes::<Pair<u64, [f64; 2]>>(&bytes).unwrap(), pair);
        bytes
    }

    #[test]
    fn a_pair_without_its_second_part_has_the_bytes_of_an_option() {
        for first in [None, Some(0), Some(1_000_000)] {
            assert_eq!(bytes(first, None), postcard::to_allocvec(&first).unwrap());
        }
    }

    #[test]
    fn a_second_part_is_written_and_read_with_and_without_the_first() {
        let second = Some([1.0, -2.0]);
        assert_ne!(bytes(None, second), bytes(None, None));
        assert_ne!(bytes(Some(7), second), bytes(Some(7), None));
    }
}
