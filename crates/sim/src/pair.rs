//! Up to five optional parts of a state in the form of one.
//!
//! States are serialised without names, so that a new field changes the bytes, and with them the fingerprint, of every
//! world. A [`Pair`] has the bytes of `Option<A>` as long as its other parts are missing: a part that few worlds have
//! stands beside one that was there before it, and the other worlds keep their fingerprints.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Two parts of a state, and seldom more, each of which may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pair<A, B, C = (), D = (), E = ()> {
    pub(crate) first: Option<A>,
    pub(crate) second: Option<B>,
    pub(crate) third: Option<C>,
    pub(crate) fourth: Option<D>,
    pub(crate) fifth: Option<E>,
}

/// What is written. The first two variants are those of an [`Option`].
#[derive(Serialize, Deserialize)]
enum Form<A, B, C, D, E> {
    Neither,
    First(A),
    Second(B),
    Both(A, B),
    Third(C),
    FirstAndThird(A, C),
    SecondAndThird(B, C),
    All(A, B, C),
    WithFourth(Option<A>, Option<B>, Option<C>, D),
    WithFifth(Option<A>, Option<B>, Option<C>, Option<D>, E),
}

impl<A: Serialize, B: Serialize, C: Serialize, D: Serialize, E: Serialize> Serialize for Pair<A, B, C, D, E> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if let Some(fifth) = &self.fifth {
            let (first, second) = (self.first.as_ref(), self.second.as_ref());
            let (third, fourth) = (self.third.as_ref(), self.fourth.as_ref());
            return Form::WithFifth(first, second, third, fourth, fifth).serialize(serializer);
        }
        if let Some(fourth) = &self.fourth {
            let (first, second, third) = (self.first.as_ref(), self.second.as_ref(), self.third.as_ref());
            let form: Form<_, _, _, _, &E> = Form::WithFourth(first, second, third, fourth);
            return form.serialize(serializer);
        }
        let form: Form<&A, &B, &C, &D, &E> = match (&self.first, &self.second, &self.third) {
            (None, None, None) => Form::Neither,
            (Some(first), None, None) => Form::First(first),
            (None, Some(second), None) => Form::Second(second),
            (Some(first), Some(second), None) => Form::Both(first, second),
            (None, None, Some(third)) => Form::Third(third),
            (Some(first), None, Some(third)) => Form::FirstAndThird(first, third),
            (None, Some(second), Some(third)) => Form::SecondAndThird(second, third),
            (Some(first), Some(second), Some(third)) => Form::All(first, second, third),
        };
        form.serialize(serializer)
    }
}

impl<'de, A, B, C, D, E> Deserialize<'de> for Pair<A, B, C, D, E>
where
    A: Deserialize<'de>,
    B: Deserialize<'de>,
    C: Deserialize<'de>,
    D: Deserialize<'de>,
    E: Deserialize<'de>,
{
    fn deserialize<F: Deserializer<'de>>(deserializer: F) -> Result<Self, F::Error> {
        let (mut fourth, mut fifth) = (None, None);
        let (first, second, third) = match Form::deserialize(deserializer)? {
            Form::Neither => (None, None, None),
            Form::First(first) => (Some(first), None, None),
            Form::Second(second) => (None, Some(second), None),
            Form::Both(first, second) => (Some(first), Some(second), None),
            Form::Third(third) => (None, None, Some(third)),
            Form::FirstAndThird(first, third) => (Some(first), None, Some(third)),
            Form::SecondAndThird(second, third) => (None, Some(second), Some(third)),
            Form::All(first, second, third) => (Some(first), Some(second), Some(third)),
            Form::WithFourth(first, second, third, last) => {
                fourth = Some(last);
                (first, second, third)
            }
            Form::WithFifth(first, second, third, fourth_too, last) => {
                (fourth, fifth) = (fourth_too, Some(last));
                (first, second, third)
            }
        };
        Ok(Self { first, second, third, fourth, fifth })
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::Pair;

    fn bytes(first: Option<u64>, second: Option<[f64; 2]>) -> Vec<u8> {
        let pair = Pair { first, second, third: None::<()>, fourth: None::<()>, fifth: None::<()> };
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

    #[test]
    fn a_third_part_is_written_and_read_with_and_without_the_others() {
        for (first, second) in [(None, None), (Some(7), None), (None, Some(8)), (Some(7), Some(8))] {
            let pair = Pair { first, second, third: Some(9_u64), fourth: None::<()>, fifth: None::<()> };
            let bytes = postcard::to_allocvec(&pair).unwrap();
            assert_eq!(postcard::from_bytes::<Pair<u64, u64, u64>>(&bytes).unwrap(), pair);
            let pair = Pair { first, second, third: pair.third, fourth: Some(10_u64), fifth: None::<()> };
            let bytes = postcard::to_allocvec(&pair).unwrap();
            assert_eq!(postcard::from_bytes::<Pair<u64, u64, u64, u64>>(&bytes).unwrap(), pair);
            let pair = Pair { first, second, third: None::<u64>, fourth: pair.fourth, fifth: Some(11_u64) };
            let bytes = postcard::to_allocvec(&pair).unwrap();
            assert_eq!(postcard::from_bytes::<Pair<u64, u64, u64, u64, u64>>(&bytes).unwrap(), pair);
        }
    }
}
