//! `explore` in narrow arenas (`baudbot_tests::narrow`), by both methods, for bodies of 0.1 to 0.6 m and passages of 1.4 to 3 times
//! their width: the whole table.
//!
//! ```sh
//! cargo run --release -p baudbot-tests --example explore_narrow -- target/narrow.tsv [--seeds 1..3] [WORDS …]
//! ```
//!
//! The first argument is the journal, a line for each run as it ends; a second start goes on where the first was stopped. Of the
//! runs whose names have all of the words, such as `zigzag/0.4/`, those are run that the journal lacks. The last line says how many of
//! all in the journal are as they should be.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::ops::RangeInclusive;

use baudbot_tests::narrow::{Case, Shape};

const BODIES_M: [f64; 4] = [0.1, 0.2, 0.4, 0.6];
const TIMES: [f64; 4] = [1.4, 1.7, 2.2, 3.0];
/// The longest run, in seconds.
const MOST_S: f64 = 1800.0;

fn main() {
    let mut arguments = std::env::args().skip(1).peekable();
    let Some(journal) = arguments.next() else {
        eprintln!("usage: explore_narrow JOURNAL [--seeds 1..3] [WORDS …]");
        std::process::exit(2);
    };
    let mut seeds = 1..=1;
    if arguments.next_if(|argument| argument == "--seeds").is_some() {
        seeds = arguments.next().and_then(|text| range(&text)).unwrap_or_else(|| {
            eprintln!("--seeds: must be FIRST..LAST");
            std::process::exit(2);
        });
    }
    let words: Vec<_> = arguments.collect();
    let known = fs::read_to_string(&journal).unwrap_or_default();
    let mut file = OpenOptions::new().create(true).append(true).open(&journal).expect("the journal");
    let is_known = |name: &str| known.lines().any(|line| line.split('\t').next() == Some(name));
    let is_wanted = |case: &Case| {
        let name = case.name();
        words.iter().all(|word| name.contains(word.as_str())) && !is_known(&name)
    };
    for case in cases(&seeds).into_iter().filter(is_wanted) {
        let run = case.run(MOST_S);
        let line = format!(
            "{}\t{}\t{:.4}\t{}\t{:.0}\t{:.0}\t{:.0}\t{:.1}\t{}",
            case.name(),
            run.problem().unwrap_or("good"),
            run.share,
            run.collisions,
            run.seconds,
            run.stale_s,
            run.untold_s,
            run.distance_m,
            run.said
        );
        println!("{line}");
        writeln!(file, "{line}").expect("the journal takes a line");
    }
    let all = fs::read_to_string(&journal).expect("the journal");
    let good = all.lines().filter(|line| line.split('\t').nth(1) == Some("good")).count();
    println!("{good} of {} are good", all.lines().count());
}

fn range(text: &str) -> Option<RangeInclusive<u64>> {
    let (first, last) = text.split_once("..")?;
    Some(first.parse().ok()?..=last.parse().ok()?)
}

/// All of the table.
fn cases(seeds: &RangeInclusive<u64>) -> Vec<Case> {
    let mut cases = vec![];
    for seed in seeds.clone() {
        for shape in Shape::ALL {
            for body_m in BODIES_M {
                for times in TIMES {
                    for by_frontiers in [false, true] {
                        cases.push(Case { shape, body_m, times, seed, by_frontiers });
                    }
                }
            }
        }
    }
    cases
}
