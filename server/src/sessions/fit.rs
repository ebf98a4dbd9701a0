//! Whether a brain fits its robot.

use baudbot_sim::link::Link;
use baudbot_sim::robot::RobotSpec;
use tonic::Status;

use crate::letter::Attach;

/// Whether a robot can have such a brain.
pub(super) fn check_brain(spec: &RobotSpec, request: &Attach) -> Result<(), Status> {
    if request.raw && spec.hands_over() {
        return Err(Status::invalid_argument(format!(
            "hello.mode: the brain of robot `{}` is on board: it reads its sensors itself, and there is no cable with \
             bytes; use PORT_MODE_MESSAGES",
            spec.name
        )));
    }
    check_memory(spec, request.memory_bytes)
}

/// Whether a brain's variables fit into the robot that its program is to run on.
fn check_memory(spec: &RobotSpec, bytes: Option<u64>) -> Result<(), Status> {
    let Some(bytes) = bytes else { return Ok(()) };
    let name = &spec.name;
    if !matches!(spec.link, Link::Onboard) {
        return Err(Status::invalid_argument(format!(
            "hello.memory_bytes: robot `{name}` is not onboard; its brain runs on a laptop, which has room"
        )));
    }
    match spec.processor.ram_bytes {
        Some(ram) if bytes > ram => Err(Status::resource_exhausted(format!(
            "hello.memory_bytes: the brain needs {bytes} bytes, but the microcontroller of robot `{name}` has {ram}"
        ))),
        Some(_) | None => Ok(()),
    }
}
