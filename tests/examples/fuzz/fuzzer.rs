//! The loop that tries a target.

use std::collections::HashSet;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use anyhow::Context;

use crate::alter::altered;
use crate::chance::Chance;
use crate::targets::Target;

/// The condition under which enough has been tried.
#[derive(Clone, Copy)]
pub(crate) enum Until {
    Time(Duration),
    /// A number of altered inputs.
    Executions(u64),
}

pub(crate) struct Fuzzer {
    target: Target,
    chance: Chance,
    folder: PathBuf,
    /// The inputs to alter.
    inputs: Vec<Vec<u8>>,
    /// The inputs that have been found in this run.
    new: Vec<Vec<u8>>,
    /// The outcomes of inputs so far.
    outcomes: HashSet<u64>,
    tried: u64,
    bytes: u64,
    began: Instant,
    failed: Option<Vec<u8>>,
    watch: Arc<Watch>,
}

/// The input that is being tried, and since when, for the thread that notices if it does not end.
#[derive(Default)]
struct Watch {
    input: Mutex<Vec<u8>>,
    /// The start of the present input by the wall clock, in milliseconds; 0 if there is none.
    since_ms: AtomicU64,
}

impl Fuzzer {
    pub(crate) fn new(target: Target, seed: u64) -> anyhow::Result<Self> {
        let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/fuzz/corpus").join(target.name);
        let mut files: Vec<_> = match fs::read_dir(&folder) {
            Ok(entries) => entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?,
            Err(_) => Vec::new(),
        };
        files.sort();
        let read = |file: PathBuf| fs::read(&file).with_context(|| format!("cannot read {}", file.display()));
        let mut inputs = files.into_iter().map(read).collect::<anyhow::Result<Vec<_>>>()?;
        inputs.extend(target.seeds.iter().cloned());
        let watch = Arc::new(Watch::default());
        guard(target.name, &watch, &folder);
        let (chance, outcomes) = (Chance(seed), HashSet::new());
        Ok(Self {
            target,
            chance,
            folder,
            inputs,
            new: Vec::new(),
            outcomes,
            tried: 0,
            bytes: 0,
            began: Instant::now(),
            failed: None,
            watch,
        })
    }

    /// Tries what there is, and then altered inputs.
    pub(crate) fn run(&mut self, until: Until) {
        let begun = Instant::now();
        for input in self.inputs.clone() {
            self.once(&input);
        }
        let mut altered_ones = 0;
        let goes_on = |tried: u64| match until {
            Until::Time(time) => begun.elapsed() < time,
            Until::Executions(wanted) => tried < wanted,
        };
        while goes_on(altered_ones) && self.failed.is_none() {
            altered_ones += 1;
            let [one, other] = [0; 2].map(|_| self.chance.below(self.inputs.len()));
            let input = altered(&self.inputs[one], &self.inputs[other], self.target.words, &mut self.chance);
            let known = self.outcomes.len();
            self.once(&input);
            if self.outcomes.len() > known && self.inputs.len() < MAX_INPUTS {
                self.new.push(input.clone());
                self.inputs.push(input);
            }
        }
    }

    /// Tries one input.
    pub(crate) fn once(&mut self, input: &[u8]) {
        if self.failed.is_some() {
            return;
        }
        self.tried += 1;
        self.bytes += input.len() as u64;
        self.watch.begin(input);
        let outcome = catch_unwind(AssertUnwindSafe(|| (self.target.run)(input)));
        self.watch.since_ms.store(0, Ordering::Relaxed);
        match outcome {
            Ok(outcome) => drop(self.outcomes.insert(outcome)),
            Err(_) => self.failed = Some(input.to_vec()),
        }
    }

    /// Prints the result, and the command that repeats a failure; returns whether there was one.
    pub(crate) fn report(self) -> anyhow::Result<bool> {
        let Self { target, folder, outcomes, tried, bytes, began, failed, .. } = self;
        let name = target.name;
        let Some(input) = failed else {
            let (outcomes, took_s) = (outcomes.len(), began.elapsed().as_secs_f64());
            println!(
                "{name:12} {tried:10} inputs, {bytes:13} bytes, {outcomes:5} outcomes, {took_s:6.0} s, no failure"
            );
            return Ok(false);
        };
        let file = folder.join(format!("failed-{:016x}", fingerprint(&input)));
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        fs::write(&file, &input).with_context(|| format!("cannot write {}", file.display()))?;
        println!("{name:12} FAILED at input {tried}, of {} bytes. To see it again:", input.len());
        println!("    cargo run -p baudbot-tests --example fuzz -- {name} --input {}", file.display());
        Ok(true)
    }
}

impl Fuzzer {
    /// Keeps the shortest input for each of some outcomes that nothing kept before leads to.
    pub(crate) fn keep(&mut self) -> anyhow::Result<()> {
        let (target, before) = (&mut self.target, self.inputs.len() - self.new.len());
        let known: HashSet<_> = self.inputs[..before].iter().map(|input| (target.run)(input)).collect();
        let mut kept: Vec<(u64, &Vec<u8>)> = Vec::new();
        self.new.sort_by_key(Vec::len);
        for input in self.new.iter().take_while(|input| input.len() <= LONGEST_KEPT) {
            let outcome = (target.run)(input);
            if kept.len() < MOST_KEPT
                && !known.contains(&outcome)
                && kept.iter().all(|(other, _)| *other != outcome)
            {
                kept.push((outcome, input));
            }
        }
        fs::create_dir_all(&self.folder).with_context(|| format!("cannot make {}", self.folder.display()))?;
        for (_, input) in kept {
            let file = self.folder.join(format!("{:016x}", fingerprint(input)));
            fs::write(&file, input).with_context(|| format!("cannot write {}", file.display()))?;
        }
        Ok(())
    }
}

impl Watch {
    fn begin(&self, input: &[u8]) {
        let mut kept = self.input.lock().unwrap_or_else(PoisonError::into_inner);
        kept.clear();
        kept.extend(input);
        self.since_ms.store(now_ms().max(1), Ordering::Relaxed);
    }
}

fn now_ms() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u64)
}

/// Ends the program if an input takes for ever, and keeps that.
fn guard(name: &'static str, watch: &Arc<Watch>, folder: &Path) {
    let (watch, folder) = (Arc::downgrade(watch), folder.to_owned());
    std::thread::spawn(move || {
        while let Some(watch) = watch.upgrade() {
            let since = watch.since_ms.load(Ordering::Relaxed);
            if since > 0 && now_ms().saturating_sub(since) > FOR_EVER_MS {
                let input = watch.input.lock().unwrap_or_else(PoisonError::into_inner).clone();
                let file = folder.join(format!("hangs-{:016x}", fingerprint(&input)));
                let _ = fs::create_dir_all(&folder).and_then(|()| fs::write(&file, &input));
                println!("{name:12} HANGS. To see it again:");
                println!(
                    "    cargo run -p baudbot-tests --example fuzz -- {name} --input {}",
                    file.display()
                );
                std::process::exit(1);
            }
            drop(watch);
            std::thread::sleep(Duration::from_millis(200));
        }
    });
}

fn fingerprint(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

/// Inputs of a target that one run adds to its folder, at most.
const MOST_KEPT: usize = 8;

/// The longest of them, in bytes. What needs more is found again soon.
const LONGEST_KEPT: usize = 2048;

/// Most inputs that are kept to be altered.
const MAX_INPUTS: usize = 2000;

/// An input that takes so long does not end: an ordinary one takes some milliseconds, on a busy machine a second.
const FOR_EVER_MS: u64 = 120_000;
