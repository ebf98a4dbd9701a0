//! Schemas of our messages, each with only the types that it needs.

use std::collections::BTreeSet;

use prost::Message;
use prost_types::{DescriptorProto, FileDescriptorSet};

/// The descriptors of a message of `baudbot.v1` and of all that is in it, in MCAP's form.
pub(crate) fn of(message: &str) -> Vec<u8> {
    // The descriptors are made by our own build from our own files.
    let mut set = FileDescriptorSet::decode(baudbot_proto::TYPES).expect("our own descriptors");
    let mut needed = BTreeSet::new();
    note(&set, &format!(".{PACKAGE}.{message}"), &mut needed);
    let is_needed = |name: &str| needed.contains(&format!(".{PACKAGE}.{name}"));
    for file in &mut set.file {
        file.service.clear();
        file.message_type.retain(|message| is_needed(message.name()));
        file.enum_type.retain(|kind| is_needed(kind.name()));
    }
    set.file.retain(|file| !file.message_type.is_empty() || !file.enum_type.is_empty());
    let names: BTreeSet<String> = set.file.iter().map(|file| file.name().to_owned()).collect();
    for file in &mut set.file {
        file.dependency.retain(|name| names.contains(name));
        file.public_dependency.clear();
        file.weak_dependency.clear();
    }
    set.encode_to_vec()
}

/// Notes a type, and the types of its fields.
fn note(set: &FileDescriptorSet, name: &str, needed: &mut BTreeSet<String>) {
    if !needed.insert(name.to_owned()) {
        return;
    }
    let messages = set.file.iter().flat_map(|file| &file.message_type);
    let found = messages.into_iter().find(|message| format!(".{PACKAGE}.{}", message.name()) == name);
    let Some(DescriptorProto { field, .. }) = found else { return };
    field.iter().filter_map(|field| field.type_name.as_deref()).for_each(|name| note(set, name, needed));
}

pub(crate) const PACKAGE: &str = "baudbot.v1";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_schema_has_what_its_message_needs_and_nothing_else() {
        let set = FileDescriptorSet::decode(of("RecordedInputs").as_slice()).unwrap();
        let messages = set.file.iter().flat_map(|file| &file.message_type);
        let names: BTreeSet<_> = messages.map(DescriptorProto::name).collect();
        let wanted = [
            "PlaceRobot",
            "PlaceThing",
            "PullCable",
            "RecordedChange",
            "RecordedInput",
            "RecordedInputs",
            "RecordedPort",
            "SetBaud",
        ];
        assert_eq!(names, BTreeSet::from(wanted));
        assert_eq!(set.file.len(), 2, "recording.proto and control.proto");
        assert_eq!(set.file.iter().flat_map(|file| &file.dependency).count(), 1);
        assert!(of("WatchResponse").len() < 8000, "{}", of("WatchResponse").len());
    }
}
