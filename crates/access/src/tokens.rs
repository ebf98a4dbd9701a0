//! The grants in effect, and how a caller's is found.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::SystemTime;

use crate::date;
use crate::grant::{Grant, GrantName};
use crate::token::{Token, TokenHash};

/// The grants in effect.
///
/// A caller's grant is looked up by the SHA-256 of its token. The time that the lookup takes may depend on how much of
/// that hash is like one that is known; this reveals nothing of use. To profit from it, a guesser would need tokens
/// whose hashes begin with chosen bits; it can search for those, but each bit doubles the search, and a hash that is
/// known in full still has to be inverted. The token itself is never compared with anything.
#[derive(Debug, Default)]
pub struct Tokens {
    grants: HashMap<TokenHash, Arc<Grant>>,
    generation: u64,
    /// The file of grants cannot be read: none of it is in effect.
    is_unreadable: bool,
}

/// The caller is not known: no token, a wrong one, or one that is over.
///
/// The words are the same for whatever is wrong with a token, so that a guesser learns nothing. An expired token is
/// named as such, as only its holder can have it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refused {
    /// None was given.
    #[error(
        "a token is needed here; give one, as `authorization: Bearer baudbot_…` (see docs/reference/trust.md)"
    )]
    Missing,
    /// The token is not valid here.
    #[error("the token is not valid on this server; ask its operator for another one")]
    Unknown,
    /// The validity is unknown, as the file of tokens cannot be read.
    #[error(
        "the server cannot read its token file, and accepts no tokens until it can; its log has the reason"
    )]
    Unreadable,
    /// The token was valid.
    #[error("the token `{name}` expired on {}; ask the operator of this server for another one", date::print(*.at))]
    Expired {
        /// The token.
        name: GrantName,
        /// The instant at which it expired.
        at: SystemTime,
    },
}

impl Tokens {
    /// The set of these grants. `generation` counts the sets that were in effect before.
    pub fn new(grants: impl IntoIterator<Item = Grant>, generation: u64) -> Self {
        let grants = grants.into_iter().map(|grant| (grant.hash, Arc::new(grant))).collect();
        Self { grants, generation, is_unreadable: false }
    }

    /// The same; a token that is not among them may be one of a file that cannot be read.
    pub(crate) fn refusing(self) -> Self {
        Self { is_unreadable: true, ..self }
    }

    /// The refusal of tokens that are not among these.
    fn unknown(&self) -> Refused {
        if self.is_unreadable { Refused::Unreadable } else { Refused::Unknown }
    }

    /// Whether the file of grants cannot be read.
    pub(crate) fn is_refusing(&self) -> bool {
        self.is_unreadable
    }

    /// Another number means that grants may have been revoked or changed since.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// The number of tokens, whether they have expired or not.
    pub fn len(&self) -> usize {
        self.grants.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.grants.is_empty()
    }

    /// The grant of the caller who shows this token; [`bearer`] takes it out of a header.
    ///
    /// # Errors
    /// If it is not one of these, or has expired.
    pub fn authenticate(&self, token: &str, now: SystemTime) -> Result<&Arc<Grant>, Refused> {
        let token: Token = token.parse().map_err(|_| Refused::Unknown)?;
        self.still(&token.hash(), now)
    }

    /// The grant of a caller who was authenticated before, as it is now: it may have other rights.
    ///
    /// # Errors
    /// If it was revoked, or has expired.
    pub fn still(&self, hash: &TokenHash, now: SystemTime) -> Result<&Arc<Grant>, Refused> {
        let grant = self.grants.get(hash).ok_or_else(|| self.unknown())?;
        match grant.expires_at {
            Some(at) if grant.has_expired(now) => Err(Refused::Expired { name: grant.name.clone(), at }),
            Some(_) | None => Ok(grant),
        }
    }
}

/// The token in an `authorization` header: `Bearer baudbot_…`.
///
/// # Errors
/// If there is none of this kind.
pub fn bearer(authorization: Option<&str>) -> Result<&str, Refused> {
    let (scheme, token) = authorization.unwrap_or_default().split_once(' ').ok_or(Refused::Missing)?;
    // RFC 7235: names of schemes have no case.
    if !scheme.eq_ignore_ascii_case("bearer") {
        return Err(Refused::Missing);
    }
    Ok(token.trim_matches(' '))
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, UNIX_EPOCH};

    use super::*;

    fn at(seconds: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(seconds)
    }

    fn tokens() -> (Tokens, Token, Token) {
        let (lasting, short) = (Token::random().unwrap(), Token::random().unwrap());
        let grants = [
            Grant { name: "lasting".parse().unwrap(), ..Grant::local(lasting.hash(), at(0)) },
            Grant {
                name: "short".parse().unwrap(),
                expires_at: Some(at(100)),
                ..Grant::local(short.hash(), at(0))
            },
        ];
        (Tokens::new(grants, 7), lasting, short)
    }

    #[test]
    fn a_token_finds_its_grant() {
        let (tokens, lasting, short) = tokens();
        let name = |token: &Token, now| {
            tokens.authenticate(&token.reveal(), now).map(|grant| grant.name.to_string())
        };
        assert_eq!(name(&lasting, at(99)).unwrap(), "lasting");
        assert_eq!(name(&short, at(99)).unwrap(), "short");
        assert_eq!(name(&lasting, at(1 << 40)).unwrap(), "lasting");
        assert_eq!(
            name(&short, at(100)),
            Err(Refused::Expired { name: "short".parse().unwrap(), at: at(100) })
        );
        assert_eq!((tokens.len(), tokens.generation()), (2, 7));
    }

    #[test]
    fn whatever_is_wrong_with_a_token_the_words_are_the_same() {
        let (tokens, lasting, _) = tokens();
        let near = lasting.reveal().replacen('_', "-", 1);
        let mut changed = lasting.reveal().into_bytes();
        changed[20] = if changed[20] == b'A' { b'B' } else { b'A' };
        let changed = String::from_utf8(changed).unwrap();
        let other = Token::random().unwrap().reveal();
        let hash = lasting.hash().to_string();
        for wrong in ["", "baudbot_", &near, &changed, &other, &hash, "lasting"] {
            assert_eq!(tokens.authenticate(wrong, at(1)).unwrap_err(), Refused::Unknown, "{wrong}");
        }
        assert!(Tokens::default().authenticate(&lasting.reveal(), at(1)).is_err());
    }

    #[test]
    fn a_header_has_a_token_or_none() {
        for header in ["Bearer abc", "bearer abc", "BEARER  abc "] {
            assert_eq!(bearer(Some(header)), Ok("abc"), "{header}");
        }
        assert_eq!(bearer(Some("Bearer ")), Ok(""), "which is then not valid");
        for header in [None, Some(""), Some("Bearer"), Some("Basic abc"), Some("abc"), Some(" Bearer abc")] {
            assert_eq!(bearer(header), Err(Refused::Missing), "{header:?}");
        }
    }

    #[test]
    fn expiry_is_told_by_name() {
        let words = Refused::Expired { name: "short".parse().unwrap(), at: at(100) }.to_string();
        let expected = "the token `short` expired on 1970-01-01T00:01:40Z; ask the operator of this server for another one";
        assert_eq!(words, expected);
    }
}
