//! The fixed parts of an exported file, in C.

/// A part of the file that is the same in each brain that needs it, in the order of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Fragment {
    Max,
    Min,
    Clamp,
    Since,
    Parts,
    Tanh,
    Greatest,
    Utility,
    Reservoir,
    Layer,
    Limit,
    Chance,
    Wander,
    Avoid,
}

impl Fragment {
    /// The parts that it calls.
    pub(super) fn needs(self) -> &'static [Self] {
        match self {
            Self::Max
            | Self::Min
            | Self::Clamp
            | Self::Since
            | Self::Parts
            | Self::Tanh
            | Self::Greatest
            | Self::Chance => &[],
            Self::Utility => &[Self::Parts, Self::Min, Self::Tanh],
            Self::Reservoir => &[Self::Parts, Self::Max, Self::Min, Self::Greatest],
            Self::Layer => &[Self::Tanh],
            Self::Limit => &[Self::Clamp],
            Self::Wander => &[Self::Chance],
            Self::Avoid => &[Self::Chance, Self::Max, Self::Clamp, Self::Since],
        }
    }

    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Max => include_str!("c/max.c"),
            Self::Min => include_str!("c/min.c"),
            Self::Clamp => include_str!("c/clamp.c"),
            Self::Since => include_str!("c/since.c"),
            Self::Parts => include_str!("c/parts.c"),
            Self::Tanh => include_str!("c/tanh.c"),
            Self::Greatest => include_str!("c/greatest.c"),
            Self::Utility => include_str!("c/utility.c"),
            Self::Reservoir => include_str!("c/reservoir.c"),
            Self::Layer => include_str!("c/layer.c"),
            Self::Limit => include_str!("c/limit.c"),
            Self::Chance => include_str!("c/chance.c"),
            Self::Wander => include_str!("c/wander.c"),
            Self::Avoid => include_str!("c/avoid.c"),
        }
    }
}
