//! A server of this process that only this user's programs reach, as brains: for runs whose brains are programs.

use std::sync::Arc;
use std::thread::JoinHandle;

use baudbot_access::private_folder;
use baudbot_client::Client;
use baudbot_server::{Address, Builder, Server, WorldConfig};
use tempfile::TempDir;
use tokio::sync::oneshot;

use crate::error::Error;

/// A server whose brains come by a Unix socket in a folder that only this user may enter, and whose operator is in this process. It
/// ends when this is dropped.
pub(crate) struct PrivateServer {
    /// The address for brains, in the form in which programs get it.
    pub(crate) address: String,
    server: Option<Arc<Server>>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
    _folder: TempDir,
}

impl PrivateServer {
    /// Starts it, with these worlds.
    pub(crate) fn start(worlds: impl IntoIterator<Item = WorldConfig>) -> Result<Self, Error> {
        let failed = |error: &dyn ToString| {
            Error::Server(format!("cannot start a server for programs: {}", error.to_string()))
        };
        let folder = private_folder().map_err(|error| failed(&error))?;
        let path = folder.path().join("socket");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| failed(&error))?;
        let builder = Server::builder().brains(Address::Unix(path.clone()));
        let builder = worlds.into_iter().fold(builder, Builder::world);
        let server = Arc::new(runtime.block_on(builder.serve()).map_err(|error| failed(&error))?);
        let (stop, stopped) = oneshot::channel();
        let served = Arc::clone(&server);
        let thread = std::thread::Builder::new().name("private server".to_owned()).spawn(move || {
            runtime.block_on(async {
                let _ = stopped.await;
                let server = Arc::into_inner(served).expect("the other one is dropped first");
                let _ = tokio::time::timeout(PATIENCE, server.shutdown()).await;
            });
        });
        let thread = Some(thread.map_err(|error| failed(&error))?);
        let address = format!("unix:{}", path.display());
        Ok(Self { address, server: Some(server), stop: Some(stop), thread, _folder: folder })
    }

    /// The server itself. Nobody may keep it for longer than this lives.
    pub(crate) fn server(&self) -> Option<&Arc<Server>> {
        self.server.as_ref()
    }

    /// A connection of its operator.
    pub(crate) async fn operator(&self) -> Result<Client, Error> {
        let failed = |error: &dyn ToString| Error::Server(error.to_string());
        let server = self.server.as_ref().ok_or_else(|| failed(&"the server for programs is over"))?;
        Ok(Client::from_channel(server.channel().await.map_err(|error| failed(&error))?))
    }
}

impl Drop for PrivateServer {
    fn drop(&mut self) {
        drop(self.server.take());
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// The time that connections have to close.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(1);
