//! The exported file beside the brain of this program, turn by turn.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use baudbot_brain::{Body, Brain, Reading, Turn};

use crate::catalogue;
use crate::chance::Chance;
use crate::description::Description;
use crate::registry::Registry;
use crate::test_body::body;

/// Reads turns from stdin, and writes the commands.
const PROGRAM: &str = r#"
#include BRAIN
#include <stdio.h>

int main(void) {
  static struct brain brain;
  static struct brain_readings readings;
  struct brain_command command;
  double values[BRAIN_VALUES], signals[2];
  int i;
  brain_init(&brain);
  while (fread(&readings.at_ns, 8, 1, stdin) == 1 && fread(values, sizeof values, 1, stdin) == 1
         && fread(readings.is_new, sizeof readings.is_new, 1, stdin) == 1) {
    for (i = 0; i < BRAIN_VALUES; i++) readings.values[i] = (brain_real)values[i];
    brain_turn(&brain, &readings, &command);
    signals[0] = command.left;
    signals[1] = command.right;
    fwrite(signals, sizeof signals, 1, stdout);
  }
  return 0;
}
"#;

/// A folder that is gone at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("baudbot-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("program.c"), PROGRAM).unwrap();
        Self(folder)
    }

    /// A compiler at work on this brain, with the program that it makes.
    fn compile(&self, name: &str, file: &str, options: &[&str]) -> (PathBuf, Child) {
        let (source, program) = (format!("{name}.c"), self.0.join(name));
        fs::write(self.0.join(&source), file).unwrap();
        let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off"];
        let mut compiler = Command::new("cc");
        compiler.current_dir(&self.0).args(strict).args(options).arg(format!("-DBRAIN=\"{source}\""));
        (program.clone(), compiler.arg("program.c").arg("-o").arg(program).arg("-lm").spawn().unwrap())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A robot whose cable is always free.
fn robot() -> Body {
    let sensors = [
        ("left", "ir", 0.6),
        ("front", "ir", 0.0),
        ("right", "ir", -0.6),
        ("sonar", "sonar", 0.3),
        ("other", "sonar", -0.4),
        ("laser", "laser", 0.0),
        ("nose", "field", 0.0),
    ];
    Body { baud: None, bits_per_character: None, ..body(&sensors) }
}

/// Turns with messages, at random times and with readings of random sensors.
fn turns(body: &Body, count: usize, chance: &mut Chance) -> Vec<Turn> {
    let shared = Arc::new(body.clone());
    let mut at_ns = 1_000_000_000;
    let mut readings: Vec<Option<Reading>> = vec![None; body.sensors.len()];
    let mut turn = |tick| {
        let pause_ms = 60.0 * chance.uniform();
        at_ns += (1e6 * if chance.happens(0.02) { 50.0 * pause_ms } else { pause_ms }) as u64;
        for (sensor, reading) in body.sensors.iter().zip(&mut readings) {
            if let Some(old) = reading {
                old.readable = false;
            }
            if chance.happens(0.7) {
                let beyond = chance.happens(0.1);
                let value = |_| if beyond { -1.0 } else { chance.uniform() };
                let values = (0..sensor.values()).map(value).collect();
                *reading = Some(Reading { values, sampled_at_ns: None, sequence: 0, readable: true });
            }
        }
        Turn { tick, at_ns, readings: readings.clone(), body: shared.clone(), has_message: true }
    };
    (0..count as u64).map(&mut turn).collect()
}

/// The signals of the program in these turns.
fn answers(program: &Path, turns: &[Turn]) -> Vec<[f64; 2]> {
    let mut bytes = Vec::new();
    for turn in turns {
        bytes.extend(turn.at_ns.to_ne_bytes());
        for (sensor, reading) in turn.body.sensors.iter().zip(&turn.readings) {
            let values =
                reading.as_ref().map_or_else(|| vec![0.0; sensor.values()], |reading| reading.values.clone());
            bytes.extend(values.iter().flat_map(|value| value.to_ne_bytes()));
        }
        let is_new = |reading: &Option<Reading>| reading.as_ref().is_some_and(|reading| reading.readable);
        bytes.extend(turn.readings.iter().map(|reading| u8::from(is_new(reading))));
    }
    let mut child =
        Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("a program");
    let mut stdin = child.stdin.take().unwrap();
    let writes = std::thread::spawn(move || stdin.write_all(&bytes).unwrap());
    let mut answers = Vec::new();
    child.stdout.take().unwrap().read_to_end(&mut answers).unwrap();
    writes.join().unwrap();
    assert!(child.wait().unwrap().success());
    let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().unwrap());
    answers.chunks(16).map(|pair| [number(&pair[..8]), number(&pair[8..])]).collect()
}

/// The signals of the brain in these turns.
fn decisions(brain: &mut dyn Brain, turns: &[Turn]) -> Vec<[f64; 2]> {
    let decide = |turn| {
        let signals = brain.step(turn).signals.expect("a command in each turn");
        [signals.left, signals.right]
    };
    turns.iter().map(decide).collect()
}

/// A description by chance, of all that can be exported.
struct Descriptions(Chance);

impl Descriptions {
    fn below(&mut self, count: usize) -> usize {
        (self.0.uniform() * count as f64) as usize
    }

    fn number(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.0.uniform()
    }

    fn one_of<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }

    fn network(&mut self, inputs: usize, answers: usize) -> Vec<Vec<Vec<f64>>> {
        let hidden = 1 + self.below(4);
        let mut layer = |count: usize, inputs: usize| -> Vec<Vec<f64>> {
            (0..count).map(|_| (0..=inputs).map(|_| self.number(-3.0, 3.0)).collect()).collect()
        };
        vec![layer(hidden, inputs), layer(answers, hidden)]
    }

    fn variable(&mut self, name: &str) -> String {
        let sources: Vec<_> = (0..=self.below(3))
            .map(|_| self.one_of(&["left", "front", "right", "sonar", "laser", "laser.1", "nose"]))
            .collect();
        let values: usize = sources.iter().map(|source| if *source == "laser" { 3 } else { 1 }).sum();
        let by = match self.below(4) {
            0 => "by = \"min\"".to_owned(),
            1 => "by = \"max\"".to_owned(),
            2 => {
                let weights: Vec<_> = (0..values).map(|_| self.number(-2.0, 2.0)).collect();
                format!("by = \"sum\"\nweights = {weights:?}")
            }
            _ => format!("by = \"network\"\nnetwork = {:?}", self.network(values, 1)),
        };
        let stale = if self.0.happens(0.4) { "stale_s = 0.1\n" } else { "" };
        format!("[state_variables.{name}]\nof = {sources:?}\n{by}\n{stale}")
    }

    fn internal(&mut self, name: &str) -> String {
        let [rate, release, during, gain] = [0.3, 1.0, 1.0, 3.0].map(|most| self.number(-most, most));
        let decay = if self.0.happens(0.5) { "decay_s = 0.7\n" } else { "" };
        let lethal = if self.0.happens(0.1) { "lethal_above = 0.99\n" } else { "" };
        format!(
            "[internal.{name}]\ninitial = 0.4\nrate_hz = {rate:?}\nrelease = {{ a = {release:?} }}\nduring = {{ m0 = {during:?} }}\n\
             gain = {{ a = {gain:?} }}\n{decay}{lethal}"
        )
    }

    fn motor(&mut self, name: &str) -> String {
        let [x, y, z] = [0; 3].map(|_| self.number(-0.9, 0.9));
        let kind = self.one_of(&super::motors::kinds());
        let parameters = match kind {
            "constant" => format!("left = {x:?}, right = {:?}", 2.0 * y),
            "fixed_action" => format!("motions = [[{x:?}, {y:?}, 0.2], [{y:?}, {z:?}, 0.07]]"),
            "follow_wall" => {
                let (sensor, side) = (self.one_of(&["left", "sonar"]), self.one_of(&["left", "right"]));
                format!("sensor = \"{sensor}\", side = \"{side}\", gain = {x:?}, forward = {y:?}")
            }
            "taxis" => format!("left = \"left\", right = \"right\", gain = {x:?}, forward = {y:?}"),
            "turn_away" => format!("turn = {x:?}"),
            "wander" => format!("forward = {x:?}, turn = {:?}, turn_probability = 0.2", 2.0 * y),
            _ => format!("turn_reading = {:?}, stale_s = 0.3", 0.6 + z / 4.0),
        };
        let utility = if self.0.happens(0.8) {
            let [bias, a, slope, tau] = [(-1.0, 1.0), (-3.0, 3.0), (0.2, 2.0), (0.02, 0.3)]
                .map(|(least, most)| self.number(least, most));
            format!(
                "utility = {{ bias = {bias:?}, weights = {{ a = {a:?} }}, slope = {slope:?}, tau_s = {tau:?} }}\n"
            )
        } else {
            String::new()
        };
        format!("[motor.{name}]\nkind = \"{kind}\"\nparameters = {{ {parameters} }}\n{utility}")
    }

    fn when(&mut self) -> String {
        let comparison = self.one_of(&["<", "<=", ">", ">="]);
        format!("a {comparison} {:?}", self.number(-0.2, 1.0))
    }

    fn node(&mut self, depth: usize) -> String {
        match self.below(if depth == 0 { 2 } else { 5 }) {
            0 => format!("\"m{}\"", self.below(3)),
            1 => format!("\"{}\"", self.when()),
            2 => format!("{{ invert = {} }}", self.node(depth - 1)),
            kind => {
                let parts: Vec<_> = (0..=self.below(3)).map(|_| self.node(depth - 1)).collect();
                let name = if kind == 3 { "select" } else { "sequence" };
                format!("{{ {name} = [{}] }}", parts.join(", "))
            }
        }
    }

    fn decision(&mut self, method: usize) -> String {
        let text = match method {
            0 => format!("method = \"utility\"\nchange_cost = {:?}", 0.1 * self.below(3) as f64),
            1 => {
                let way = |s: &mut Self| {
                    format!(
                        "{{ from = \"m{}\", to = \"m{}\", when = [\"{}\"] }}",
                        s.below(3),
                        s.below(3),
                        s.when()
                    )
                };
                let ways: Vec<_> = (0..6).map(|_| way(self)).collect();
                let any = format!("{{ to = \"m0\", when = [\"{}\", \"{}\"] }}", self.when(), self.when());
                format!("method = \"machine\"\nstart = \"m1\"\ntransitions = [{}, {any}]", ways.join(", "))
            }
            2 => {
                let layer = |s: &mut Self| {
                    format!(
                        "{{ behavior = \"m{}\", when = [\"{}\", \"{}\"] }}",
                        s.below(3),
                        s.when(),
                        s.when()
                    )
                };
                let layers: Vec<_> = (0..3).map(|_| layer(self)).collect();
                format!("method = \"layers\"\nbase = \"m0\"\nlayers = [{}]", layers.join(", "))
            }
            3 => format!(
                "method = \"tree\"\nstart = \"m2\"\nroot = {{ select = [{}, {}] }}",
                self.node(2),
                self.node(3)
            ),
            4 => {
                let fill = self.number(0.1, 1.0);
                format!(
                    "method = \"hydraulic\"\nbase = \"m0\"\nreservoirs = [{{ behavior = \"m1\", releaser = \"a\", fill_hz = {fill:?}, spring = 0.8 }}, \
                     {{ behavior = \"m2\", fill_hz = 0.3, spring = 0.5, outflow_hz = 7.0 }}]"
                )
            }
            _ => format!(
                "method = \"cooperative\"\nweights = {{ m0 = {:?}, m2 = 2.0 }}",
                self.number(0.0, 1.0)
            ),
        };
        format!("[decision]\n{text}\n")
    }

    /// A description with this method of decision, of six.
    fn next(&mut self, method: usize) -> String {
        let variables = ["a", "b"].map(|name| self.variable(name)).concat();
        let internal = if self.0.happens(0.5) { self.internal("h") } else { String::new() };
        let motors = ["m0", "m1", "m2"].map(|name| self.motor(name)).concat();
        format!("{variables}{internal}{motors}{}", self.decision(method))
    }

    fn policy(&mut self, with_ages: bool) -> String {
        let inputs = if with_ages { 9 + 2 * 7 } else { 9 };
        format!("[policy]\nages = {with_ages}\nlayers = {:?}\n", self.network(inputs, 2))
    }
}

/// A brain, its file and its robot.
struct Pair {
    name: String,
    brain: Box<dyn Brain + Send>,
    file: String,
    body: Body,
}

fn of_catalogue(description: &str, body: Body) -> Pair {
    let brain = catalogue::brain(description, 7, &body).unwrap();
    let file = catalogue::c_file(description, 7, &body).unwrap();
    Pair { name: description.replace(|c: char| !c.is_ascii_alphanumeric(), "_"), brain, file, body }
}

fn of_text(name: String, toml: &str, body: Body) -> Pair {
    let description = Description::parse(toml).unwrap_or_else(|error| panic!("{error}\n{toml}"));
    let brain = description.any_brain(7, &body, &Registry::standard());
    let brain = brain.unwrap_or_else(|error| panic!("{error}\n{toml}"));
    let file = description.c_file(7, &body).unwrap_or_else(|error| panic!("{error}\n{toml}"));
    Pair { name, brain, file, body }
}

/// The export of Section 3.1.
#[test]
fn an_exported_brain_decides_as_that_of_the_program_to_the_bit() {
    let eyes = |names: &[(&'static str, &'static str, f64)]| Body {
        baud: None,
        bits_per_character: None,
        ..body(names)
    };
    let mut pairs = vec![
        of_catalogue("avoid:stale_s=0.3", robot()),
        of_catalogue("wander:turn=1.5,turn_probability=0.1", robot()),
        of_catalogue("constant:left=0.3,right=-2", robot()),
        of_catalogue("goose", eyes(&[("eye", "ir", 0.0)])),
        of_catalogue("patient", eyes(&[("ir_front", "ir", 0.0)])),
    ];
    let mut descriptions = Descriptions(Chance::new(1, "descriptions"));
    for place in 0..18 {
        pairs.push(of_text(format!("random_{place}"), &descriptions.next(place % 6), robot()));
    }
    for with_ages in [false, true] {
        pairs.push(of_text(format!("policy_{with_ages}"), &descriptions.policy(with_ages), robot()));
    }
    let folder = Folder::new("export");
    let compile = |pair: &Pair| folder.compile(&pair.name, &pair.file, &[]);
    let compilers: Vec<_> = pairs.iter().map(compile).collect();
    let (mut compared, mut changes) = (0, 0);
    for (pair, (program, mut compiler)) in pairs.iter_mut().zip(compilers) {
        assert!(compiler.wait().unwrap().success(), "{}", pair.file);
        let turns = turns(&pair.body, 4_100, &mut Chance::new(2, &pair.name));
        let (expected, found) = (decisions(&mut *pair.brain, &turns), answers(&program, &turns));
        assert_eq!(found.len(), expected.len(), "{}", pair.name);
        for (turn, (expected, found)) in expected.iter().zip(&found).enumerate() {
            let [expected_bits, found_bits] = [expected, found].map(|signals| signals.map(f64::to_bits));
            assert_eq!(
                found_bits, expected_bits,
                "{} in turn {turn}: {found:?} is not {expected:?}",
                pair.name
            );
        }
        compared += turns.len();
        changes += found.windows(2).filter(|pair| pair[0] != pair[1]).count();
    }
    assert!(compared >= 100_000 && changes >= 20_000, "{compared} turns, {changes} changes");
}

#[test]
fn single_precision_answers_a_network_to_a_few_millionths() {
    let mut descriptions = Descriptions(Chance::new(3, "policies"));
    let mut pair = of_text("policy".to_owned(), &descriptions.policy(false), robot());
    let folder = Folder::new("export-single");
    // What an AVR does: its double has 32 bits.
    let options = ["-DBRAIN_SINGLE", "-fsingle-precision-constant"];
    let (program, mut compiler) = folder.compile(&pair.name, &pair.file, &options);
    assert!(compiler.wait().unwrap().success());
    let turns = turns(&pair.body, 10_000, &mut Chance::new(4, "turns"));
    let (expected, found) = (decisions(&mut *pair.brain, &turns), answers(&program, &turns));
    let off = |(expected, found): (&[f64; 2], &[f64; 2])| {
        (expected[0] - found[0]).abs().max((expected[1] - found[1]).abs())
    };
    let worst = expected.iter().zip(&found).map(off).fold(0.0, f64::max);
    assert!(worst > 0.0 && worst < MOST_OFF, "{worst}");
}

/// The error of a signal that a network of two layers, with weights of at most 3, answers in single precision.
const MOST_OFF: f64 = 5e-6;

#[test]
fn what_cannot_be_exported_is_named_by_its_path() {
    let problem = |toml: &str| Description::parse(toml).unwrap().c_file(1, &robot()).unwrap_err().to_string();
    let go = "[motor.go]\nkind = \"go_to\"\nparameters = { points_m = [[1.0, 0.0]] }";
    assert_eq!(
        problem(go),
        "motor.go.kind: `go_to` cannot be exported; these can: avoid, constant, fixed_action, follow_wall, taxis, turn_away, wander"
    );
    let odometry = "[motor.a]\nkind = \"constant\"\n[cognitive.where]\nkind = \"odometry\"";
    assert!(problem(odometry).starts_with("cognitive.where: cognitive processes cannot be exported"));
    // Errors of the description itself are those that it always has.
    assert!(problem("[motor.a]\nkind = \"turn\"").starts_with("motor.a.kind: `turn` cannot be exported"));
    let near = "[state_variables.near]\nof = [\"rear\"]\nby = \"max\"\n[motor.a]\nkind = \"constant\"";
    assert!(problem(near).starts_with("state_variables.near.of[0]: there is no sensor `rear`"));
}
