//! The server of a soak test: the program of users.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::SystemTime;

use baudbot_access::certificates::{Authority, Role};
use baudbot_access::{NewGrant, TokenFile};
use baudbot_tests::crowd;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};

/// The number of worlds with robots.
pub(crate) const WORLDS: usize = 8;

/// The number of robots of each world.
pub(crate) const ROBOTS: usize = 16;

/// The holders of tokens, with the rights of each.
const HOLDERS: [(&str, &str); 3] = [("viewer", "observe"), ("brain", "drive */*"), ("operator", "operate")];

/// `baudbot serve` and its address. What it needs, the tokens and the authority of its certificate are in this folder.
pub(crate) async fn start(program: &Path, folder: &Path) -> (Child, String) {
    let [certificate, key] = certificate(folder);
    tokens(folder);
    let recordings = folder.join("recordings");
    std::fs::create_dir(&recordings).expect("a folder");
    let mut tls = certificate.into_os_string();
    tls.push(",");
    tls.push(key);
    let mut command = Command::new(program);
    command.args(["serve", "--listen", "127.0.0.1:0", "--viewer", "off", "--pace", "real-time"]);
    command.args(["--set", "step_ms=50.0"]);
    command.args([OsStr::new("--tls"), &tls]);
    command.args([OsStr::new("--tokens"), folder.join("tokens.toml").as_os_str()]);
    command.args([OsStr::new("--recordings"), recordings.as_os_str()]);
    command.args(scenarios(folder)).stdout(Stdio::piped()).kill_on_drop(true);
    let problem = |error| panic!("{}: {error}; cargo build --release makes it", program.display());
    let mut child = command.spawn().unwrap_or_else(problem);
    let mut lines = BufReader::new(child.stdout.take().expect("it is piped")).lines();
    while let Some(line) = lines.next_line().await.expect("its output") {
        if let Some(address) = line.strip_prefix("listening on ") {
            // The rest is read, too, so that it never waits for room.
            let address = format!("https://{}", address.trim_start_matches("https://"));
            tokio::spawn(async move { while lines.next_line().await.is_ok_and(|line| line.is_some()) {} });
            return (child, address);
        }
    }
    panic!("the server ended before it listened");
}

/// A file for each world, in which robots drive in a room.
fn scenarios(folder: &Path) -> Vec<PathBuf> {
    let names: Vec<_> = (0..ROBOTS).map(|i| format!("r{i}")).collect();
    let room = crowd(&names);
    let file = |i| {
        let path = folder.join(format!("w{i}.toml"));
        let text = room.replacen("name = \"crowd\"", &format!("name = \"w{i}\""), 1);
        std::fs::write(&path, text).expect("its file");
        path
    };
    (0..WORLDS).map(file).collect()
}

/// The files of a certificate for this machine and of its key.
fn certificate(folder: &Path) -> [PathBuf; 2] {
    let now = SystemTime::now();
    let authority = Authority::new(&"soak".parse().expect("a name"), "4w".parse().expect("a time"), now);
    let authority = authority.expect("an authority");
    authority.write(folder).expect("its files");
    let role = Role::Server(vec!["127.0.0.1".parse().expect("a host")]);
    let issued = authority.issue(&role, "2w".parse().expect("a time"), now).expect("a certificate");
    let paths = issued.write(folder, &role).expect("its files");
    [paths.certificate, paths.key]
}

/// A token for each holder, in a file of its own.
fn tokens(folder: &Path) {
    let tokens = TokenFile::at(folder.join("tokens.toml"));
    for (holder, right) in HOLDERS {
        let rights = vec![right.parse().expect("a right")];
        let new = NewGrant { name: holder.parse().expect("a name"), rights, expires_at: None };
        let token = tokens.add(new, SystemTime::now()).expect("a token");
        std::fs::write(folder.join(format!("{holder}.token")), token.reveal()).expect("its file");
    }
}
