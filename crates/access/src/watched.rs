//! The grants in effect while a file of them may change.

use std::fs::File;
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
///
/// A file that cannot be read for two seconds, whatever the reason, is a file without tokens: one of them may have been revoked. The
/// server's own grants stay in effect.
#[derive(Debug)]
pub struct Watched {
    file: Option<TokenFile>,
    own: Vec<Grant>,
    latest: RwLock<Arc<Tokens>>,
    look: Mutex<Look>,
}

/// The state of the file at the last look.
#[derive(Debug)]
struct Look {
    at: Instant,
    stamp: Option<Stamp>,
    /// Since when the file cannot be read.
    failing: Option<Instant>,
    /// A descriptor that is kept for the next reading: another file is open, whatever the process has open by then.
    spare: Option<File>,
}

/// The result of a look at the file; a line for the log.
#[derive(Debug)]
pub enum News {
    /// The file has changed, and these grants are in effect.
    Changed {
        /// The number of tokens, with those that the server was started with.
        tokens: usize,
    },
    /// The file has changed, and cannot be read any more: what was in effect remains so for [two seconds](Watched).
    /// This is reported once for each change.
    Unreadable(FileError),
    /// The file could not be read for so long: nothing of it is in effect until it can be, as a token may have been
    /// revoked.
    Refused(FileError),
}

/// The interval between two looks at the file.
const INTERVAL: Duration = Duration::from_secs(1);

/// The time for which the last grants stay in effect if the file cannot be read: it may be about to be written.
const PATIENCE: Duration = Duration::from_secs(2);

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
        let spare = file.as_ref().and_then(spare);
        let look = Mutex::new(Look { at: now, stamp, failing: None, spare });
        Ok(Self { file, own, latest: RwLock::new(Arc::new(tokens)), look })
    }

    /// The grants in effect. The file is looked at if that was not done within a second, and read if it has changed;
    /// concurrent callers get what was in effect before. The news goes to the caller that has looked.
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
        if stamp == look.stamp && look.failing.is_none() {
            return None;
        }
        // If the file changes again before it is read, the next look finds that its stamp is a later one.
        let is_changed = look.stamp != stamp;
        look.stamp = stamp;
        // The reading needs a descriptor.
        look.spare = None;
        let read = file.read_stamped();
        look.spare = spare(file);
        match read {
            Ok((grants, stamp)) => {
                (look.stamp, look.failing) = (Some(stamp), None);
                let tokens = self.replace(grants);
                Some(News::Changed { tokens })
            }
            Err(error) => {
                let since = *look.failing.get_or_insert(now);
                if now.saturating_duration_since(since) >= PATIENCE && !self.latest().is_refusing() {
                    self.refuse();
                    return Some(News::Refused(error));
                }
                is_changed.then_some(News::Unreadable(error))
            }
        }
    }

    /// Nothing of the file is in effect any more.
    fn refuse(&self) {
        let mut latest = self.latest.write().unwrap_or_else(PoisonError::into_inner);
        *latest = Arc::new(Tokens::new(self.own.iter().cloned(), latest.generation() + 1).refusing());
    }

    /// Puts grants into effect, and returns how many there are now.
    fn replace(&self, grants: Vec<Grant>) -> usize {
        let mut latest = self.latest.write().unwrap_or_else(PoisonError::into_inner);
        let all = grants.into_iter().chain(self.own.iter().cloned());
        let tokens = Tokens::new(all, latest.generation() + 1);
        let count = tokens.len();
        *latest = Arc::new(tokens);
        count
    }
}

/// A descriptor that is free as soon as this is dropped.
fn spare(file: &TokenFile) -> Option<File> {
    File::open(file.path()).or_else(|_| File::open("/dev/null")).ok()
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
    fn a_file_that_is_spoiled_for_two_seconds_has_no_tokens_until_it_is_mended() {
        let scene = Scene::new();
        let alice = scene.add("alice");
        let own = Token::random().unwrap();
        let grant = Grant::local(own.hash(), SystemTime::now());
        let watched = Watched::open(Some(scene.file.clone()), vec![grant], scene.begin).unwrap();
        let good = fs::read_to_string(scene.file.path()).unwrap();
        let mode = |mode| fs::set_permissions(scene.file.path(), fs::Permissions::from_mode(mode)).unwrap();
        let spoil: [(&str, &dyn Fn()); 4] = [
            ("rights", &|| fs::write(scene.file.path(), good.replace("observe", "observes")).unwrap()),
            ("TOML", &|| fs::write(scene.file.path(), "version = ").unwrap()),
            ("mode", &|| mode(0o644)),
            ("absence", &|| fs::remove_file(scene.file.path()).unwrap()),
        ];
        let mut second = 1;
        let mut look = || {
            second += 1;
            watched.current(scene.after_ms(second * 1000))
        };
        for (what, spoil) in spoil {
            // Two changes within the same moment of the file system's clock could look alike.
            std::thread::sleep(Duration::from_millis(20));
            spoil();
            let now = SystemTime::now();
            let (tokens, news) = look();
            assert!(matches!(news, Some(News::Unreadable(_))), "{what}: {news:?}");
            assert!(tokens.authenticate(&alice.reveal(), now).is_ok(), "{what}: somebody may be writing it");
            let (tokens, news) = look();
            assert!(news.is_none() && tokens.authenticate(&alice.reveal(), now).is_ok(), "{what}: {news:?}");
            let generation = tokens.generation();
            let (tokens, news) = look();
            assert!(matches!(news, Some(News::Refused(_))), "{what}: {news:?}");
            assert_ne!(tokens.generation(), generation, "streams end");
            assert_eq!(tokens.still(&alice.hash(), now).unwrap_err(), Refused::Unreadable, "{what}");
            assert!(tokens.still(&own.hash(), now).is_ok(), "{what}: the server's own");
            let (_, news) = look();
            assert!(news.is_none(), "{what}: {news:?}");
            std::thread::sleep(Duration::from_millis(20));
            fs::write(scene.file.path(), &good).unwrap();
            mode(0o600);
            let (tokens, news) = look();
            assert!(matches!(news, Some(News::Changed { tokens: 2 })), "{what}: {news:?}");
            assert!(tokens.still(&alice.hash(), now).is_ok(), "{what}");
        }
    }

    /// In a process of its own, as it has all files open that it may have.
    #[test]
    fn a_revocation_is_read_though_all_descriptors_are_taken() {
        const CHILD: &str = "BAUDBOT_TEST_DESCRIPTORS";
        if std::env::var_os(CHILD).is_none() {
            let test = "watched::tests::a_revocation_is_read_though_all_descriptors_are_taken";
            let mut child = std::process::Command::new("sh");
            let program = std::env::current_exe().unwrap();
            child.args(["-c", "ulimit -n 64; exec \"$0\" --exact \"$1\" --nocapture"]).arg(program).arg(test);
            let output = child.env(CHILD, "1").output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            return;
        }
        let scene = Scene::new();
        let (alice, bob) = (scene.add("alice"), scene.add("bob"));
        let watched = scene.open();
        scene.file.revoke(&name("alice")).unwrap();
        let all: Vec<_> = std::iter::from_fn(|| File::open("/dev/null").ok()).take(1000).collect();
        assert!(all.len() < 64 && File::open(scene.file.path()).is_err(), "none is left");
        let (tokens, news) = watched.current(scene.after_ms(1000));
        assert!(matches!(news, Some(News::Changed { tokens: 1 })), "{news:?}");
        assert!(tokens.still(&alice.hash(), SystemTime::now()).is_err());
        assert!(tokens.still(&bob.hash(), SystemTime::now()).is_ok());
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
