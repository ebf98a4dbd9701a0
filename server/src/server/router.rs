//! The services of a listener. Brains, observers and operators have all but that of trainers; trainers have that one
//! and the operator's; where there are brains only, they have theirs only.

use std::sync::Arc;
use std::time::Duration;

use baudbot_proto::v1::trainer_service_server::{SERVICE_NAME as TRAINER, TrainerServiceServer};
use prost::Message as _;
use prost_types::FileDescriptorSet;
use tokio::sync::watch;
use tonic::server::NamedService;
use tonic::transport::Server as Transport;
use tonic_health::server::HealthReporter;
use tower::layer::util::{Identity, Stack};

use super::ServerError;
use crate::brain_link::{BrainLink, BrainLinkServer};
use crate::control::{Control, ControlServer};
use crate::gate::{CheckCalls, Gate};
use crate::limits::Limit;
use crate::observe::{Observe, ObserveServer};
use crate::trainer::Trainer;

/// The interval at which a silent connection is pinged, and the time that it has to answer.
const KEEPALIVE: Duration = Duration::from_secs(20);

/// Streams of a connection beyond its limit, in which calls are refused in words.
const SPARE_STREAMS: usize = 64;

/// The services, behind the check of each call.
pub(super) type Router = tonic::transport::server::Router<Stack<CheckCalls, Identity>>;

/// The services for brains, observers and operators.
///
/// # Errors
/// If they cannot be described for reflection.
pub(super) async fn ordinary(
    control: &Arc<Control>,
    check: &CheckCalls,
    gate: &Gate,
) -> Result<Router, ServerError> {
    let (health, health_service) = tonic_health::server::health_reporter();
    is_serving::<BrainLinkServer>(&health).await;
    is_serving::<ObserveServer>(&health).await;
    let observe = Observe { registry: control.registry.clone() };
    Ok(with_operator(control, check, gate, &health, without_trainers(contract()))
        .await?
        .add_service(health_service)
        .add_service(ObserveServer::new(observe))
        .add_service(brain_link(control, gate)))
}

/// The service for brains.
pub(super) fn brains(control: &Arc<Control>, check: &CheckCalls, gate: &Gate) -> Router {
    transport(check, gate).add_service(brain_link(control, gate))
}

fn brain_link(control: &Control, gate: &Gate) -> BrainLinkServer {
    BrainLinkServer::new(BrainLink { registry: control.registry.clone(), patience: gate.patience() })
}

/// The services for trainers.
///
/// # Errors
/// If they cannot be described for reflection.
pub(super) async fn trainers(
    control: &Arc<Control>,
    check: &CheckCalls,
    gate: &Gate,
    stopped: watch::Receiver<bool>,
) -> Result<Router, ServerError> {
    let (health, health_service) = tonic_health::server::health_reporter();
    is_serving::<TrainerServiceServer<Trainer>>(&health).await;
    let trainer = Trainer { registry: control.registry.clone(), patience: gate.patience(), stopped };
    Ok(with_operator(control, check, gate, &health, contract())
        .await?
        .add_service(health_service)
        .add_service(TrainerServiceServer::new(trainer)))
}

/// The operator's service, and reflection of this contract.
async fn with_operator(
    control: &Arc<Control>,
    check: &CheckCalls,
    gate: &Gate,
    health: &HealthReporter,
    contract: FileDescriptorSet,
) -> Result<Router, ServerError> {
    is_serving::<ControlServer>(health).await;
    let reflection = || {
        tonic_reflection::server::Builder::configure()
            .register_file_descriptor_set(contract.clone())
            .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
    };
    Ok(transport(check, gate)
        // Python's reflection client speaks only v1alpha.
        .add_service(reflection().build_v1()?)
        .add_service(reflection().build_v1alpha()?)
        .add_service(
            // A scenario may have 16 MiB, and a request is a little longer than that.
            ControlServer::new(Arc::clone(control), baudbot_scenario::MAX_BYTES + (1 << 16)),
        ))
}

/// The layers that all services share.
fn transport(check: &CheckCalls, gate: &Gate) -> Transport<Stack<CheckCalls, Identity>> {
    let streams = gate.limits().count(Limit::StreamsPerConnection);
    Transport::builder()
        // The brains of a machine that has vanished are detached after a while.
        .http2_keepalive_interval(Some(KEEPALIVE))
        .http2_keepalive_timeout(Some(KEEPALIVE))
        // A client that keeps to this waits without an answer. So there are some more than are answered, and the next
        // ones get an error.
        .max_concurrent_streams(u32::try_from(streams.saturating_add(SPARE_STREAMS)).unwrap_or(u32::MAX))
        .layer(check.clone())
}

async fn is_serving<S: NamedService>(health: &HealthReporter) {
    health.set_serving::<S>().await;
}

fn contract() -> FileDescriptorSet {
    FileDescriptorSet::decode(baudbot_proto::DESCRIPTORS).expect("the contract is sound, as a test knows")
}

/// The contract without the file of the trainers' service: where that is not served, reflection does not show it.
fn without_trainers(mut contract: FileDescriptorSet) -> FileDescriptorSet {
    contract.file.retain(|file| {
        let mut services =
            file.service.iter().map(|service| format!("{}.{}", file.package(), service.name()));
        !services.any(|name| name == TRAINER)
    });
    contract
}
