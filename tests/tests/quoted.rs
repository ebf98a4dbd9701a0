//! A client's text comes back in errors as text: nothing in it is obeyed by the terminal that shows them.

use std::collections::BTreeSet;
use std::time::Duration;

use baudbot_fields::printable::is_printable;
use baudbot_proto::v1;
use baudbot_server::{Server, WorldConfig};
use baudbot_tests::system::{lockstep, operator};
use baudbot_tests::{WANDER, scenario};
use prost::Message;
use prost::bytes::{Buf, BufMut};
use prost_types::field_descriptor_proto::Type;
use prost_types::{DescriptorProto, FileDescriptorSet};
use tonic::client::Grpc;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::transport::Channel;
use tonic::{Request, Status};

/// A colour, a bell, and letters from right to left.
const HOSTILE: &str = "\u{1b}[31m\u{7}\u{202e}x";

/// Requests are bytes, and of answers nothing is wanted.
#[derive(Clone, Copy, Debug, Default)]
struct Bytes;

impl Codec for Bytes {
    type Encode = Vec<u8>;
    type Decode = ();
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Bytes {
    type Item = Vec<u8>;
    type Error = Status;

    fn encode(&mut self, item: Vec<u8>, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        out.put_slice(&item);
        Ok(())
    }
}

impl Decoder for Bytes {
    type Item = ();
    type Error = Status;

    fn decode(&mut self, from: &mut DecodeBuf<'_>) -> Result<Option<()>, Status> {
        from.advance(from.remaining());
        Ok(Some(()))
    }
}

fn put(number: i32, content: &[u8], out: &mut Vec<u8>) {
    prost::encoding::encode_key(number as u32, prost::encoding::WireType::LengthDelimited, out);
    prost::encoding::encode_varint(content.len() as u64, out);
    out.put_slice(content);
}

/// Messages of this kind in which one field, at any depth, has a hostile text; each with the path of that. Beside it names are
/// those of the world and the robot that are there, so that more of the request is looked at.
fn hostile(files: &FileDescriptorSet, kind: &str, depth: usize) -> Vec<(String, Vec<u8>)> {
    let short = kind.trim_start_matches(".baudbot.v1.");
    let mut messages = files.file.iter().flat_map(|file| &file.message_type);
    let Some(DescriptorProto { field, .. }) = messages.find(|message| message.name() == short) else {
        return Vec::new();
    };
    let mut usual = Vec::new();
    for field in field {
        match field.name() {
            "world" if field.r#type() == Type::String => put(field.number(), b"w", &mut usual),
            "robot" if field.r#type() == Type::String => put(field.number(), b"robot", &mut usual),
            _ => {}
        }
    }
    let mut made = Vec::new();
    for field in field {
        let inner = match field.r#type() {
            Type::String => vec![(String::new(), HOSTILE.as_bytes().to_vec())],
            Type::Message if depth > 0 => hostile(files, field.type_name(), depth - 1),
            _ => Vec::new(),
        };
        for (path, content) in inner {
            let mut bytes = usual.clone();
            put(field.number(), &content, &mut bytes);
            made.push((format!(".{}{path}", field.name()), bytes));
        }
    }
    made
}

async fn call(channel: Channel, path: &str, request: Vec<u8>) -> Result<(), Status> {
    let mut client = Grpc::new(channel);
    client.ready().await.map_err(|error| Status::unknown(error.to_string()))?;
    let path = PathAndQuery::try_from(path).unwrap();
    let requests = Request::new(tokio_stream::once(request));
    let mut answers = client.streaming(requests, path, Bytes).await?.into_inner();
    tokio::time::timeout(Duration::from_millis(500), answers.message()).await.unwrap_or(Ok(None)).map(|_| ())
}

#[tokio::test]
async fn no_error_of_any_call_has_in_it_what_a_terminal_obeys() {
    let folder = tempfile::tempdir().unwrap();
    let files = FileDescriptorSet::decode(baudbot_proto::DESCRIPTORS).unwrap();
    let world = || WorldConfig::new("w", scenario(WANDER, &[])).pace(lockstep());
    let builder = Server::builder().world(world()).recordings(folder.path().to_owned());
    let server = builder.in_process().await.unwrap();
    let (mut refusals, mut silent) = (0, BTreeSet::new());
    let services = files.file.iter().flat_map(|file| &file.service);
    for (service, method) in
        services.flat_map(|service| service.method.iter().map(move |method| (service, method)))
    {
        let path = format!("/baudbot.v1.{}/{}", service.name(), method.name());
        let before = refusals;
        for (field, request) in hostile(&files, method.input_type(), 4) {
            let channel = server.channel().await.unwrap();
            let Err(status) = call(channel, &path, request).await else { continue };
            refusals += 1;
            let is_shown = |c: char| is_printable(c) || c == '\n' || c == '\t';
            assert!(status.message().chars().all(is_shown), "{path}, {field}: {:?}", status.message());
        }
        if refusals == before {
            silent.insert(method.name());
        }
        // Some calls take the world away, or leave it in another state.
        let mut operator = operator(&server).await;
        let _ = operator.delete_world(v1::DeleteWorldRequest { world: "w".into() }).await;
        let create = v1::CreateWorldRequest {
            world: "w".into(),
            scenario_toml: WANDER.into(),
            paused: true,
            ..Default::default()
        };
        operator.create_world(create).await.unwrap();
    }
    assert!(refusals > 40, "{refusals}");
    // These calls take no text.
    assert_eq!(silent, BTreeSet::from(["GetLimits", "ListRecordings", "ListWorlds"]));
    server.shutdown().await;
}
