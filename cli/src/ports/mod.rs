//! Serial ports for other people's programs: `serve --port`, `port open`.

mod spoken;

use std::collections::{BTreeMap, BTreeSet};

use anyhow::Context;
use baudbot_client::Channel;
use baudbot_fields::endpoint::Endpoint;
use baudbot_port::{News, PortAddress, PortError, Reach, Report, RobotPorts};
use baudbot_sim::scenario::SerialPort;
use tokio::sync::watch;
use tokio::task::JoinSet;

pub(crate) use self::spoken::Known;
use crate::args::OpenPortArgs;
use crate::connect;
use crate::error::{Refused, from_server};
use crate::signals::Stop;
use crate::text::{self, tell};

/// Ticks that are longer than this make programs wait for what they have asked.
const LONG_STEP_NS: u64 = 1_000_000;

/// `baudbot port open`.
pub(crate) async fn open(args: &OpenPortArgs) -> anyhow::Result<()> {
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let channel = connect::channel(&args.server).await?;
    let world = connect::world(channel.clone(), &args.server).await?;
    let names: Vec<_> = world.robots.iter().map(|robot| robot.robot.clone()).collect();
    let ports = by_robot(&args.ports, &names, args.open)?;
    let known = |_: &str, robot: &str, _: Option<&str>| {
        let status = world.robots.iter().find(|status| status.robot == robot);
        Known { has_chip: status.is_some_and(|status| status.chip.is_some()), answers: None }
    };
    let ports = [(world.world.clone(), ports)];
    let mut open = OpenPorts::open(channel, &ports, reach(args.open), known).await?;
    text::print(&open.greeting())?;
    tokio::select! {
        gone = open.gone() => gone?,
        () = stop.wait() => tell!("closing"),
    }
    text::print(&open.close().await)
}

/// Ports by the names of their robots.
pub(crate) type PortsByRobot = BTreeMap<String, Vec<(Option<String>, Endpoint)>>;

/// The ports that are to be opened at each of these robots.
pub(crate) fn by_robot(ports: &[PortAddress], robots: &[String], open: bool) -> anyhow::Result<PortsByRobot> {
    let mut by_robot = PortsByRobot::new();
    for PortAddress { robot, device, endpoint: place } in ports {
        is_allowed(place, open)?;
        let robot = match (robot, robots) {
            (Some(robot), _) if robots.contains(robot) => robot,
            (None, [only]) => only,
            (Some(robot), _) => {
                let there_are = robots.join(", ");
                return Err(Refused::error(format!(
                    "{place}: there is no robot `{robot}`; there are: {there_are}"
                )));
            }
            (None, _) => {
                let there_are = robots.join(", ");
                return Err(Refused::error(format!(
                    "{place}: name its robot, as in ROBOT={place}; there are: {there_are}"
                )));
            }
        };
        by_robot.entry(robot.clone()).or_default().push((device.clone(), place.clone()));
    }
    Ok(by_robot)
}

/// These ports, and those of a scenario. Ports that are given for a cable take the place of all that the scenario has
/// there.
pub(crate) fn with_those_of_scenario(
    given: &PortsByRobot,
    scenario: &[SerialPort],
) -> anyhow::Result<PortsByRobot> {
    let mut all = given.clone();
    for SerialPort { robot, sensor, endpoint } in scenario {
        let is_its_cable = |(device, _): &(Option<String>, Endpoint)| device == sensor;
        if given.get(robot).is_some_and(|ports| ports.iter().any(is_its_cable)) {
            continue;
        }
        is_allowed(endpoint, false)?;
        all.entry(robot.clone()).or_default().push((sensor.clone(), endpoint.clone()));
    }
    Ok(all)
}

/// The users whose programs may open ports.
pub(crate) fn reach(open: bool) -> Reach {
    if open { Reach::Anyone } else { Reach::OwnUser }
}

fn is_allowed(place: &Endpoint, open: bool) -> anyhow::Result<()> {
    if place.is_local() || open {
        return Ok(());
    }
    Err(Refused::error(PortError::NotLocal { place: place.clone() }.to_string()))
}

/// A robot, and what its ports have done.
type Done = (String, Result<Vec<(String, Report)>, PortError>);

/// Ports that are open.
pub(crate) struct OpenPorts {
    tasks: JoinSet<Done>,
    stop: watch::Sender<bool>,
    greeting: String,
}

impl OpenPorts {
    /// Opens the ports of robots of these worlds. The names of a world, a robot and a device give the protocol of a
    /// port, for the note that no driver will understand it.
    pub(crate) async fn open(
        channel: Channel,
        worlds: &[(String, PortsByRobot)],
        reach: Reach,
        known: impl Fn(&str, &str, Option<&str>) -> Known,
    ) -> anyhow::Result<Self> {
        let (stop, _) = watch::channel(false);
        let mut open = Self { tasks: JoinSet::new(), stop, greeting: String::new() };
        let robots = worlds.iter().flat_map(|(world, ports)| ports.iter().map(move |robot| (world, robot)));
        for (world, (robot, ports)) in robots {
            let opened = RobotPorts::open(channel.clone(), world, robot, ports, reach).await.map_err(refused);
            let opened = opened.with_context(|| format!("the serial ports of {robot}"))?;
            open.greet(ports, &opened);
            let devices: BTreeSet<_> = ports.iter().map(|(device, _)| device.as_deref()).collect();
            for device in devices {
                spoken::note(opened.description(), device, known(world, robot, device))
                    .iter()
                    .for_each(|note| tell!("note: {note}"));
            }
            let mut stopped = open.stop.subscribe();
            let robot = robot.clone();
            open.tasks.spawn(async move {
                let stop = async move { drop(stopped.wait_for(|stop| *stop).await) };
                let name = robot.clone();
                (robot, opened.serve(stop, |news| tell_news(&name, &news)).await)
            });
        }
        Ok(open)
    }

    fn greet(&mut self, ports: &[(Option<String>, Endpoint)], opened: &RobotPorts) {
        for ((device, _), place) in ports.iter().zip(opened.places()) {
            let of = device.as_ref().map_or_else(String::new, |device| format!("/{device}"));
            self.greeting += &format!("serial port of {}{of}: {place}\n", opened.robot());
        }
        if opened.step_ns() > LONG_STEP_NS {
            let step_ms = opened.step_ns() as f64 * 1e-6;
            tell!(
                "note: bytes that a program writes enter the cable at the end of a tick, up to {step_ms} ms later; use --set step_ms=1 for programs that ask and wait"
            );
        }
    }

    /// The line that lists the ports' places.
    pub(crate) fn greeting(&self) -> String {
        self.greeting.clone()
    }

    /// Waits until the server ends a robot's stream.
    ///
    /// # Errors
    /// Why it did.
    pub(crate) async fn gone(&mut self) -> anyhow::Result<()> {
        match self.tasks.join_next().await {
            Some(Ok((robot, Err(error)))) => {
                Err(refused(error).context(format!("the ports of {robot} are closed")))
            }
            Some(Ok((robot, Ok(_)))) => anyhow::bail!("the server has released {robot}"),
            Some(Err(error)) => Err(error.into()),
            None => std::future::pending().await,
        }
    }

    /// Closes the ports. Gives what each has done, for people.
    pub(crate) async fn close(mut self) -> String {
        // The receiver may be gone.
        let _ = self.stop.send(true);
        let mut text = String::new();
        while let Some(Ok((robot, reports))) = self.tasks.join_next().await {
            for (place, report) in reports.unwrap_or_default() {
                text += &format!("port {place} of {robot}: {report}\n");
            }
        }
        text
    }
}

fn tell_news(robot: &str, news: &News) {
    match news {
        News::Opened(place) => tell!("a program has opened {place} of {robot}"),
        News::Closed(place) => tell!("the program has closed {place} of {robot}"),
        News::Refused(place) => {
            tell!(
                "a program that has opened {place} of {robot} was disconnected: another port of that cable is in use"
            );
        }
        News::Ended => tell!("the run of {robot} is over; commands from programs have no effect"),
    }
}

fn refused(error: PortError) -> anyhow::Error {
    match error {
        PortError::Server(status) => from_server(&status),
        PortError::InTheWay { .. } | PortError::NotLocal { .. } | PortError::NoDevice { .. } => {
            Refused::error(error.to_string())
        }
        PortError::Open { .. } | PortError::Contract(_) | PortError::NoClock => error.into(),
    }
}
