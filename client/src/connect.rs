//! The way from an address to a client.

use crate::address;
use crate::client::Client;
use crate::credentials::Credentials;
use crate::error::Error;

/// Connects to the server at `HOST:PORT`, `http://HOST:PORT`, `https://HOST:PORT` or `unix:/PATH`, with the [credentials of the
/// environment](Credentials).
///
/// # Errors
/// [`Error::Address`] if that is no address, [`Error::Connect`] if no server answers there within 5 s, or a program
/// takes connections there and sends nothing for as long; [`Error::ServerCertificate`] and [`Error::ClientCertificate`]
/// if the two do not trust each other; [`Error::Unprotected`] if there is a token, which is not sent to another machine
/// without TLS; [`Error::Credentials`] if the environment has unsound ones.
pub async fn connect(address: &str) -> Result<Client, Error> {
    connect_with(address, &Credentials::from_environment()?).await
}

/// The same with these credentials.
///
/// # Errors
/// As [`connect`].
pub async fn connect_with(address: &str, credentials: &Credentials) -> Result<Client, Error> {
    Ok(Client::from_channel(address::connect(address, credentials).await?))
}
