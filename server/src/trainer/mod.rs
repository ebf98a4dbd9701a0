//! The trainers' service: a stream that drives the robots of many worlds, and gets the truth about them.
//!
//! A trainer holds robots by the same sessions, and its Steps take the same way, as those of a brain (`brain_link`). Only what
//! comes back is more: with each Turn, and with the end of a run, the truth at the start of that tick (`truth`). A trainer is
//! no observer: worlds look ahead as for any brain.

mod cycle;
mod world;

use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::train_request::Request as Content;
use baudbot_proto::v1::trainer_service_server::TrainerService;
use tokio::sync::{mpsc, watch};
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status, Streaming};

use crate::audit::call::note_robots;
use crate::brain_link::next_request;
use crate::limits::Limit;
use crate::registry::Registry;
use cycle::{act, checked};
use world::Trained;

pub(crate) struct Trainer {
    pub(crate) registry: Registry,
    /// The time for which a stream may be open without an Open.
    pub(crate) patience: Duration,
    /// Becomes true when the server stops.
    pub(crate) stopped: watch::Receiver<bool>,
}

#[tonic::async_trait]
impl TrainerService for Trainer {
    type TrainStream = ReceiverStream<Result<v1::TrainResponse, Status>>;

    async fn train(
        &self,
        request: Request<Streaming<v1::TrainRequest>>,
    ) -> Result<Response<Self::TrainStream>, Status> {
        let mut requests = request.into_inner();
        let patience = self.patience;
        let first = tokio::time::timeout(patience, requests.message());
        let late = |_| Status::deadline_exceeded(format!("request: nothing has come within {patience:?}"));
        let open = match first.await.map_err(late)??.and_then(|request| request.request) {
            Some(Content::Open(open)) => open,
            Some(Content::Cycle(_)) => {
                return Err(Status::failed_precondition("request: the first request must be an `open`"));
            }
            None => return Err(Status::invalid_argument("request: the first request must be an `open`")),
        };
        let worlds = self.open(open).await?;
        let (responses, stream) = mpsc::channel(1);
        // The task lives as long as the trainer stays.
        tokio::spawn(train(requests, worlds, responses, self.stopped.clone()));
        Ok(Response::new(ReceiverStream::new(stream)))
    }
}

impl Trainer {
    /// Takes the robots of all worlds, or of none.
    async fn open(&self, open: v1::OpenTraining) -> Result<Vec<Trained>, Status> {
        let count = open.worlds.len();
        if count == 0 {
            return Err(Status::invalid_argument("open.worlds: must name at least one world"));
        }
        let limits = self.registry.limits();
        limits.check(Limit::WorldsPerTrainer, count, |count| format!("open.worlds: there are {count}"))?;
        note_robots(&open.worlds);
        let mut worlds: Vec<Trained> = Vec::with_capacity(count);
        for (i, hello) in open.worlds.into_iter().enumerate() {
            let at = |status: Status| within(&format!("open.worlds[{i}]"), &status);
            if worlds.iter().any(|world| world.name() == hello.world) {
                let text = format!("open.worlds[{i}].world: `{}` is named twice", hello.world);
                return Err(Status::invalid_argument(text));
            }
            worlds.push(Trained::open(&self.registry, hello).await.map_err(at)?);
        }
        Ok(worlds)
    }
}

/// A status whose text begins with this field.
fn within(field: &str, status: &Status) -> Status {
    Status::new(status.code(), format!("{field}.{}", status.message()))
}

/// Answers the requests of a trainer until it is gone or one of them is invalid; then its robots are released.
async fn train(
    mut requests: Streaming<v1::TrainRequest>,
    mut worlds: Vec<Trained>,
    responses: mpsc::Sender<Result<v1::TrainResponse, Status>>,
    mut stopped: watch::Receiver<bool>,
) {
    let end = tokio::select! {
        end = answer_all(&mut requests, &mut worlds, &responses) => end,
        // A trainer that no longer reads is gone.
        () = responses.closed() => Ok(()),
        _ = stopped.wait_for(|stopped| *stopped) => Err(Status::unavailable("this server stops")),
    };
    if let Err(status) = end {
        worlds.iter_mut().for_each(|world| world.end(status.message()));
        tokio::select! {
            _ = responses.send(Err(status)) => {}
            () = responses.closed() => {}
        }
    }
}

async fn answer_all(
    requests: &mut Streaming<v1::TrainRequest>,
    worlds: &mut [Trained],
    responses: &mpsc::Sender<Result<v1::TrainResponse, Status>>,
) -> Result<(), Status> {
    let mut actions = Vec::new();
    let mut order: Vec<_> = (0..worlds.len()).collect();
    loop {
        // Requests are always read on: unread ones would hold up all other streams of their connection.
        let response = tokio::select! {
            response = act(worlds, actions, &order) => response,
            early = next_request(requests) => return match early? {
                Some(_) => Err(Status::failed_precondition(
                    "request: the previous request has not been answered yet; wait for its response",
                )),
                None => Ok(()),
            },
        };
        if responses.send(Ok(response)).await.is_err() {
            return Ok(());
        }
        let Some(request) = next_request(requests).await? else { return Ok(()) };
        (actions, order) = checked(request, worlds)?;
    }
}
