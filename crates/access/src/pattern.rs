//! Patterns of robots: `WORLD/ROBOT`, with `*` for any characters within a part.

use std::fmt;
use std::str::FromStr;

use baudbot_fields::printable::Printable;

/// The robots that may be driven: `wander/alice`, `class-*/robot1`, `*/*`.
///
/// A `*` stands for any characters of a name, also for none, and never for the slash between the parts.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct DrivePattern {
    world: Part,
    robot: Part,
}

/// A name in which some characters may be open.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Part(String);

/// A text that is not a pattern of robots.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a pattern of robots: {problem}", Printable(brief(text)))]
pub struct BadPattern {
    text: String,
    /// The fault in it.
    pub problem: PatternProblem,
}

/// A fault in a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatternProblem {
    /// The pattern does not have two parts.
    #[error(
        "it has {0} slashes and must have one; write WORLD/ROBOT, such as wander/alice, or */* for all robots"
    )]
    Slashes(usize),
    /// A part is empty.
    #[error("the {0} is empty; write `*` for any")]
    Empty(Half),
    /// A part is longer than a name can be.
    #[error("the {0} has {1} characters; names have at most {MAX_LENGTH}")]
    TooLong(Half, usize),
    /// A character that no name has.
    #[error(
        "the {half} has `{}` in it; names have letters, digits, `_` and `-`, and `*` stands for any of these",
        Printable(character)
    )]
    Character {
        /// The part.
        half: Half,
        /// The character.
        character: char,
    },
}

/// A part of a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The part before the slash.
    World,
    /// The part after the slash.
    Robot,
}

/// Characters of the longest name of a world or robot.
const MAX_LENGTH: usize = 64;

impl DrivePattern {
    /// The pattern of all robots, `*/*`.
    pub fn all() -> Self {
        let any = || Part("*".to_owned());
        Self { world: any(), robot: any() }
    }

    /// Whether it covers this robot of this world.
    pub fn covers(&self, world: &str, robot: &str) -> bool {
        self.world.matches(world) && self.robot.matches(robot)
    }
}

impl FromStr for DrivePattern {
    type Err = BadPattern;

    fn from_str(text: &str) -> Result<Self, BadPattern> {
        let bad = |problem| BadPattern { text: text.to_owned(), problem };
        let mut parts = text.split('/');
        let (Some(world), Some(robot), None) = (parts.next(), parts.next(), parts.next()) else {
            return Err(bad(PatternProblem::Slashes(text.matches('/').count())));
        };
        let world = Part::parse(Half::World, world).map_err(bad)?;
        let robot = Part::parse(Half::Robot, robot).map_err(bad)?;
        Ok(Self { world, robot })
    }
}

impl fmt::Display for DrivePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.world.0, self.robot.0)
    }
}

impl Part {
    fn parse(half: Half, text: &str) -> Result<Self, PatternProblem> {
        let fits = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '*');
        if text.is_empty() {
            return Err(PatternProblem::Empty(half));
        }
        if let Some(character) = text.chars().find(|c| !fits(*c)) {
            return Err(PatternProblem::Character { half, character });
        }
        if text.len() > MAX_LENGTH {
            return Err(PatternProblem::TooLong(half, text.len()));
        }
        Ok(Self(text.to_owned()))
    }

    /// Whether the pattern stands for the name. Each `*` first stands for nothing, and takes one character more whenever what
    /// follows does not fit; only the last one met can matter, so the effort is at most the product of both lengths.
    fn matches(&self, name: &str) -> bool {
        let (pattern, name) = (self.0.as_bytes(), name.as_bytes());
        let (mut at, mut seen) = (0, 0);
        let mut last: Option<(usize, usize)> = None;
        while seen < name.len() {
            match pattern.get(at) {
                Some(b'*') => {
                    last = Some((at, seen));
                    at += 1;
                }
                Some(&byte) if byte == name[seen] => {
                    at += 1;
                    seen += 1;
                }
                Some(_) | None => {
                    let Some((star, taken)) = last else { return false };
                    last = Some((star, taken + 1));
                    (at, seen) = (star + 1, taken + 1);
                }
            }
        }
        pattern[at..].iter().all(|&byte| byte == b'*')
    }
}

impl fmt::Display for Half {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::World => "world",
            Self::Robot => "robot",
        })
    }
}

/// The beginning of a text, for messages.
pub(crate) fn brief(text: &str) -> String {
    let mut characters = text.chars();
    let begin: String = characters.by_ref().take(80).collect();
    if characters.next().is_some() { begin + "…" } else { begin }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn covers(pattern: &str, world: &str, robot: &str) -> bool {
        pattern.parse::<DrivePattern>().unwrap().covers(world, robot)
    }

    #[test]
    fn a_name_covers_itself_and_nothing_else() {
        assert!(covers("wander/alice", "wander", "alice"));
        for (world, robot) in
            [("wander", "bob"), ("wander2", "alice"), ("wande", "alice"), ("Wander", "alice"), ("wander", "")]
        {
            assert!(!covers("wander/alice", world, robot), "{world}/{robot}");
        }
    }

    #[test]
    fn a_star_covers_any_characters_of_its_part() {
        assert!(covers("*/*", "wander", "alice"));
        assert!(covers("class-*/robot1", "class-7", "robot1"));
        assert!(covers("class-*/robot1", "class-", "robot1"));
        assert!(!covers("class-*/robot1", "class", "robot1"));
        assert!(!covers("class-*/robot1", "class-7", "robot10"));
        assert!(covers("w/*-left", "w", "a-left-left"));
        assert!(covers("w/a*b*c", "w", "aXbbYcZc"));
        assert!(!covers("w/a*b*c", "w", "aXcYb"));
        assert!(!covers("*/robot", "wander/x", "robot2"));
    }

    #[test]
    fn a_pattern_that_is_wrong_is_refused_with_the_remedy() {
        let bad = |text: &str| text.parse::<DrivePattern>().unwrap_err().to_string();
        let expected = "`alice` is not a pattern of robots: it has 0 slashes and must have one; write WORLD/ROBOT, such as wander/alice, or */* for all robots";
        assert_eq!(bad("alice"), expected);
        assert!(bad("a/b/c").contains("it has 2 slashes"), "{}", bad("a/b/c"));
        assert_eq!(bad("/b"), "`/b` is not a pattern of robots: the world is empty; write `*` for any");
        assert_eq!(bad("a/"), "`a/` is not a pattern of robots: the robot is empty; write `*` for any");
        let expected = "`a/b c` is not a pattern of robots: the robot has ` ` in it; names have letters, digits, `_` and `-`, and `*` stands for any of these";
        assert_eq!(bad("a/b c"), expected);
        assert!(bad(&format!("{}/b", "a".repeat(65))).contains("the world has 65 characters"));
        assert!(bad("a/\u{1b}[31m").contains(r"\u{1b}"), "a terminal obeys nothing of it");
        assert!(bad(&"x".repeat(100_000)).len() < 400);
    }

    /// The same relation by its definition: a star is nothing, or one character and the star again.
    fn stands_for(pattern: &[u8], name: &[u8]) -> bool {
        match (pattern.split_first(), name.split_first()) {
            (None, None) => true,
            (Some((b'*', rest)), None) => stands_for(rest, name),
            (Some((b'*', rest)), Some((_, later))) => stands_for(rest, name) || stands_for(pattern, later),
            (Some((one, rest)), Some((other, later))) => one == other && stands_for(rest, later),
            (None, Some(_)) | (Some(_), None) => false,
        }
    }

    proptest! {
        #[test]
        fn what_is_printed_is_read_again(text in "[a-zA-Z0-9_*-]{1,64}/[a-zA-Z0-9_*-]{1,64}") {
            let pattern: DrivePattern = text.parse().unwrap();
            prop_assert_eq!(pattern.to_string(), text);
            prop_assert_eq!(pattern.to_string().parse::<DrivePattern>().unwrap(), pattern);
        }

        #[test]
        fn no_text_makes_the_parser_panic(text in ".*", narrow in "[a*/ \u{1b}]{0,80}") {
            for text in [text, narrow] {
                match text.parse::<DrivePattern>() {
                    Ok(pattern) => prop_assert_eq!(pattern.to_string(), text),
                    Err(error) => prop_assert_eq!(error.to_string().find('\u{1b}'), None),
                }
            }
        }

        #[test]
        fn stars_mean_what_their_definition_says(pattern in "[ab*]{1,8}", name in "[ab]{0,10}") {
            let part = Part(pattern.clone());
            prop_assert_eq!(part.matches(&name), stands_for(pattern.as_bytes(), name.as_bytes()), "{} {}", pattern, name);
        }
    }
}
