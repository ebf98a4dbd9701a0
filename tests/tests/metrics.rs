//! `/metrics` as Prometheus meets it.

use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use baudbot_proto::v1;
use baudbot_proto::v1::observe_service_client::ObserveServiceClient;
use baudbot_server::{Pace, Server, WatchdogPolicy, WorldConfig};
use baudbot_tests::system::{client, drive, lockstep, operator, status, watched};
use baudbot_tests::{WANDER, scenario};
use prometheus_parse::{Sample, Scrape, Value};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tonic::Code;

async fn serve(pace: Pace) -> Server {
    let world = WorldConfig::new("w", scenario(WANDER, &[])).pace(pace);
    let free = SocketAddr::from(([127, 0, 0, 1], 0));
    Server::builder().world(world).viewer(free).serve().await.unwrap()
}

/// The answer to a request for `/metrics` with these headers besides: its head and its body.
async fn ask(server: &Server, headers: &str) -> (String, String) {
    let mut stream = TcpStream::connect(server.viewers()[0]).await.unwrap();
    let request = format!("GET /metrics HTTP/1.1\r\n{headers}Connection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    let read = tokio::time::timeout(Duration::from_secs(20), stream.read_to_string(&mut answer));
    read.await.unwrap().unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.to_owned(), body.to_owned())
}

/// The result of a scrape.
struct Metrics(Scrape);

impl Metrics {
    async fn of(server: &Server) -> Self {
        let (head, body) = ask(server, "Host: 127.0.0.1\r\n").await;
        assert!(head.starts_with("HTTP/1.1 200 OK"), "{head}");
        assert!(head.contains("content-type: text/plain; version=0.0.4"), "{head}");
        Self(Scrape::parse(body.lines().map(|line| Ok(line.to_owned()))).unwrap())
    }

    fn find(&self, name: &str, labels: &[(&str, &str)]) -> Option<&Sample> {
        let fits = |sample: &&Sample| {
            sample.metric == name
                && sample.labels.len() == labels.len()
                && labels.iter().all(|(label, value)| sample.labels.get(label) == Some(value))
        };
        self.0.samples.iter().find(fits)
    }

    /// The value of a counter or a gauge.
    fn value(&self, name: &str, labels: &[(&str, &str)]) -> f64 {
        let sample = self.find(name, labels).unwrap_or_else(|| panic!("no {name} with {labels:?}"));
        match (&sample.value, name.ends_with("_total")) {
            (Value::Counter(value), true) | (Value::Gauge(value), false) => *value,
            (other, _) => panic!("{name} is {other:?}"),
        }
    }

    fn of_world(&self, name: &str) -> f64 {
        self.value(name, &[("world", "w")])
    }

    fn of_robot(&self, name: &str) -> f64 {
        self.value(name, &[("world", "w"), ("robot", "robot")])
    }
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// A world that stands: its status, and its metrics.
async fn standing(server: &Server) -> (v1::WorldStatus, Metrics) {
    loop {
        // A tick that was under way when the world was paused is still done.
        let before = status(server).await;
        let metrics = Metrics::of(server).await;
        if status(server).await == before {
            return (before, metrics);
        }
    }
}

fn compare_line(metrics: &Metrics, direction: &str, line: &v1::LineStatus) {
    let expected = [
        ("bytes_total", line.bytes),
        ("messages_total", line.messages),
        ("lost_bytes_total", line.lost_bytes),
        ("overrun_bytes_total", line.overrun_bytes),
        ("refused_bytes_total", line.refused_bytes),
        ("corrupted_bytes_total", line.corrupted_bytes),
        ("bad_frames_total", line.bad_frames),
        ("bad_messages_total", line.bad_messages),
    ];
    for (name, value) in expected {
        let labels = [("world", "w"), ("robot", "robot"), ("direction", direction)];
        let found = metrics.value(&format!("baudbot_link_{name}"), &labels);
        assert_eq!(found, value as f64, "{name} {direction}");
    }
}

fn compare(metrics: &Metrics, status: &v1::WorldStatus) {
    let (pacing, robot) = (status.pacing.as_ref().unwrap(), &status.robots[0]);
    let (cycles, battery) = (robot.cycles.as_ref().unwrap(), &robot.battery);
    assert!(battery.is_none() && status.tick > 100 && robot.turns > 100 && cycles.late > 0, "{status:?}");
    for (name, value) in [
        ("ticks_total", status.tick as f64),
        ("simulated_seconds_total", seconds(status.time_ns)),
        ("running_seconds_total", seconds(status.running_wall_ns)),
        ("step_seconds", seconds(status.step_ns)),
        ("tick_overruns_total", pacing.late_ticks as f64),
        ("watchdog_timeouts_total", pacing.watchdog_timeouts as f64),
        ("brain_wait_seconds_total", seconds(pacing.waiting_wall_ns)),
        ("robots", 1.0),
        ("robots_left_out", 0.0),
        ("up", 1.0),
    ] {
        let found = metrics.of_world(&format!("baudbot_world_{name}"));
        assert!((found - value).abs() <= value * 1e-12, "{name}: {found} is not {value}");
    }
    for (name, value) in [
        ("baudbot_robot_turns_total", robot.turns as f64),
        ("baudbot_robot_commands_total", robot.commands as f64),
        ("baudbot_robot_collisions_total", robot.collisions as f64),
        ("baudbot_robot_distance_meters_total", robot.distance_m),
        ("baudbot_robot_reading_frames_missed_total", robot.frames_missed as f64),
        ("baudbot_brain_attached", f64::from(u8::from(robot.attached))),
        ("baudbot_brain_deliveries_lost_total", robot.lost_deliveries as f64),
        ("baudbot_brain_cycle_deadline_seconds", seconds(cycles.deadline_ns)),
    ] {
        assert_eq!(metrics.of_robot(name), value, "{name}");
    }
    compare_line(metrics, "up", robot.uplink.as_ref().unwrap());
    compare_line(metrics, "down", robot.downlink.as_ref().unwrap());
    let outcome = |outcome| {
        let labels = [("world", "w"), ("robot", "robot"), ("outcome", outcome)];
        metrics.value("baudbot_brain_cycles_total", &labels)
    };
    let outcomes = ["kept", "late", "unanswered"].map(outcome);
    assert_eq!(outcomes, [cycles.kept, cycles.late, cycles.unanswered].map(|n| n as f64));
    compare_durations(metrics, cycles.durations.as_ref().unwrap());
}

fn compare_durations(metrics: &Metrics, durations: &v1::Durations) {
    let labels = [("world", "w"), ("robot", "robot")];
    let sample = metrics.find("baudbot_brain_cycle_seconds", &labels).unwrap();
    let Value::Summary(quantiles) = &sample.value else { panic!("{sample:?}") };
    let found: Vec<_> = quantiles.iter().map(|quantile| (quantile.quantile, quantile.count)).collect();
    let v1::Durations { p50_ns, p95_ns, p99_ns, count, .. } = durations;
    let expected = [(0.5, p50_ns), (0.95, p95_ns), (0.99, p99_ns)].map(|(q, ns)| (q, seconds(*ns)));
    assert_eq!(found, expected);
    let counted = metrics.find("baudbot_brain_cycle_seconds_count", &labels).unwrap();
    assert!(matches!(counted.value, Value::Untyped(n) if n == *count as f64), "{counted:?}");
}

fn states(metrics: &Metrics) -> BTreeMap<&str, f64> {
    let state = |sample: &Sample| sample.metric == "baudbot_world_state";
    let states = metrics.0.samples.iter().filter(|sample| state(sample));
    states
        .map(|sample| match sample.value {
            Value::Gauge(value) => (sample.labels.get("state").unwrap(), value),
            _ => panic!("{sample:?}"),
        })
        .collect()
}

#[tokio::test]
async fn metrics_are_what_the_operator_is_told() {
    let server = serve(lockstep()).await;
    let (client, mut operator) = (client(&server).await, operator(&server).await);
    let brain = tokio::spawn(async move { drive(&client, "robot", "avoid", 1).await });
    while status(&server).await.tick < 300 {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    operator.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    let (paused, metrics) = standing(&server).await;
    compare(&metrics, &paused);
    let paused = [("ended", 0.0), ("paused", 1.0), ("running", 0.0), ("waiting_for_brains", 0.0)];
    assert_eq!(states(&metrics), BTreeMap::from(paused));
    // `avoid` is asked once a message, and not at the other steps.
    let answers = metrics.of_robot("baudbot_brain_answers_total");
    assert!(answers > 100.0 && answers < metrics.of_robot("baudbot_robot_turns_total"), "{answers}");
    assert!(metrics.of_robot("baudbot_brain_answer_seconds_total") > 0.0);
    brain.abort();
    server.shutdown().await;
}

#[tokio::test]
async fn lateness_is_counted_in_seconds_by_the_wall_clock() {
    let server = serve(Pace::REAL_TIME).await;
    while status(&server).await.tick < 30 {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    operator(&server).await.pause_world(v1::PauseWorldRequest { world: "w".into() }).await.unwrap();
    let (paused, metrics) = standing(&server).await;
    let sample = metrics.find("baudbot_world_tick_lateness_seconds", &[("world", "w")]).unwrap();
    let Value::Histogram(buckets) = &sample.value else { panic!("{sample:?}") };
    let told = paused.pacing.unwrap().lateness_us_log2;
    let mut up_to = 0;
    for (log2, n) in told.iter().enumerate() {
        up_to += n;
        assert_eq!(buckets[log2].less_than, 1e-6 * f64::from(1u32 << log2));
        assert_eq!(buckets[log2].count, up_to as f64, "{told:?}");
    }
    let last = buckets.last().unwrap();
    assert!(last.less_than.is_infinite() && last.count == up_to as f64 && up_to >= 30, "{last:?}, {told:?}");
    let sum = metrics.find("baudbot_world_tick_lateness_seconds_sum", &[("world", "w")]).unwrap();
    assert!(matches!(sum.value, Value::Untyped(sum) if sum > 0.0), "{sum:?}");
    server.shutdown().await;
}

#[tokio::test]
async fn a_brain_that_does_not_answer_is_seen_while_it_does_not() {
    let server = serve(watched(600_000, WatchdogPolicy::Wait)).await;
    // The Turn is open before the brain knows that it is attached.
    let begun = Instant::now();
    let _silent = client(&server).await.attach("w", "robot").await.unwrap();
    let metrics = loop {
        let metrics = Metrics::of(&server).await;
        if metrics.of_robot("baudbot_brain_oldest_open_turn_seconds") > 0.3 {
            break metrics;
        }
        assert!(begun.elapsed() < Duration::from_secs(20));
    };
    assert_eq!(metrics.of_robot("baudbot_brain_open_turns"), 1.0);
    assert_eq!(metrics.of_robot("baudbot_brain_answers_total"), 0.0);
    assert_eq!(metrics.of_robot("baudbot_brain_attached"), 1.0);
    assert!(metrics.of_robot("baudbot_brain_oldest_open_turn_seconds") <= begun.elapsed().as_secs_f64());
    server.shutdown().await;
}

#[tokio::test]
async fn observers_and_what_they_miss_are_counted_also_when_they_are_gone() {
    let server = serve(Pace::Free).await;
    let mut observer = ObserveServiceClient::new(server.channel().await.unwrap());
    let request = v1::WatchRequest {
        world: "w".into(),
        every_ticks: 1,
        details: vec!["robot".into()],
        ..Default::default()
    };
    let unread = observer.watch(request).await.unwrap();
    let frames_missed = "baudbot_world_observer_frames_missed_total";
    let mut metrics = Metrics::of(&server).await;
    assert_eq!(metrics.of_world("baudbot_world_observers"), 1.0);
    let begun = Instant::now();
    while metrics.of_world(frames_missed) == 0.0 {
        assert!(begun.elapsed() < Duration::from_secs(20));
        metrics = Metrics::of(&server).await;
    }
    let missed = metrics.of_world(frames_missed);
    drop((unread, observer));
    while metrics.of_world("baudbot_world_observers") > 0.0 {
        assert!(begun.elapsed() < Duration::from_secs(40));
        metrics = Metrics::of(&server).await;
    }
    assert!(metrics.of_world(frames_missed) >= missed);
    server.shutdown().await;
}

#[tokio::test]
async fn a_world_that_is_deleted_is_gone_and_names_cannot_leave_their_labels() {
    let server = serve(lockstep()).await;
    let mut operator = operator(&server).await;
    let mut create = async |world: &str, scenario_toml: &str| {
        let (world, scenario_toml) = (world.to_owned(), scenario_toml.to_owned());
        operator.create_world(v1::CreateWorldRequest { world, scenario_toml, ..Default::default() }).await
    };
    create("second", WANDER).await.unwrap();
    for name in ["a\"b", "a\nb", "a}b", "a\\b", ""] {
        let hostile = WANDER.replace("name = \"robot\"", &format!("name = {name:?}"));
        assert_eq!(create("third", &hostile).await.unwrap_err().code(), Code::InvalidArgument, "{name:?}");
        if !name.is_empty() {
            assert_eq!(create(name, WANDER).await.unwrap_err().code(), Code::InvalidArgument, "{name:?}");
        }
    }
    let worlds = |metrics: &Metrics| {
        let names = metrics.0.samples.iter().filter_map(|sample| sample.labels.get("world"));
        names.map(str::to_owned).collect::<BTreeSet<_>>()
    };
    let metrics = Metrics::of(&server).await;
    assert_eq!(worlds(&metrics), BTreeSet::from(["second".to_owned(), "w".to_owned()]));
    assert_eq!(metrics.value("baudbot_worlds", &[]), 2.0);
    operator.delete_world(v1::DeleteWorldRequest { world: "second".into() }).await.unwrap();
    let metrics = Metrics::of(&server).await;
    assert_eq!(worlds(&metrics), BTreeSet::from(["w".to_owned()]));
    assert_eq!(metrics.value("baudbot_worlds", &[]), 1.0);
    server.shutdown().await;
}

#[tokio::test]
async fn pages_of_strangers_get_no_metrics() {
    let server = serve(lockstep()).await;
    let own = format!("Host: {0}\r\nOrigin: http://{0}\r\n", server.viewers()[0]);
    for (headers, expected) in [
        ("Host: localhost\r\n", "200"),
        (own.as_str(), "200"),
        ("Host: localhost\r\nOrigin: http://evil.example\r\n", "403"),
        ("Host: localhost\r\nOrigin: null\r\n", "403"),
        ("Host: evil.example\r\n", "403"),
    ] {
        let (head, body) = ask(&server, headers).await;
        assert!(head.starts_with(&format!("HTTP/1.1 {expected}")), "{headers}: {head}");
        assert_eq!(body.contains("baudbot_"), expected == "200", "{headers}: {body}");
    }
    server.shutdown().await;
}

/// Names that are in a text.
fn names(text: &str) -> BTreeSet<&str> {
    let words = text.split(|c: char| !c.is_ascii_lowercase() && c != '_');
    words.filter(|word| word.starts_with("baudbot_") && word.len() > 8).collect()
}

#[tokio::test]
async fn all_metrics_are_explained() {
    let server = serve(lockstep()).await;
    let (_, body) = ask(&server, "Host: localhost\r\n").await;
    let of = |start| {
        move |line: &str| line.strip_prefix(start).map(|rest| rest.split(' ').next().unwrap().to_owned())
    };
    let typed: BTreeSet<_> = body.lines().filter_map(of("# TYPE ")).collect();
    let helped: BTreeSet<_> = body.lines().filter_map(of("# HELP ")).collect();
    assert_eq!(typed, helped);
    assert!(typed.len() > 30, "{typed:?}");
    let docs = include_str!("../../docs/reference/metrics.md");
    let rows: String = docs.lines().filter(|line| line.starts_with("| `")).collect();
    assert_eq!(names(&rows), typed.iter().map(String::as_str).collect());
    // The metrics of the examples are there.
    let suffixes = ["", "_bucket", "_sum", "_count"];
    let (docs, _) = docs.split_once("## The log").unwrap();
    for name in names(docs) {
        assert!(
            suffixes.iter().any(|s| name.strip_suffix(s).is_some_and(|name| typed.contains(name))),
            "{name}"
        );
    }
    server.shutdown().await;
}
