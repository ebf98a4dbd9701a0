//! The callers that may connect to a `baudbot serve`: programs of its user by themselves, others with a token.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::cli::{Running, command, place, said};

/// A user of this machine, to all programs: with a runtime folder of their own.
struct User(PathBuf);

impl User {
    fn new(name: &str) -> Self {
        let folder = place(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        fs::set_permissions(&folder, fs::Permissions::from_mode(0o700)).unwrap();
        Self(folder)
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = command(args);
        command.env("XDG_RUNTIME_DIR", &self.0);
        command
    }

    fn runs(&self, args: &[&str]) -> (i32, String, String) {
        said(self.command(args).output().unwrap())
    }

    /// A server with its address and that of its page.
    fn serves(&self, args: &[&str]) -> (Running, String, String) {
        let listen = ["serve", "--listen", "127.0.0.1:0", "--viewer", "127.0.0.1:0"];
        let mut server = Running(self.command(&[&listen, args].concat()).spawn().unwrap());
        let lines = server.lines_until("open in a browser: ");
        let address = lines[0].strip_prefix("listening on ").unwrap().to_owned();
        (server, address, lines.last().unwrap().strip_prefix("open in a browser: ").unwrap().to_owned())
    }
}

fn token_of(user: &User, address: &str) -> PathBuf {
    user.0.join(format!("baudbot/{address}.token"))
}

#[test]
fn a_servers_own_user_needs_no_token_and_another_one_gets_nothing() {
    let (owner, other) = (User::new("trust-owner"), User::new("trust-other"));
    let (server, address, link) = owner.serves(&["wander"]);
    let file = token_of(&owner, &address);
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o600);
    let token = fs::read_to_string(&file).unwrap();
    assert!(link.ends_with(&format!("/#token={token}")), "{link}");
    let look = ["watch", "--once", "--connect", &address];
    let (code, out, err) = owner.runs(&look);
    assert_eq!((code, err.as_str()), (0, ""));
    assert!(out.starts_with("world wander"), "{out}");
    assert_eq!(
        owner.runs(&["token", "local", "--connect", &address]),
        (0, format!("{token}\n"), String::new())
    );
    for args in
        [&look[..], &["brain", "avoid", "--connect", &address, "--world", "wander", "--robot", "robot"]]
    {
        let (code, out, err) = other.runs(args);
        assert_eq!((code, out.as_str()), (1, ""), "{args:?}");
        assert!(err.contains("a token is needed here"), "{err}");
    }
    let (code, _, err) = other.runs(&["token", "local", "--connect", &address]);
    assert_eq!(code, 1);
    assert!(err.contains("there is no token of yours"), "{err}");
    server.signal("-TERM");
    assert_eq!(server.end().0, 0);
    assert!(!file.exists(), "the token is of no use any more");
}

#[test]
fn an_open_server_asks_for_no_token() {
    let (owner, other) = (User::new("open-owner"), User::new("open-other"));
    let (_server, address, link) = owner.serves(&["wander", "--open"]);
    assert!(link.ends_with('/') && !token_of(&owner, &address).exists(), "{link}");
    assert_eq!(other.runs(&["watch", "--once", "--connect", &address]).0, 0);
}

#[test]
fn a_pupil_drives_a_robot_with_a_token_and_sees_nothing_else() {
    let (teacher, pupil) = (User::new("class-teacher"), User::new("class-pupil"));
    let (tokens, token) = (teacher.0.join("tokens.toml"), pupil.0.join("alice.token"));
    let tokens = tokens.to_str().unwrap();
    let drive = ["token", "new", "--name", "alice", "--drive", "wander/robot", "--file", tokens];
    fs::write(&token, teacher.runs(&drive).1).unwrap();
    let run = ["wander", "--tokens", tokens, "--pace", "lockstep", "--set", "end.after_s=1.0"];
    let (_server, address, _) = teacher.serves(&run);
    let with_token = |args: &[&str]| {
        let mut command = pupil.command(&[args, &["--connect", &address]].concat());
        said(command.env("BAUDBOT_TOKEN_FILE", &token).output().unwrap())
    };
    let (code, _, err) = with_token(&["watch", "--once"]);
    assert_eq!(code, 1);
    assert!(err.contains("the token `alice` has no right to this, which needs `observe`"), "{err}");
    for names in
        [&[][..], &["--world", "wander"], &["--robot", "robot"], &["--world", "wander", "--robot", "rob*"]]
    {
        let (code, _, err) = with_token(&[&["brain", "avoid"], names].concat());
        assert_eq!(code, 1);
        let remedy =
            "this token cannot list worlds and robots, so name both in full with --world and --robot: ";
        assert!(err.contains(remedy) && err.contains("the token `alice` has no right to this"), "{err}");
    }
    let (code, out, err) = with_token(&["brain", "avoid", "--world", "wander", "--robot", "robot"]);
    assert_eq!(code, 0, "{err}");
    assert_eq!(out, "the run is over after 50 turns\n");
    let missing = pupil.0.join("missing.token");
    let mut command = pupil.command(&["watch", "--once", "--connect", &address, "--token-file"]);
    let (code, _, err) = said(command.arg(&missing).output().unwrap());
    assert_eq!(code, 1);
    assert!(err.starts_with("error: --token-file ") && err.contains("missing.token: "), "{err}");
    let mut command = pupil.command(&["watch", "--once", "--connect", &address]);
    let (code, _, err) = said(command.env("BAUDBOT_TOKEN_FILE", "").output().unwrap());
    assert_eq!(code, 1);
    assert!(err.contains("a token is needed here"), "an empty variable is none: {err}");
    let broken = Path::new(tokens);
    fs::write(broken, "version = ").unwrap();
    let (code, _, err) = teacher.runs(&["serve", "wander", "--tokens", tokens, "--listen", "127.0.0.1:0"]);
    assert_eq!(code, 2);
    assert!(err.contains("tokens.toml"), "{err}");
}

#[test]
fn a_token_is_not_sent_to_another_machine_without_tls() {
    let user = User::new("trust-elsewhere");
    let (tokens, token) = (user.0.join("tokens.toml"), user.0.join("eve.token"));
    let new = ["token", "new", "--name", "eve", "--observe", "--file", tokens.to_str().unwrap()];
    fs::write(&token, user.runs(&new).1).unwrap();
    // The addresses are reserved for documents: no machine has them.
    for args in [&["watch", "--once"][..], &["brain", "avoid", "--world", "w", "--robot", "r"]] {
        let mut command = user.command(&[args, &["--connect", "http://192.0.2.7:7400"]].concat());
        let (code, _, err) = said(command.env("BAUDBOT_TOKEN_FILE", &token).output().unwrap());
        assert_eq!(code, 1);
        let expected = "error: no token is sent to 192.0.2.7:7400 without TLS, as that is another machine: write https://192.0.2.7:7400";
        assert!(err.starts_with(expected), "{err}");
    }
}

#[test]
fn who_does_not_trust_a_certificate_is_told_what_to_do() {
    let user = User::new("trust-certificates");
    let file = |name: &str| user.0.join(name).to_str().unwrap().to_owned();
    let made = |args: &[&str]| assert_eq!(user.runs(&[&["cert"], args].concat()).0, 0, "{args:?}");
    for lab in ["lab", "others"] {
        made(&["ca", &file(lab)]);
    }
    made(&["server", &file("lab"), "127.0.0.1"]);
    made(&["client", &file("others"), "eve"]);
    let tls = format!("{},{}", file("lab/127.0.0.1.pem"), file("lab/127.0.0.1-key.pem"));
    let (_server, address, _) =
        user.serves(&["wander", "--paused", "--tls", &tls, "--client-ca", &file("lab/ca.pem")]);
    let address = format!("https://{address}");
    let watch = |args: &[&str], variables: &[(&str, String)]| {
        let mut command = user.command(&[&["watch", "--once", "--connect", &address], args].concat());
        let (code, _, err) = said(command.envs(variables.iter().cloned()).output().unwrap());
        assert_eq!(code, 1, "{err}");
        err.replace(&address, "ADDRESS")
    };
    let told = watch(&[], &[]);
    let trust = "the certificate of the server at ADDRESS is not trusted";
    assert_eq!(
        told,
        format!("error: {trust}: name the authority that signed it with --ca FILE or BAUDBOT_CA\n")
    );
    let told = watch(&["--ca", &file("others/ca.pem")], &[]);
    let signed = format!("error: {trust}: the authority in {} has not signed it", file("others/ca.pem"));
    assert!(told.starts_with(&signed), "{told}");
    let ca = file("lab/ca.pem");
    let told = watch(&["--ca", &ca], &[]);
    let wanted = "asks for a client certificate: set BAUDBOT_CERTIFICATE and BAUDBOT_KEY";
    assert_eq!(told, format!("error: the server at ADDRESS {wanted}\n"));
    let own = [("BAUDBOT_CERTIFICATE", file("others/eve.pem")), ("BAUDBOT_KEY", file("others/eve-key.pem"))];
    let told = watch(&["--ca", &ca], &own);
    assert!(
        told.contains("does not accept the client certificate in ") && told.contains("eve.pem"),
        "{told}"
    );
}
