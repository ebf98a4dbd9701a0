//! Events, as lines of a log.

use std::sync::Arc;

use baudbot_proto::v1::ReplayEventKind as Kind;
use foxglove::messages::Log;
use foxglove::messages::log::Level;

use super::message::FoxgloveMessage;
use super::parts::time;

pub(super) fn event(topic: &Arc<str>, time_ns: u64, kind: Kind, text: &str) -> FoxgloveMessage {
    let (level, name) = match kind {
        Kind::Unspecified => (Level::Info, "world"),
        Kind::Collision => (Level::Warning, "collision"),
        Kind::Brain => (Level::Info, "brain"),
        Kind::Change => (Level::Info, "change"),
        Kind::Ending => (Level::Info, "ending"),
        Kind::Order => (Level::Info, "order"),
    };
    let log = Log {
        timestamp: Some(time(time_ns)),
        level: level.into(),
        message: text.to_owned(),
        name: name.to_owned(),
        ..Log::default()
    };
    FoxgloveMessage::new(topic, time_ns, &log)
}

#[cfg(test)]
mod tests {
    use foxglove::Decode as _;

    use super::*;

    #[test]
    fn a_collision_is_a_warning() {
        let message = event(&"/log".into(), 1_000_000_001, Kind::Collision, "alice ran into wall");
        assert_eq!((message.schema.name.as_str(), message.time_ns), ("foxglove.Log", 1_000_000_001));
        let log = Log::decode(&message.data[..]).unwrap();
        assert_eq!(log.level(), Level::Warning);
        assert_eq!((log.name.as_str(), log.message.as_str()), ("collision", "alice ran into wall"));
        let at = log.timestamp.unwrap();
        assert_eq!((at.sec(), at.nsec()), (1, 1));
    }
}
