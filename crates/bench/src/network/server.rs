//! A server with its worlds, on a thread of its own, as in `baudbot serve`.

use std::thread::JoinHandle;

use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::{GetWorldRequest, StartWorldRequest, WorldStatus};
use baudbot_server::{Server, WorldConfig};
use tokio::runtime::Handle;
use tokio::sync::oneshot;
use tonic::Status;
use tonic::transport::Channel;

use super::guards::Guards;
use super::{NetworkError, ping};

/// The name of a world that is alone.
pub(super) const WORLD: &str = "w";

/// The client of an operator.
pub(super) type Operator = ControlServiceClient<Channel>;

/// A server that runs.
pub(super) struct Running {
    handle: Handle,
    address: String,
    operator: Operator,
    stop: oneshot::Sender<()>,
    thread: JoinHandle<()>,
}

impl Running {
    /// Starts it on a free port of this machine.
    pub(super) fn start(worlds: Vec<WorldConfig>, guards: Option<&Guards>) -> Result<Self, NetworkError> {
        let failed = |error: &dyn std::fmt::Display| NetworkError::Server(error.to_string());
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|error| failed(&error))?;
        let handle = runtime.handle().clone();
        let address = "127.0.0.1:0".parse().map_err(|error| failed(&error))?;
        let (server, operator) = runtime
            .block_on(async {
                let builder = match guards {
                    Some(guards) => guards.guard(Server::builder()),
                    None => Server::builder(),
                };
                let builder = worlds.into_iter().fold(builder, |builder, world| builder.world(world));
                let server = builder.listen(address).serve().await?;
                let operator =
                    ControlServiceClient::new(server.channel().await?).max_decoding_message_size(LARGEST);
                Ok((server, operator))
            })
            .map_err(|error: baudbot_server::ServerError| failed(&error))?;
        let scheme = if server.is_encrypted() { "https://" } else { "" };
        let address = server.addresses().first().map(ToString::to_string).unwrap_or_default();
        let address = format!("{scheme}{address}");
        let (stop, stopped) = oneshot::channel::<()>();
        let thread = std::thread::Builder::new().name("server".to_owned()).spawn(move || {
            runtime.block_on(async {
                // An error is the other end that is gone: an end as good as any.
                let _ = stopped.await;
                server.shutdown().await;
            });
        });
        let thread = thread.map_err(|error| failed(&error))?;
        Ok(Self { handle, address, operator, stop, thread })
    }

    /// The server's address.
    pub(super) fn address(&self) -> String {
        self.address.clone()
    }

    /// Serves a ping-pong with so many streams on the same thread, and returns where.
    pub(super) fn ping(&self, streams: usize) -> Result<String, NetworkError> {
        let address = self.handle.block_on(ping::serve(streams));
        Ok(address.map_err(|error| NetworkError::Server(error.to_string()))?.to_string())
    }

    /// The client of an operator; each has its own.
    pub(super) fn operator(&self) -> Operator {
        self.operator.clone()
    }

    /// Does this on this thread, with the server beside it.
    pub(super) fn block_on<F: Future>(&self, work: F) -> F::Output {
        self.handle.block_on(work)
    }

    /// The status of the only world.
    pub(super) fn status(&self) -> Result<WorldStatus, NetworkError> {
        let request = GetWorldRequest { world: WORLD.to_owned() };
        let response = self.handle.block_on(self.operator.clone().get_world(request));
        let status = response.map_err(|status| failed(&status))?.into_inner();
        Ok(status.status.unwrap_or_default())
    }

    /// Lets a world go on.
    pub(super) fn go(&self, world: &str) -> Result<(), NetworkError> {
        let request = StartWorldRequest { world: world.to_owned() };
        let response = self.handle.block_on(self.operator.clone().start_world(request));
        response.map_err(|status| failed(&status))?;
        Ok(())
    }

    /// Ends it, and waits until it has.
    pub(super) fn end(self) {
        let _ = self.stop.send(());
        let _ = self.thread.join();
    }
}

/// The error for the status of a call that failed.
pub(super) fn failed(status: &Status) -> NetworkError {
    NetworkError::Server(status.message().to_owned())
}

/// A status of a thousand robots is not short.
const LARGEST: usize = 64 << 20;
