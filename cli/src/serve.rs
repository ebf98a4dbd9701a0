//! `baudbot serve`: worlds for brains in other processes.

use std::fmt::Write;
use std::time::Duration;

use anyhow::Context;
use baudbot_server::{Address, Server, WorldConfig};
use baudbot_sim::Scenario;

use crate::args::{DEFAULT_ADDRESS, ServeArgs};
use crate::crew;
use crate::error::from_builder;
use crate::run::overrides;
use crate::scenarios::{self, Source};
use crate::signals::Stop;
use crate::text;
use crate::viewer;

pub(crate) async fn serve(args: &ServeArgs) -> anyhow::Result<()> {
    let pace = args.pace.with(&args.watchdog)?;
    let overrides = overrides(&args.changes)?;
    let default = [scenarios::DEFAULT.to_owned()];
    let names = if args.scenarios.is_empty() { &default[..] } else { &args.scenarios };
    let mut builder = Server::builder().insecure(args.listen.insecure);
    let mut worlds = Vec::new();
    for name in names {
        let source = Source::find(name)?;
        let scenario = source.parse(&overrides)?;
        let world = source.world_name(&scenario);
        worlds.push((
            world.clone(),
            describe(&world, &scenario),
            scenario.robots().first().map(|spec| (spec.name.clone(), crew::fitting_brain(spec))),
        ));
        scenarios::warn(&scenario);
        builder = builder.world(WorldConfig::new(world, scenario).pace(pace).paused(args.paused));
    }
    let listening = addresses(args)?;
    for address in listening.clone() {
        builder = builder.listen(address);
    }
    // Who keeps a server to a socket's file wants nobody else to reach it.
    let open = listening.iter().any(|address| matches!(address, Address::Tcp(_)));
    builder = viewer::add(builder, args.listen.viewer, open);
    // Scenarios may have come through FIFOs; there a single signal is to end the program.
    let mut stop = Stop::listen().context("cannot listen for Ctrl-C")?;
    let server = builder.serve().await.map_err(from_builder)?;
    text::print(&greeting(&server, &worlds))?;
    stop.wait().await;
    eprintln!("stopping");
    tokio::select! {
        () = server.shutdown() => {}
        () = tokio::time::sleep(PATIENCE) => eprintln!("note: somebody kept a connection open; it was cut"),
    }
    Ok(())
}

fn addresses(args: &ServeArgs) -> anyhow::Result<Vec<Address>> {
    if args.listen.listen.is_empty() {
        return Ok(vec![DEFAULT_ADDRESS.parse()?]);
    }
    Ok(args.listen.listen.clone())
}

/// A world's name, what is in it, and a robot with a brain that can drive it.
type Described = (String, String, Option<(String, &'static str)>);

/// Programs read the lines `listening on ADDRESS`; they come first and stay as they are.
fn greeting(server: &Server, worlds: &[Described]) -> String {
    let mut text = String::new();
    for address in server.addresses() {
        let _ = writeln!(text, "listening on {address}");
    }
    for (_, description, _) in worlds {
        text += description;
    }
    if let Some(link) = viewer::link(server) {
        let _ = writeln!(text, "\n{link}");
    }
    let robot = worlds.iter().find_map(|(world, _, robot)| Some((world, robot.as_ref()?)));
    if let (Some(address), Some((world, (robot, brain)))) = (server.addresses().first(), robot) {
        let _ = writeln!(text, "\nIn a second terminal:");
        let _ = writeln!(text, "  baudbot brain {brain} --connect {address} --world {world} --robot {robot}");
        let _ = writeln!(text, "  baudbot watch --connect {address} --world {world}");
        let _ = writeln!(text, "Ctrl-C stops the server.");
    }
    text
}

fn describe(world: &str, scenario: &Scenario) -> String {
    let robots: Vec<_> = scenario.robots().iter().map(|spec| spec.name.as_str()).collect();
    let robots = match robots.as_slice() {
        [] => "no robots".to_owned(),
        [robot] => format!("robot {robot}"),
        many if many.len() <= 10 => format!("robots {}", many.join(", ")),
        many => format!("{} robots {} … {}", many.len(), many[0], many[many.len() - 1]),
    };
    format!("world {world}: {robots}\n")
}

/// How long connections have to close.
const PATIENCE: Duration = Duration::from_secs(3);
