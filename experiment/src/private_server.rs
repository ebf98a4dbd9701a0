//! A server of this process that only this user's programs reach: for runs whose brains are programs.

use std::net::{Ipv4Addr, SocketAddr};
use std::thread::JoinHandle;
use std::time::SystemTime;

use baudbot_access::{DrivePattern, NewGrant, Right, TokenFile};
use baudbot_client::Credentials;
use baudbot_server::{Address, Builder, Server, WorldConfig};
use tempfile::TempDir;
use tokio::sync::oneshot;

use crate::error::Error;

/// A server on a Unix socket in a folder that only this user may enter. It ends when this is dropped.
pub(crate) struct PrivateServer {
    /// Where it listens, as clients are told.
    pub(crate) address: String,
    /// What programs show it, if it asks.
    keys: Option<Keys>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    _folder: TempDir,
}

/// The tokens of a server on which a program may only drive.
pub(crate) struct Keys {
    /// Of who runs the worlds.
    pub(crate) own: Credentials,
    /// Of the programs.
    pub(crate) program: String,
}

impl PrivateServer {
    /// Starts it, with these worlds. Whoever reaches it may do everything.
    pub(crate) fn start(worlds: impl IntoIterator<Item = WorldConfig>) -> Result<Self, Error> {
        let folder = folder()?;
        let path = folder.path().join("socket");
        Self::listen(Server::builder().listen(Address::Unix(path)), worlds, folder, None)
    }

    /// The same, but programs may do nothing but drive robots, and so cannot learn what is true. A Unix socket would ask this
    /// user's programs for no token, so it listens on this machine's own network.
    pub(crate) fn start_sealed(worlds: impl IntoIterator<Item = WorldConfig>) -> Result<Self, Error> {
        let folder = folder()?;
        let file = TokenFile::at(folder.path().join("tokens.toml"));
        let make = |name: &str, rights| {
            let name = name.parse().expect("a name of our own is sound");
            let new = NewGrant { name, rights, expires_at: None };
            file.add(new, SystemTime::now()).map_err(|error| failed(&error))
        };
        let program = make("brain", vec![Right::Drive(DrivePattern::all())])?;
        let own = make("baudbot", Right::all())?;
        let keys = Keys { own: Credentials::default().token(own), program: program.reveal() };
        let address = Address::Tcp(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
        Self::listen(Server::builder().listen(address).tokens(file), worlds, folder, Some(keys))
    }

    fn listen(
        builder: Builder,
        worlds: impl IntoIterator<Item = WorldConfig>,
        folder: TempDir,
        keys: Option<Keys>,
    ) -> Result<Self, Error> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| failed(&error))?;
        let builder = worlds.into_iter().fold(builder, Builder::world);
        let server = runtime.block_on(builder.serve()).map_err(|error| failed(&error))?;
        let address = server.addresses().first().map(ToString::to_string).unwrap_or_default();
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::Builder::new().name("private server".to_owned()).spawn(move || {
            runtime.block_on(async {
                let _ = stopped.await;
                let _ = tokio::time::timeout(PATIENCE, server.shutdown()).await;
            });
        });
        let thread = Some(thread.map_err(|error| failed(&error))?);
        Ok(Self { address, keys, stop: Some(stop), thread, _folder: folder })
    }

    /// The tokens that it asks for.
    pub(crate) fn keys(&self) -> Option<&Keys> {
        self.keys.as_ref()
    }
}

fn folder() -> Result<TempDir, Error> {
    tempfile::Builder::new().prefix("baudbot-").tempdir().map_err(|error| failed(&error))
}

fn failed(error: &dyn ToString) -> Error {
    Error::Server(format!("cannot start a server for programs: {}", error.to_string()))
}

impl Drop for PrivateServer {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// How long connections have to close.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(1);
