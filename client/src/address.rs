//! Where a server is.

use std::time::Duration;

use tonic::transport::{Channel, Endpoint};

use crate::error::Error;

/// Connects to the server at `HOST:PORT`, `http://HOST:PORT` or `unix:/PATH`.
pub(crate) async fn connect(address: &str) -> Result<Channel, Error> {
    let endpoint = endpoint(address).ok_or_else(|| Error::Address { address: address.to_owned() })?;
    endpoint.connect().await.map_err(|error| Error::connect(address, &error))
}

fn endpoint(address: &str) -> Option<Endpoint> {
    let uri = match address.split_once(':')? {
        ("unix", path) => (!path.is_empty()).then(|| address.to_owned())?,
        ("http", _) => with_port(address, address.strip_prefix("http://")?)?,
        _ => with_port(&format!("http://{address}"), address)?,
    };
    // A step is a small message that must go at once: waiting for more to send along would cost 40 ms.
    let endpoint = Endpoint::from_shared(uri).ok()?.tcp_nodelay(true).connect_timeout(CONNECT_TIMEOUT);
    // A brain that waits for its turn hears nothing for long, and would not notice that nobody is there any more.
    Some(endpoint.http2_keep_alive_interval(KEEPALIVE).keep_alive_timeout(KEEPALIVE))
}

/// Without a port a URI means port 80, where no world is.
fn with_port(uri: &str, authority: &str) -> Option<String> {
    let (host, port) = authority.trim_end_matches('/').rsplit_once(':')?;
    (!host.is_empty() && !host.contains('/') && port.parse::<u16>().is_ok()).then(|| uri.to_owned())
}

const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// How long a server that says nothing is left in peace, and then how long it has for an answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses() {
        for good in [
            "127.0.0.1:7400",
            "localhost:7400",
            "[::1]:7400",
            "http://127.0.0.1:7400",
            "http://box:1/",
            "unix:/run/b",
        ] {
            assert!(endpoint(good).is_some(), "{good}");
        }
        for bad in [
            "",
            "7400",
            ":7400",
            "box",
            "box:",
            "box:http",
            "https://box:7400",
            "unix:",
            "a b:7400",
            "http://box",
        ] {
            assert!(endpoint(bad).is_none(), "{bad}");
        }
    }

    #[tokio::test]
    async fn a_silent_address_is_named_with_the_fix() {
        // Port 1 needs a privileged server, of which a test machine has none.
        let text = connect("127.0.0.1:1").await.unwrap_err().to_string();
        assert!(text.starts_with("no server answers at 127.0.0.1:1 ("), "{text}");
        assert!(text.ends_with("is `baudbot serve` running there?"), "{text}");
        let text = connect("nowhere").await.unwrap_err().to_string();
        assert!(text.starts_with("`nowhere` is no address"), "{text}");
    }
}
