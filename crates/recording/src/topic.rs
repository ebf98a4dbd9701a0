//! The topics of a recording that a replay needs.

/// Of the first message, a `RecordingHeader`.
pub const HEADER: &str = "/baudbot/header";
/// Of `RecordedState`.
pub const STATE: &str = "/baudbot/state";
/// Of `RecordedInputs`.
pub const INPUTS: &str = "/baudbot/inputs";
/// Of `RecordedMark`.
pub const MARKS: &str = "/baudbot/marks";
/// Of `RecordedEvent`.
pub const EVENTS: &str = "/baudbot/events";
/// Of `RecordedThinking`.
pub const THINKING: &str = "/baudbot/thinking";
/// Of the one `DescribeWorldResponse`: what stands still, and what the robots are.
pub const WORLD: &str = "/baudbot/world";
/// Of `WatchResponse`: what an observer saw.
pub const FRAMES: &str = "/baudbot/frames";
