//! Many worlds in one server: how fast they go, or whether they keep their clocks, and how soon the services answer an
//! operator meanwhile.

use std::sync::Arc;
use std::time::{Duration, Instant};

use baudbot_proto::v1::{GetWorldRequest, ListWorldsRequest, StepWorldRequest};
use baudbot_server::{Lockstep, Pace, Progress, WorldConfig};
use tokio::task::JoinSet;
use tonic::Status;

use super::heartbeat::Heartbeat;
use super::server::{Operator, Running, failed};
use super::{Found, NetworkError};
use crate::calibration;
use crate::in_process::Unfit;
use crate::measure::{Effort, Sample};
use crate::process;
use crate::scenario::parse;

/// The pace of many worlds in a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Worlds {
    /// The worlds run as fast as they can; the figure is the ticks a second of all.
    Free,
    /// Tick by tick, as clients ask for; ticks a second of all.
    Stepped,
    /// The worlds follow the wall clock; the figure is the percentage of ticks that end less than a step late.
    RealTime,
}

impl Worlds {
    fn number(self) -> usize {
        match self {
            Self::Free | Self::Stepped => 200,
            Self::RealTime => 1000,
        }
    }

    fn pace(self) -> Pace {
        match self {
            Self::Free => Pace::Free,
            Self::Stepped => Pace::Stepped(Lockstep::default()),
            Self::RealTime => Pace::REAL_TIME,
        }
    }

    /// Measures it.
    pub(crate) fn run(
        self,
        effort: Effort,
        mut progress: impl FnMut(u32),
    ) -> Result<(Found, Vec<String>), NetworkError> {
        // The calibration comes before anything runs: later it would be timed with the worlds' own work.
        let calibration_per_s = calibration::rounds_per_second();
        let before = process::memory_bytes();
        let seen = Seen::new(self.number());
        let heartbeat = (self == Self::RealTime).then(Heartbeat::start);
        let server = self.start(&seen)?;
        std::thread::sleep(Duration::from_secs_f64(effort.seconds / 4.0));
        let a_world = before.zip(process::memory_bytes());
        let a_world = a_world.map(|(before, after)| after.saturating_sub(before) / self.number() as u64);
        let (start, cpu) = (Instant::now(), process::cpu_time());
        let (mut samples, mut asked) = (Vec::new(), Asked::default());
        for repeat in 1..=effort.repeats {
            progress(repeat);
            let (from, counted, late) = (Instant::now(), seen.counted(), late(&server)?);
            let until = from + Duration::from_secs_f64(effort.seconds);
            server.block_on(self.ask(server.operator(), until, &mut asked))?;
            let ticks = (seen.counted() - counted) as f64;
            let value = match self {
                Self::Free | Self::Stepped => ticks / from.elapsed().as_secs_f64(),
                Self::RealTime => on_time_percent(ticks, self::late(&server)?.ticks - late.ticks),
            };
            samples.push(Sample { value, calibration_per_s });
        }
        let mut notes = asked.told();
        if let Some(heartbeat) = heartbeat {
            notes.extend([told(seen.counted(), &late(&server)?), heartbeat.told()]);
        }
        let processors = (process::cpu_time() - cpu).as_secs_f64() / start.elapsed().as_secs_f64();
        notes.push(format!(
            "{} worlds, {processors:.2} processors while measured, {:.0} kB a world",
            self.number(),
            a_world.map_or(f64::NAN, |bytes| bytes as f64 / 1e3)
        ));
        server.end();
        if samples.iter().any(|sample| sample.value <= 0.0) {
            return Err(Unfit::NotReal("no world went on".to_owned()).into());
        }
        Ok((Found { samples, beside: None, usage: Some(process::usage()) }, notes))
    }

    /// A server with the worlds, each from a scenario of its own, as those have that operators create. They have no hook, with
    /// which each would have a thread.
    fn start(self, seen: &Seen) -> Result<Running, NetworkError> {
        let mut worlds = Vec::new();
        for (i, progress) in seen.progress.iter().enumerate() {
            let scenario = parse(SCENARIO).map_err(Unfit::from)?;
            let world = WorldConfig::new(name(i), scenario).pace(self.pace()).paused(self == Self::RealTime);
            worlds.push(world.progress(Arc::clone(progress)));
        }
        let server = Running::start(worlds, None)?;
        // Worlds that wait for brains go on without them on request.
        if self != Self::Free {
            (0..self.number()).try_for_each(|i| server.go(&name(i)))?;
        }
        Ok(server)
    }

    /// Asks for all worlds and for one of them by turns, and notes how long the answers take; beside it, clients step worlds
    /// if that is their pace.
    async fn ask(
        self,
        mut operator: Operator,
        until: Instant,
        asked: &mut Asked,
    ) -> Result<(), NetworkError> {
        let mut clients = JoinSet::new();
        if self == Self::Stepped {
            for client in 0..CLIENTS {
                let names = (client..self.number()).step_by(CLIENTS).map(name).collect();
                clients.spawn(step(operator.clone(), names, until));
            }
        }
        for i in 0.. {
            asked.list.push(answered(operator.list_worlds(ListWorldsRequest {})).await?);
            let world = name(i % self.number());
            asked.get.push(answered(operator.get_world(GetWorldRequest { world })).await?);
            if Instant::now() >= until {
                break;
            }
            tokio::time::sleep(BETWEEN).await;
        }
        while let Some(done) = clients.join_next().await {
            done.expect("a client does not panic")?;
        }
        Ok(())
    }
}

/// The duration of a call; one that is not answered for too long is left.
async fn answered<T>(call: impl Future<Output = Result<T, Status>>) -> Result<Duration, NetworkError> {
    let start = Instant::now();
    match tokio::time::timeout(PATIENCE, call).await {
        Ok(answer) => answer.map(|_| start.elapsed()).map_err(|status| failed(&status)),
        Err(_) => Ok(PATIENCE),
    }
}

/// Steps these worlds, one after the other, a tick each.
async fn step(mut operator: Operator, worlds: Vec<String>, until: Instant) -> Result<(), NetworkError> {
    for world in worlds.iter().cycle() {
        if Instant::now() >= until {
            break;
        }
        let request = StepWorldRequest { world: world.clone(), ticks: 1 };
        operator.step_world(request).await.map_err(|status| failed(&status))?;
    }
    Ok(())
}

/// The numbers that the worlds count themselves.
struct Seen {
    progress: Vec<Arc<Progress>>,
}

impl Seen {
    fn new(worlds: usize) -> Self {
        Self { progress: std::iter::repeat_with(Arc::default).take(worlds).collect() }
    }

    /// Ticks of all.
    fn counted(&self) -> u64 {
        self.progress.iter().map(|progress| progress.tick()).sum()
    }
}

/// The ticks that ended a step late or more.
struct Late {
    ticks: u64,
    most: Duration,
}

fn on_time_percent(ticks: f64, late: u64) -> f64 {
    100.0 * (1.0 - late as f64 / ticks.max(1.0))
}

/// The lateness counted by the worlds since their start.
fn late(server: &Running) -> Result<Late, NetworkError> {
    let list =
        async { server.operator().list_worlds(ListWorldsRequest {}).await.map_err(|status| failed(&status)) };
    let worlds = server.block_on(list)?.into_inner().worlds;
    let pacing = || worlds.iter().filter_map(|world| world.pacing.as_ref());
    let most_ns = pacing().map(|pacing| pacing.lateness_max_wall_ns).max().unwrap_or_default();
    Ok(Late { ticks: pacing().map(|pacing| pacing.late_ticks).sum(), most: Duration::from_nanos(most_ns) })
}

/// The durations of answers.
#[derive(Default)]
struct Asked {
    list: Vec<Duration>,
    get: Vec<Duration>,
}

impl Asked {
    fn told(self) -> Vec<String> {
        let told = |(what, mut times): (&str, Vec<Duration>)| {
            times.sort();
            let ms = |share| percentile(&times, share).as_secs_f64() * 1e3;
            format!(
                "{what} answered {} times, half within {:.2} ms, 99 % within {:.2} ms, {:.2} ms at most",
                times.len(),
                ms(0.5),
                ms(0.99),
                ms(1.0)
            )
        };
        [("ListWorlds", self.list), ("GetWorld", self.get)].map(told).to_vec()
    }
}

/// The least of these that as large a share of them is within; they are in order.
fn percentile(times: &[Duration], share: f64) -> Duration {
    let place = (share * times.len() as f64).ceil() as usize;
    times.get(place.saturating_sub(1)).copied().unwrap_or_default()
}

fn told(ticks: u64, late: &Late) -> String {
    let most_ms = late.most.as_secs_f64() * 1e3;
    format!(
        "{ticks} ticks since the start, {} of them late by a step or more, {most_ms:.1} ms at most",
        late.ticks
    )
}

fn name(i: usize) -> String {
    format!("w{i:04}")
}

/// A scenario with one small robot, which has no brain.
const SCENARIO: &str = include_str!("../../../../catalogue/scenarios/khepera.toml");

/// Clients that step worlds.
const CLIENTS: usize = 8;

/// The longest wait of an operator for an answer; one that takes longer counts as this.
const PATIENCE: Duration = Duration::from_secs(10);

/// The time between two questions of the operator.
const BETWEEN: Duration = Duration::from_millis(10);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_is_the_least_that_as_many_are_within() {
        let times: Vec<_> = (1..=200).map(Duration::from_millis).collect();
        let ms = |share| percentile(&times, share).as_millis();
        assert_eq!([0.5, 0.99, 1.0].map(ms), [100, 198, 200]);
        assert_eq!(percentile(&times[..1], 0.99).as_millis(), 1);
        assert_eq!(percentile(&[], 0.5), Duration::ZERO);
    }

    #[test]
    fn late_ticks_are_counted() {
        let text = told(4, &Late { ticks: 2, most: Duration::from_millis(25) });
        assert_eq!(text, "4 ticks since the start, 2 of them late by a step or more, 25.0 ms at most");
    }
}
