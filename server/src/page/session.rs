//! Sessions of pages: a browser shows its token once, and then a cookie.
//!
//! A script cannot set the `Authorization` header of a WebSocket, and a token in an address would stay in histories and logs. So the
//! page sends its token by `POST /session`, and gets a cookie that no script can read and no other site's page sends along. The
//! cookie is good for twelve hours, and not for longer than the token.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::http::{HeaderMap, header};
use baudbot_access::{Refused, Token, TokenHash};

use crate::access::{Access, Caller, authorization};

/// The sessions of a server. Clones share them.
#[derive(Clone)]
pub(super) struct Sessions {
    access: Access,
    open: Arc<Mutex<HashMap<TokenHash, Session>>>,
    /// Whether cookies go over TLS only.
    secure: bool,
    /// The cookie's. A browser sends cookies to all ports of a host, where other servers may be.
    name: String,
}

struct Session {
    caller: Caller,
    until: Instant,
}

impl Sessions {
    /// The sessions of a listener at this port.
    pub(super) fn new(access: Access, secure: bool, port: u16) -> Self {
        Self { access, open: Arc::default(), secure, name: format!("baudbot_session_{port}") }
    }

    /// The caller of a request, by its token or the cookie of its session.
    ///
    /// # Errors
    /// If it has neither, or it is not valid any more.
    pub(super) fn caller(&self, headers: &HeaderMap) -> Result<Caller, Refused> {
        let shown = authorization(headers);
        match (shown, self.cookie(headers)) {
            (None, Some(key)) if !self.access.is_open() => {
                let session =
                    self.lock().get(&key.hash()).map(|session| (session.caller.clone(), session.until));
                match session {
                    Some((caller, until)) if Instant::now() < until => self.access.still(&caller),
                    Some(_) | None => Err(Refused::Missing),
                }
            }
            (shown, _) => self.access.caller(shown),
        }
    }

    /// Begins a session of the caller who shows this token. Gives its cookie.
    ///
    /// # Errors
    /// If the token is not valid.
    pub(super) fn begin(&self, headers: &HeaderMap) -> Result<String, Refused> {
        let caller = self.access.caller(authorization(headers))?;
        // Sessions cannot begin without randomness.
        let key = Token::random().map_err(|_| Refused::Missing)?;
        let now = Instant::now();
        let mut open = self.lock();
        open.retain(|_, session| now < session.until);
        // A caller that asks again and again ends its own sessions only.
        make_room(&mut open, A_TOKEN, |session| session.caller.name() == caller.name());
        make_room(&mut open, MOST, |_| true);
        open.insert(key.hash(), Session { caller, until: now + LASTS });
        let secure = if self.secure { "; Secure" } else { "" };
        let seconds = LASTS.as_secs();
        let (name, key) = (&self.name, key.reveal());
        Ok(format!("{name}={key}; HttpOnly; SameSite=Strict; Path=/; Max-Age={seconds}{secure}"))
    }

    /// The key of a session that a browser shows.
    fn cookie(&self, headers: &HeaderMap) -> Option<Token> {
        let pairs = headers.get_all(header::COOKIE).iter().filter_map(|cookies| cookies.to_str().ok());
        let mut pairs = pairs.flat_map(|cookies| cookies.split(';'));
        pairs.find_map(|pair| pair.trim().strip_prefix(&self.name)?.strip_prefix('=')?.parse().ok())
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<TokenHash, Session>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Forgets the oldest of these sessions if there are so many.
fn make_room(open: &mut HashMap<TokenHash, Session>, most: usize, is_one: impl Fn(&Session) -> bool) {
    let those = open.iter().filter(|(_, session)| is_one(session));
    if those.clone().count() >= most
        && let Some(oldest) = those.min_by_key(|(_, session)| session.until).map(|(hash, _)| *hash)
    {
        open.remove(&oldest);
    }
}

/// The lifetime of a session.
const LASTS: Duration = Duration::from_secs(12 * 60 * 60);

/// Sessions at a time; then the oldest is forgotten.
const MOST: usize = 4096;

/// The most sessions of a token: a class may share one.
const A_TOKEN: usize = 256;

#[cfg(test)]
mod tests {
    use std::time::SystemTime;

    use baudbot_access::{Grant, Watched};

    use super::*;

    fn headers(name: header::HeaderName, value: &str) -> HeaderMap {
        HeaderMap::from_iter([(name, value.parse().unwrap())])
    }

    #[test]
    fn a_session_has_the_rights_of_its_token() {
        let token = Token::random().unwrap();
        let own = vec![Grant::local(token.hash(), SystemTime::now())];
        let access = Access::by(Watched::open(None, own, Instant::now()).unwrap());
        let sessions = Sessions::new(access, false, 7401);
        assert!(matches!(sessions.caller(&HeaderMap::new()), Err(Refused::Missing)));
        let bearer = headers(header::AUTHORIZATION, &format!("Bearer {}", token.reveal()));
        assert_eq!(sessions.caller(&bearer).unwrap().name(), "local");
        let set = sessions.begin(&bearer).unwrap();
        assert!(set.contains("; HttpOnly; SameSite=Strict; ") && !set.contains("Secure"), "{set}");
        assert!(!set.contains(&token.reveal()), "a cookie is not the token");
        let pair = set.split(';').next().unwrap();
        let back = headers(header::COOKIE, &format!("theme=dark; {pair}"));
        assert_eq!(sessions.caller(&back).unwrap().name(), "local");
        let beside = headers(
            header::COOKIE,
            &format!("baudbot_session_7402={}; {pair}", Token::random().unwrap().reveal()),
        );
        assert_eq!(
            sessions.caller(&beside).unwrap().name(),
            "local",
            "another server of this host has another cookie"
        );
        let forged = format!("baudbot_session_7401={}", Token::random().unwrap().reveal());
        assert!(sessions.caller(&headers(header::COOKIE, &forged)).is_err());
        assert!(sessions.begin(&HeaderMap::new()).is_err());
    }

    #[test]
    fn whoever_begins_many_sessions_ends_its_own_only() {
        let tokens: Vec<_> = (0..2).map(|_| Token::random().unwrap()).collect();
        let grant = |(i, token): (usize, &Token)| Grant {
            name: format!("pupil-{i}").parse().unwrap(),
            ..Grant::local(token.hash(), SystemTime::now())
        };
        let own = tokens.iter().enumerate().map(grant).collect();
        let access = Access::by(Watched::open(None, own, Instant::now()).unwrap());
        let sessions = Sessions::new(access, false, 7401);
        let begin = |token: &Token| {
            let shown = headers(header::AUTHORIZATION, &format!("Bearer {}", token.reveal()));
            sessions.begin(&shown).unwrap().split(';').next().unwrap().to_owned()
        };
        let is_known = |cookie: &str| sessions.caller(&headers(header::COOKIE, cookie)).is_ok();
        let (quiet, first) = (begin(&tokens[0]), begin(&tokens[1]));
        let last = (0..A_TOKEN).fold(String::new(), |_, _| begin(&tokens[1]));
        assert!(is_known(&quiet) && is_known(&last) && !is_known(&first));
    }
}
