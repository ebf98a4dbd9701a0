//! The offer of a topic by its publisher, as the recorder of ROS 2 notes it: for `ros2 bag play`, which offers it so
//! again.

/// Whether a person who comes later is given the last message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Durability {
    /// A listener that comes later is given the last message. A listener of `/tf_static` asks for it, and is not joined
    /// with a publisher that does not offer it.
    TransientLocal,
    /// A listener that comes later gets only new messages.
    Volatile,
}

impl Durability {
    pub(super) fn of(topic: &str) -> Self {
        if topic == "/tf_static" { Self::TransientLocal } else { Self::Volatile }
    }
}

/// The text of `offered_qos_profiles`: a list of one profile in YAML, in the numbers of `rmw/types.h`. All topics are reliable and keep
/// the last messages.
pub(super) fn profile(durability: Durability) -> String {
    let (durability, depth) = match durability {
        Durability::TransientLocal => (1, 1),
        Durability::Volatile => (2, 10),
    };
    let endless = "\n    sec: 9223372036\n    nsec: 854775807";
    format!(
        "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  deadline:{endless}\n  lifespan:{endless}\n  \
         liveliness: 1\n  liveliness_lease_duration:{endless}\n  avoid_ros_namespace_conventions: false"
    )
}
