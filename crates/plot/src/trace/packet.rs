//! The part of Perfetto's trace format that is needed, with its field numbers
//! (<https://perfetto.dev/docs/reference/trace-packet-proto>).
//!
//! Fields that are a oneof there are optional here: on the wire that is the same. `xtask/tools/check_trace.py` reads traces
//! with Perfetto's own schema.

use std::io::{self, Write};

use prost::Message;

/// A packet. A file is packets one after the other, each as field 1 of the message `Trace`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct TracePacket {
    /// In nanoseconds, by the trace's clock.
    #[prost(uint64, optional, tag = "8")]
    pub(crate) timestamp: Option<u64>,
    #[prost(uint32, optional, tag = "10")]
    pub(crate) trusted_packet_sequence_id: Option<u32>,
    #[prost(message, optional, tag = "11")]
    pub(crate) track_event: Option<TrackEvent>,
    #[prost(uint32, optional, tag = "13")]
    pub(crate) sequence_flags: Option<u32>,
    #[prost(message, optional, tag = "60")]
    pub(crate) track_descriptor: Option<TrackDescriptor>,
    #[prost(bool, optional, tag = "87")]
    pub(crate) first_packet_on_sequence: Option<bool>,
}

/// A line of the picture.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct TrackDescriptor {
    #[prost(uint64, optional, tag = "1")]
    pub(crate) uuid: Option<u64>,
    #[prost(string, optional, tag = "2")]
    pub(crate) name: Option<String>,
    #[prost(message, optional, tag = "3")]
    pub(crate) process: Option<ProcessDescriptor>,
    #[prost(uint64, optional, tag = "5")]
    pub(crate) parent_uuid: Option<u64>,
    #[prost(message, optional, tag = "8")]
    pub(crate) counter: Option<CounterDescriptor>,
    #[prost(int32, optional, tag = "11")]
    pub(crate) child_ordering: Option<i32>,
    #[prost(int32, optional, tag = "12")]
    pub(crate) sibling_order_rank: Option<i32>,
    #[prost(int32, optional, tag = "15")]
    pub(crate) sibling_merge_behavior: Option<i32>,
}

/// A line of numbers.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct CounterDescriptor {}

/// A group of lines: for us, a robot.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct ProcessDescriptor {
    #[prost(int32, optional, tag = "1")]
    pub(crate) pid: Option<i32>,
    #[prost(string, optional, tag = "6")]
    pub(crate) process_name: Option<String>,
}

/// The begin or the end of a slice, an instant, or a number.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct TrackEvent {
    #[prost(message, repeated, tag = "4")]
    pub(crate) debug_annotations: Vec<DebugAnnotation>,
    #[prost(int32, optional, tag = "9")]
    pub(crate) r#type: Option<i32>,
    #[prost(uint64, optional, tag = "11")]
    pub(crate) track_uuid: Option<u64>,
    #[prost(string, repeated, tag = "22")]
    pub(crate) categories: Vec<String>,
    #[prost(string, optional, tag = "23")]
    pub(crate) name: Option<String>,
    #[prost(int64, optional, tag = "30")]
    pub(crate) counter_value: Option<i64>,
}

/// A name and a value, shown when the slice is clicked.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct DebugAnnotation {
    #[prost(bool, optional, tag = "2")]
    pub(crate) bool_value: Option<bool>,
    #[prost(uint64, optional, tag = "3")]
    pub(crate) uint_value: Option<u64>,
    #[prost(string, optional, tag = "6")]
    pub(crate) string_value: Option<String>,
    #[prost(string, optional, tag = "10")]
    pub(crate) name: Option<String>,
}

impl TracePacket {
    /// Writes it as a field of a trace.
    pub(crate) fn write(&self, out: &mut impl Write) -> io::Result<()> {
        let mut bytes = vec![FIELD_1];
        // A vector takes whatever is put into it.
        self.encode_length_delimited(&mut bytes).map_err(io::Error::other)?;
        out.write_all(&bytes)
    }
}

/// Tag of field 1 with a length: `Trace.packet`.
const FIELD_1: u8 = 0x0a;

/// `TrackEvent.Type`.
pub(crate) const SLICE_BEGIN: i32 = 1;
/// `TrackEvent.Type`.
pub(crate) const SLICE_END: i32 = 2;
/// `TrackEvent.Type`.
pub(crate) const INSTANT: i32 = 3;
/// `TrackEvent.Type`.
pub(crate) const COUNTER: i32 = 4;
/// `TracePacket.SequenceFlags`: from here on, nothing before this packet is needed.
pub(crate) const INCREMENTAL_STATE_CLEARED: u32 = 1;
/// `TrackDescriptor.ChildTracksOrdering`: by `sibling_order_rank`.
pub(crate) const EXPLICIT: i32 = 3;
/// `TrackDescriptor.SiblingMergeBehavior`: tracks of one name stay apart.
pub(crate) const NO_MERGE: i32 = 2;
