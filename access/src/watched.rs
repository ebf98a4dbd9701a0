//! The grants in effect while a file of them may change.

use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};
use std::time::{Duration, Instant};

use crate::file::{FileError, TokenFile};
use crate::grant::Grant;
use crate::private::Stamp;
use crate::tokens::Tokens;

/// The grants of a server: those of its file, which is read anew when it changes, and those that it was started with.
///
/// A server asks for [`current`](Self::current) at each call. It also does so once a second while streams are open, and when the
/// [`generation`](Tokens::generation) is another one, it ends the streams whose callers [are no longer
/// known](Tokens::still) or [may no longer](Grant::may) do what they do. A grant that expires changes no generation; its end is
/// known when the stream begins.
#[derive(Debug)]
pub struct Watched {
    file: Option<TokenFile>,
    own: Vec<Grant>,
    latest: RwLock<Arc<Tokens>>,
    look: Mutex<Look>,
}

/// What was there when the file was last looked at.
#[derive(Debug)]
struct Look {
    at: Instant,
    stamp: Option<Stamp>,
}

/// What a look at the file has found; a line for the log.
#[derive(Debug)]
pub enum News {
    /// It has changed, and these grants are in effect.
    Changed {
        /// How many there are, with those that the server was started with.
        tokens: usize,
    },
    /// It has changed, and cannot be read any more: what was in effect remains so. This is told once for each change.
    Unreadable(FileError),
}

/// Between two looks at the file.
const INTERVAL: Duration = Duration::from_secs(1);

impl Watched {
    /// The grants of a file, if there is one, and those of the server's own, such as [`Grant::local`].
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn open(file: Option<TokenFile>, own: Vec<Grant>, now: Instant) -> Result<Self, FileError> {
        let (tokens, stamp) = match &file {
            Some(file) => {
                let (grants, stamp) = file.read_stamped()?;
                (Tokens::new(grants.into_iter().chain(own.iter().cloned()), 0), Some(stamp))
            }
            None => (Tokens::new(own.iter().cloned(), 0), None),
        };
        let look = Mutex::new(Look { at: now, stamp });
        Ok(Self { file, own, latest: RwLock::new(Arc::new(tokens)), look })
    }

    /// The grants in effect. Looks at the file if nobody has within a second, and reads it if it has changed; whoever asks
    /// meanwhile gets what was in effect before. What there is to be told goes to the one who has looked.
    pub fn current(&self, now: Instant) -> (Arc<Tokens>, Option<News>) {
        let news = self.look(now);
        (self.latest(), news)
    }

    /// The grants in effect, without a look at the file.
    pub fn latest(&self) -> Arc<Tokens> {
        Arc::clone(&self.latest.read().unwrap_or_else(PoisonError::into_inner))
    }

    fn look(&self, now: Instant) -> Option<News> {
        let file = self.file.as_ref()?;
        let mut look = match self.look.try_lock() {
            Ok(look) => look,
            Err(TryLockError::Poisoned(error)) => error.into_inner(),
            Err(TryLockError::WouldBlock) => return None,
        };
        if now.saturating_duration_since(look.at) < INTERVAL {
            return None;
        }
        look.at = now;
        let stamp = Stamp::at(file.path());
        if stamp == look.stamp {
            return None;
        }
        // If the file changes again before it is read, the next look finds that its stamp is a later one.
        look.stamp = stamp;
        match file.read_stamped() {
            Ok((grants, stamp)) => {
                look.stamp = Some(stamp);
                let tokens = self.replace(grants);
                Some(News::Changed { tokens })
            }
            Err(error) => Some(News::Unreadable(error)),
        }
    }

    /// Puts grants into effect, and says how many there are now.
    fn replace(&self, grants: Vec<Grant>) -> usize {
        let mut latest = self.latest.write().unwrap_or_else(PoisonError::into_inner);
        let all = grants.into_iter().chain(self.own.iter().cloned());
        let tokens = Tokens::new(all, latest.generation() + 1);
        let count = tokens.len();
        *latest = Arc::new(tokens);
        count
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::os::unix::fs::PermissionsExt;
    use std::time::SystemTime;

    use super::*;
    use crate::file::NewGrant;
    use crate::tokens::Refused;
    use crate::{GrantName, Need, Token};

    struct Scene {
        _folder: tempfile::TempDir,
        file: TokenFile,
        begin: Instant,
    }

    impl Scene {
        fn new() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let file = TokenFile::at(folder.path().join("tokens.toml"));
            Self { _folder: folder, file, begin: Instant::now() }
        }

        fn add(&self, name: &str) -> Token {
            let new = NewGrant {
                name: name.parse().unwrap(),
                rights: vec!["observe".parse().unwrap()],
                expires_at: None,
            };
            self.file.add(new, SystemTime::now()).unwrap()
        }

        fn open(&self) -> Watched {
            Watched::open(Some(self.file.clone()), Vec::new(), self.begin).unwrap()
        }

        fn after_ms(&self, ms: u64) -> Instant {
            self.begin + Duration::from_millis(ms)
        }
    }

    fn name(name: &str) -> GrantName {
        name.parse().unwrap()
    }

    #[test]
    fn a_token_that_is_revoked_is_not_valid_a_second_later() {
        let scene = Scene::new();
        let (alice, bob) = (scene.add("alice"), scene.add("bob"));
        let watched = scene.open();
        let (before, news) = watched.current(scene.after_ms(0));
        assert!(news.is_none(), "{news:?}");
        let now = SystemTime::now();
        before.authenticate(&alice.reveal(), now).unwrap();
        scene.file.revoke(&name("alice")).unwrap();
        let (soon, news) = watched.current(scene.after_ms(999));
        assert!(news.is_none() && soon.still(&alice.hash(), now).is_ok(), "nobody looks so often: {news:?}");
        let (later, news) = watched.current(scene.after_ms(1000));
        assert!(matches!(news, Some(News::Changed { tokens: 1 })), "{news:?}");
        assert_ne!(later.generation(), before.generation());
        assert_eq!(later.still(&alice.hash(), now).unwrap_err(), Refused::Unknown);
        later.still(&bob.hash(), now).unwrap().may(Need::Observe).unwrap();
        let (same, news) = watched.current(scene.after_ms(5000));
        assert!(news.is_none() && same.generation() == later.generation(), "{news:?}");
    }

    #[test]
    fn a_token_that_is_added_is_valid_a_second_later() {
        let scene = Scene::new();
        scene.add("alice");
        let watched = scene.open();
        let bob = scene.add("bob");
        assert!(watched.latest().authenticate(&bob.reveal(), SystemTime::now()).is_err());
        let (tokens, _) = watched.current(scene.after_ms(1000));
        assert!(tokens.authenticate(&bob.reveal(), SystemTime::now()).is_ok());
        assert!(watched.latest().authenticate(&bob.reveal(), SystemTime::now()).is_ok());
    }

    #[test]
    fn a_file_that_is_spoiled_changes_nothing_and_is_reported_once() {
        let scene = Scene::new();
        let alice = scene.add("alice");
        let watched = scene.open();
        let good = fs::read_to_string(scene.file.path()).unwrap();
        let mode = |mode| fs::set_permissions(scene.file.path(), fs::Permissions::from_mode(mode)).unwrap();
        let spoil: [(&str, &dyn Fn()); 4] = [
            ("rights", &|| fs::write(scene.file.path(), good.replace("observe", "observes")).unwrap()),
            ("TOML", &|| fs::write(scene.file.path(), "version = ").unwrap()),
            ("mode", &|| mode(0o644)),
            ("absence", &|| fs::remove_file(scene.file.path()).unwrap()),
        ];
        let mut second = 1;
        for (what, spoil) in spoil {
            // Two changes within the same moment of the file system's clock could look alike.
            std::thread::sleep(Duration::from_millis(20));
            spoil();
            let (tokens, news) = watched.current(scene.after_ms(second * 1000));
            assert!(matches!(news, Some(News::Unreadable(_))), "{what}: {news:?}");
            assert!(tokens.authenticate(&alice.reveal(), SystemTime::now()).is_ok(), "{what}");
            let (tokens, news) = watched.current(scene.after_ms(second * 1000 + 1000));
            assert!(news.is_none() && tokens.generation() == 0, "{what}: {news:?}");
            second += 2;
        }
        fs::write(scene.file.path(), &good).unwrap();
        mode(0o600);
        let (tokens, news) = watched.current(scene.after_ms(second * 1000));
        assert!(matches!(news, Some(News::Changed { tokens: 1 })), "{news:?}");
        assert_eq!(tokens.generation(), 1);
    }

    #[test]
    fn a_server_has_grants_of_its_own_with_a_file_and_without() {
        let scene = Scene::new();
        let own = Token::random().unwrap();
        let grant = Grant::local(own.hash(), SystemTime::now());
        let bare = Watched::open(None, vec![grant.clone()], scene.begin).unwrap();
        let (tokens, news) = bare.current(scene.after_ms(10_000));
        assert!(news.is_none() && tokens.len() == 1);
        scene.add("alice");
        let watched = Watched::open(Some(scene.file.clone()), vec![grant], scene.begin).unwrap();
        scene.file.revoke(&name("alice")).unwrap();
        let (tokens, _) = watched.current(scene.after_ms(1000));
        assert!(tokens.authenticate(&own.reveal(), SystemTime::now()).is_ok());
        assert_eq!(tokens.len(), 1);
    }

    #[test]
    fn a_server_does_not_start_with_a_file_that_is_wrong() {
        let scene = Scene::new();
        assert!(Watched::open(Some(scene.file.clone()), Vec::new(), scene.begin).is_err());
    }
}
