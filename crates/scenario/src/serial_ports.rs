//! The serial ports that a robot's table asks for: where programs find the laptop's ends of its cables.
//!
//! They are no part of a cable, which is the same for each robot of a table, and on which the run depends.

use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;

use baudbot_fields::endpoint::Endpoint;
use baudbot_fields::{FieldError, Path};
use baudbot_sim::scenario::SerialPort;
use toml::Value;

use super::{raw, starts};

type Result<T> = core::result::Result<T, FieldError>;

/// Most ports of one cable.
const MOST: usize = 8;

/// The serial ports of a table whose first robot has this name. One that stands for several has none.
pub(super) fn of(path: &Path, raw: &raw::Robot, robot: &str) -> Result<Vec<SerialPort>> {
    let own = raw.link.serial_port.iter().map(|value| (path.field("link"), None, value));
    let at = path.field("sensors");
    let of_sensors = raw.sensors.0.iter().filter_map(|(name, table)| {
        let value = table.get("port")?.get("link")?.get("serial_port")?;
        Some((at.field(name).field("port").field("link"), Some(name), value))
    });
    let mut ports = Vec::new();
    for (link, sensor, value) in own.chain(of_sensors) {
        let path = link.field("serial_port");
        let endpoints = endpoints(&path, value)?;
        let robots = starts::number(raw);
        if robots > 1 && !endpoints.is_empty() {
            let problem = format!(
                "is for one robot, and this table describes {robots}; leave it out, and use `serve --port ROBOT=…`"
            );
            return Err(path.error(problem));
        }
        let port = |endpoint| SerialPort { robot: robot.to_string(), sensor: sensor.cloned(), endpoint };
        ports.extend(endpoints.into_iter().map(port));
    }
    Ok(ports)
}

/// One, or a list of them.
fn endpoints(path: &Path, value: &Value) -> Result<Vec<Endpoint>> {
    let Value::Array(values) = value else { return Ok(alloc::vec![endpoint(path, value)?]) };
    if values.len() > MOST {
        return Err(path.error(format!("there are {}, the limit is {MOST}", values.len())));
    }
    values.iter().enumerate().map(|(i, value)| endpoint(&path.index(i), value)).collect()
}

fn endpoint(path: &Path, value: &Value) -> Result<Endpoint> {
    let Value::String(text) = value else {
        return Err(path.error("must be a text such as \"pty:khepera.tty\", or a list of such texts"));
    };
    text.parse().map_err(|error| path.error(format!("{error}")))
}
