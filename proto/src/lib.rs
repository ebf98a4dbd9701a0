//! The gRPC contract of baudbot.
//!
//! [`v1`] is generated (`proto/examples/generate.rs`) from `baudbot/v1/*.proto`, which also holds its documentation. Any language's gRPC
//! tools can be given those files. The feature `services` (a default) adds the services' clients and servers to the messages,
//! `brain` adds `convert`, between the contract and what a brain sees and does.

#[cfg(test)]
mod comment_tests;
#[cfg(feature = "brain")]
pub mod convert;

/// Package `baudbot.v1`: the services of the operator, the brain and the observer.
#[allow(missing_docs, unreachable_pub, unused_qualifications, clippy::all, reason = "generated code")]
pub mod v1 {
    include!("generated/baudbot.v1.rs");
}

impl v1::SensorKind {
    /// Its name in scenarios: `SENSOR_KIND_LINE_CAMERA` is `line-camera`.
    pub fn scenario_name(self) -> String {
        self.as_str_name().trim_start_matches("SENSOR_KIND_").replace('_', "-").to_lowercase()
    }
}

/// The trailer that says why an Attach has ended, where its status alone does not.
pub const REASON: &str = "baudbot-reason";

/// The reason that the operator restarts the brain.
pub const RESTART: &str = "restart";

/// The contract as a serialised `FileDescriptorSet` with its comments, for server reflection.
pub static DESCRIPTORS: &[u8] = include_bytes!("generated/descriptors.bin");

/// The contract as a serialised `FileDescriptorSet` without comments, a quarter as long: messages, services and their methods.
pub static TYPES: &[u8] = include_bytes!("generated/types.bin");
