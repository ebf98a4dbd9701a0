//! The ports of a robot: to its world they are a brain in RAW mode.

use std::collections::BTreeMap;

use baudbot_client::Channel;
use baudbot_fields::endpoint::Endpoint;
use baudbot_proto::v1;
use baudbot_proto::v1::attach_request::Request;
use baudbot_proto::v1::attach_response::Response;
use baudbot_proto::v1::brain_link_service_client::BrainLinkServiceClient;
use tokio::sync::mpsc::{Sender, UnboundedReceiver, UnboundedSender, channel, unbounded_channel};
use tokio_stream::wrappers::ReceiverStream;
use tonic::Streaming;

use crate::clock::{Ahead, Clock, now_unix_ns};
use crate::driver::{Order, Told};
use crate::error::PortError;
use crate::hold::Hold;
use crate::line::Line;
use crate::report::Report;
use baudbot_access::peer::Reach;
use baudbot_board::far_end::Settings;

/// Steps of one tick: the server takes 64.
const MOST_STEPS: usize = 32;

/// The serial ports of a robot, open for programs.
#[derive(Debug)]
pub struct RobotPorts {
    robot: v1::RobotDescription,
    step_ns: u64,
    lines: Vec<Line>,
    /// The lead of this machine's clock over the server's.
    ahead: Ahead,
    told: UnboundedReceiver<(usize, Told)>,
    requests: Sender<v1::AttachRequest>,
    responses: Streaming<v1::AttachResponse>,
}

/// An event at a port, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum News {
    /// A program has opened the port at this place.
    Opened(String),
    /// The port is no longer open in any program.
    Closed(String),
    /// A program has opened the port at this place and was sent away, as one has the cable at another port.
    Refused(String),
    /// The run is over; what is written is not obeyed.
    Ended,
}

impl RobotPorts {
    /// Takes hold of a robot, and opens ports at its cables: that of the microcontroller, or those of sensors' own. `reach` is about
    /// those over TCP; the files of others are this user's.
    ///
    /// # Errors
    /// If a port cannot be opened, the robot cannot be had, or its world does not follow the wall clock.
    pub async fn open(
        channel_: Channel,
        world: &str,
        robot: &str,
        ports: &[(Option<String>, Endpoint)],
        reach: Reach,
    ) -> Result<Self, PortError> {
        let (requests, stream) = channel(MOST_STEPS);
        let hello = v1::Hello {
            world: world.to_owned(),
            robots: vec![robot.to_owned()],
            mode: v1::PortMode::Raw.into(),
            brain: "serial port".to_owned(),
            serial_port: true,
            ..v1::Hello::default()
        };
        // There is room: the channel has just been made.
        drop(requests.send(request(Request::Hello(hello))).await);
        let mut client = BrainLinkServiceClient::new(channel_);
        let mut responses = client.attach(ReceiverStream::new(stream)).await?.into_inner();
        let welcome = match responses.message().await?.and_then(|response| response.response) {
            Some(Response::Welcome(welcome)) => welcome,
            Some(Response::Turn(_)) => return Err(PortError::Contract("a Turn")),
            Some(Response::Ended(_)) => return Err(PortError::Contract("the end of the run")),
            None => return Err(PortError::Contract("nothing")),
        };
        let Some(description) = welcome.robots.into_iter().next() else {
            return Err(PortError::Contract("a Welcome without robots"));
        };
        let (tell, told) = unbounded_channel();
        let lines = lines(&description, ports, reach, welcome.step_ns, &tell)?;
        Ok(Self {
            robot: description,
            step_ns: welcome.step_ns,
            lines,
            ahead: Ahead::default(),
            told,
            requests,
            responses,
        })
    }

    /// Name of the robot.
    pub fn robot(&self) -> &str {
        &self.robot.robot
    }

    /// The robot as the server describes it.
    pub fn description(&self) -> &v1::RobotDescription {
        &self.robot
    }

    /// Length of the world's tick, in nanoseconds. What a program writes enters the cable when the tick is over.
    pub fn step_ns(&self) -> u64 {
        self.step_ns
    }

    /// The places at which programs find the ports, in their order.
    pub fn places(&self) -> impl Iterator<Item = &str> {
        self.lines.iter().map(|line| line.place.as_str())
    }

    /// Passes bytes on until the server ends the stream, or `stop` is ready. Gives what each port has done.
    ///
    /// # Errors
    /// If the server ends the stream with an error.
    pub async fn serve(
        mut self,
        stop: impl Future<Output = ()>,
        mut news: impl FnMut(News),
    ) -> Result<Vec<(String, Report)>, PortError> {
        tokio::pin!(stop);
        let mut steps = 0;
        let error = loop {
            tokio::select! {
                response = self.responses.message() => match response {
                    Ok(Some(response)) => {
                        if let Some(Response::Ended(_)) = response.response {
                            news(News::Ended);
                        }
                        if let Some(Response::Turn(turn)) = response.response {
                            steps = 0;
                            if !self.pass_on(turn) {
                                break Some(PortError::NoClock);
                            }
                        }
                    }
                    Ok(None) => break None,
                    Err(status) => break Some(status.into()),
                },
                Some(first) = self.told.recv(), if steps < MOST_STEPS => {
                    for (number, told) in self.together(first) {
                        steps += 1;
                        self.send(number, told, &mut news).await;
                    }
                }
                () = &mut stop => break None,
            }
        };
        let reports = self.lines.into_iter().map(|line| (line.place.clone(), line.close())).collect();
        error.map_or(Ok(reports), Err)
    }

    /// The reports up to now; bytes of a port that follow each other are put together.
    fn together(&mut self, first: (usize, Told)) -> Vec<(usize, Told)> {
        let mut all = vec![first];
        while let Ok((number, told)) = self.told.try_recv() {
            match (all.last_mut(), told) {
                (Some((last, Told::Bytes(bytes))), Told::Bytes(more)) if *last == number => {
                    bytes.extend(more);
                }
                (_, told) => all.push((number, told)),
            }
        }
        all
    }

    /// Passes on what has arrived in a tick; `false` if the world does not follow the wall clock any more.
    fn pass_on(&mut self, turn: v1::Turn) -> bool {
        let begins_ns = turn.tick * self.step_ns;
        let Some(wall) = turn.wall_clock else { return false };
        let told_ns = wall.tick_begins_unix_ns.max(0) as u64;
        let ahead_ns = self.ahead.note(now_unix_ns() as i64 - told_ns as i64);
        let clock = Clock {
            sim_ns: begins_ns,
            unix_ns: told_ns.saturating_add_signed(ahead_ns),
            factor: wall.factor,
        };
        for part in turn.robots {
            let at = |baud| At { clock, begins_ns, baud };
            self.order(None, at(part.baud), (&part.raw, &part.raw_after_ns));
            for port in &part.ports {
                self.order(Some(port.sensor), at(port.baud), (&port.data, &port.after_ns));
            }
        }
        true
    }

    fn order(&self, sensor: Option<u32>, at: At, (data, after_ns): (&[u8], &[u64])) {
        let arrival = |(i, byte): (usize, &u8)| (at.begins_ns + after_ns.get(i).copied().unwrap_or(0), *byte);
        let bytes: Vec<_> = data.iter().enumerate().map(arrival).collect();
        for line in self.lines.iter().filter(|line| line.sensor == sensor) {
            line.order(Order::Bytes { clock: at.clock, baud: at.baud, bytes: bytes.clone() });
        }
    }

    async fn send(&self, number: usize, told: Told, news: &mut impl FnMut(News)) {
        let line = &self.lines[number];
        let mut step = v1::RobotStep::default();
        match told {
            Told::Opened => {
                news(News::Opened(line.place.clone()));
                step.opened = line.sensor.is_none();
            }
            Told::Closed => return news(News::Closed(line.place.clone())),
            Told::Refused => return news(News::Refused(line.place.clone())),
            Told::Bytes(bytes) => {
                line.sent(bytes.len());
                match line.sensor {
                    None => step.output = Some(v1::robot_step::Output::Raw(bytes)),
                    Some(sensor) => {
                        step.ports.push(v1::PortBytes {
                            sensor,
                            data: bytes,
                            after_ns: Vec::new(),
                            baud: None,
                        });
                    }
                }
            }
        }
        drop(self.requests.send(request(Request::Step(v1::Step { turn: 0, robots: vec![step] }))).await);
    }
}

/// Opens ports at cables of a robot; those at the same one share it.
fn lines(
    robot: &v1::RobotDescription,
    ports: &[(Option<String>, Endpoint)],
    reach: Reach,
    step_ns: u64,
    tell: &UnboundedSender<(usize, Told)>,
) -> Result<Vec<Line>, PortError> {
    let mut holds = BTreeMap::<Option<u32>, Hold>::new();
    let open = |(number, (device, place)): (usize, &(Option<String>, Endpoint))| {
        let (sensor, settings) = cable(robot, device.as_deref())?;
        let hold = holds.entry(sensor).or_insert_with(|| Hold::new(number)).beside(number);
        Line::open((sensor, place, reach), hold, settings, step_ns, (number, tell.clone()))
    };
    ports.iter().enumerate().map(open).collect()
}

/// The beginning of a tick, and the speed of the cable in it.
#[derive(Clone, Copy)]
struct At {
    clock: Clock,
    begins_ns: u64,
    baud: Option<u32>,
}

fn request(request: Request) -> v1::AttachRequest {
    v1::AttachRequest { request: Some(request) }
}

/// The cable of a robot's microcontroller or of a device: whose place it is, and how its UART is set, if it has one.
fn cable(
    robot: &v1::RobotDescription,
    device: Option<&str>,
) -> Result<(Option<u32>, Option<Settings>), PortError> {
    let settings = |baud: Option<u32>, bits: Option<u32>| Some(Settings::of_cable(baud?, bits.unwrap_or(10)));
    let Some(device) = device else {
        return Ok((None, settings(robot.baud, robot.bits_per_character)));
    };
    let found = robot.sensors.iter().position(|sensor| sensor.sensor == device);
    let port = found.and_then(|i| Some((i, robot.sensors[i].port?)));
    let Some((i, port)) = port else {
        let with_port = robot.sensors.iter().filter(|sensor| sensor.port.is_some());
        let names: Vec<_> = with_port.map(|sensor| sensor.sensor.as_str()).collect();
        let there_are = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        return Err(PortError::NoDevice { robot: robot.robot.clone(), device: device.to_owned(), there_are });
    };
    Ok((Some(i as u32), settings(port.baud, port.bits_per_character)))
}
