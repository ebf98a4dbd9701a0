//! `metadata.yaml`, without which the tools of ROS do not open a bag.

use std::fmt::Write;

use super::qos::{self, Durability};

/// A topic of a bag.
pub(super) struct Topic {
    pub(super) name: String,
    pub(super) kind: &'static str,
    pub(super) messages: u64,
}

/// The text of the metadata for a bag with this file, that lasts from one instant to another.
pub(super) fn text(file: &str, topics: &[Topic], (from_ns, to_ns): (u64, u64)) -> String {
    let messages: u64 = topics.iter().map(|topic| topic.messages).sum();
    let duration_ns = to_ns - from_ns;
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: {duration_ns}\n  \
         starting_time:\n    nanoseconds_since_epoch: {from_ns}\n  message_count: {messages}\n  topics_with_message_count:\n"
    );
    for Topic { name, kind, messages } in topics {
        let offered = qos::profile(Durability::of(name)).replace('\n', "\\n");
        let _ = write!(
            text,
            "    - topic_metadata:\n        name: {name}\n        type: {kind}\n        serialization_format: cdr\n        \
             offered_qos_profiles: \"{offered}\"\n      message_count: {messages}\n"
        );
    }
    let _ = write!(
        text,
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file}\n  files:\n    - path: {file}\n      \
         starting_time:\n        nanoseconds_since_epoch: {from_ns}\n      duration:\n        nanoseconds: {duration_ns}\n      \
         message_count: {messages}\n"
    );
    text
}
