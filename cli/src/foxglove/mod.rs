//! `baudbot watch --foxglove`: a world as it moves, for Foxglove to show. An observer like any other, that passes on.

use baudbot_server::Address;

use crate::args::ConnectArgs;
use crate::error::Refused;

#[cfg(feature = "foxglove")]
mod bridge;

/// Passes a world on until the server is gone.
pub(crate) async fn pass_on(server: &ConnectArgs, at: &Address) -> anyhow::Result<()> {
    let Address::Tcp(at) = at else {
        return Err(Refused::error(format!("--foxglove={at}: Foxglove connects to an IP:PORT only")));
    };
    if !at.ip().is_loopback() {
        let port = at.port();
        return Err(Refused::error(format!(
            "--foxglove={at}: anyone who reaches this address sees the truth; only addresses of this machine are \
             allowed, such as 127.0.0.1:{port} (from elsewhere: ssh -L {port}:127.0.0.1:{port} HOST)"
        )));
    }
    serve(server, *at).await
}

#[cfg(feature = "foxglove")]
use bridge::serve;

#[cfg(not(feature = "foxglove"))]
async fn serve(_: &ConnectArgs, _: std::net::SocketAddr) -> anyhow::Result<()> {
    Err(Refused::error(
        "--foxglove: this program was built without it; cargo build --release --features foxglove",
    ))
}
