//! The world's side of its journal: what happens to the world is collected here, and goes into the file before any
//! answer.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_recording::journal::{At, Entries, KeptRecording, PortState, Ports, Settings};
use baudbot_sim::{Scenario, World};

use super::files::WorldFiles;
use super::work::Work;
use crate::convert;
use crate::endpoint::Sender;
use crate::log::event;
use crate::message::RecordConfig;
use crate::pace::Pace;
use crate::pool::Waker;
use crate::report::Keeping;
use crate::sessions::Sessions;

/// The interval at which a world that does not wait for its brains writes; twice as often as promised, since it has
/// to be written yet.
const WRITE_EVERY: Duration = Duration::from_millis(400);

/// Bytes that are collected before that.
const MOST_COLLECTED: usize = 1 << 20;

/// The interval at which the fingerprint of the whole state is written, which a restart compares.
const HASH_EVERY: Duration = Duration::from_secs(1);

/// Ticks, and time of the wall clock, between two whole states: a restart does no more once again.
const STATE_EVERY_TICKS: u64 = 6000;
const STATE_EVERY: Duration = Duration::from_secs(10);

/// A journal that is longer, and has more than eight whole states' worth, is replaced by a new one.
const LONG: u64 = 4 << 20;

/// The time after a failure until another journal is attempted.
const RETRY_AFTER: Duration = Duration::from_secs(2);

/// A world at the moment, as far as it is kept.
pub(crate) struct Now<'a> {
    pub(crate) name: &'a str,
    pub(crate) world: &'a World,
    pub(crate) sessions: &'a Sessions,
    pub(crate) pace: Pace,
    pub(crate) paused: bool,
    /// The writing ends of ports, as they were when the tick began, if it has.
    pub(crate) senders: &'a [Sender],
    /// Robots whose brain a server has lost, and that has not come back yet.
    pub(crate) coming_back: &'a [bool],
    /// The recording.
    pub(crate) recording: Option<&'a RecordConfig>,
}

/// Keeps a world.
pub(crate) struct Keeper {
    files: Arc<WorldFiles>,
    /// The scenario with which the world was made.
    made: Arc<Scenario>,
    entries: Entries,
    /// The last settings that were written.
    settings: Settings,
    pace: Pace,
    senders: Vec<Sender>,
    at: (u64, bool),
    /// The instant at which things were written last.
    written: Instant,
    hashed: Instant,
    stated: (Instant, u64),
    /// Bytes of the present journal, and of its beginning.
    length: u64,
    beginning: u64,
    /// Bytes of it that are on the disk for good.
    on_disk: Arc<AtomicU64>,
    lost: Option<Lost>,
    /// Snapshots that are in the folder, by their numbers, in case that they have to be written again.
    snapshots: Vec<(u64, Vec<u8>)>,
}

/// The state of a world is not kept at the moment.
struct Lost {
    /// The instant at which another journal is attempted.
    retry: Instant,
    /// One is being written.
    is_trying: bool,
}

impl Keeper {
    /// Keeps a world from now on. `made`: the scenario with which it was made.
    pub(super) fn new(files: WorldFiles, made: Arc<Scenario>, now: &Now<'_>) -> Self {
        let instant = files.now();
        let mut keeper = Self {
            files: Arc::new(files),
            made,
            entries: Entries::default(),
            settings: Settings::default(),
            pace: now.pace,
            senders: Vec::new(),
            at: (0, false),
            written: instant,
            hashed: instant,
            stated: (instant, 0),
            length: 0,
            beginning: 0,
            on_disk: Arc::default(),
            lost: None,
            snapshots: Vec::new(),
        };
        keeper.begin(now);
        keeper
    }

    /// Whether nothing of the world is kept, and up to which tick it is.
    pub(crate) fn keeping(&self) -> Keeping {
        self.files.keeping()
    }

    /// Collects what entered the world.
    pub(crate) fn inputs(&mut self, inputs: &v1::RecordedInputs) {
        if self.lost.as_ref().is_none_or(|lost| lost.is_trying) {
            self.entries.inputs(inputs);
        }
    }

    /// Keeps the state at the start of a tick or before an answer: where the world waits for its brains, all until now
    /// goes into the journal; elsewhere if it is time for that.
    pub(crate) fn keep(&mut self, now: &Now<'_>) {
        let waits = waits(now.pace);
        if waits || self.entries.len() >= MOST_COLLECTED || self.since(self.written) >= WRITE_EVERY {
            self.keep_now(now);
        }
    }

    /// All until now goes into the journal, on the world's own thread if it waits for its brains.
    pub(crate) fn keep_now(&mut self, now: &Now<'_>) {
        if !self.look_for_failure(now) {
            return;
        }
        let at = (now.world.tick(), now.world.is_begun());
        if at != self.at && self.needs_state(now) {
            if self.length > LONG.max(8 * self.beginning) {
                return self.begin(now);
            }
            self.entries.state(now.world);
            self.senders.clear();
            self.stated = (self.files.now(), at.0);
        }
        self.note_ports(now);
        self.note_settings(now);
        if at != self.at || !self.entries.is_empty() {
            self.note_place(now);
        }
        self.write(at.0, waits(now.pace));
        self.look_for_failure(now);
    }

    /// Ends the journal: the world is over, and will be there again.
    pub(crate) fn close(&mut self, now: &Now<'_>) {
        self.hashed = self.files.now().checked_sub(HASH_EVERY).unwrap_or(self.hashed);
        self.at = (u64::MAX, false);
        self.keep_now(now);
        self.files.write();
        self.files.sync();
        let Keeping { is_lost, tick } = self.keeping();
        match is_lost {
            true => event!(now, error, problem = self.files.problem(), kept_tick = tick, "state not stored"),
            false => event!(now, info, "state stored"),
        }
    }

    /// The world is deleted.
    pub(crate) fn remove(&self, now: &Now<'_>) {
        if let Err(error) = self.files.remove() {
            event!(now, error, %error, "the state of a deleted world cannot be removed");
        }
    }

    /// Another run begins, or it goes on from another state: so does another journal.
    pub(crate) fn begin(&mut self, now: &Now<'_>) {
        if self.lost.is_some() {
            // The world may be kept again with this journal, and what follows belongs to it.
            self.begin_again(now);
        } else {
            self.begin_journal(now);
            self.look_for_failure(now);
        }
    }

    fn begin_journal(&mut self, now: &Now<'_>) {
        (self.settings, self.pace) = (settings(now), now.pace);
        let all = ports(now.senders, &[]);
        // Later entries stand behind it.
        self.entries = Entries::beginning(now.name, now.world, &self.made, &self.settings, &all);
        let journal = self.entries.take();
        self.senders = now.senders.to_vec();
        self.at = (now.world.tick(), now.world.is_begun());
        self.stated = (self.files.now(), self.at.0);
        self.beginning = journal.len() as u64;
        self.length = self.beginning;
        self.on_disk = Arc::default();
        let snapshots = if self.lost.is_some() { self.snapshots.clone() } else { Vec::new() };
        let (tick, on_disk) = (self.at.0, Arc::clone(&self.on_disk));
        self.files.add(Work::Begin { journal, tick, snapshots, on_disk }, waits(now.pace));
    }

    /// Keeps a snapshot, and no more than `most` of them.
    pub(crate) fn snapshot(&mut self, now: &Now<'_>, number: u64, most: usize) {
        let (settings, ports) = (Settings::default(), ports(now.senders, &[]));
        let bytes = Entries::beginning(now.name, now.world, &self.made, &settings, &ports).take();
        self.note_snapshot(number, bytes.clone(), most);
        self.files.add(Work::Snapshot(number, bytes), waits(now.pace));
        self.look_for_failure(now);
    }

    /// Remembers a snapshot that is in the folder.
    pub(crate) fn note_snapshot(&mut self, number: u64, bytes: Vec<u8>, most: usize) {
        self.snapshots.push((number, bytes));
        if self.snapshots.len() > most {
            let (oldest, _) = self.snapshots.remove(0);
            self.files.add(Work::Forget(oldest), false);
        }
    }

    /// Wakes the world if something cannot be written, or forced onto the disk, later.
    pub(crate) fn wakes_if_lost(&self, waker: Waker) {
        self.files.wakes_if_lost(waker);
    }

    /// The instant at which another journal is to be attempted, if nothing is kept at the moment; at once if that has
    /// not been noted yet.
    pub(crate) fn retry_at(&self) -> Option<Instant> {
        match &self.lost {
            Some(lost) => Some(lost.retry),
            None => self.files.is_lost().then_some(self.written),
        }
    }

    /// Notes that something could not be written, and attempts another journal when it is time. Whether entries can be collected.
    fn look_for_failure(&mut self, now: &Now<'_>) -> bool {
        let is_lost = self.files.is_lost();
        let instant = self.files.now();
        match &mut self.lost {
            None if is_lost => {
                let (problem, kept_tick) = (self.files.problem(), self.keeping().tick);
                event!(now, error, problem, kept_tick, "state not stored; the world continues");
                self.entries.clear();
                self.lost = Some(Lost { retry: instant + RETRY_AFTER, is_trying: false });
                false
            }
            None => true,
            Some(lost) if lost.is_trying && !is_lost => {
                event!(now, warn, "state stored again");
                self.lost = None;
                true
            }
            Some(lost) if instant >= lost.retry => {
                lost.is_trying = true;
                self.begin_again(now)
            }
            Some(lost) => lost.is_trying,
        }
    }

    /// Attempts another journal, once. Whether things are kept again.
    fn begin_again(&mut self, now: &Now<'_>) -> bool {
        self.begin_journal(now);
        // A disk that is full and slow may have taken longer for this than until the next attempt: between two of them others have
        // their turn.
        let retry = self.files.now() + RETRY_AFTER;
        let has_failed = waits(now.pace) && self.files.is_lost();
        if let Some(lost) = &mut self.lost {
            (lost.retry, lost.is_trying) = (retry, !has_failed);
        }
        if has_failed {
            self.entries.clear();
            return false;
        }
        self.look_for_failure(now) && self.lost.is_none()
    }

    /// The time since an instant. The clock may have been turned back.
    fn since(&self, instant: Instant) -> Duration {
        self.files.now().saturating_duration_since(instant)
    }

    fn needs_state(&self, now: &Now<'_>) -> bool {
        let (when, tick) = self.stated;
        let ticks = now.world.tick().saturating_sub(tick);
        ticks >= STATE_EVERY_TICKS || (ticks > 0 && self.since(when) >= STATE_EVERY)
    }

    fn note_ports(&mut self, now: &Now<'_>) {
        if self.senders != now.senders {
            self.entries.ports(&ports(now.senders, &self.senders));
            // In place: a crowd has many, and this is done at each tick.
            self.senders.resize_with(now.senders.len(), Sender::default);
            self.senders.clone_from_slice(now.senders);
        }
    }

    fn note_settings(&mut self, now: &Now<'_>) {
        if self.pace != now.pace || !is_same(&self.settings, now) {
            (self.settings, self.pace) = (settings(now), now.pace);
            self.entries.settings(&self.settings);
        }
    }

    fn note_place(&mut self, now: &Now<'_>) {
        let is_due = self.since(self.hashed) >= HASH_EVERY;
        let state_hash = is_due.then(|| now.world.hash());
        if is_due {
            self.hashed = self.files.now();
        }
        let (tick, begun) = (now.world.tick(), now.world.is_begun());
        let on_disk = self.on_disk.load(Ordering::Relaxed);
        self.entries.at(At { tick, begun, state_hash, on_disk });
        self.at = (tick, begun);
    }

    fn write(&mut self, tick: u64, waits: bool) {
        self.written = self.files.now();
        if !self.entries.is_empty() {
            self.length += self.entries.len() as u64;
            if waits {
                self.files.append(self.entries.bytes(), tick);
                self.entries.clear();
            } else {
                self.files.add(Work::Append(self.entries.take(), tick), false);
            }
        }
    }
}

/// Whether a world waits for its brains: then no answer has anything that is not in the journal.
fn waits(pace: Pace) -> bool {
    pace.lockstep().is_some()
}

fn settings(now: &Now<'_>) -> Settings {
    let recording = now.recording.map(|RecordConfig { name, path, look_hz }| KeptRecording {
        name: name.clone(),
        // The next server may be started elsewhere.
        path: std::path::absolute(path).unwrap_or_else(|_| path.clone()).display().to_string(),
        look_hz: *look_hz,
    });
    Settings {
        pace: Some(convert::pace_to(now.pace)),
        paused: now.paused,
        slots: now.sessions.standing(now.coming_back).collect(),
        recording,
    }
}

/// Whether these are the settings but for the pace, as at nearly every tick.
fn is_same(settings: &Settings, now: &Now<'_>) -> bool {
    let recording = settings.recording.as_ref().map(|recording| &recording.name);
    settings.paused == now.paused
        && recording == now.recording.map(|config| &config.name)
        && settings.slots.iter().copied().eq(now.sessions.standing(now.coming_back))
}

/// The writing ends of ports that are not as they were.
fn ports(senders: &[Sender], before: &[Sender]) -> Ports {
    let changed = senders.iter().enumerate().filter(|(robot, sender)| before.get(*robot) != Some(*sender));
    let state = |(robot, sender): (usize, &Sender)| {
        let (sequence, raw, others) = sender.parts();
        PortState { robot: robot as u32, sequence: sequence.into(), raw, others: others.to_vec() }
    };
    Ports { ports: changed.map(state).collect() }
}
