//! A program that drives a robot through serial ports in simulated time, as a command line or a file names it.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use baudbot_sim::cable::Cable;
use baudbot_sim::model::RobotSpec;

use crate::programs::program::{self, BadProgram};
use crate::programs::task::Output;

/// The prefix of such a program's words in the place of a brain's name.
pub const PROGRAM: &str = "program:";

/// An unmodified program that opens serial ports of a robot, and runs in simulated time.
#[derive(Clone, Debug, PartialEq)]
pub struct PortProgram {
    /// The text of the program, without `program:`.
    text: String,
    /// The program and its arguments, in which `{NAME}` stands for a parameter.
    words: Vec<String>,
    /// The folder that it is started in; `None`: the current one.
    pub(crate) folder: Option<PathBuf>,
    /// The paths of ports with the cables that they are, by their names, as far as they are given.
    ports: Vec<(String, String)>,
    /// The price of each call that does not wait, in nanoseconds; `None`: only those are charged that are made over and over.
    price_ns: Option<u64>,
}

/// A program of this kind for a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct PortTask {
    /// The program.
    pub program: PortProgram,
    /// The robot's name.
    pub robot: String,
    /// The program's parameters by name, for `{NAME}` among its words.
    pub parameters: BTreeMap<String, String>,
    /// The destination of its output.
    pub output: Output,
}

/// A port that cannot be given to a program.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BadPort {
    /// There is no cable of this name.
    #[error("robot `{robot}` has no cable `{cable}` for {path}; its cables are: {there_are}")]
    Cable {
        /// The robot's name.
        robot: String,
        /// The path of the port.
        path: String,
        /// The name that was given.
        cable: String,
        /// The names that there are.
        there_are: String,
    },
    /// There is no such robot.
    #[error("there is no robot `{0}`")]
    Robot(String),
    /// The robot's brain is on board.
    #[error("robot `{0}` has no serial cable: its brain is on board (link.kind = \"onboard\")")]
    None(String),
}

impl PortProgram {
    /// Reads a program and its arguments as [`Program::parse`](crate::programs::Program::parse). Words in front of the program say how it
    /// is run: `/dev/NAME=CABLE` is a port, and `price=5us` is the price of a call.
    ///
    /// # Errors
    /// If there is no program, a quote is not closed, or a word in front of it says nothing that is known.
    pub fn parse(text: &str) -> Result<Self, BadProgram> {
        let mut words = shlex::split(text).ok_or_else(|| BadProgram::Quotes(format!("{PROGRAM}{text}")))?;
        let settings = words.iter().position(|word| !word.contains('=')).unwrap_or(words.len());
        let mut program = Self {
            text: text.trim().to_owned(),
            words: words.split_off(settings),
            folder: None,
            ports: Vec::new(),
            price_ns: None,
        };
        for word in words {
            let (name, value) = word.split_once('=').unwrap_or((&word, ""));
            match name {
                "price" => {
                    program.price_ns =
                        Some(nanoseconds(value).ok_or_else(|| BadProgram::Price(word.clone()))?);
                }
                path if path.starts_with("/dev/") && !value.is_empty() && !program.has_port(path) => {
                    program.ports.push((path.to_owned(), value.to_owned()));
                }
                _ => return Err(BadProgram::Setting(word)),
            }
        }
        if program.words.first().is_none_or(String::is_empty) {
            return Err(BadProgram::NoPortProgram);
        }
        Ok(program)
    }

    fn has_port(&self, path: &str) -> bool {
        self.ports.iter().any(|(other, _)| other == path)
    }

    /// The program that the text of a brain names, if it names one: `program:python3 driver.py`.
    ///
    /// # Errors
    /// As [`parse`](Self::parse).
    pub fn of_brain(brain: &str) -> Option<Result<Self, BadProgram>> {
        Some(Self::parse(brain.strip_prefix(PROGRAM)?))
    }

    /// The same, started in a folder, from which its relative paths go.
    #[must_use]
    pub fn in_folder(self, folder: PathBuf) -> Self {
        Self { folder: Some(folder).filter(|folder| !folder.as_os_str().is_empty()), ..self }
    }

    /// The files that its words name, as [`Program::files`](crate::programs::Program::files).
    pub fn files(&self) -> Vec<PathBuf> {
        program::files(&self.words, self.folder.as_deref())
    }

    /// The price of each call that does not wait, in nanoseconds, if there is one.
    pub fn price_ns(&self) -> Option<u64> {
        self.price_ns
    }

    /// Whether `{NAME}` is among its words.
    pub fn takes(&self, name: &str) -> bool {
        let place = format!("{{{name}}}");
        self.words.iter().any(|word| word.contains(&place))
    }

    /// The paths of its ports with the cables of a robot. Without any that are given, the robot's cable is `/dev/ttyUSB0`, and those
    /// of sensors' own follow in the order of the data sheet.
    ///
    /// # Errors
    /// If the robot has no such cable, or none at all.
    pub fn cables(&self, spec: &RobotSpec) -> Result<Vec<(String, Cable)>, BadPort> {
        let all: Vec<_> = Cable::all(spec).map(|cable| (name_of(spec, cable), cable)).collect();
        if all.is_empty() {
            return Err(BadPort::None(spec.name.clone()));
        }
        if self.ports.is_empty() {
            let numbered = all.into_iter().enumerate();
            return Ok(numbered.map(|(i, (_, cable))| (format!("/dev/ttyUSB{i}"), cable)).collect());
        }
        let cable_of = |(path, name): &(String, String)| {
            let found = all.iter().find(|(other, _)| other == name);
            found.map(|(_, cable)| (path.clone(), *cable)).ok_or_else(|| BadPort::Cable {
                robot: spec.name.clone(),
                path: path.clone(),
                cable: name.clone(),
                there_are: all.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
            })
        };
        self.ports.iter().map(cable_of).collect()
    }
}

impl PortTask {
    /// A program for this robot, without parameters, whose output is only kept.
    pub fn new(program: PortProgram, robot: String) -> Self {
        Self { program, robot, parameters: BTreeMap::new(), output: Output::Kept }
    }

    /// The words of the program, in which the places of parameters are filled, also those of the run: the seed, the robot's name, and the
    /// baud rate of its cable. Other braces stay.
    pub(crate) fn words(&self, spec: &RobotSpec, seed: u64) -> Vec<String> {
        let baud = spec.link.baud().map(|baud| baud.to_string()).unwrap_or_default();
        let of_run = [("seed", seed.to_string()), ("robot", self.robot.clone()), ("baud", baud)];
        let own = self.parameters.iter().map(|(name, value)| (name.as_str(), value.clone()));
        let all: Vec<_> = own.chain(of_run).collect();
        let fill = |word: &String| {
            all.iter().fold(word.clone(), |word, (name, value)| word.replace(&format!("{{{name}}}"), value))
        };
        self.program.words.iter().map(fill).collect()
    }
}

/// The name by which a port is given a cable.
fn name_of(spec: &RobotSpec, cable: Cable) -> String {
    match cable {
        Cable::Robot => "robot".to_owned(),
        Cable::Sensor(i) => spec.sensors[i].name.clone(),
    }
}

/// A duration of ns, us or ms, of at least a nanosecond and at most a second.
fn nanoseconds(text: &str) -> Option<u64> {
    let units = [("ns", 1.0), ("us", 1e3), ("µs", 1e3), ("ms", 1e6)];
    let (number, factor) =
        units.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    let ns = (number.parse::<f64>().ok()? * factor).round();
    (1.0..=1e9).contains(&ns).then_some(ns as u64)
}

impl fmt::Display for PortProgram {
    /// The text of the program without `program:`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(toml: &str) -> RobotSpec {
        let body = "body = { radius_m = 0.1, mass_kg = 1.0, inertia_kg_m2 = 0.1, wheel_radius_m = 0.1 }";
        let toml = format!("[[robots]]\nname = \"r\"\n{body}\n{toml}");
        baudbot_scenario::parse(&toml).unwrap().robots[0].clone()
    }

    const UART: &str = "link = { kind = \"uart\", baud = 9600 }";

    #[test]
    fn words_before_the_program_say_how_it_is_run() {
        let program =
            PortProgram::parse("price=5us /dev/ttyACM0=robot python3 'a b.py' --baud={baud} x=1").unwrap();
        assert_eq!(program.price_ns(), Some(5000));
        assert_eq!(program.cables(&robot(UART)), Ok(vec![("/dev/ttyACM0".to_owned(), Cable::Robot)]));
        let task = PortTask::new(program, "r".to_owned());
        assert_eq!(task.words(&robot(UART), 7), ["python3", "a b.py", "--baud=9600", "x=1"]);
        assert!(task.program.takes("baud") && !task.program.takes("gain"));
    }

    #[test]
    fn what_says_nothing_is_refused() {
        for (text, words) in [
            ("", "names no program"),
            ("price=5us", "names no program"),
            ("price=5 a", "`price=5`"),
            ("price=0ns a", "`price=0ns`"),
            ("ports=3 a", "`ports=3`"),
            ("/dev/a=robot /dev/a=robot a", "`/dev/a=robot`"),
            ("a 'b", "a quote is not closed"),
        ] {
            let error = PortProgram::parse(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }

    #[test]
    fn ports_are_numbered_unless_they_are_named_and_missing_ones_are_told() {
        let usual = PortProgram::parse("a").unwrap();
        assert_eq!(usual.cables(&robot(UART)), Ok(vec![("/dev/ttyUSB0".to_owned(), Cable::Robot)]));
        let named = PortProgram::parse("/dev/ttyS0=urg a").unwrap();
        let error = named.cables(&robot(UART)).unwrap_err().to_string();
        assert_eq!(error, "robot `r` has no cable `urg` for /dev/ttyS0; its cables are: robot");
        let error = usual.cables(&robot("link = { kind = \"onboard\" }")).unwrap_err().to_string();
        assert!(error.contains("is on board"), "{error}");
    }
}
