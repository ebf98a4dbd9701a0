//! The deeds of an operator, and the answers to them.

use std::fs;
use std::time::Duration;

use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_tests::WANDER;
use tokio::time::sleep;
use tonic::metadata::MetadataValue;
use tonic::transport::Channel;
use tonic::{Code, Request, Response, Status};

use super::life::{Dead, Life, Run};
use super::model::Unsure;
use crate::actors::channel;

/// So long a server of a file of tokens may take a token that is revoked.
const REVOKED_AFTER: Duration = Duration::from_millis(2100);

/// So long may it take one if the file cannot be read.
const REFUSED_AFTER: Duration = Duration::from_secs(5);

/// Names of worlds, which are given again.
const NAMES: [&str; 6] = ["w1", "w2", "w3", "w4", "w5", "w6"];

type Answer = Result<Option<v1::WorldStatus>, Status>;

impl Run {
    pub(super) fn request<T>(&self, message: T) -> Request<T> {
        by(self.tokens.as_ref().map(|tokens| tokens.stays.as_str()), message)
    }

    pub(super) async fn control(&mut self, life: &mut Life) -> ControlServiceClient<Channel> {
        loop {
            if let Some(control) = &life.control {
                return control.clone();
            }
            if let Ok(channel) = channel(&life.network, "operator").await {
                life.control = Some(ControlServiceClient::new(channel));
            }
            sleep(self.chance.ms(1, 200)).await;
        }
    }

    /// A request was not answered as it should be, by the network.
    pub(super) async fn lost(&mut self, life: &mut Life, status: &Status) {
        self.seen.unanswered += 1;
        self.trace.note(format!("  no answer: {:?}", status.code()));
        let is_network = matches!(
            status.code(),
            Code::Unavailable | Code::Unknown | Code::Cancelled | Code::DeadlineExceeded | Code::Internal
        );
        assert!(is_network, "{status:?}");
        life.control = None;
        // Bytes that were on their way have arrived by then, or never will.
        sleep(Duration::from_secs(10)).await;
    }

    /// An answer that counts: its server lived when it came.
    fn answer(&mut self, life: &Life, status: Option<v1::WorldStatus>) -> Result<v1::WorldStatus, Dead> {
        if !life.mounted.is_alive() {
            return Err(Dead);
        }
        let status = status.unwrap();
        self.seen.deeds += 1;
        let v1::WorldStatus { world, tick, state_hash, .. } = &status;
        self.trace.note(format!("  `{world}` is at tick {tick} with {state_hash:016x}"));
        Ok(status)
    }

    /// Something that an operator does.
    pub(super) async fn deed(&mut self, life: &mut Life) -> Result<(), Dead> {
        let there = self.model.there();
        if there.is_empty() || (there.len() < 4 && self.chance.one_in(6)) {
            return self.create(life).await;
        }
        let world = self.chance.one(&there).clone();
        match self.chance.below(16) {
            0..6 => self.step(life, &world).await,
            6..8 => self.put(life, &world).await,
            8..10 => self.snapshot(life, &world).await,
            10..12 => self.restore(life, &world).await,
            12 => self.reset(life, &world).await,
            13 => self.delete(life, &world).await,
            14 => self.use_revoked(life).await,
            _ => self.look(life, &world).await,
        }
    }

    async fn create(&mut self, life: &mut Life) -> Result<(), Dead> {
        let now = self.now();
        let free: Vec<_> = NAMES.into_iter().filter(|name| self.model.is_free(name, now)).collect();
        let Some(world) = free.first().map(|_| (*self.chance.one(&free)).to_owned()) else { return Ok(()) };
        self.made += 1;
        self.trace.note(format!("create `{world}`, with seed {}", self.made));
        let request = self.request(v1::CreateWorldRequest {
            world: world.clone(),
            scenario_toml: WANDER.into(),
            overrides: vec![
                format!("seed={}", self.made),
                "collision=stop-robot".into(),
                "end.after_s=100000.0".into(),
            ],
            pace: Some(v1::Pace { kind: Some(v1::pace::Kind::Stepped(v1::Stepped::default())) }),
            ..Default::default()
        });
        self.model.create(&world);
        let answer = self.control(life).await.create_world(request).await;
        match answer {
            Ok(answer) => {
                let status = self.answer(life, answer.into_inner().status)?;
                self.model.told(&status, self.now());
                // The world's robots have no brains.
                let request = self.request(v1::StartWorldRequest { world: world.clone() });
                let answer = self.control(life).await.start_world(request).await;
                self.done(life, &world, answer.map(|answer| answer.into_inner().status), Unsure::Any).await
            }
            Err(_) if !life.mounted.is_alive() => Err(Dead),
            Err(status) => {
                self.lost(life, &status).await;
                self.look(life, &world).await
            }
        }
    }

    /// Takes the answer to a request that gives a status; without an answer the world is read.
    pub(super) async fn done(
        &mut self,
        life: &mut Life,
        world: &str,
        answer: Answer,
        unsure: Unsure,
    ) -> Result<(), Dead> {
        match answer {
            Ok(status) => {
                let status = self.answer(life, status).inspect_err(|_| self.model.unsure(world, unsure))?;
                self.model.told(&status, self.now());
                Ok(())
            }
            Err(status) => {
                self.model.unsure(world, unsure);
                if !life.mounted.is_alive() {
                    return Err(Dead);
                }
                self.lost(life, &status).await;
                self.look(life, world).await
            }
        }
    }

    async fn look(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        self.trace.note(format!("look at `{world}`"));
        loop {
            let request = self.request(v1::GetWorldRequest { world: world.into() });
            let answer = self.control(life).await.get_world(request).await;
            if !life.mounted.is_alive() {
                return Err(Dead);
            }
            match answer {
                Ok(answer) => {
                    let status = self.answer(life, answer.into_inner().status)?;
                    self.model.told(&status, self.now());
                    return Ok(());
                }
                Err(status) if status.code() == Code::NotFound => {
                    self.trace.note("  it is gone");
                    self.model.is_gone(world);
                    return Ok(());
                }
                Err(status) => self.lost(life, &status).await,
            }
        }
    }

    async fn step(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        let ticks = 1 + self.chance.below(6);
        self.trace.note(format!("step `{world}` by {ticks}"));
        let request = self.request(v1::StepWorldRequest { world: world.into(), ticks });
        let answer = self.control(life).await.step_world(request).await;
        let answer = answer.map(|answer| answer.into_inner().status);
        self.done(life, world, answer, Unsure::Ticks(ticks)).await
    }

    async fn put(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        let [x_m, y_m] = [0.1, 0.0].map(|least| least + self.chance.below(100) as f64 / 500.0);
        self.trace.note(format!("put the robot of `{world}` to {x_m} {y_m}"));
        let place = v1::PlaceRobot { robot: "robot".into(), x_m, y_m, heading_rad: x_m };
        let intervention = Some(v1::intervene_request::Intervention::PlaceRobot(place));
        let request = self.request(v1::InterveneRequest { world: world.into(), intervention });
        let answer = self.control(life).await.intervene(request).await;
        if answer.as_ref().is_err_and(|status| status.code() == Code::FailedPrecondition) {
            // The world goes on within a tick: it was restored so.
            return Ok(());
        }
        let answer = answer.map(|answer| answer.into_inner().status);
        self.done(life, world, answer, Unsure::Any).await
    }

    async fn snapshot(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        self.trace.note(format!("snapshot of `{world}`"));
        let request = self.request(v1::SnapshotWorldRequest { world: world.into() });
        let answer = self.control(life).await.snapshot_world(request).await;
        match answer.map(Response::into_inner) {
            Ok(v1::SnapshotWorldResponse { snapshot, status }) => {
                let status = self.answer(life, status)?;
                self.trace.note(format!("  it is snapshot {snapshot}"));
                self.model.snapshot(snapshot, &status, self.now());
                Ok(())
            }
            Err(status) => {
                self.model.may_have_snapshot(world);
                self.done(life, world, Err(status), Unsure::Ticks(0)).await
            }
        }
    }

    async fn restore(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        let snapshots: Vec<_> = self.model.worlds[world].snapshots.keys().copied().collect();
        if snapshots.is_empty() {
            return Ok(());
        }
        let snapshot = *self.chance.one(&snapshots);
        self.trace.note(format!("restore snapshot {snapshot} of `{world}`"));
        let request = self.request(v1::RestoreWorldRequest { world: world.into(), snapshot });
        let answer = self.control(life).await.restore_world(request).await;
        match answer {
            Ok(answer) => {
                let status = self.answer(life, answer.into_inner().status);
                let status = status.inspect_err(|_| self.model.unsure(world, Unsure::Any))?;
                self.model.restored(snapshot, &status, self.now());
                Ok(())
            }
            Err(status) if status.code() == Code::NotFound && life.mounted.is_alive() => {
                self.trace.note("  it is not there");
                self.model.no_snapshot(world, snapshot);
                Ok(())
            }
            Err(status) => self.done(life, world, Err(status), Unsure::Any).await,
        }
    }

    async fn reset(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        self.trace.note(format!("reset `{world}`"));
        let request = self.request(v1::ResetWorldRequest { world: world.into(), ..Default::default() });
        let answer = self.control(life).await.reset_world(request).await;
        let answer = answer.map(|answer| answer.into_inner().status);
        self.done(life, world, answer, Unsure::Any).await
    }

    async fn delete(&mut self, life: &mut Life, world: &str) -> Result<(), Dead> {
        self.trace.note(format!("delete `{world}`"));
        let request = self.request(v1::DeleteWorldRequest { world: world.into() });
        let answer = self.control(life).await.delete_world(request).await;
        match answer {
            Ok(_) if life.mounted.is_alive() => {
                self.seen.deeds += 1;
                self.trace.note("  it is deleted");
                self.model.deleted(world, self.now());
                Ok(())
            }
            Ok(_) => {
                self.model.unsure(world, Unsure::Gone);
                Err(Dead)
            }
            Err(status) => self.done(life, world, Err(status), Unsure::Gone).await,
        }
    }

    /// A token is revoked, or its file is spoiled for a while: who shows it does nothing.
    async fn use_revoked(&mut self, life: &mut Life) -> Result<(), Dead> {
        let Some(tokens) = &mut self.tokens else { return Ok(()) };
        let (goes, stays, path) = (tokens.goes.clone(), tokens.stays.clone(), tokens.path().to_owned());
        if !tokens.is_revoked {
            self.trace.note("revoke a token");
            tokens.revoke();
            sleep(REVOKED_AFTER).await;
        }
        self.is_refused(life, &goes).await?;
        if self.chance.one_in(3) {
            self.trace.note("spoil the file of tokens");
            let good = fs::read(&path).unwrap();
            fs::write(&path, "version = ").unwrap();
            sleep(REFUSED_AFTER).await;
            let refused = self.is_refused(life, &stays).await;
            fs::write(&path, good).unwrap();
            sleep(REVOKED_AFTER).await;
            refused?;
            self.is_refused(life, &goes).await?;
        }
        Ok(())
    }

    async fn is_refused(&mut self, life: &mut Life, token: &str) -> Result<(), Dead> {
        loop {
            let world = self.model.there().first().cloned().unwrap_or_default();
            let request = by(Some(token), v1::DeleteWorldRequest { world });
            let answer = self.control(life).await.delete_world(request).await;
            if !life.mounted.is_alive() {
                return Err(Dead);
            }
            match answer {
                Err(status) if status.code() == Code::Unauthenticated => {
                    self.trace.note("  who shows it is refused");
                    self.seen.refused += 1;
                    return Ok(());
                }
                Err(status) => self.lost(life, &status).await,
                Ok(_) => panic!("a token that is revoked has acted"),
            }
        }
    }
}

/// A request of who has this token.
fn by<T>(token: Option<&str>, message: T) -> Request<T> {
    let mut request = Request::new(message);
    if let Some(token) = token {
        let value = MetadataValue::try_from(format!("Bearer {token}")).unwrap();
        request.metadata_mut().insert("authorization", value);
    }
    request
}
