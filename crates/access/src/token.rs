//! Tokens: what a client shows to a server, and what the server keeps of it.

use std::fmt;
use std::str::FromStr;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use sha2::{Digest, Sha256};

/// The beginning of every token, by which people and scanners for leaked secrets recognise it.
pub const PREFIX: &str = "baudbot_";

/// Characters after the prefix: 32 bytes in base64url.
const CHARACTERS: usize = 43;

/// Bytes of a token, and of a hash.
const BYTES: usize = 32;

/// A secret of 256 random bits: its holder may do what its grant allows.
///
/// As text it is `baudbot_` and 43 characters of base64url; each token has one text only. `Debug` does not show it, and there is
/// no `Display`: it is shown only where [`reveal`](Self::reveal) stands in the code.
pub struct Token([u8; BYTES]);

/// A text that is not a token. It does not have the text in it, which may be a token with a typing error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadToken {
    /// The text begins otherwise.
    #[error("a token begins with `{PREFIX}`")]
    Prefix,
    /// The text is too short or too long.
    #[error("a token has {CHARACTERS} characters after `{PREFIX}`, this one has {0}; is it complete?")]
    Length(usize),
    /// A character that no token has at this place.
    #[error(
        "character {0} after `{PREFIX}` is wrong; a token has letters, digits, `-` and `_` as they were printed"
    )]
    Character(usize),
}

/// The system gives no random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the operating system gives no random numbers: {0}")]
pub struct NoRandomness(getrandom::Error);

/// The SHA-256 of a token's text: what files and servers keep. The token cannot be found from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TokenHash([u8; BYTES]);

/// A text that is not the hash of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("must be the SHA-256 of a token's text, 64 digits in 0-9 and a-f")]
pub struct BadHash;

impl Token {
    /// A new token, of random bits from the operating system.
    ///
    /// # Errors
    /// If the system gives none.
    pub fn random() -> Result<Self, NoRandomness> {
        let mut bits = [0; BYTES];
        getrandom::fill(&mut bits).map_err(NoRandomness)?;
        Ok(Self(bits))
    }

    /// The token's text. It is for its holder only, and never for a log.
    pub fn reveal(&self) -> String {
        PREFIX.to_owned() + &URL_SAFE_NO_PAD.encode(self.0)
    }

    /// The hash, which may be kept: `printf %s "$TOKEN" | sha256sum` prints the same.
    pub fn hash(&self) -> TokenHash {
        TokenHash(Sha256::digest(self.reveal()).into())
    }
}

impl FromStr for Token {
    type Err = BadToken;

    fn from_str(text: &str) -> Result<Self, BadToken> {
        let secret = text.strip_prefix(PREFIX).ok_or(BadToken::Prefix)?;
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let wrong = secret.chars().position(|c| !fits(c));
        let length = secret.chars().count();
        if length != CHARACTERS {
            return Err(BadToken::Length(length));
        }
        if let Some(place) = wrong {
            return Err(BadToken::Character(place + 1));
        }
        // 43 characters have two bits more than 32 bytes; a text in which these are not 0 is none of ours.
        let bytes = URL_SAFE_NO_PAD.decode(secret).ok().and_then(|bytes| bytes.try_into().ok());
        bytes.map(Self).ok_or(BadToken::Character(CHARACTERS))
    }
}

impl fmt::Debug for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Token(secret)")
    }
}

impl FromStr for TokenHash {
    type Err = BadHash;

    fn from_str(text: &str) -> Result<Self, BadHash> {
        let digits = text.as_bytes();
        if digits.len() != 2 * BYTES {
            return Err(BadHash);
        }
        let mut hash = [0; BYTES];
        for (byte, pair) in hash.iter_mut().zip(digits.chunks_exact(2)) {
            *byte = 16 * digit(pair[0])? + digit(pair[1])?;
        }
        Ok(Self(hash))
    }
}

impl fmt::Display for TokenHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

fn digit(character: u8) -> Result<u8, BadHash> {
    match character {
        b'0'..=b'9' => Ok(character - b'0'),
        b'a'..=b'f' => Ok(character - b'a' + 10),
        _ => Err(BadHash),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn tokens_differ_and_come_back_from_their_text() {
        let tokens: Vec<_> = (0..100).map(|_| Token::random().unwrap()).collect();
        for token in &tokens {
            let text = token.reveal();
            assert_eq!(text.len(), 51);
            let again: Token = text.parse().unwrap();
            assert_eq!((again.0, again.hash()), (token.0, token.hash()));
        }
        let hashes: std::collections::BTreeSet<_> = tokens.iter().map(Token::hash).collect();
        assert_eq!(hashes.len(), tokens.len());
    }

    #[test]
    fn the_hash_is_that_of_sha256sum() {
        let token = Token([0; BYTES]);
        assert_eq!(token.reveal(), format!("baudbot_{}", "A".repeat(43)));
        // printf %s baudbot_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA | sha256sum
        let expected = "0139a6dc2921f301fcc37f59ee36111b16684882f1b06c1376ff8d22bf5339b2";
        assert_eq!(token.hash().to_string(), expected);
        assert_eq!(expected.parse(), Ok(token.hash()));
    }

    #[test]
    fn a_token_is_never_shown_by_accident() {
        let token = Token::random().unwrap();
        assert_eq!(format!("{token:?}"), "Token(secret)");
        assert_eq!(format!("{:#?}", Some(&token)).matches(&token.reveal()[8..16]).count(), 0);
    }

    #[test]
    fn a_text_that_is_no_token_is_refused_with_the_reason() {
        let bad = |text: &str| text.parse::<Token>().unwrap_err();
        let end = "A".repeat(42);
        assert_eq!(bad(""), BadToken::Prefix);
        assert_eq!(bad("Bearer baudbot_"), BadToken::Prefix);
        assert_eq!(bad("baudbot_"), BadToken::Length(0));
        assert_eq!(bad("baudbot_abc…"), BadToken::Length(4));
        assert_eq!(bad(&format!("baudbot_{end}AA")), BadToken::Length(44));
        assert_eq!(bad(&format!("baudbot_=A{end}")), BadToken::Length(44));
        assert_eq!(bad(&format!("baudbot_{end}+")), BadToken::Character(43));
        assert_eq!(bad(&format!("baudbot_/{end}")), BadToken::Character(1));
        assert_eq!(bad(&format!("baudbot_{end}µ")), BadToken::Character(43));
        // `AB` and `AA` would be the same byte.
        assert_eq!(bad(&format!("baudbot_{end}B")), BadToken::Character(43));
        assert_eq!("ab".parse::<TokenHash>(), Err(BadHash));
        assert_eq!("A".repeat(64).parse::<TokenHash>(), Err(BadHash));
        assert_eq!(("µ".repeat(32)).parse::<TokenHash>(), Err(BadHash));
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parsers_panic(text in ".*", secret in "[A-Za-z0-9_-]{42,44}") {
            let _ = text.parse::<Token>();
            let _ = text.parse::<TokenHash>();
            let whole = format!("{PREFIX}{secret}");
            if let Ok(token) = whole.parse::<Token>() {
                prop_assert_eq!(token.reveal(), whole);
            }
        }
    }
}
