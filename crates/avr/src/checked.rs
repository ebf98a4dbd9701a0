//! Values that are saved and loaded, and checked when they are loaded.

/// Implements `Serialize` and `Deserialize` for a type that derives them with `#[serde(remote = "Self")]`. What is loaded must
/// fulfil its `is_possible`.
macro_rules! checked {
    ($type:ty, $refusal:literal) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Self::serialize(self, serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let value = Self::deserialize(deserializer)?;
                if value.is_possible() { Ok(value) } else { Err(serde::de::Error::custom($refusal)) }
            }
        }
    };
}

pub(crate) use checked;
