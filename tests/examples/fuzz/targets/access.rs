//! The bytes that are read before their sender is known, and the files on senders.

use std::time::{Duration, UNIX_EPOCH};

use baudbot_access::{Grant, Need, Token, TokenFile, Tokens, bearer, needs_at};

use super::{Target, outcome};

pub(super) fn targets() -> Vec<Target> {
    let good = format!("Bearer {TOKEN}");
    let headers = [&good, "bearer  baudbot_", "Basic YTpi", "/baudbot.v1.ControlService/GetWorld"];
    vec![
        Target {
            name: "headers",
            what: "tokens in headers, and paths of calls",
            seeds: headers.map(|header| header.as_bytes().to_vec()).to_vec(),
            words: HEADER_WORDS,
            run: Box::new(header),
        },
        Target {
            name: "tokens",
            what: "files of tokens",
            seeds: vec![FILE.as_bytes().to_vec(), b"version = 1\ntokens = []\n".to_vec()],
            words: WORDS,
            run: Box::new(file),
        },
    ]
}

fn header(bytes: &[u8]) -> u64 {
    let text = String::from_utf8_lossy(bytes);
    let known = TOKEN.parse::<Token>().map(|token| Grant::local(token.hash(), UNIX_EPOCH));
    let tokens = Tokens::new(known, 0);
    let now = UNIX_EPOCH + Duration::from_secs(1);
    let may = u64::from(needs_at(&text) == Some(Need::Observe));
    match bearer(Some(&text)).and_then(|token| tokens.authenticate(token, now)) {
        // Nothing else may open the server.
        Ok(grant) => {
            assert!(text.contains(TOKEN), "{text:?} is taken for the token of {}", grant.name);
            2 + may
        }
        Err(refused) => outcome(&refused.to_string()) ^ may,
    }
}

fn file(bytes: &[u8]) -> u64 {
    match TokenFile::at("tokens.toml").parse(&String::from_utf8_lossy(bytes)) {
        Ok(grants) => {
            assert!(grants.iter().all(|grant| !grant.rights.is_empty()), "a right is lost");
            grants.len().min(5) as u64
        }
        Err(error) => outcome(&error.to_string()),
    }
}

/// The token's bits are all 0.
const TOKEN: &str = "baudbot_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";

const FILE: &str = r#"version = 1

# A pupil.
[[tokens]]
name = "alice"
hash = "2c26b46b68ffc68ff99b453c1d30413413422d706483bfa0f98a5e886266e7ae"
rights = ["observe", "drive class-*/alice"]
created_at = 2026-12-01T08:00:00Z
expires_at = 2027-02-01T08:00:00+01:00
"#;

const HEADER_WORDS: &[&[u8]] =
    &[b"Bearer ", b"baudbot_", b"/baudbot.v1.ControlService/", b"GetWorld", b"\xc2\xb5"];

const WORDS: &[&[u8]] = &[
    b"version",
    b"[[tokens]]",
    b"tokens",
    b"name",
    b"hash",
    b"rights",
    b"operate",
    b"train",
    b"drive */*",
    b"created_at",
    b"expires_at",
    b"2027-01-31T12:00:00Z",
    b"9999-12-31T23:59:60-23:59",
];
