//! The thread that writes a recording.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use baudbot_proto::v1;
use baudbot_recording::{RecordingFile, WriteError, Writer};
use tokio::sync::oneshot;
use tonic::Status;

use super::Entry;
use crate::convert;
use crate::report::RecordingReport;

/// Batches that wait to be written before a world that can wait does so.
const BATCHES: usize = 64;

/// The handle of the thread. When it is dropped, the thread ends the file, and is waited for.
pub(super) struct RecorderThread {
    work: Option<SyncSender<Work>>,
    thread: Option<JoinHandle<()>>,
    progress: Arc<Progress>,
}

enum Work {
    Batch(Vec<Entry>),
    /// Ends the file. The report, brought up to date, goes to the sender.
    Close(RecordingReport, Option<oneshot::Sender<RecordingReport>>),
}

/// The progress of the thread, shared with the world.
#[derive(Default)]
struct Progress {
    bytes: AtomicU64,
    problem: Mutex<Option<String>>,
}

/// Whether a batch was taken.
pub(super) enum Sent {
    /// It was taken, or nothing is written any more.
    Taken,
    /// Too much waits to be written; the batch is given back.
    Full(Vec<Entry>),
}

impl RecorderThread {
    /// Starts the thread. `described` is the world and since when it is so, if the recording has frames.
    pub(super) fn start(
        file: RecordingFile,
        header: v1::RecordingHeader,
        described: Option<(u64, v1::DescribeWorldResponse)>,
    ) -> Result<Self, Status> {
        let (work, to_do) = sync_channel(BATCHES);
        let progress = Arc::new(Progress::default());
        let own = Arc::clone(&progress);
        let thread = thread::Builder::new().name(format!("recording {}", header.world));
        let thread = thread.spawn(move || write_all(file, &header, described.as_ref(), &to_do, &own));
        let thread = thread
            .map_err(|error| Status::resource_exhausted(format!("no thread for a recording: {error}")))?;
        Ok(Self { work: Some(work), thread: Some(thread), progress })
    }

    /// Sends a batch without waiting.
    pub(super) fn send(&self, batch: Vec<Entry>) -> Sent {
        let Some(work) = &self.work else { return Sent::Taken };
        match work.try_send(Work::Batch(batch)) {
            Err(TrySendError::Full(Work::Batch(batch))) => Sent::Full(batch),
            Ok(()) | Err(TrySendError::Full(Work::Close(..)) | TrySendError::Disconnected(_)) => Sent::Taken,
        }
    }

    /// Sends a batch, and waits until there is room.
    pub(super) fn send_at_last(&self, batch: Vec<Entry>) {
        if let Some(work) = &self.work {
            // The thread takes all until it is dropped.
            let _ = work.send(Work::Batch(batch));
        }
    }

    /// Writes nothing from now on.
    pub(super) fn fail(&self, problem: &str) {
        self.progress.fail(problem.to_owned());
    }

    /// Ends the file, and waits until it is closed, unless there is a `reply`: that then gets this report, brought up to date.
    pub(super) fn close(mut self, report: RecordingReport, reply: Option<oneshot::Sender<RecordingReport>>) {
        if let Some(work) = self.work.take() {
            let is_told = reply.is_some();
            let _ = work.send(Work::Close(report, reply));
            self.thread.take_if(|_| is_told);
        }
    }

    /// Bytes in the file, and why it ended too early, if it did.
    pub(super) fn progress(&self) -> (u64, Option<String>) {
        self.progress.get()
    }
}

impl Drop for RecorderThread {
    fn drop(&mut self) {
        self.work = None;
        if let Some(thread) = self.thread.take() {
            // Its panic is on stderr already.
            let _ = thread.join();
        }
    }
}

impl Progress {
    fn fail(&self, problem: String) {
        let mut slot = self.problem.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.is_none() {
            tracing::error!(problem, "a recording ends too early");
            *slot = Some(problem);
        }
    }

    fn get(&self) -> (u64, Option<String>) {
        let problem = self.problem.lock().unwrap_or_else(PoisonError::into_inner).clone();
        (self.bytes.load(Ordering::Relaxed), problem)
    }
}

/// The thread. After an error it takes what comes, and throws it away.
fn write_all(
    file: RecordingFile,
    header: &v1::RecordingHeader,
    described: Option<&(u64, v1::DescribeWorldResponse)>,
    work: &Receiver<Work>,
    progress: &Progress,
) {
    let length = file.length();
    let mut writer = begin(file, header, described).map_err(|error| progress.fail(error.to_string())).ok();
    let mut waiting = None;
    let mut is_whole = writer.is_some();
    while let Ok(work) = work.recv() {
        match work {
            Work::Batch(batch) => {
                if let Some(open) = writer.as_mut().filter(|_| is_whole)
                    && let Err(error) = batch.into_iter().try_for_each(|entry| write(open, entry))
                {
                    is_whole = false;
                    progress.fail(error.to_string());
                }
                progress.bytes.store(length.load(Ordering::Relaxed), Ordering::Relaxed);
            }
            Work::Close(report, reply) => {
                waiting = Some((report, reply));
                break;
            }
        }
    }
    if let Some(open) = writer.take() {
        if !is_whole {
            // The file ends where it is still whole.
            open.abandon();
        } else if let Err(error) = open.finish() {
            progress.fail(error.to_string());
        }
    }
    progress.bytes.store(length.load(Ordering::Relaxed), Ordering::Relaxed);
    if let Some((report, Some(reply))) = waiting {
        let (bytes, problem) = progress.get();
        let _ = reply.send(RecordingReport { bytes, problem, ..report });
    }
}

fn begin(
    file: RecordingFile,
    header: &v1::RecordingHeader,
    described: Option<&(u64, v1::DescribeWorldResponse)>,
) -> Result<Writer<RecordingFile>, WriteError> {
    let mut writer = Writer::new(file, header)?;
    if let Some((time_ns, described)) = described {
        writer.world(*time_ns, described)?;
    }
    Ok(writer)
}

fn write(writer: &mut Writer<RecordingFile>, entry: Entry) -> Result<(), WriteError> {
    match entry {
        Entry::Inputs(inputs) => writer.inputs(&inputs),
        Entry::Mark(mark) => writer.mark(&mark),
        Entry::State(state) => writer.state(&state),
        Entry::Event(event) => writer.event(&event),
        Entry::Thinking(thinking) => writer.thinking(&thinking),
        Entry::Frame(frame) => writer.frame(&convert::frame(*frame)),
    }
}
