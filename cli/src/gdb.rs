//! The debuggers that `--gdb` lets in.

use std::io::ErrorKind;
use std::sync::Arc;

use anyhow::Context;
use baudbot_port::Reach;
use baudbot_port::debug::GdbServer;
use baudbot_sim::model::RobotSpec;
use baudbot_sim::{Scenario, World};

use crate::args::GdbAddress;
use crate::error::Refused;
use crate::natural;
use crate::signals::Stop;
use crate::text::tell;

/// The ports at which debuggers of chips connect.
pub(crate) struct Debuggers(Vec<(usize, Arc<GdbServer>)>);

impl Debuggers {
    /// Listens for debuggers of robots of a scenario. Worlds that wait for one go on without it if the program is to end.
    pub(crate) fn listen(
        addresses: &[GdbAddress],
        scenario: &Scenario,
        reach: Reach,
        stop: &Stop,
    ) -> anyhow::Result<Self> {
        let mut servers: Vec<(usize, Arc<GdbServer>)> = Vec::new();
        for address in addresses {
            let robot = robot(address, &scenario.robots)?;
            if servers.iter().any(|(other, _)| *other == robot) {
                let text = format!("--gdb {address}: robot `{}` has a debugger already", address.robot);
                return Err(Refused::error(text));
            }
            let server = GdbServer::listen(address.port, reach, stop.flag()).map_err(|error| {
                if error.kind() == ErrorKind::AddrInUse {
                    let text = "the port is in use; choose another, or 0 for any free one";
                    return Refused::error(format!("--gdb {address}: {text}"));
                }
                anyhow::Error::from(error).context(format!("--gdb {address}"))
            })?;
            servers.push((robot, Arc::new(server)));
        }
        Ok(Self(servers))
    }

    /// Puts the debuggers on the chips of a world, which then waits for them.
    pub(crate) fn put_on(&self, world: &mut World) {
        for (robot, server) in &self.0 {
            world.probe(*robot, Arc::clone(server) as _);
        }
    }

    /// Prints how to connect.
    pub(crate) fn tell(&self, scenario: &Scenario) {
        for (robot, server) in &self.0 {
            tell!(
                "robot `{}` waits at its reset for a debugger: avr-gdb program.elf -ex 'target remote {}'",
                scenario.robots[*robot].name,
                server.address()
            );
        }
    }
}

/// The place of the robot that is meant.
fn robot(address: &GdbAddress, robots: &[RobotSpec]) -> anyhow::Result<usize> {
    let name = &address.robot;
    let place = robots.iter().position(|spec| spec.name == *name).with_context(|| {
        let names: Vec<_> = natural::sorted(robots, |spec| &spec.name);
        format!(
            "--gdb {address}: there is no robot `{name}`; there are: {}",
            names.iter().map(|spec| &*spec.name).collect::<Vec<_>>().join(", ")
        )
    });
    let place = place.map_err(|error| Refused::error(error.to_string()))?;
    if robots[place].chip.is_none() {
        return Err(Refused::error(format!(
            "--gdb {address}: robot `{name}` has no program on its microcontroller; give it one with --firmware \
             {name}=FILE"
        )));
    }
    Ok(place)
}
