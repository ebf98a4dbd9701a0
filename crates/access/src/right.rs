//! Rights: what a token is good for.

use std::fmt;
use std::str::FromStr;

use baudbot_fields::printable::Printable;

use crate::need::Need;
use crate::pattern::{BadPattern, DrivePattern, brief};

/// A right of a token's holder.
///
/// In files it is `observe`, `operate`, `train` or `drive WORLD/ROBOT`.
///
/// Rights do not contain each other, but for observing: an operator can save a state and read it, and a trainer gets
/// the truth, so that keeping the rest from them would hide nothing. Driving is never contained. A robot has one driver
/// at a time; a program that starts and stops worlds must not take another user's robot by mistake, and only the
/// holders of tokens for a robot can drive it. For the same reason driving does not contain observing: a brain gets
/// only the readings of its cable. A token has as many rights as its holder needs.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Right {
    /// See what is true: worlds, robots, cables, recordings by name, metrics.
    Observe,
    /// Make worlds, run them, change them, delete them; and observe.
    Operate,
    /// Drive robots in lockstep and get the truth, as a program does that learns; and observe.
    Train,
    /// Drive these robots.
    Drive(DrivePattern),
}

/// A text that is not a right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadRight {
    /// There is no such right.
    #[error("`{}` is not a right; rights are `observe`, `operate`, `train` and `drive WORLD/ROBOT`", Printable(brief(.0)))]
    Unknown(String),
    /// The text lacks the robots that may be driven.
    #[error(
        "`drive` must name robots: `drive WORLD/ROBOT`, such as `drive wander/alice`, or `drive */*` for all"
    )]
    NoPattern,
    /// The robots that may be driven are not a pattern.
    #[error(transparent)]
    Pattern(#[from] BadPattern),
}

impl Right {
    /// All rights: those of the user's own token.
    pub fn all() -> Vec<Self> {
        vec![Self::Observe, Self::Operate, Self::Train, Self::Drive(DrivePattern::all())]
    }

    /// Whether it meets this need. For [`Need::Drive`] it is whether any robot may be driven.
    pub fn gives(&self, need: Need) -> bool {
        match need {
            Need::Nothing | Need::AnyToken => true,
            Need::Observe => match self {
                Self::Observe | Self::Operate | Self::Train => true,
                Self::Drive(_) => false,
            },
            Need::Operate => *self == Self::Operate,
            Need::Train => *self == Self::Train,
            Need::Drive => matches!(self, Self::Drive(_)),
        }
    }

    /// Whether this robot may be driven.
    pub fn drives(&self, world: &str, robot: &str) -> bool {
        matches!(self, Self::Drive(pattern) if pattern.covers(world, robot))
    }
}

impl FromStr for Right {
    type Err = BadRight;

    fn from_str(text: &str) -> Result<Self, BadRight> {
        match text {
            "observe" => Ok(Self::Observe),
            "operate" => Ok(Self::Operate),
            "train" => Ok(Self::Train),
            "drive" => Err(BadRight::NoPattern),
            _ => match text.strip_prefix("drive ") {
                Some(pattern) => Ok(Self::Drive(pattern.parse()?)),
                None => Err(BadRight::Unknown(text.to_owned())),
            },
        }
    }
}

impl fmt::Display for Right {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Observe => f.write_str("observe"),
            Self::Operate => f.write_str("operate"),
            Self::Train => f.write_str("train"),
            Self::Drive(pattern) => write!(f, "drive {pattern}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const NEEDS: [Need; 6] =
        [Need::Nothing, Need::AnyToken, Need::Observe, Need::Operate, Need::Train, Need::Drive];

    #[test]
    fn each_right_meets_its_own_needs() {
        let met = |right: Right| NEEDS.map(|need| right.gives(need));
        assert_eq!(met(Right::Observe), [true, true, true, false, false, false]);
        assert_eq!(met(Right::Operate), [true, true, true, true, false, false]);
        assert_eq!(met(Right::Train), [true, true, true, false, true, false]);
        assert_eq!(met(Right::Drive(DrivePattern::all())), [true, true, false, false, false, true]);
        assert!(NEEDS.iter().all(|need| Right::all().iter().any(|right| right.gives(*need))));
    }

    #[test]
    fn a_text_that_is_no_right_is_refused_with_the_remedy() {
        let bad = |text: &str| text.parse::<Right>().unwrap_err().to_string();
        let rights = "rights are `observe`, `operate`, `train` and `drive WORLD/ROBOT`";
        assert_eq!(bad("fly"), format!("`fly` is not a right; {rights}"));
        assert_eq!(bad("Observe"), format!("`Observe` is not a right; {rights}"));
        assert_eq!(bad("drivex/y"), format!("`drivex/y` is not a right; {rights}"));
        assert!(bad("drive").contains("must name robots"));
        assert!(bad("drive alice").contains("it has 0 slashes"), "{}", bad("drive alice"));
        assert!(bad("drive  a/b").contains("the world has ` ` in it"), "{}", bad("drive  a/b"));
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read_again(which in 0..4_usize, pattern in "[a-z*]{1,9}/[a-z*]{1,9}") {
            let right = match which {
                3 => Right::Drive(pattern.parse().unwrap()),
                which => Right::all().swap_remove(which),
            };
            prop_assert_eq!(right.to_string().parse::<Right>().unwrap(), right);
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in ".*", more in "drive .*") {
            for text in [text, more] {
                if let Ok(right) = text.parse::<Right>() {
                    prop_assert_eq!(right.to_string(), text);
                }
            }
        }
    }
}
