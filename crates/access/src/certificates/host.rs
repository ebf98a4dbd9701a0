//! Names by which servers are reached.

use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;

use baudbot_fields::printable::Printable;

use crate::pattern::brief;

/// A name by which a server is reached.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Host {
    /// A name of DNS in small letters: `robots.lab`, or `*.lab` for all names one level below.
    Name(String),
    /// An address.
    Ip(IpAddr),
}

/// A text that is not the name of a server.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{}` is not the name of a server; names look like robots.lab, *.lab, 10.0.0.7 or ::1, without a port",
    Printable(brief(.0))
)]
pub struct BadHost(String);

impl Host {
    /// The host as the name of a file.
    pub(super) fn stem(&self) -> String {
        let text = self.to_string();
        text.chars().map(|c| if c.is_ascii_alphanumeric() || "-.".contains(c) { c } else { '_' }).collect()
    }
}

impl FromStr for Host {
    type Err = BadHost;

    fn from_str(text: &str) -> Result<Self, BadHost> {
        if let Ok(ip) = text.trim_start_matches('[').trim_end_matches(']').parse() {
            return Ok(Self::Ip(ip));
        }
        let labels = text.strip_prefix("*.").unwrap_or(text);
        let last = labels.rsplit('.').next().unwrap_or_default();
        // A name whose last label is a number would be taken for an address.
        let is_good = text.len() <= LONGEST
            && labels.split('.').all(is_label)
            && last.contains(|c: char| !c.is_ascii_digit());
        is_good.then(|| Self::Name(text.to_ascii_lowercase())).ok_or_else(|| BadHost(text.to_owned()))
    }
}

impl fmt::Display for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => f.write_str(name),
            Self::Ip(ip) => ip.fmt(f),
        }
    }
}

/// Characters of the longest name in DNS.
const LONGEST: usize = 253;

fn is_label(label: &str) -> bool {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-';
    (1..=63).contains(&label.len())
        && label.chars().all(fits)
        && !label.starts_with('-')
        && !label.ends_with('-')
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn names_and_addresses_are_told_apart() {
        let name = |text: &str| Host::Name(text.to_owned());
        for good in ["localhost", "robots.lab", "*.lab", "a-1.b2", "7.lab"] {
            assert_eq!(good.parse(), Ok(name(good)));
        }
        assert_eq!("Robots.Lab".parse(), Ok(name("robots.lab")));
        for (text, shown) in [("10.0.0.7", "10.0.0.7"), ("::1", "::1"), ("[::1]", "::1")] {
            let host: Host = text.parse().unwrap();
            assert_eq!((matches!(host, Host::Ip(_)), host.to_string().as_str()), (true, shown));
        }
        let long = format!("{}.lab", "a".repeat(64));
        for bad in [
            "",
            ".",
            "a..b",
            "lab.",
            "-a",
            "a-",
            "a_b",
            "*",
            "*.",
            "a.*.b",
            "10.0.0.256",
            "7",
            "robots.lab:7400",
            "a b",
            "é",
            &long,
        ] {
            assert!(bad.parse::<Host>().is_err(), "{bad}");
        }
        assert_eq!("*.lab".parse::<Host>().unwrap().stem(), "_.lab");
        assert_eq!("::1".parse::<Host>().unwrap().stem(), "__1");
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parser_panic(text in ".*", near in "[a-z0-9*.:\\[\\]-]{0,20}") {
            for text in [text, near] {
                if let Ok(host) = text.parse::<Host>() {
                    prop_assert_eq!(host.to_string().parse::<Host>().unwrap(), host);
                }
            }
        }
    }
}
