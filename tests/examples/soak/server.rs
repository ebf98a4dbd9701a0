//! The server of a soak test.

use std::fmt::Write as _;
use std::path::Path;
use std::time::SystemTime;

use baudbot_access::certificates::{Authority, Role};
use baudbot_access::{NewGrant, TokenFile};
use baudbot_server::{Pace, Server, Tls, WorldConfig};
use baudbot_tests::{crowd, scenario};

/// Worlds with robots.
pub(crate) const WORLDS: usize = 8;

/// Robots of each.
pub(crate) const ROBOTS: usize = 16;

/// Tokens, by holder, with what they are good for.
const HOLDERS: [(&str, &str); 3] = [("viewer", "observe"), ("brain", "drive */*"), ("operator", "operate")];

/// Serves until it is killed. Its tokens and the authority of its certificate are in this folder; its address is told.
pub(crate) async fn serve(folder: &Path) {
    let now = SystemTime::now();
    let authority = Authority::new(&"soak".parse().expect("a name"), "4w".parse().expect("a time"), now);
    let authority = authority.expect("an authority");
    authority.write(folder).expect("its files");
    let role = Role::Server(vec!["127.0.0.1".parse().expect("a host")]);
    let issued = authority.issue(&role, "2w".parse().expect("a time"), now).expect("a certificate");
    let paths = issued.write(folder, &role).expect("its files");
    let tokens = TokenFile::at(folder.join("tokens.toml"));
    for (holder, right) in HOLDERS {
        let rights = vec![right.parse().expect("a right")];
        let new = NewGrant { name: holder.parse().expect("a name"), rights, expires_at: None };
        let token = tokens.add(new, now).expect("a token");
        std::fs::write(folder.join(format!("{holder}.token")), token.reveal()).expect("its file");
    }
    let recordings = folder.join("recordings");
    std::fs::create_dir(&recordings).expect("a folder");
    let names: Vec<_> = (0..ROBOTS).map(|i| format!("r{i}")).collect();
    let mut builder = Server::builder()
        .tls(Tls::read(&paths.certificate, &paths.key, None).expect("TLS"))
        .tokens(tokens)
        .recordings(recordings)
        .listen("127.0.0.1:0".parse().expect("an address"));
    for i in 0..WORLDS {
        let room = scenario(&crowd(&names), &["step_ms=50.0"]);
        builder = builder.world(WorldConfig::new(format!("w{i}"), room).pace(Pace::REAL_TIME));
    }
    let server = builder.serve().await.expect("a server");
    let mut addresses = String::new();
    for address in server.addresses() {
        write!(addresses, "https://{address}").expect("text");
    }
    println!("{addresses}");
    std::future::pending::<()>().await;
}
