//! Checks whether a brain can have the robots that it asks for.

use baudbot_sim::Scenario;
use baudbot_sim::link::Link;
use baudbot_sim::model::RobotSpec;
use tonic::Status;

use super::Sessions;
use crate::message::Attach;
use crate::quote::{brief, list};

impl Sessions {
    /// The indices of the robots that a brain asks for.
    ///
    /// # Errors
    /// Why it cannot have one of them, with the field of the Hello.
    pub(super) fn choose(
        &self,
        world: &str,
        scenario: &Scenario,
        request: &Attach,
    ) -> Result<Vec<usize>, Status> {
        let mut robots = Vec::new();
        for (i, name) in request.robots.iter().enumerate() {
            let Some(robot) = scenario.robots.iter().position(|spec| spec.name == *name) else {
                let names = list(scenario.robots.iter().map(|spec| spec.name.as_str()));
                let name = brief(name);
                return Err(Status::not_found(format!(
                    "hello.robots[{i}]: there is no robot `{name}` in world `{world}`; there are: {names}"
                )));
            };
            if robots.contains(&robot) {
                return Err(Status::invalid_argument(format!("hello.robots[{i}]: `{name}` is named twice")));
            }
            if let Some(session) = self.slots[robot].session() {
                return Err(Status::already_exists(format!(
                    "hello.robots[{i}]: robot `{name}` of world `{world}` is held by brain `{}`",
                    self.name(session)
                )));
            }
            check_brain(&scenario.robots[robot], request)?;
            robots.push(robot);
        }
        Ok(robots)
    }
}

/// Checks that a robot can have such a brain.
fn check_brain(spec: &RobotSpec, request: &Attach) -> Result<(), Status> {
    if request.mode.is_raw() && spec.hands_over() {
        return Err(Status::invalid_argument(format!(
            "hello.mode: the brain of robot `{}` is on board: it reads its sensors itself, and there is no cable with \
             bytes; use PORT_MODE_MESSAGES",
            spec.name
        )));
    }
    check_memory(spec, request.memory_bytes)
}

/// Checks that a brain's variables fit into the robot that its program is to run on.
fn check_memory(spec: &RobotSpec, bytes: Option<u64>) -> Result<(), Status> {
    let Some(bytes) = bytes else { return Ok(()) };
    let name = &spec.name;
    if !matches!(spec.link, Link::Onboard) {
        return Err(Status::invalid_argument(format!(
            "hello.memory_bytes: robot `{name}` is not onboard; its brain runs on a laptop, whose memory is not limited"
        )));
    }
    match spec.processor.ram_bytes {
        Some(ram) if bytes > ram => Err(Status::resource_exhausted(format!(
            "hello.memory_bytes: the brain needs {bytes} bytes, but the microcontroller of robot `{name}` has {ram}"
        ))),
        Some(_) | None => Ok(()),
    }
}
