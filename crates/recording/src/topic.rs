//! The topics of a recording that a replay needs.

/// The topic of the first message, a `RecordingHeader`.
pub const HEADER: &str = "/baudbot/header";
/// The topic of `RecordedState`.
pub const STATE: &str = "/baudbot/state";
/// The topic of `RecordedInputs`.
pub const INPUTS: &str = "/baudbot/inputs";
/// The topic of `RecordedMark`.
pub const MARKS: &str = "/baudbot/marks";
/// The topic of `RecordedEvent`.
pub const EVENTS: &str = "/baudbot/events";
/// The topic of `RecordedThinking`.
pub const THINKING: &str = "/baudbot/thinking";
/// The topic of the one `DescribeWorldResponse`: what stands still, and what the robots are.
pub const WORLD: &str = "/baudbot/world";
/// The topic of `WatchResponse`: the frames of an observer.
pub const FRAMES: &str = "/baudbot/frames";
