//! A server of this process that only this user's programs reach: for runs whose brains are programs.

use std::thread::JoinHandle;

use baudbot_server::{Address, Builder, Server, WorldConfig};
use tempfile::TempDir;
use tokio::sync::oneshot;

use crate::error::Error;

/// A server on a Unix socket in a folder that only this user may enter. It ends when this is dropped.
pub(crate) struct PrivateServer {
    /// Where it listens, as clients are told.
    pub(crate) address: String,
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
        let folder = tempfile::Builder::new().prefix("baudbot-").tempdir().map_err(|error| failed(&error))?;
        let path = folder.path().join("socket");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| failed(&error))?;
        let builder = Server::builder().listen(Address::Unix(path.clone()));
        let builder = worlds.into_iter().fold(builder, Builder::world);
        let server = runtime.block_on(builder.serve()).map_err(|error| failed(&error))?;
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::Builder::new().name("private server".to_owned()).spawn(move || {
            runtime.block_on(async {
                let _ = stopped.await;
                let _ = tokio::time::timeout(PATIENCE, server.shutdown()).await;
            });
        });
        let thread = Some(thread.map_err(|error| failed(&error))?);
        Ok(Self { address: format!("unix:{}", path.display()), stop: Some(stop), thread, _folder: folder })
    }
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
