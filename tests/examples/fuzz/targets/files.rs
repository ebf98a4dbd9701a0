//! Files that people write: scenarios, what scenarios take in, and logs.

use std::path::{Path, PathBuf};
use std::{fs, process};

use anyhow::Context;

use super::{Target, outcome};

pub(super) fn targets() -> anyhow::Result<Vec<Target>> {
    let folder = std::env::temp_dir().join(format!("baudbot-fuzz-{}", process::id()));
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    // An altered picture has a sound description, and an altered description a sound picture.
    fs::write(folder.join("sound.yaml"), YAML.replace("map.pgm", "picture.pgm"))?;
    fs::write(folder.join("map.pgm"), PICTURE)?;
    let mut targets = vec![Target {
        name: "scenarios",
        what: "scenario files",
        seeds: scenarios()?,
        words: WORDS,
        run: Box::new(scenario),
    }];
    targets.push(Target {
        name: "logs",
        what: "logs of real robots",
        seeds: LOGS.map(|log| log.as_bytes().to_vec()).to_vec(),
        words: LOG_WORDS,
        run: Box::new(log),
    });
    targets.extend(IMPORTS.map(|import| import.target(&folder)));
    Ok(targets)
}

/// The scenarios of the project that are not long.
fn scenarios() -> anyhow::Result<Vec<Vec<u8>>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../catalogue/scenarios");
    let mut paths: Vec<PathBuf> = Vec::new();
    for folder in [root.clone(), root.join("devices")] {
        for entry in fs::read_dir(&folder).with_context(|| format!("cannot read {}", folder.display()))? {
            paths.push(entry?.path());
        }
    }
    paths.retain(|path| path.extension().is_some_and(|end| end == "toml"));
    paths.sort();
    let texts: Vec<_> = paths.iter().map(fs::read).collect::<Result<_, _>>()?;
    Ok(texts.into_iter().filter(|text| text.len() < 8_000).collect())
}

fn scenario(bytes: &[u8]) -> u64 {
    let text = String::from_utf8_lossy(bytes);
    match baudbot_scenario::parse(&text) {
        Ok(scenario) => scenario.robots.len().min(5) as u64,
        Err(error) => outcome(&error.to_string()),
    }
}

/// Reads a log.
fn log(bytes: &[u8]) -> u64 {
    let options = baudbot_fit::log::Options { readings: vec!["compass".into()], ..Default::default() };
    match baudbot_fit::log::read("log.csv", bytes, &options, &mut |_| ()) {
        Ok(log) => log.warnings.len().min(5) as u64 + 10 * log.columns.len().min(5) as u64,
        Err(error) => outcome(&error.to_string()),
    }
}

const LOGS: [&str; 3] = [
    "# experiment: echo\n# baud: 115200\nsent_us,received_us\n1,900\n1000,1900\n",
    "\u{feff}time_s;robot;x_m;compass\r\n0;a;1;2\r\n0.1;a;\"1.5\";\r\n9;a;2;3\r\n",
    "distance_mm\tvalue_raw\tsensor\n10\t1000\tir_0\n20\t300\tir_1\n",
];

/// The words of logs.
const LOG_WORDS: &[&[u8]] = &[
    b"time_s",
    b"t_ms",
    b"heading_deg",
    b"speed_m_s",
    b"nan",
    b"inf",
    b"1e999",
    b",",
    b";",
    b"\"",
    b"\n",
    b"#",
    b": ",
];

/// A file that a scenario takes in.
struct Import {
    name: &'static str,
    what: &'static str,
    file: &'static str,
    /// A sound one.
    seed: &'static [u8],
    words: &'static [&'static [u8]],
    scenario: &'static str,
}

impl Import {
    fn target(self, folder: &Path) -> Target {
        let Self { name, what, seed, words, scenario, .. } = self;
        let (folder, file) = (folder.to_owned(), folder.join(self.file));
        let run = move |bytes: &[u8]| {
            if fs::write(&file, bytes).is_err() {
                return 0;
            }
            match baudbot_import::inline(scenario, &folder) {
                Ok(text) => outcome("taken in") + (text.len() / 1_000) as u64,
                Err(error) => outcome(&error.to_string()),
            }
        };
        Target { name, what, seeds: vec![seed.to_vec()], words, run: Box::new(run) }
    }
}

const IMPORTS: [Import; 4] = [
    Import {
        name: "maps",
        what: "descriptions of ROS maps",
        file: "map.yaml",
        seed: YAML.as_bytes(),
        words: WORDS,
        scenario: "[[arena.maps]]\nname = \"m\"\nros = \"map.yaml\"\n",
    },
    Import {
        name: "pictures",
        what: "pictures of ROS maps",
        file: "picture.pgm",
        seed: PICTURE,
        words: WORDS,
        scenario: "[[arena.maps]]\nname = \"m\"\nros = \"sound.yaml\"\n",
    },
    Import {
        name: "plans",
        what: "floor plans in SVG",
        file: "p.svg",
        seed: PLAN,
        words: SVG_WORDS,
        scenario: "[[arena.maps]]\nname = \"p\"\nsvg = \"p.svg\"\nm_per_unit = 1\n",
    },
    Import {
        name: "measured",
        what: "measurements of sensors",
        file: "s.csv",
        seed: TABLE,
        words: WORDS,
        scenario: "[[robots]]\nname = \"r\"\n[robots.sensors.front]\nkind = \"ir\"\nlookup = \"s.csv\"\n",
    },
];

const YAML: &str = "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n";

const PICTURE: &[u8] = b"P5\n4 4\n255\n\x00\xff\xff\x00\xff\xff\xff\xff\x00\x00\xff\xff\xff\xff\xff\x00";

const PLAN: &[u8] = b"<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 10 10\"><g transform=\"rotate(10)\">\
<rect x=\"1\" y=\"1\" width=\"8\" height=\"2\"/><path d=\"M0 0 L4 0 C5 5 6 6 0 4 Z\"/><circle cx=\"3\" cy=\"3\" r=\"1\"/>\
<polyline points=\"0,0 1,2 3,1\"/></g></svg>";

const TABLE: &[u8] = b"distance_m,reading\n0,3.1\n0.1,2.5\n0.4,1.2\n0.8,0.4\n";

const WORDS: &[&[u8]] = &[
    b"1e308",
    b"-1",
    b"nan",
    b"inf",
    b"-0.0",
    b"0",
    b"9223372036854775807",
    b"1e-320",
    b"\"\"",
    b"[]",
    b"{}",
    b"\n[[robots]]\n",
    b" = ",
    b"true",
    b"..",
    b"P2",
    b"65536",
    b"99999 99999",
];

const SVG_WORDS: &[&[u8]] = &[
    b"<g>",
    b"</g>",
    b"1e308",
    b"nan",
    b"<use href=\"#a\" id=\"a\"/>",
    b"A1 1 0 0 1 5 5",
    b"scale(1e300)",
    b"&lt;",
    b"%",
    b"em",
];
