//! Optional parts of a state, by their names.
//!
//! A state is serialised without the names of its fields, so that a new field changes the bytes, and with them the
//! fingerprint, of every world. Optional parts are in a struct of their own, which is written as a map: of the parts that are
//! there, each with its name. So a further part changes nothing for worlds without it, and states that were kept before there was
//! such a part can be read. A struct without any of its parts has the byte of a `None`: an `Option` that a state has already
//! may become such a struct.

/// Serialises a struct whose fields are all `Option`s as a map of those that are there. A field's name is part of what is written.
macro_rules! optional_parts {
    ($type:ty { $($part:ident),+ }) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                use serde::ser::SerializeMap;
                let Self { $($part),+ } = self;
                let mut map = serializer.serialize_map(Some(0 $(+ usize::from($part.is_some()))+))?;
                $(if let Some(part) = $part {
                    map.serialize_entry(stringify!($part), part)?;
                })+
                map.end()
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Parts;

                impl<'de> serde::de::Visitor<'de> for Parts {
                    type Value = $type;

                    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                        f.write_str("parts of a state with their names")
                    }

                    fn visit_map<A: serde::de::MapAccess<'de>>(self, mut map: A) -> Result<$type, A::Error> {
                        let mut parts = <$type>::default();
                        while let Some(name) = map.next_key::<&str>()? {
                            match name {
                                $(stringify!($part) if parts.$part.is_some() => {
                                    return Err(serde::de::Error::duplicate_field(stringify!($part)));
                                }
                                stringify!($part) => parts.$part = Some(map.next_value()?),)+
                                _ => return Err(serde::de::Error::unknown_field(name, &[$(stringify!($part)),+])),
                            }
                        }
                        Ok(parts)
                    }
                }

                deserializer.deserialize_map(Parts)
            }
        }
    };
}

pub(crate) use optional_parts;

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use serde::Serialize;

    use crate::hash;

    #[derive(Debug, Default, PartialEq)]
    struct Before {
        charge: Option<u64>,
        error_m: Option<[f64; 2]>,
    }

    /// The same type with another part added.
    #[derive(Debug, Default, PartialEq)]
    struct After {
        added: Option<u64>,
        charge: Option<u64>,
        error_m: Option<[f64; 2]>,
    }

    optional_parts!(Before { charge, error_m });
    optional_parts!(After { added, charge, error_m });

    /// A state around such parts, as a robot's is.
    fn state<T: Serialize>(parts: T) -> (u8, T, [f64; 3]) {
        (1, parts, [2.0, 3.0, 4.0])
    }

    fn bytes(value: &impl Serialize) -> Vec<u8> {
        postcard::to_allocvec(value).unwrap()
    }

    #[test]
    fn a_part_that_is_added_and_absent_changes_neither_fingerprint_nor_bytes() {
        for charge in [None, Some(0), Some(1_000_000)] {
            for error_m in [None, Some([1.0, -2.0])] {
                let before = state(Before { charge, error_m });
                let after = state(After { added: None, charge, error_m });
                assert_eq!(hash::of(&before), hash::of(&after));
                assert_eq!(bytes(&before), bytes(&after));
                assert_eq!(postcard::from_bytes::<(u8, After, [f64; 3])>(&bytes(&before)).unwrap(), after);
                let with_it = state(After { added: Some(0), charge, error_m });
                assert_ne!(hash::of(&before), hash::of(&with_it));
                assert_eq!(postcard::from_bytes::<(u8, After, [f64; 3])>(&bytes(&with_it)).unwrap(), with_it);
                assert!(postcard::from_bytes::<(u8, Before, [f64; 3])>(&bytes(&with_it)).is_err());
            }
        }
    }

    #[test]
    fn a_part_that_comes_twice_or_has_another_name_is_refused() {
        let twice = |names: [&str; 2]| {
            let mut map = alloc::vec![2];
            for name in names {
                map.push(name.len() as u8);
                map.extend(name.bytes().chain([7]));
            }
            postcard::from_bytes::<After>(&map)
        };
        assert_eq!(
            twice(["charge", "added"]).unwrap(),
            After { charge: Some(7), added: Some(7), error_m: None }
        );
        for names in [["charge", "charge"], ["charge", "fuel"]] {
            assert!(twice(names).is_err(), "{names:?}");
        }
    }

    #[test]
    fn a_struct_without_its_parts_has_the_bytes_of_none() {
        assert_eq!(bytes(&Before::default()), bytes(&None::<u64>));
    }

    #[test]
    fn parts_of_equal_values_have_fingerprints_of_their_own() {
        let charge = After { charge: Some(7), ..After::default() };
        let added = After { added: Some(7), ..After::default() };
        assert_ne!(hash::of(&charge), hash::of(&added));
    }
}
