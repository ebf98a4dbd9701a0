//! Finding a server, and a world on it.

use anyhow::bail;
use baudbot_client::Channel;
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;

use crate::args::ConnectArgs;
use crate::error::from_server;
use crate::natural;

/// A connection to the server.
pub(crate) async fn channel(server: &ConnectArgs) -> anyhow::Result<Channel> {
    Ok(baudbot_client::connect_with(&server.connect, &server.credentials.read()?).await?.channel())
}

/// A client of an operator's service.
pub(crate) fn control(channel: Channel) -> ControlServiceClient<Channel> {
    ControlServiceClient::new(channel).max_decoding_message_size(MAX_MESSAGE_BYTES)
}

/// A client of an observer's service.
pub(crate) fn observe(channel: Channel) -> ObserveServiceClient<Channel> {
    ObserveServiceClient::new(channel).max_decoding_message_size(MAX_MESSAGE_BYTES)
}

/// The world that the arguments name, or the only one that there is.
pub(crate) async fn world(channel: Channel, args: &ConnectArgs) -> anyhow::Result<v1::WorldStatus> {
    let mut control = control(channel);
    if let Some(name) = &args.world {
        let answer = control.get_world(v1::GetWorldRequest { world: name.clone() }).await;
        let status = answer.map_err(|status| from_server(&status))?.into_inner().status;
        return Ok(status.unwrap_or_default());
    }
    let answer = control.list_worlds(v1::ListWorldsRequest {}).await;
    let mut worlds = answer.map_err(|status| from_server(&status))?.into_inner().worlds;
    match worlds.len() {
        0 => bail!("the server has no worlds"),
        1 => Ok(worlds.swap_remove(0)),
        _ => {
            let names = natural::sorted(worlds.iter().map(|world| world.world.as_str()), |name| name);
            bail!("the server has several worlds; choose one with --world: {}", names.join(", "))
        }
    }
}

/// Worlds are described in messages that are about as long as their scenarios, which may have 16 MiB.
const MAX_MESSAGE_BYTES: usize = 64 << 20;
