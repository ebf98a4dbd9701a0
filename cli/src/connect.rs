//! Finding a server, and a world on it.

use anyhow::bail;
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use tonic::transport::Channel;

use crate::args::ConnectArgs;
use crate::error::from_server;

/// A connection to the server.
pub(crate) async fn channel(address: &str) -> anyhow::Result<Channel> {
    Ok(baudbot_client::connect(address).await?.channel())
}

/// All worlds of the server.
pub(crate) async fn worlds(channel: Channel) -> anyhow::Result<Vec<v1::WorldStatus>> {
    let answer = ControlServiceClient::new(channel).list_worlds(v1::ListWorldsRequest {}).await;
    Ok(answer.map_err(|status| from_server(&status))?.into_inner().worlds)
}

/// The world that the arguments name, or the only one that there is.
pub(crate) async fn world(channel: Channel, args: &ConnectArgs) -> anyhow::Result<v1::WorldStatus> {
    let mut worlds = worlds(channel).await?;
    let names: Vec<_> = worlds.iter().map(|world| world.world.clone()).collect();
    let names = names.join(", ");
    match &args.world {
        Some(name) => match worlds.iter().position(|world| world.world == *name) {
            Some(i) => Ok(worlds.swap_remove(i)),
            None if worlds.is_empty() => bail!("the server has no world `{name}`, nor any other"),
            None => bail!("the server has no world `{name}`; it has: {names}"),
        },
        None => match worlds.len() {
            0 => bail!("the server has no world"),
            1 => Ok(worlds.swap_remove(0)),
            _ => bail!("the server has several worlds, choose with --world: {names}"),
        },
    }
}
