//! One message for a file, and the schemas that such messages have.

use std::sync::{Arc, LazyLock};

use baudbot_proto::v1;
use foxglove::messages::{FrameTransforms, Grid, LaserScan, Log, SceneUpdate};
use foxglove::{Encode, Schema};
use prost::Message;

use crate::{schema, topic};

/// One message for an MCAP file, or for a program that shows it.
#[derive(Clone, Debug)]
pub struct FoxgloveMessage {
    /// The topic, which has messages of one schema.
    pub topic: Arc<str>,
    /// The schema: name, encoding and description, in the form for a file and a connection. The message's own encoding
    /// is the schema's, `protobuf`.
    pub schema: &'static MessageSchema,
    /// Simulated time, at which it was there to be seen. All times within the message are by the same clock.
    pub time_ns: u64,
    /// The message, encoded.
    pub data: Vec<u8>,
}

/// The schema of a message: its name, the encoding of its description, and that description.
pub type MessageSchema = Schema;

/// Messages of Foxglove's that are made here.
pub(super) trait Shown: Encode {
    fn schema() -> &'static MessageSchema;
}

impl FoxgloveMessage {
    /// A frame itself, as it is recorded: what Foxglove's plots and tables take their values from.
    pub fn of_frame(frame: &v1::WatchResponse) -> Self {
        static TOPIC: LazyLock<Arc<str>> = LazyLock::new(|| topic::FRAMES.into());
        static SCHEMA: LazyLock<MessageSchema> = LazyLock::new(|| {
            let name = format!("{}.WatchResponse", schema::PACKAGE);
            Schema::new(name, "protobuf", schema::of("WatchResponse"))
        });
        let (topic, data) = (Arc::clone(&TOPIC), frame.encode_to_vec());
        Self { topic, schema: &SCHEMA, time_ns: frame.time_ns, data }
    }

    pub(super) fn new<M: Shown>(topic: &Arc<str>, time_ns: u64, message: &M) -> Self {
        let mut data = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        message.encode(&mut data).expect("a vector has room for any message");
        Self { topic: Arc::clone(topic), schema: M::schema(), time_ns, data }
    }
}

macro_rules! shown {
    ($($message:ident),*) => {
        $(impl Shown for $message {
            fn schema() -> &'static MessageSchema {
                static SCHEMA: LazyLock<MessageSchema> = LazyLock::new(|| {
                    <$message as Encode>::get_schema().expect("Foxglove's own messages have schemas")
                });
                &SCHEMA
            }
        })*
    };
}

shown!(FrameTransforms, Grid, LaserScan, Log, SceneUpdate);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemas_say_what_foxglove_calls_them_and_are_the_same_each_time() {
        let schema = LaserScan::schema();
        assert_eq!((schema.name.as_str(), schema.encoding.as_str()), ("foxglove.LaserScan", "protobuf"));
        assert!(!schema.data.is_empty());
        assert!(std::ptr::eq(schema, LaserScan::schema()));
        assert_eq!(LaserScan::get_message_encoding(), schema.encoding);
        assert_eq!(Grid::schema().name, "foxglove.Grid");
    }
}
