//! The exchange on the page about brains in any language is a real one.

use std::fmt::Write;

use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use baudbot_proto::v1::robot_step::Output;
use baudbot_proto::v1::{self, AttachRequest};
use baudbot_tests::system::{lockstep, serve};
use prost::Message;
use prost_reflect::text_format::FormatOptions;
use prost_reflect::{DescriptorPool, DynamicMessage};
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

const PAGE: &str = include_str!("../../docs/how-to/any-language.md");

/// The text of a block of code on the page.
fn block(language: &str) -> &'static str {
    let begins = format!("```{language}\n");
    let (_, rest) = PAGE.split_once(&begins).expect("a block");
    rest.split_once("```").expect("its end").0
}

/// What is said, in the text format of protobuf.
struct Transcript {
    contract: DescriptorPool,
    text: String,
}

impl Transcript {
    fn note(&mut self, speaker: &str, name: &str, message: &impl Message) {
        let name = format!("baudbot.v1.{name}");
        let kind = self.contract.get_message_by_name(&name).expect("a message of the contract");
        let message =
            DynamicMessage::decode(kind, message.encode_to_vec().as_slice()).expect("it is of that kind");
        let text = message.to_text_format_with_options(&FormatOptions::new().pretty(true));
        let _ = writeln!(self.text, "# {speaker}\n{}", text.trim_end());
    }
}

#[tokio::test]
async fn the_exchange_on_the_page_is_a_real_one() {
    let scenario = baudbot_scenario::parse(block("toml")).expect("the page's scenario");
    let server = serve(scenario, lockstep()).await;
    let contract = DescriptorPool::decode(baudbot_proto::DESCRIPTORS).expect("the contract");
    let mut transcript = Transcript { contract, text: String::new() };
    let (to_server, requests) = mpsc::channel(8);
    let say = async |transcript: &mut Transcript, request: Request| {
        let request = AttachRequest { request: Some(request) };
        transcript.note("the brain", "AttachRequest", &request);
        to_server.send(request).await.expect("the server listens");
    };
    let (world, robots) = ("w".to_owned(), vec!["robot".to_owned()]);
    let hello = v1::Hello {
        world,
        robots,
        mode: v1::PortMode::Messages.into(),
        brain: "first".to_owned(),
        ..Default::default()
    };
    say(&mut transcript, Request::Hello(hello)).await;
    let mut client = BrainLinkServiceClient::new(server.channel().await.expect("a pipe"));
    let mut responses = client.attach(ReceiverStream::new(requests)).await.expect("attached").into_inner();
    while let Some(response) = responses.message().await.expect("a response") {
        transcript.note("the server", "AttachResponse", &response);
        match response.response.expect("a known response") {
            Response::Welcome(_) => {}
            Response::Turn(turn) => {
                let part = &turn.robots[0];
                let nearness =
                    part.readings.first().filter(|reading| reading.readable).map(|reading| reading.values[0]);
                let command = |nearness: f64| {
                    let left_signal = if nearness > 0.3 { -0.4 } else { 0.4 };
                    Output::Command(v1::Command { left_signal, right_signal: 0.4, other_signals: Vec::new() })
                };
                let until_message = Some(v1::UntilMessage { at_latest_ns: Some(part.at_ns + 100_000_000) });
                let part = v1::RobotStep {
                    robot: 0,
                    output: nearness.map(command),
                    until_message,
                    ..Default::default()
                };
                say(&mut transcript, Request::Step(v1::Step { turn: turn.turn, robots: vec![part] })).await;
            }
            Response::Ended(_) => break,
        }
    }
    let shown = block("text");
    assert_eq!(
        transcript.text, shown,
        "docs/how-to/any-language.md has another exchange than\n{}",
        transcript.text
    );
}
