//! A server that keeps to a script, in this process.

use baudbot_client::Client;
use baudbot_proto::v1::brain_link_service_server::{BrainLinkService, BrainLinkServiceServer};
use baudbot_proto::v1::{self, AttachRequest, AttachResponse, attach_request, attach_response};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::sync::mpsc;
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::server::Connected;
use tonic::transport::{Endpoint, Server};
use tonic::{Request, Response, Status, Streaming};

/// The server's next act.
#[derive(Clone, Debug)]
pub(crate) enum Act {
    /// The server waits for a request and lets the test have it.
    Hear,
    /// The server sends a response.
    Say(attach_response::Response),
    /// The server ends the call with an error.
    Fail(Status),
}

/// A client, in this process, of a server that follows `script` and then closes the stream, and the requests that the
/// server received.
pub(crate) async fn serve(script: Vec<Act>) -> (Client, mpsc::Receiver<attach_request::Request>) {
    let (near, far) = tokio::io::duplex(1 << 16);
    let requests = serve_at(script, tokio_stream::once(Ok::<_, std::io::Error>(far)));
    let mut near = Some(TokioIo::new(near));
    let connector = tower::service_fn(move |_| {
        let near = near.take().ok_or_else(|| std::io::Error::other("connects once"));
        async { near }
    });
    let channel = Endpoint::from_static("http://fake").connect_with_connector(connector).await.unwrap();
    (Client::from_channel(channel), requests)
}

/// Serves those who come in; each gets the whole script.
pub(crate) fn serve_at<C>(
    script: Vec<Act>,
    incoming: impl Stream<Item = Result<C, std::io::Error>> + Send + 'static,
) -> mpsc::Receiver<attach_request::Request>
where
    C: AsyncRead + AsyncWrite + Connected + Unpin + Send + 'static,
{
    let (heard, requests) = mpsc::channel(100);
    let server = BrainLinkServiceServer::new(Fake { script, heard });
    tokio::spawn(Server::builder().add_service(server).serve_with_incoming(incoming));
    requests
}

struct Fake {
    script: Vec<Act>,
    heard: mpsc::Sender<attach_request::Request>,
}

#[tonic::async_trait]
impl BrainLinkService for Fake {
    type AttachStream = ReceiverStream<Result<AttachResponse, Status>>;

    async fn attach(
        &self,
        request: Request<Streaming<AttachRequest>>,
    ) -> Result<Response<Self::AttachStream>, Status> {
        let (said, responses) = mpsc::channel(100);
        let (script, heard, mut requests) = (self.script.clone(), self.heard.clone(), request.into_inner());
        tokio::spawn(async move {
            for act in script {
                match act {
                    Act::Say(response) => {
                        said.send(Ok(AttachResponse { response: Some(response) })).await.unwrap();
                    }
                    Act::Fail(status) => said.send(Err(status)).await.unwrap(),
                    Act::Hear => {
                        let Ok(Some(request)) = requests.message().await else { return };
                        heard.send(request.request.unwrap()).await.unwrap();
                    }
                }
            }
        });
        Ok(Response::new(ReceiverStream::new(responses)))
    }
}

/// A Welcome to these robots, each with an infra-red sensor and an odometer.
pub(crate) fn welcome(robots: &[&str]) -> Act {
    welcome_to(true, robots)
}

/// The same to a world that waits for its brains, or does not.
pub(crate) fn welcome_to(lockstep: bool, robots: &[&str]) -> Act {
    let robots = robots.iter().map(|robot| describe(robot)).collect();
    Act::Say(attach_response::Response::Welcome(v1::Welcome { step_ns: 10_000_000, lockstep, robots }))
}

pub(crate) fn describe(robot: &str) -> v1::RobotDescription {
    v1::RobotDescription {
        robot: robot.to_owned(),
        radius_m: 0.2,
        half_track_m: 0.2,
        wheel_radius_m: 0.1,
        signal_limit: Some(1.0),
        motor_encoding: encoding(v1::encoding::Kind::Signed(v1::encoding::Signed { bits: 8, limit: 1.0 })),
        sensors: vec![sensor("ir", &[""]), sensor("odometer", &["x_m", "y_m", "heading_rad"])],
        firmware: Some(v1::Firmware {
            protocol: Some(v1::firmware::Protocol::Framed(v1::firmware::Framed { ages: true })),
            period_ns: Some(20_000_000),
        }),
        baud: Some(9600),
        bits_per_character: Some(10),
        ..v1::RobotDescription::default()
    }
}

fn sensor(name: &str, components: &[&str]) -> v1::SensorDescription {
    let component = |name: &&str| v1::ComponentDescription {
        name: (*name).to_owned(),
        unit: "m".to_owned(),
        encoding: encoding(v1::encoding::Kind::Float64(v1::encoding::Float64 {})),
        count: 0,
    };
    v1::SensorDescription {
        sensor: name.to_owned(),
        components: components.iter().map(component).collect(),
        period_ns: 20_000_000,
        ..v1::SensorDescription::default()
    }
}

fn encoding(kind: v1::encoding::Kind) -> Option<v1::Encoding> {
    Some(v1::Encoding { kind: Some(kind) })
}

/// A turn for the first robot with these readings of its infra-red sensor.
pub(crate) fn turn(tick: u64, infrared: &[f64]) -> Act {
    let reading =
        |&value: &f64| v1::Reading { values: vec![value], readable: true, ..v1::Reading::default() };
    turn_of(tick, vec![v1::RobotTurn { readings: infrared.iter().map(reading).collect(), ..at(tick, 0) }])
}

pub(crate) fn turn_of(tick: u64, robots: Vec<v1::RobotTurn>) -> Act {
    Act::Say(attach_response::Response::Turn(v1::Turn { tick, robots, turn: number(tick), wall_clock: None }))
}

/// The number of the Turn of a tick; another than the tick, so that the two cannot be mixed up.
pub(crate) fn number(tick: u64) -> u64 {
    100 + tick
}

/// A turn of a robot to which nothing came.
pub(crate) fn at(tick: u64, robot: u32) -> v1::RobotTurn {
    v1::RobotTurn { robot, at_ns: tick * 10_000_000, ..v1::RobotTurn::default() }
}

pub(crate) fn ended(tick: u64) -> Act {
    Act::Say(attach_response::Response::Ended(v1::Ended { tick }))
}
