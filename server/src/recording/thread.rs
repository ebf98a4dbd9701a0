//! The thread that writes a recording. Where there are no threads, the world writes it itself.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use baudbot_proto::v1;
use baudbot_recording::{RecordingFile, WriteError, Writer};
use tokio::sync::oneshot;
use tonic::Status;

use super::Entry;

/// Batches that wait to be written before a world that can wait does so.
const BATCHES: usize = 64;

/// The handle of the thread. When it is dropped, the thread ends the file, and is waited for.
pub(super) struct RecorderThread {
    worker: Option<Worker>,
    progress: Arc<Progress>,
}

/// The writer.
enum Worker {
    Thread(SyncSender<Work>, JoinHandle<()>),
    /// The sender writes, in its own thread.
    Sender(Box<Mutex<Recorder>>),
}

enum Work {
    Batch(Vec<Entry>),
    /// Ends the file. The status, brought up to date, goes to the sender.
    Close(v1::RecordingStatus, Option<oneshot::Sender<v1::RecordingStatus>>),
}

/// The progress of the thread, shared with the world.
#[derive(Default)]
struct Progress {
    bytes: AtomicU64,
    problem: Mutex<Option<String>>,
}

/// Whether a batch was taken.
pub(super) enum Sent {
    /// The data were taken, or nothing is written any more.
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
        let progress = Arc::new(Progress::default());
        let own = Arc::clone(&progress);
        let name = format!("recording {}", header.world);
        let recorder = move || Recorder::new(file, &header, described.as_ref(), own);
        let worker = if cfg!(target_family = "wasm") {
            Worker::Sender(Box::new(Mutex::new(recorder())))
        } else {
            let (work, to_do) = sync_channel(BATCHES);
            let thread = thread::Builder::new().name(name).spawn(move || recorder().write_all(&to_do));
            let thread = thread
                .map_err(|error| Status::resource_exhausted(format!("no thread for a recording: {error}")))?;
            Worker::Thread(work, thread)
        };
        Ok(Self { worker: Some(worker), progress })
    }

    /// Sends a batch without waiting.
    pub(super) fn send(&self, batch: Vec<Entry>) -> Sent {
        match &self.worker {
            None => Sent::Taken,
            Some(Worker::Sender(recorder)) => {
                locked(recorder).write(batch);
                Sent::Taken
            }
            Some(Worker::Thread(work, _)) => match work.try_send(Work::Batch(batch)) {
                Err(TrySendError::Full(Work::Batch(batch))) => Sent::Full(batch),
                Ok(()) | Err(TrySendError::Full(Work::Close(..)) | TrySendError::Disconnected(_)) => {
                    Sent::Taken
                }
            },
        }
    }

    /// Sends a batch, and waits until there is room.
    pub(super) fn send_at_last(&self, batch: Vec<Entry>) {
        match &self.worker {
            None => {}
            Some(Worker::Sender(recorder)) => locked(recorder).write(batch),
            // The thread takes all until it is dropped.
            Some(Worker::Thread(work, _)) => drop(work.send(Work::Batch(batch))),
        }
    }

    /// Writes nothing from now on.
    pub(super) fn fail(&self, problem: &str) {
        self.progress.fail(problem.to_owned());
    }

    /// Ends the file, and waits until it is closed, unless there is a `reply`: that then gets this status, brought up to date.
    pub(super) fn close(
        mut self,
        status: v1::RecordingStatus,
        reply: Option<oneshot::Sender<v1::RecordingStatus>>,
    ) {
        match self.worker.take() {
            None => {}
            Some(Worker::Sender(recorder)) => unlocked(*recorder).end(Some((status, reply))),
            Some(Worker::Thread(work, thread)) => {
                let is_told = reply.is_some();
                let _ = work.send(Work::Close(status, reply));
                if !is_told {
                    // The panic of the thread is on stderr already.
                    let _ = thread.join();
                }
            }
        }
    }

    /// Bytes in the file, and why it ended too early, if it did.
    pub(super) fn progress(&self) -> (u64, Option<String>) {
        self.progress.get()
    }
}

impl Drop for RecorderThread {
    fn drop(&mut self) {
        match self.worker.take() {
            None => {}
            Some(Worker::Sender(recorder)) => unlocked(*recorder).end(None),
            Some(Worker::Thread(work, thread)) => {
                drop(work);
                let _ = thread.join();
            }
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

/// The owner of the file.
struct Recorder {
    /// `None` if nothing could be written.
    writer: Option<Writer<RecordingFile>>,
    /// Whether all has been written. After an error what comes is thrown away.
    is_whole: bool,
    length: Arc<AtomicU64>,
    progress: Arc<Progress>,
}

impl Recorder {
    fn new(
        file: RecordingFile,
        header: &v1::RecordingHeader,
        described: Option<&(u64, v1::DescribeWorldResponse)>,
        progress: Arc<Progress>,
    ) -> Self {
        let length = file.length();
        let writer = begin(file, header, described).map_err(|error| progress.fail(error.to_string())).ok();
        Self { is_whole: writer.is_some(), writer, length, progress }
    }

    /// The thread.
    fn write_all(mut self, work: &Receiver<Work>) {
        let mut waiting = None;
        while let Ok(work) = work.recv() {
            match work {
                Work::Batch(batch) => self.write(batch),
                Work::Close(status, reply) => {
                    waiting = Some((status, reply));
                    break;
                }
            }
        }
        self.end(waiting);
    }

    fn write(&mut self, batch: Vec<Entry>) {
        if let Some(open) = self.writer.as_mut().filter(|_| self.is_whole)
            && let Err(error) = batch.into_iter().try_for_each(|entry| write(open, entry))
        {
            self.is_whole = false;
            self.progress.fail(error.to_string());
        }
        self.note_length();
    }

    /// Ends the file. The status, brought up to date, goes to the sender.
    fn end(mut self, waiting: Option<(v1::RecordingStatus, Option<oneshot::Sender<v1::RecordingStatus>>)>) {
        if let Some(open) = self.writer.take() {
            if !self.is_whole {
                // The file ends where it is still whole.
                open.abandon();
            } else if let Err(error) = open.finish() {
                self.progress.fail(error.to_string());
            }
        }
        self.note_length();
        if let Some((status, Some(reply))) = waiting {
            let (bytes, problem) = self.progress.get();
            let problem = problem.unwrap_or_default();
            let _ = reply.send(v1::RecordingStatus { bytes, problem, ..status });
        }
    }

    fn note_length(&self) {
        self.progress.bytes.store(self.length.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}

fn locked(recorder: &Mutex<Recorder>) -> MutexGuard<'_, Recorder> {
    recorder.lock().unwrap_or_else(PoisonError::into_inner)
}

fn unlocked(recorder: Mutex<Recorder>) -> Recorder {
    recorder.into_inner().unwrap_or_else(PoisonError::into_inner)
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
        Entry::Frame(frame) => writer.frame(&frame),
    }
}
