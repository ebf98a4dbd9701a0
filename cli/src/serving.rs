//! A server of worlds in this program: the part that `serve` and `replay` share, with its messages.

use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::Context;
use baudbot_client::Channel;
use baudbot_port::PortAddress;
use baudbot_proto::v1;
use baudbot_proto::v1::control_service_client::ControlServiceClient;
use baudbot_server::{Address, Builder, Progress, Server, StateFolder, WorldConfig};
use baudbot_sim::Scenario;
use baudbot_sim::model::RobotSpec;
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout_at};

use crate::announcement::Announcement;
use crate::args::{DEFAULT_ADDRESS, ListenArgs, Over};
use crate::assignment::{self, Assigned};
use crate::error::{Refused, from_builder};
use crate::load::Load;
use crate::ports::{Known, OpenPorts, PortsByRobot};
use crate::signals::Stop;
use crate::summary::Summary;
use crate::text::tell;
use crate::{connect, natural, ports, report, viewer};

/// Whether there is a page by default.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Viewing {
    /// Always, since the page is the server's purpose; other machines reach it only if an address allows that.
    Always,
    /// Not if the server listens on a socket's file only: others are not to reach it.
    IfOpen,
}

/// A server that is going to be started, and the description of its worlds.
pub(crate) struct Serving<'a> {
    builder: Builder,
    listen: &'a ListenArgs,
    worlds: Vec<Described>,
    /// The live worlds, which have a summary at the end.
    live: Vec<(String, Arc<Scenario>)>,
    /// The ends of their runs.
    runs: Vec<(String, Arc<Progress>)>,
    /// The serial ports of each of these.
    ports: Vec<(String, PortsByRobot)>,
    /// The time that worlds have to end in good order.
    stop_within: Duration,
    announcement: Announcement,
}

/// A world's name, what is in it, and its robots that a brain of the catalogue can drive, each with one.
type Described = (String, String, Vec<(String, String)>);

impl<'a> Serving<'a> {
    /// # Errors
    /// If what the server is to be guarded with cannot be used.
    pub(crate) fn new(listen: &'a ListenArgs) -> anyhow::Result<Self> {
        let builder = listen.builder()?;
        Ok(Self {
            builder,
            listen,
            worlds: Vec::new(),
            live: Vec::new(),
            runs: Vec::new(),
            ports: Vec::new(),
            stop_within: STOP_WITHIN,
            announcement: Announcement::default(),
        })
    }

    /// Lets operators record into a folder.
    pub(crate) fn keep_recordings(&mut self, folder: &Path) {
        self.builder = std::mem::take(&mut self.builder).recordings(folder.to_owned());
    }

    /// Keeps worlds in a folder.
    pub(crate) fn keep_state(&mut self, folder: StateFolder) {
        self.builder = std::mem::take(&mut self.builder).state(folder);
    }

    /// Gives worlds so long to end in good order.
    pub(crate) fn stop_within(&mut self, limit: Duration) {
        self.stop_within = limit;
    }

    /// Tells programs in this way that the server is ready.
    ///
    /// # Errors
    /// If the file of an earlier server cannot be removed.
    pub(crate) fn announce(&mut self, announcement: Announcement) -> anyhow::Result<()> {
        announcement.prepare()?;
        self.announcement = announcement;
        Ok(())
    }

    /// Takes trainers at an address.
    pub(crate) fn take_trainers(&mut self, address: Address) {
        self.builder = std::mem::take(&mut self.builder).trainer(address);
    }

    /// A world that brains can come to.
    pub(crate) fn add(&mut self, name: &str, scenario: &Arc<Scenario>, world: WorldConfig) {
        // No brain of the catalogue understands a robot whose program has a language of its own.
        let is_understood = |spec: &&RobotSpec| spec.chip.as_ref().is_none_or(|chip| !chip.is_opaque());
        let robots = scenario.robots.iter().filter(is_understood);
        let robots = robots.map(|spec| (spec.name.clone(), assignment::fitting_brain(spec).to_owned()));
        self.worlds.push((name.to_owned(), describe(name, scenario), robots.collect()));
        self.live.push((name.to_owned(), Arc::clone(scenario)));
        let run = Arc::new(Progress::default());
        self.runs.push((name.to_owned(), Arc::clone(&run)));
        self.builder = std::mem::take(&mut self.builder).world(world.progress(run));
    }

    /// Names a brain for the world that was added last, instead of one that only fits its robots.
    pub(crate) fn suggest(&mut self, brain: &str) {
        for (_, fitting) in self.worlds.last_mut().into_iter().flat_map(|(_, _, robots)| robots) {
            brain.clone_into(fitting);
        }
    }

    /// Opens the serial ports that scenarios ask for, and these at robots of the only world.
    pub(crate) fn open_ports(&mut self, ports: &[PortAddress]) -> anyhow::Result<()> {
        let given = match self.live.as_slice() {
            _ if ports.is_empty() => PortsByRobot::new(),
            [(_, scenario)] => {
                let robots: Vec<_> = scenario.robots.iter().map(|spec| spec.name.clone()).collect();
                ports::by_robot(ports, &robots, false)?
            }
            _ => {
                let text = "--port: takes a single world, and there are several; use `baudbot port open --world WORLD`";
                return Err(Refused::error(text));
            }
        };
        for (world, scenario) in &self.live {
            let ports = ports::with_those_of_scenario(&given, &scenario.serial_ports)?;
            // A robot that has a port is its program's: no brain gets it.
            for (_, _, robots) in self.worlds.iter_mut().filter(|(name, ..)| name == world) {
                robots.retain(|(robot, _)| !ports.contains_key(robot));
            }
            self.ports.push((world.clone(), ports));
        }
        Ok(())
    }

    /// A world that does a recording again.
    pub(crate) fn add_replay(&mut self, name: &str, world: WorldConfig) {
        self.worlds.push((name.to_owned(), format!("world {name}: replays a recording\n"), Vec::new()));
        self.builder = std::mem::take(&mut self.builder).world(world);
    }

    /// Serves until it is stopped.
    pub(crate) async fn until_stopped(self, viewing: Viewing) -> anyhow::Result<()> {
        let Self { mut builder, listen, worlds, live, runs, ports, stop_within, announcement } = self;
        let listening = addresses(listen, viewing)?;
        for address in listening.clone() {
            builder = builder.listen(address);
        }
        let open = listening.iter().any(|address| matches!(address, Address::Tcp(_)));
        builder = viewer::add(builder, listen.viewer, open || viewing == Viewing::Always);
        // Scenarios may have come through FIFOs; there a single signal is to end the program.
        let mut stop = hear(stop_within).context("cannot listen for Ctrl-C")?;
        let server = builder.serve().await.map_err(from_builder)?;
        announcement.people(&greeting(&server, &worlds))?;
        let known = |world: &str, robot: &str, device: Option<&str>| of_port(&live, world, robot, device);
        let reach = ports::reach(listen.access.open);
        let mut open = OpenPorts::open(server.channel().await?.into(), &ports, reach, known).await?;
        announcement.people(&open.greeting())?;
        announcement.ready(&server, &live)?;
        let ends = tell_ends(&connect::control(server.channel().await?.into()), runs);
        loop {
            tokio::select! {
                // An operator may have deleted the world; the server has others, or will.
                gone = open.gone() => if let Err(error) = gone {
                    tell!("note: {}", crate::error::text(&error));
                },
                () = stop.wait() => break,
            }
        }
        tell!("stopping");
        drop(ends);
        server.refuse_worlds();
        let limit = Instant::now() + stop_within;
        let ports = timeout_at(limit, open.close()).await;
        announcement.people(&ports.unwrap_or_default())?;
        announcement.people(&last_words(&server, &live, limit).await?)?;
        end(server, limit, stop_within).await
    }
}

/// The summaries, unless the server does not answer, which does not delay the stop.
async fn last_words(
    server: &Server,
    live: &[(String, Arc<Scenario>)],
    limit: Instant,
) -> anyhow::Result<String> {
    // The patience is that at the end of `run`.
    let patience = limit.min(Instant::now() + PATIENCE);
    timeout_at(patience, summaries(server, live)).await.unwrap_or_else(|_| Ok(String::new()))
}

/// The properties of a port in these scenarios that the contract lacks.
fn of_port(live: &[(String, Arc<Scenario>)], world: &str, robot: &str, device: Option<&str>) -> Known {
    let scenario = live.iter().find(|(name, _)| name == world).map(|(_, scenario)| scenario);
    let spec = scenario.and_then(|scenario| scenario.robots.iter().find(|spec| spec.name == robot));
    let sensor =
        device.and_then(|device| spec?.sensors.iter().find(|sensor| sensor.name == device)?.port.as_ref());
    Known {
        has_chip: spec.is_some_and(|spec| spec.chip.is_some()),
        answers: sensor.map(|port| port.dialogue.is_some()),
    }
}

fn hear(stop_within: Duration) -> std::io::Result<Stop> {
    let stop = Stop::listen()?;
    let words = |cause: &str| format!("the server cannot shut down, and exits as if killed; {cause}");
    stop.exit_after(stop_within + LAST_RESORT, words)?;
    Ok(stop)
}

/// Ends the server. Clients that keep their connections open are no fault of it; worlds that do not end by then are.
async fn end(mut server: Server, limit: Instant, within: Duration) -> anyhow::Result<()> {
    let load = Load::begin();
    if timeout_at(limit, server.end_worlds()).await.is_err() {
        let worlds = server.unended().join(", ");
        let within = within.as_secs();
        return Err(anyhow::anyhow!(
            "not everything has ended within {within} s (--stop-within), and the server exits as if killed: changes of {worlds} since the \
             last marks of their recordings and states may be missing; {}",
            load.cause()
        ));
    }
    if timeout_at(Instant::now() + PATIENCE, server.end_streams()).await.is_err() {
        tell!("note: a client kept its connection open; it was closed");
    }
    Ok(())
}

/// Prints the ends of worlds' runs, each for the first time: with a brain that is trained a run may end many times a
/// second.
fn tell_ends(control: &ControlServiceClient<Channel>, runs: Vec<(String, Arc<Progress>)>) -> JoinSet<()> {
    let tell_end = |(world, run): (String, Arc<Progress>)| {
        let mut control = control.clone();
        async move {
            run.ended().await;
            // An operator may have deleted it.
            let answer = control.get_world(v1::GetWorldRequest { world: world.clone() }).await;
            let status = answer.ok().and_then(|answer| answer.into_inner().status);
            if let Some(status) = status.filter(|status| !status.ending.is_empty()) {
                let v1::WorldStatus { time_ns, ending, .. } = status;
                let time_s = time_ns as f64 / 1e9;
                tell!(
                    "note: the run of world {world} ended at {time_s} s because {ending}; Reset on the page begins it again"
                );
            }
        }
    };
    runs.into_iter().map(tell_end).collect()
}

/// Worlds with a whole summary at the end; of each of more, a line.
const MOST_IN_FULL: usize = 4;

/// The summaries of the worlds that are still there and have begun.
async fn summaries(server: &Server, worlds: &[(String, Arc<Scenario>)]) -> anyhow::Result<String> {
    let mut control = connect::control(server.channel().await?.into());
    let mut text = String::new();
    // Full summaries of many worlds would be pages that are not read.
    let many = worlds.len() > MOST_IN_FULL;
    for (name, scenario) in worlds {
        let request = v1::GetWorldRequest { world: name.clone() };
        // An operator may have deleted it.
        let Ok(answer) = control.get_world(request).await else { continue };
        let status = answer.into_inner().status.unwrap_or_default();
        if status.tick > 0 {
            let summary = Summary::new(scenario, &status, true, &Assigned::default(), Over::Grpc);
            if many {
                text += &report::line(&summary);
            } else {
                let _ = write!(text, "\n{}", report::text(&summary));
            }
        }
    }
    Ok(text)
}

fn addresses(args: &ListenArgs, viewing: Viewing) -> anyhow::Result<Vec<Address>> {
    if args.listen.is_empty() && viewing == Viewing::IfOpen {
        return Ok(vec![DEFAULT_ADDRESS.parse()?]);
    }
    Ok(args.listen.clone())
}

/// Programs read the lines `listening on ADDRESS`; they come first and stay as they are.
fn greeting(server: &Server, worlds: &[Described]) -> String {
    let mut text = String::new();
    for address in server.addresses() {
        let _ = writeln!(text, "listening on {address}");
    }
    for address in server.trainers() {
        let _ = writeln!(text, "listening for trainers on {address}");
    }
    for (_, description, _) in worlds {
        text += description;
    }
    if let Some(link) = viewer::link(server) {
        let _ = writeln!(text, "\n{link}");
    }
    let with_robot = worlds.iter().find(|(_, _, robots)| !robots.is_empty());
    if let (Some((address, is_local)), Some((world, _, robots))) =
        (server.client_address(), with_robot.or_else(|| worlds.first()))
    {
        // On this machine, programs of this user find the server's token themselves.
        let ca = if address.starts_with("https://") { " --ca FILE" } else { "" };
        let token = if is_local { "" } else { " --token-file FILE" };
        let connect = format!("--connect {address}{ca}{token} --world {world}");
        let _ = writeln!(text, "\nIn a second terminal:");
        if let Some((robot, brain)) = robots.first() {
            let _ = writeln!(text, "  baudbot brain {brain} {connect} --robot {robot}");
        }
        let _ = writeln!(text, "  baudbot watch {connect}");
        let _ = writeln!(text, "Ctrl-C stops the server.");
    }
    text
}

fn describe(world: &str, scenario: &Scenario) -> String {
    let robots = natural::sorted(scenario.robots.iter().map(|spec| spec.name.as_str()), |name| name);
    let robots = match robots.as_slice() {
        [] => "no robots".to_owned(),
        [robot] => format!("robot {robot}"),
        many if many.len() <= 10 => format!("robots {}", many.join(", ")),
        many => format!("{} robots {} … {}", many.len(), many[0], many[many.len() - 1]),
    };
    format!("world {world}: {robots}\n")
}

/// The time that worlds have to end in good order, unless the command line sets another.
const STOP_WITHIN: Duration = Duration::from_secs(10);

/// The time that the server may take beyond that: connections are closed, and the system has work to do at an end.
const LAST_RESORT: Duration = Duration::from_secs(5);

/// The time that connections have to close.
const PATIENCE: Duration = Duration::from_secs(3);
