//! Programs that drive until their run is over, and come back to a server that they have lost.

use std::cell::Cell;
use std::convert::Infallible;

use baudbot_client::{Action, Attachment, Brain, Reconnect, Signals, Turn};
use baudbot_server::{Address, Server, WorldConfig};
use baudbot_tests::system::{client, lockstep, serve as serve_world, status, strict};
use baudbot_tests::{WANDER, crowd, scenario};
use tokio::sync::mpsc;

/// A brain that keeps still.
struct Still;

impl Brain for Still {
    fn step(&mut self, _: &Turn) -> Action {
        Action::wait()
    }
}

/// A server with the world `w` on this socket, whose run takes so many seconds of simulated time.
async fn serve(address: &Address, seconds: f64) -> Server {
    let scenario = scenario(WANDER, &[&format!("end.after_s={seconds:?}")]);
    let world = WorldConfig::new("w", scenario).pace(lockstep());
    Server::builder().world(world).listen(address.clone()).serve().await.expect("a server")
}

fn attachment(name: &str, reconnect: Reconnect) -> (Address, Attachment) {
    let socket = std::env::temp_dir().join(format!("baudbot-{name}-{}.sock", std::process::id()));
    let address = Address::Unix(socket);
    let attachment = Attachment {
        credentials: None,
        connect: address.to_string(),
        world: "w".to_owned(),
        robots: vec!["robot".to_owned()],
        brain: "still".to_owned(),
        thinks_as_scenario: false,
        reconnect,
    };
    (address, attachment)
}

#[tokio::test]
async fn a_program_comes_back_to_a_server_that_was_started_again_with_a_new_brain() {
    let (address, attachment) = attachment("back", Reconnect::default());
    let first = serve(&address, 1e8).await;
    let made = Cell::new(0);
    let make = |_: &_| {
        made.set(made.get() + 1);
        Ok::<_, Infallible>(Still)
    };
    let (told, mut lines) = mpsc::unbounded_channel();
    let driving = attachment.drive(make, |line| told.send(line.to_owned()).expect("somebody listens"));
    let server = async {
        assert_eq!(lines.recv().await.unwrap(), "driving robot of world w");
        first.shutdown().await;
        let lost = lines.recv().await.unwrap();
        assert!(lost.ends_with("; trying to reconnect for 600 s"), "{lost}");
        let second = serve(&address, 1.0).await;
        let back = lines.recv().await.unwrap();
        assert_eq!(back, "reconnected with a restarted brain: driving robot of world w");
        second
    };
    let (driven, second) = tokio::join!(driving, server);
    assert_eq!(driven.unwrap().last_tick, 99);
    assert_eq!(made.get(), 2);
    second.shutdown().await;
}

#[tokio::test]
async fn a_program_that_is_not_to_come_back_ends_with_its_server() {
    let (address, attachment) = attachment("off", Reconnect::Off);
    let server = serve(&address, 1e8).await;
    let (told, mut lines) = mpsc::unbounded_channel();
    let make = |_: &_| Ok::<_, Infallible>(Still);
    let driving = attachment.drive(make, |line| told.send(line.to_owned()).expect("somebody listens"));
    let closing = async {
        assert_eq!(lines.recv().await.unwrap(), "driving robot of world w");
        server.shutdown().await;
    };
    let (driven, ()) = tokio::join!(driving, closing);
    driven.unwrap_err();
    assert!(lines.try_recv().is_err(), "it tells nothing of an attempt");
}

#[tokio::test]
async fn a_brain_that_cannot_be_made_ends_the_program() {
    let (address, attachment) = attachment("unmade", Reconnect::default());
    let server = serve(&address, 1e8).await;
    let make = |_: &_| Err::<Still, _>("the robot has no laser");
    let error = attachment.drive(make, |line| panic!("{line}")).await.unwrap_err();
    assert_eq!(error.to_string(), "the robot has no laser");
    server.shutdown().await;
}

#[tokio::test]
async fn a_tick_that_two_brains_have_left_waits_for_both_of_their_successors() {
    let names = ["r0", "r1"].map(str::to_owned);
    let server = serve_world(scenario(&crowd(&names), &[]), strict()).await;
    let client = client(&server).await;
    let [mut first, mut second] =
        [client.attach("w", "r0").await.unwrap(), client.attach("w", "r1").await.unwrap()];
    for _ in 0..5 {
        for robot in [&mut first, &mut second] {
            robot.turn().await.unwrap().unwrap();
        }
        for robot in [&mut first, &mut second] {
            robot.drive(Signals { left: 0.3, right: 0.2 }).await.unwrap();
        }
    }
    let open = first.turn().await.unwrap().unwrap().tick;
    assert_eq!(second.turn().await.unwrap().unwrap().tick, open);
    drop((first, second));
    while status(&server).await.robots.iter().any(|robot| robot.attached) {
        tokio::task::yield_now().await;
    }
    let mut first = client.attach("w", "r0").await.unwrap();
    assert_eq!(first.turn().await.unwrap().unwrap().tick, open);
    first.drive(Signals { left: 0.3, right: 0.2 }).await.unwrap();
    // The Step is on its way; the tick does not end with it.
    tokio::time::sleep(std::time::Duration::from_millis(100)).await;
    assert_eq!(status(&server).await.tick, open);
    let mut second = client.attach("w", "r1").await.unwrap();
    assert_eq!(second.turn().await.unwrap().unwrap().tick, open, "nobody has answered it yet");
    server.shutdown().await;
}
