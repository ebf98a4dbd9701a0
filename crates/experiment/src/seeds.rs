//! The seeds with which a combination is run.

use toml::Value;

use crate::error::Error;

/// Seeds of the runs of a combination.
#[derive(Clone, Debug, PartialEq)]
pub enum Seeds {
    /// The seeds from one to another, both of them too.
    From(u64, u64),
    /// The seeds of a list.
    List(Vec<u64>),
}

impl Seeds {
    /// The number of seeds; never 0.
    pub fn count(&self) -> u64 {
        match self {
            Self::From(first, last) => last - first + 1,
            Self::List(seeds) => seeds.len() as u64,
        }
    }

    /// One of them, from 0.
    pub fn get(&self, place: u64) -> u64 {
        match self {
            Self::From(first, _) => first + place,
            Self::List(seeds) => seeds[place as usize],
        }
    }

    /// Parses `N` (1 to N), `A..B` (both of them too) or `A,B,C`.
    ///
    /// # Errors
    /// If it is none of these.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let problem = || Error::field("seeds", format!("`{text}` is not N, A..B or A,B,C"));
        let number =
            |text: &str| text.trim().parse().ok().filter(|&seed| seed <= MAX_SEED).ok_or_else(problem);
        if let Some((first, last)) = text.split_once("..") {
            let (first, last) = (number(first)?, number(last)?);
            return if first <= last { Ok(Self::From(first, last)) } else { Err(problem()) };
        }
        match text.split(',').map(number).collect::<Result<Vec<_>, _>>()?.as_slice() {
            [count] => Self::up_to(*count),
            seeds => Self::list(seeds.to_vec()),
        }
    }

    /// The greatest of them.
    pub fn last(&self) -> u64 {
        match self {
            Self::From(_, last) => *last,
            Self::List(seeds) => seeds.iter().copied().max().unwrap_or(0),
        }
    }

    fn up_to(count: u64) -> Result<Self, Error> {
        if count == 0 {
            return Err(Error::field("seeds", "must be at least 1, is 0"));
        }
        Ok(Self::From(1, count))
    }

    fn list(seeds: Vec<u64>) -> Result<Self, Error> {
        let mut sorted = seeds.clone();
        sorted.sort_unstable();
        if let Some(local) = sorted.windows(2).find(|local| local[0] == local[1]) {
            return Err(Error::field("seeds", format!("{} appears twice", local[0])));
        }
        if seeds.is_empty() {
            return Err(Error::field("seeds", "is empty, so there is nothing to run; give at least one"));
        }
        Ok(Self::List(seeds))
    }

    /// The seeds of a file's field: a number of them, or a list. 10 if it has none.
    ///
    /// # Errors
    /// If it is neither.
    pub fn of(value: Option<&Value>) -> Result<Self, Error> {
        let problem = || {
            Error::field(
                "seeds",
                "must be how many there are, or a list such as [1, 5, 9], of whole numbers from 0",
            )
        };
        let seed =
            |value: &Value| value.as_integer().and_then(|seed| u64::try_from(seed).ok()).ok_or_else(problem);
        match value {
            None => Self::up_to(DEFAULT_SEEDS),
            Some(Value::Array(list)) => Self::list(list.iter().map(seed).collect::<Result<_, _>>()?),
            Some(count) => Self::up_to(seed(count)?),
        }
    }
}

/// The number of seeds if the file has none.
const DEFAULT_SEEDS: u64 = 10;

/// Largest seed that a scenario can have.
const MAX_SEED: u64 = i64::MAX as u64;
