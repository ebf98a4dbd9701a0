//! Grants: what the holder of a token may do, and until when.

use std::fmt;
use std::str::FromStr;
use std::time::SystemTime;

use baudbot_fields::printable::Printable;

use crate::date;
use crate::need::Need;
use crate::pattern::brief;
use crate::right::Right;
use crate::token::TokenHash;

/// The rights of a token's holder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grant {
    /// The token's name in logs.
    pub name: GrantName,
    /// The token.
    pub hash: TokenHash,
    /// The rights that it gives.
    pub rights: Vec<Right>,
    /// The instant at which it was made.
    pub created_at: SystemTime,
    /// The instant from which on the grant is not valid; `None` for never.
    pub expires_at: Option<SystemTime>,
}

/// The name of a grant: 1 to 64 letters, digits, `_`, `-`, `.` and `@`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct GrantName(String);

/// A text that is not the name of a grant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be 1 to {MAX_LENGTH} letters, digits, `_`, `-`, `.` or `@`, is `{}`", Printable(brief(.0)))]
pub struct BadName(String);

/// The caller is known, and may not do this.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Denied {
    /// None of its rights meets the need.
    #[error("the token `{name}` has no right to this, which needs `{need}`; it has {}", listed(rights))]
    Need {
        /// The token.
        name: GrantName,
        /// The missing right.
        need: Need,
        /// The caller's rights.
        rights: Vec<Right>,
    },
    /// The grant does not allow to drive this robot.
    #[error(
        "the token `{name}` has no right to drive {}; it has {}",
        Printable(brief(robot)),
        listed(rights)
    )]
    Robot {
        /// The token.
        name: GrantName,
        /// The robot, as `WORLD/ROBOT`.
        robot: String,
        /// The caller's rights.
        rights: Vec<Right>,
    },
}

/// Characters of the longest name.
const MAX_LENGTH: usize = 64;

/// The name of the grant that is no file's.
pub(crate) const LOCAL: &str = "local";

/// The name in the logs of a caller without a valid token.
const NOBODY: &str = "nobody";

impl Grant {
    /// The grant of the user who runs the server, with all rights and no end. Its name is `local`, which no file has.
    pub fn local(hash: TokenHash, now: SystemTime) -> Self {
        let name = GrantName(LOCAL.to_owned());
        Self { name, hash, rights: Right::all(), created_at: now, expires_at: None }
    }

    /// Whether a call with this need may be made. For [`Need::Drive`] this is whether any robot may be driven; a call
    /// that has named one goes on only if [`may_drive`](Self::may_drive) allows it, too.
    ///
    /// # Errors
    /// If no right meets the need.
    pub fn may(&self, need: Need) -> Result<(), Denied> {
        let may = match need {
            Need::Nothing | Need::AnyToken => true,
            Need::Observe | Need::Operate | Need::Train | Need::Drive => {
                self.rights.iter().any(|right| right.gives(need))
            }
        };
        let denied = || Denied::Need { name: self.name.clone(), need, rights: self.rights.clone() };
        may.then_some(()).ok_or_else(denied)
    }

    /// Whether this robot of this world may be driven.
    ///
    /// # Errors
    /// If no right covers it.
    pub fn may_drive(&self, world: &str, robot: &str) -> Result<(), Denied> {
        if self.rights.iter().any(|right| right.drives(world, robot)) {
            return Ok(());
        }
        let robot = format!("{world}/{robot}");
        Err(Denied::Robot { name: self.name.clone(), robot, rights: self.rights.clone() })
    }

    /// Whether it is over.
    pub fn has_expired(&self, now: SystemTime) -> bool {
        self.expires_at.is_some_and(|end| now >= end)
    }
}

impl GrantName {
    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether no token of a file may have it, because the logs call others so.
    pub fn is_reserved(&self) -> bool {
        [LOCAL, NOBODY].contains(&self.as_str())
    }
}

impl FromStr for GrantName {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.' | '@');
        let is_good = (1..=MAX_LENGTH).contains(&text.len()) && text.chars().all(fits);
        is_good.then(|| Self(text.to_owned())).ok_or_else(|| BadName(text.to_owned()))
    }
}

impl fmt::Display for GrantName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The rights for people. Of a token with many, the first.
fn listed(rights: &[Right]) -> String {
    let shown: Vec<_> = rights.iter().take(MOST_SHOWN).map(|right| format!("`{right}`")).collect();
    match rights.len().checked_sub(MOST_SHOWN) {
        None | Some(0) => shown.join(", "),
        Some(more) => format!("{} and {more} more", shown.join(", ")),
    }
}

const MOST_SHOWN: usize = 8;

/// In words, for lists and logs: `operate, drive */*, until 2027-01-31T12:00:00Z`.
impl fmt::Display for Grant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&words(&self.rights, self.expires_at))
    }
}

/// Rights and their end in words.
pub(crate) fn words(rights: &[Right], expires_at: Option<SystemTime>) -> String {
    let rights: Vec<_> = rights.iter().map(ToString::to_string).collect();
    let end = expires_at.map(|end| format!(", until {}", date::print(end)));
    rights.join(", ") + &end.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, UNIX_EPOCH};

    use super::*;
    use crate::token::Token;

    fn grant(rights: &[&str]) -> Grant {
        let rights = rights.iter().map(|right| right.parse().unwrap()).collect();
        let hash = Token::random().unwrap().hash();
        Grant { name: "alice".parse().unwrap(), hash, rights, created_at: UNIX_EPOCH, expires_at: None }
    }

    #[test]
    fn rights_add_up() {
        let both = grant(&["observe", "drive wander/alice", "drive class-*/robot"]);
        assert_eq!(both.may(Need::Observe), Ok(()));
        assert_eq!(both.may(Need::Drive), Ok(()));
        assert_eq!(both.may_drive("wander", "alice"), Ok(()));
        assert_eq!(both.may_drive("class-7", "robot"), Ok(()));
        assert!(both.may_drive("wander", "robot").is_err(), "a world of one and the robot of another");
        assert!(both.may(Need::Operate).is_err());
        assert!(both.may(Need::Train).is_err());
    }

    #[test]
    fn who_is_denied_something_is_told_what_is_missing() {
        let alice = grant(&["observe", "drive wander/alice"]);
        let words = alice.may(Need::Operate).unwrap_err().to_string();
        let expected = "the token `alice` has no right to this, which needs `operate`; it has `observe`, `drive wander/alice`";
        assert_eq!(words, expected);
        let words = alice.may_drive("wander", "bob\u{1b}[2J").unwrap_err().to_string();
        let expected = r"the token `alice` has no right to drive wander/bob\u{1b}[2J; it has `observe`, `drive wander/alice`";
        assert_eq!(words, expected);
        let many: Vec<_> = (0..100).map(|i| format!("drive wander/r{i}")).collect();
        let many: Vec<_> = many.iter().map(String::as_str).collect();
        let words = grant(&many).may(Need::Train).unwrap_err().to_string();
        assert!(words.ends_with("`drive wander/r7` and 92 more"), "{words}");
    }

    #[test]
    fn the_local_user_may_do_everything() {
        let local = Grant::local(Token::random().unwrap().hash(), UNIX_EPOCH);
        for need in [Need::Nothing, Need::AnyToken, Need::Observe, Need::Operate, Need::Train, Need::Drive] {
            assert_eq!(local.may(need), Ok(()));
        }
        assert_eq!(local.may_drive("any", "robot"), Ok(()));
        assert!(!local.has_expired(SystemTime::now()));
    }

    #[test]
    fn a_grant_is_over_at_its_end() {
        let end = UNIX_EPOCH + Duration::from_secs(100);
        let short = Grant { expires_at: Some(end), ..grant(&["observe"]) };
        assert!(!short.has_expired(end - Duration::from_nanos(1)));
        assert!(short.has_expired(end));
        assert_eq!(short.to_string(), "observe, until 1970-01-01T00:01:40Z");
    }

    #[test]
    fn names_go_into_logs_and_paths() {
        for good in ["alice", "a", "laptop-2.lab@uni", &"x".repeat(64)] {
            assert_eq!(good.parse::<GrantName>().unwrap().as_str(), good);
        }
        for bad in ["", "a b", "a/b", "a\n", "é", &"x".repeat(65)] {
            assert!(bad.parse::<GrantName>().is_err(), "{bad}");
        }
    }
}
