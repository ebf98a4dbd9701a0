//! The token of the user who runs a server, for programs of the same user on the same machine.
//!
//! A server writes a token with all rights into a file that only its user can read, one for each address on which it
//! can be reached from this machine only. Clients that connect to such an address look there. So users of a server of
//! their own need not handle tokens, and no other user of the machine can use it.
//!
//! # Where
//!
//! The folder is `$XDG_RUNTIME_DIR/baudbot` or, where there is no such variable or its folder belongs to another user,
//! `/tmp/baudbot-UID` with the number of the user. Any user can make that one first; a folder of another user is passed
//! over, and `~/.baudbot` takes its place. The folder has the mode 0700 and belongs to the user; a link, or a folder
//! that others can read, is refused. A client looks into all of these, in this order. The file has the mode 0600 and
//! the token in it, without a line's end, and its name is
//!
//! - `127.0.0.1:7400.token`, `[::1]:7400.token` for an address of loopback;
//! - `unix-HASH.token` for a Unix socket, where HASH is the SHA-256 of the absolute path without links, in hexadecimal digits.
//!
//! A server that listens on 0.0.0.0 is found at 127.0.0.1, and one that listens on \[::\] at both addresses of loopback. For other
//! addresses there are no files: a machine may get the address of another one, and its programs would then send their tokens
//! there.
//!
//! A server removes its files when it ends. What one leaves behind that was killed is worthless, as its token was known to that
//! server only, and the next server of this user on this address replaces it, in whichever of these folders it is.
//!
//! In Python:
//!
//! ```python
#![doc = include_str!("local.py")]
//! ```

use std::env;
use std::fs;
use std::io::ErrorKind;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::private::{self, PrivateError};
use crate::token::Token;

/// Files with a server's token, for the addresses on which it listens. Dropping this removes them.
#[derive(Debug)]
#[must_use = "the files are removed when this is dropped"]
pub struct LocalFiles(Vec<LocalFile>);

#[derive(Debug)]
struct LocalFile {
    path: PathBuf,
    /// The server's token, or empty if another server has the file.
    text: String,
}

/// Bytes of the longest file that is read. A token has 51.
const MOST_BYTES: u64 = 1024;

/// Writes the server's token for these addresses, such as `127.0.0.1:7400` and `unix:/tmp/baudbot.sock`; a Unix socket must be
/// there already. Addresses that other machines can reach, too, are passed over.
///
/// # Errors
/// If the folder cannot be made, is not this user's own, or a file cannot be written.
pub fn publish<'a>(
    addresses: impl IntoIterator<Item = &'a str>,
    token: &Token,
) -> Result<LocalFiles, PrivateError> {
    let names: Vec<_> = addresses.into_iter().flat_map(names).collect();
    publish_in(&folders(), &names, token)
}

/// The token of the server at this address, if one of the same user listens there on this machine: `localhost:7400`,
/// `http://127.0.0.1:7400` or `unix:/tmp/baudbot.sock`.
///
/// # Errors
/// If there is a folder, or a file, that is not this user's own, or the file cannot be read.
pub fn find(address: &str) -> Result<Option<Token>, PrivateError> {
    find_in(&folders(), &names(address))
}

fn publish_in(folders: &[PathBuf], names: &[String], token: &Token) -> Result<LocalFiles, PrivateError> {
    let mut foreign = None;
    for folder in folders.iter().filter(|_| !names.is_empty()) {
        match (make(folder), &foreign) {
            (Ok(()), _) => {
                let files = write(folder, names, token)?;
                retire(folders.iter().filter(|other| *other != folder), names);
                return Ok(files);
            }
            (Err(PrivateError::Foreign { path, owner }), _) => {
                foreign.get_or_insert(PrivateError::NoPlace { path, owner });
            }
            (Err(error), None) => return Err(error),
            (Err(_), Some(_)) => {}
        }
    }
    foreign.map_or_else(|| Ok(LocalFiles(Vec::new())), Err)
}

fn write(folder: &Path, names: &[String], token: &Token) -> Result<LocalFiles, PrivateError> {
    let mut files = LocalFiles(Vec::new());
    for name in names {
        let (path, text) = (folder.join(name), token.reveal());
        private::write(&path, &text)?;
        files.0.push(LocalFile { path, text });
    }
    Ok(files)
}

/// Removes what servers that were killed have left for these addresses in other folders, where a client might look first.
fn retire<'a>(folders: impl Iterator<Item = &'a PathBuf>, names: &[String]) {
    for folder in folders.filter(|folder| private::check_folder(folder).is_ok()) {
        for name in names {
            // The token is absent, as a rule.
            let _ = fs::remove_file(folder.join(name));
        }
    }
}

fn find_in(folders: &[PathBuf], names: &[String]) -> Result<Option<Token>, PrivateError> {
    for folder in folders.iter().filter(|_| !names.is_empty()) {
        match private::check_folder(folder) {
            Ok(()) => {}
            // A folder of another user holds nothing of this user's.
            Err(PrivateError::Foreign { .. }) => continue,
            Err(error) if error.is_absent() => continue,
            Err(error) => return Err(error),
        }
        for name in names {
            match private::read(&folder.join(name), MOST_BYTES) {
                // Other text belongs to a later version.
                Ok((text, _)) => match text.trim().parse() {
                    Ok(token) => return Ok(Some(token)),
                    Err(_) => continue,
                },
                Err(error) if error.is_absent() => {}
                Err(error) => return Err(error),
            }
        }
    }
    Ok(None)
}

/// The folders in which clients look for the token. A server uses the first that does not belong to another user.
fn folders() -> Vec<PathBuf> {
    let user = private::user();
    let of_session = env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    // The folder in the environment is that of another user with `sudo -E`.
    let is_own = |folder: &PathBuf| {
        folder.is_absolute()
            && fs::metadata(folder).is_ok_and(|metadata| metadata.is_dir() && metadata.uid() == user)
    };
    let of_session = of_session.filter(is_own).map(|folder| folder.join("baudbot"));
    let home = env::var_os("HOME").map(PathBuf::from).filter(is_own);
    let of_home = home.map(|home| home.join(".baudbot"));
    of_session.into_iter().chain([PathBuf::from(format!("/tmp/baudbot-{user}"))]).chain(of_home).collect()
}

/// Makes a folder for this user only, or checks that it is one.
fn make(folder: &Path) -> Result<(), PrivateError> {
    match fs::DirBuilder::new().mode(0o700).create(folder) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
        Err(source) => Err(PrivateError::Io { action: "make the folder", path: folder.to_owned(), source }),
    }?;
    private::check_folder(folder)
}

/// The names of the files for an address.
fn names(address: &str) -> Vec<String> {
    if let Some(path) = address.strip_prefix("unix:").filter(|path| !path.is_empty()) {
        return vec![format!("unix-{}.token", hash_of(&real(Path::new(path))))];
    }
    let address =
        ["http://", "https://"].iter().find_map(|scheme| address.strip_prefix(scheme)).unwrap_or(address);
    let address = address.trim_end_matches('/');
    let (v4, v6) = (IpAddr::V4(Ipv4Addr::LOCALHOST), IpAddr::V6(Ipv6Addr::LOCALHOST));
    let of =
        |ips: &[IpAddr], port| ips.iter().map(|ip| format!("{}.token", SocketAddr::new(*ip, port))).collect();
    if let Some(port) = address.strip_prefix("localhost:").and_then(|port| port.parse().ok()) {
        return of(&[v4, v6], port);
    }
    match address.parse::<SocketAddr>() {
        Ok(socket) if socket.ip().is_loopback() => of(&[socket.ip()], socket.port()),
        Ok(socket) if socket.ip() == IpAddr::V4(Ipv4Addr::UNSPECIFIED) => of(&[v4], socket.port()),
        // Linux takes connections of both versions there.
        Ok(socket) if socket.ip().is_unspecified() => of(&[v6, v4], socket.port()),
        Ok(_) | Err(_) => Vec::new(),
    }
}

/// The absolute path without links, as far as it is there.
fn real(path: &Path) -> PathBuf {
    let absolute = || std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    fs::canonicalize(path).unwrap_or_else(|_| absolute())
}

fn hash_of(path: &Path) -> String {
    Sha256::digest(path.as_os_str().as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Drop for LocalFile {
    fn drop(&mut self) {
        // Another server may have taken the address since.
        if private::read(&self.path, MOST_BYTES).is_ok_and(|(text, _)| text == self.text) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::Command;

    use super::*;

    fn token() -> Token {
        Token::random().unwrap()
    }

    fn text(found: Result<Option<Token>, PrivateError>) -> Option<String> {
        found.unwrap().map(|token| token.reveal())
    }

    #[test]
    fn addresses_of_this_machine_have_names() {
        assert_eq!(names("127.0.0.1:7400"), ["127.0.0.1:7400.token"]);
        assert_eq!(names("http://127.0.0.1:7400/"), ["127.0.0.1:7400.token"]);
        assert_eq!(names("127.0.0.2:1"), ["127.0.0.2:1.token"]);
        assert_eq!(names("localhost:7400"), ["127.0.0.1:7400.token", "[::1]:7400.token"]);
        assert_eq!(names("[::1]:7400"), ["[::1]:7400.token"]);
        assert_eq!(names("0.0.0.0:7400"), ["127.0.0.1:7400.token"]);
        assert_eq!(names("[::]:7400"), ["[::1]:7400.token", "127.0.0.1:7400.token"]);
        for far in [
            "10.0.0.7:7400",
            "robots.lab:7400",
            "localhost.lab:7400",
            "localhost:x",
            "unix:",
            "",
            "/",
            "../x",
        ] {
            assert!(names(far).is_empty(), "{far}");
        }
    }

    #[test]
    fn a_socket_has_one_name_whatever_leads_there() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::create_dir(&real).unwrap();
        symlink(&real, &link).unwrap();
        fs::write(real.join("a.sock"), "").unwrap();
        let names = |path: PathBuf| names(&format!("unix:{}", path.display()));
        let name = names(real.join("a.sock"));
        assert_eq!(names(link.join("a.sock")), name);
        assert_eq!(names(real.join("../link/./a.sock")), name);
        assert_ne!(names(real.join("b.sock")), name);
        assert_eq!(name[0].len(), "unix-.token".len() + 64);
    }

    #[test]
    fn a_client_finds_the_token_until_the_server_ends() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("baudbot"), folder.path().join("other")];
        let token = token();
        let names = names("[::]:7400");
        assert_eq!(text(find_in(&folders, &names)), None);
        let files = publish_in(&folders, &names, &token).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().mode() & 0o777;
        assert_eq!(mode(&folders[0]), 0o700);
        for name in &names {
            assert_eq!(mode(&folders[0].join(name)), 0o600);
            assert_eq!(text(find_in(&folders, std::slice::from_ref(name))), Some(token.reveal()));
        }
        // A client that has no such variable, or another one, looks further.
        let reversed = [folders[1].clone(), folders[0].clone()];
        assert_eq!(text(find_in(&reversed, &names)), Some(token.reveal()));
        drop(files);
        assert_eq!(text(find_in(&folders, &names)), None);
        assert_eq!(fs::read_dir(&folders[0]).unwrap().count(), 0);
    }

    #[test]
    fn the_file_of_a_dead_server_is_replaced_and_that_of_the_next_one_stays() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("baudbot")];
        let names = names("127.0.0.1:7400");
        let (dead, next) = (token(), token());
        let old = publish_in(&folders, &names, &dead).unwrap();
        let new = publish_in(&folders, &names, &next).unwrap();
        assert_eq!(text(find_in(&folders, &names)), Some(next.reveal()));
        drop(old);
        assert_eq!(text(find_in(&folders, &names)), Some(next.reveal()));
        drop(new);
        assert_eq!(text(find_in(&folders, &names)), None);
    }

    /// A server that was started with another `XDG_RUNTIME_DIR`, or without one, has its files elsewhere.
    #[test]
    fn the_file_of_a_dead_server_in_another_folder_is_in_nobodys_way() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("session"), folder.path().join("tmp")];
        let names = names("127.0.0.1:7400");
        let dead = publish_in(&folders[..1], &names, &token()).unwrap();
        let next = token();
        let files = publish_in(&folders[1..], &names, &next).unwrap();
        assert_ne!(text(find_in(&folders, &names)), Some(next.reveal()), "it knows of no other folder");
        drop(files);
        let reversed = [folders[1].clone(), folders[0].clone()];
        let files = publish_in(&reversed, &names, &next).unwrap();
        assert_eq!(text(find_in(&folders, &names)), Some(next.reveal()));
        drop((dead, files));
    }

    #[test]
    fn what_others_could_have_made_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let names = names("127.0.0.1:7400");
        let (open, link) = (folder.path().join("open"), folder.path().join("link"));
        let files = publish_in(std::slice::from_ref(&open), &names, &token()).unwrap();
        symlink(&open, &link).unwrap();
        for bad in [&link, &open] {
            if *bad == open {
                fs::set_permissions(&open, fs::Permissions::from_mode(0o755)).unwrap();
            }
            let folders = std::slice::from_ref(bad);
            assert!(find_in(folders, &names).is_err(), "{}", bad.display());
            assert!(publish_in(folders, &names, &token()).is_err(), "{}", bad.display());
        }
        fs::set_permissions(&open, fs::Permissions::from_mode(0o700)).unwrap();
        let path = open.join(&names[0]);
        fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).unwrap();
        let error = find_in(std::slice::from_ref(&open), &names).unwrap_err();
        assert!(matches!(error, PrivateError::Exposed { .. }), "{error}");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        fs::write(&path, "no token").unwrap();
        assert_eq!(text(find_in(std::slice::from_ref(&open), &names)), None);
        drop(files);
        assert!(path.exists(), "it is not what the server wrote");
    }

    #[test]
    fn a_folder_that_somebody_else_has_made_first_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let names = names("127.0.0.1:7400");
        // Only root can make what is another user's. What is root's is another user's to everybody else.
        let (foreign, link) = match private::user() {
            0 => {
                fs::create_dir(path("theirs")).unwrap();
                symlink("/nowhere", path("link")).unwrap();
                std::os::unix::fs::chown(path("theirs"), Some(65534), Some(65534)).unwrap();
                std::os::unix::fs::lchown(path("link"), Some(65534), Some(65534)).unwrap();
                (path("theirs"), path("link"))
            }
            _ => (PathBuf::from("/usr"), PathBuf::from("/proc/1/exe")),
        };
        let token = token();
        for theirs in [&foreign, &link] {
            let folders = [theirs.clone(), path("own")];
            let files = publish_in(&folders, &names, &token).unwrap();
            assert_eq!(text(find_in(&folders, &names)), Some(token.reveal()), "{}", theirs.display());
            drop(files);
            let error = publish_in(&folders[..1], &names, &token).unwrap_err();
            assert!(error.to_string().contains("set XDG_RUNTIME_DIR to a folder of your own"), "{error}");
            assert_eq!(text(find_in(&folders[..1], &names)), None, "nothing of this user's is there");
        }
    }

    #[test]
    fn addresses_of_others_have_no_files() {
        let folder = tempfile::tempdir().unwrap();
        let folders = [folder.path().join("baudbot")];
        let files = publish_in(&folders, &names("10.0.0.7:7400"), &token()).unwrap();
        assert!(files.0.is_empty() && !folders[0].exists());
    }

    /// The client that the documentation shows, beside this one.
    #[test]
    #[ignore = "needs Python: ./test python-client"]
    fn a_client_in_python_finds_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let (runtime, socket) = (folder.path().join("runtime"), folder.path().join("a b.sock"));
        fs::create_dir(&runtime).unwrap();
        fs::write(&socket, "").unwrap();
        let folders = [runtime.join("baudbot")];
        let token = token();
        let unix = format!("unix:{}", socket.display());
        let addresses = ["127.0.0.1:1", "localhost:1", "[::1]:2", &unix, "127.0.0.1:3", "10.0.0.7:1"];
        let published: Vec<_> = ["127.0.0.1:1", "[::1]:2", &unix].into_iter().flat_map(names).collect();
        let _files = publish_in(&folders, &published, &token).unwrap();
        let program = format!(
            "{}\nimport sys\nfor address in sys.argv[1:]:\n    print(local_token(address))",
            include_str!("local.py")
        );
        let mut python = Command::new("python3");
        let output =
            python.arg("-c").arg(program).args(addresses).env("XDG_RUNTIME_DIR", &runtime).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let out = String::from_utf8(output.stdout).unwrap();
        let python: Vec<_> =
            out.lines().map(|line| Some(line.to_owned()).filter(|line| line != "None")).collect();
        let rust: Vec<_> = addresses.iter().map(|address| text(find_in(&folders, &names(address)))).collect();
        assert_eq!(python, rust);
        assert_eq!(rust.iter().flatten().count(), 4);
    }
}
