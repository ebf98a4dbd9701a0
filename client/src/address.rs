//! The way from an address to a connection.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use hyper_util::rt::TokioIo;
use tokio::sync::SetOnce;
use tokio::time::timeout;
use tokio_rustls::TlsConnector;
use tonic::transport::Endpoint;
use tower::service_fn;

use crate::attempt::Attempt;
use crate::channel::Channel;
use crate::credentials::Credentials;
use crate::error::{Error, root};
use crate::line::{First, Line};
use crate::place::Place;

/// Connects to the server at `HOST:PORT`, `http://HOST:PORT`, `https://HOST:PORT` or `unix:/PATH`.
pub(crate) async fn connect(address: &str, credentials: &Credentials) -> Result<Channel, Error> {
    connect_within(address, credentials, PATIENCE).await
}

async fn connect_within(
    address: &str,
    credentials: &Credentials,
    patience: Duration,
) -> Result<Channel, Error> {
    let (place, endpoint) = place(address).ok_or_else(|| Error::Address { address: address.to_owned() })?;
    let token = credentials.token_for(address)?;
    if let (Some(_), Some(authority)) = (&token, place.unprotected()) {
        return Err(Error::Unprotected { authority: authority.to_owned() });
    }
    let tls = if place.is_encrypted() { Some(TlsConnector::from(credentials.tls()?)) } else { None };
    let heard = Arc::new(SetOnce::new());
    // Also makes the connections that take the place of one that is lost.
    let connector = service_fn({
        let (place, heard) = (place.clone(), Arc::clone(&heard));
        move |_| {
            let (place, tls, heard) = (place.clone(), tls.clone(), Arc::clone(&heard));
            async move { Ok::<_, io::Error>(TokioIo::new(Line::new(place.open(tls.as_ref()).await?, heard))) }
        }
    });
    let attempt = Attempt { address, place: &place, credentials };
    let channel = endpoint.connect_timeout(patience).connect_with_connector(connector).await;
    let channel = channel.map_err(|error| match heard.get() {
        // The stream has the reason for the end of the connection, the error only that it ended.
        Some(First::End(end)) => attempt.error(end),
        Some(First::Bytes | First::Words(_)) | None => attempt.error(root(&error)),
    })?;
    // A server sends its settings at once. A program that does not would leave the first call without an answer.
    match timeout(patience, heard.wait()).await {
        Err(_) => Err(attempt.silence(patience)),
        Ok(First::Words(words)) => Err(Error::Connect { address: address.to_owned(), cause: words.clone() }),
        // In TLS 1.3 it is only now that a server refuses a client's certificate.
        Ok(First::End(end)) if place.is_encrypted() => Err(attempt.error(end)),
        // The loss of any other connection is reported by the first call.
        Ok(First::End(_) | First::Bytes) => Ok(Channel::new(channel, token.as_deref())),
    }
}

fn place(address: &str) -> Option<(Place, Endpoint)> {
    let place = Place::of(address)?;
    // A brain that waits for its turn receives nothing for long, and would not notice that the server is gone.
    let endpoint = Endpoint::from_shared(place.uri())
        .ok()?
        .http2_keep_alive_interval(KEEPALIVE)
        .keep_alive_timeout(KEEPALIVE);
    Some((place, endpoint))
}

/// The time in which a server must be reached, and then send its first bytes.
const PATIENCE: Duration = Duration::from_secs(5);

/// The time for which a silent server is left in peace, and then the time it has for an answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

#[cfg(test)]
mod tests {
    use baudbot_access::Token;

    use super::*;

    #[test]
    fn addresses() {
        for good in [
            "127.0.0.1:7400",
            "localhost:7400",
            "[::1]:7400",
            "http://127.0.0.1:7400",
            "http://box:1/",
            "https://box:7400",
            "https://[::1]:7400/",
            "unix:/run/b",
        ] {
            assert!(place(good).is_some(), "{good}");
        }
        for bad in [
            "",
            "7400",
            ":7400",
            "box",
            "box:",
            "box:http",
            "https://box",
            "https://a b:7400",
            "unix:",
            "a b:7400",
            "http://box",
        ] {
            assert!(place(bad).is_none(), "{bad}");
        }
    }

    #[tokio::test]
    async fn a_port_that_takes_connections_and_says_nothing_is_given_up() {
        let silent = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = silent.local_addr().unwrap().to_string();
        let text = connect_within(&address, &Credentials::default(), Duration::from_millis(100))
            .await
            .unwrap_err()
            .to_string();
        let words = "a program accepts connections there, but has not answered for 100ms";
        let expected = format!("no server answers at {address} ({words}); is `baudbot serve` running there?");
        assert_eq!(text, expected);
    }

    #[tokio::test]
    async fn a_silent_address_is_named_with_the_fix() {
        // Port 1 needs a privileged server, of which a test machine has none.
        let text = connect("127.0.0.1:1", &Credentials::default()).await.unwrap_err().to_string();
        assert!(text.starts_with("no server answers at 127.0.0.1:1 ("), "{text}");
        assert!(text.ends_with("is `baudbot serve` running there?"), "{text}");
        let text = connect("nowhere", &Credentials::default()).await.unwrap_err().to_string();
        assert!(text.starts_with("`nowhere` is not a server address"), "{text}");
    }

    #[tokio::test]
    async fn a_token_is_not_sent_to_another_machine_without_tls() {
        let with_token = Credentials::default().token(Token::random().unwrap());
        // The addresses are reserved for documents: no machine has them.
        for address in ["192.0.2.7:7400", "http://192.0.2.7:7400/"] {
            let error = connect(address, &with_token).await.unwrap_err();
            let remedy = "write https://192.0.2.7:7400, or, if the server is behind a proxy, the proxy's https:// address";
            let place = "no token is sent to 192.0.2.7:7400 without TLS, as that is another machine";
            assert_eq!(error.to_string(), format!("{place}: {remedy}"));
            assert!(!error.may_pass());
        }
        let now = Duration::from_millis(100);
        for address in ["127.0.0.1:1", "localhost:1", "http://[::1]:1", "unix:/none"] {
            let error = connect_within(address, &with_token, now).await.unwrap_err();
            assert!(matches!(error, Error::Connect { .. }), "{error}");
        }
        let without = connect_within("192.0.2.7:7400", &Credentials::default(), now).await;
        assert!(!matches!(without, Err(Error::Unprotected { .. })), "{without:?}");
    }
}
