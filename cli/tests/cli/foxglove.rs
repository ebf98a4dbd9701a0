//! `baudbot watch --foxglove`, as Foxglove sees it.

use crate::cli::baudbot;

mod live {
    use baudbot_proto::v1;
    use futures_util::{SinkExt, StreamExt};
    use prost::Message as _;
    use serde_json::{Value, json};
    use tokio::net::TcpStream;
    use tokio_tungstenite::tungstenite::Message;
    use tokio_tungstenite::tungstenite::client::IntoClientRequest;
    use tokio_tungstenite::{MaybeTlsStream, WebSocketStream};

    use crate::cli::Running;
    use crate::cli::processes::serve;

    /// A client that has connected, by <https://github.com/foxglove/ws-protocol>.
    struct Foxglove {
        socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
        /// The channels that were offered.
        channels: Vec<Value>,
    }

    impl Foxglove {
        async fn connect(at: &str) -> Self {
            let mut request = at.into_client_request().unwrap();
            request.headers_mut().insert("sec-websocket-protocol", "foxglove.sdk.v1".parse().unwrap());
            let (socket, _) = tokio_tungstenite::connect_async(request).await.unwrap();
            Self { socket, channels: Vec::new() }
        }

        async fn next(&mut self) -> Message {
            let message = tokio::time::timeout(std::time::Duration::from_secs(20), self.socket.next()).await;
            message.expect("something is sent").unwrap().unwrap()
        }

        /// Subscribes to a topic when it is offered.
        async fn subscribe(&mut self, topic: &str, id: u32) -> Value {
            loop {
                if let Some(channel) = self.channels.iter().find(|channel| channel["topic"] == topic) {
                    let subscriptions = json!([{ "id": id, "channelId": channel["id"] }]);
                    let subscribe = json!({ "op": "subscribe", "subscriptions": subscriptions });
                    self.socket.send(Message::text(subscribe.to_string())).await.unwrap();
                    return channel.clone();
                }
                self.take_channels().await;
            }
        }

        async fn take_channels(&mut self) {
            if let Message::Text(text) = self.next().await {
                let message: Value = serde_json::from_str(&text).unwrap();
                if let Some(channels) = message["channels"].as_array() {
                    self.channels.extend(channels.iter().cloned());
                }
            }
        }

        /// The next message of a subscription, and its time.
        async fn message(&mut self, id: u32) -> (u64, Vec<u8>) {
            loop {
                if let Message::Binary(data) = self.next().await
                    && data[0] == 1
                    && data[1..5] == id.to_le_bytes()
                {
                    return (u64::from_le_bytes(data[5..13].try_into().unwrap()), data[13..].to_vec());
                }
            }
        }
    }

    #[tokio::test]
    async fn a_world_is_there_for_who_comes_early_and_for_who_comes_late() {
        let (_server, tcp, _) = serve("foxglove.sock", &["wander"]);
        let mut bridge = Running::start(&["watch", "--connect", &tcp, "--foxglove=127.0.0.1:0"]);
        let line = bridge.lines_until("world").remove(0);
        let at = line.strip_prefix("world wander for Foxglove: ").expect("an address").to_owned();

        let mut early = Foxglove::connect(&at).await;
        let channel = early.subscribe("/baudbot/frames", 7).await;
        assert_eq!(
            (&channel["encoding"], &channel["schemaName"]),
            (&json!("protobuf"), &json!("baudbot.v1.WatchResponse"))
        );
        let mut last = None;
        for _ in 0..5 {
            let (time_ns, data) = early.message(7).await;
            let frame = v1::WatchResponse::decode(data.as_slice()).unwrap();
            assert_eq!((frame.time_ns, frame.robots.len(), frame.details.len()), (time_ns, 1, 1));
            // The first may be of the beginning.
            assert!(last < Some(time_ns));
            last = Some(time_ns);
        }
        let last = last.unwrap();

        let mut late = Foxglove::connect(&at).await;
        let channel = late.subscribe("/scene/arena", 3).await;
        assert_eq!(channel["schemaName"], "foxglove.SceneUpdate");
        let (time_ns, arena) = late.message(3).await;
        assert!(time_ns < last && !arena.is_empty(), "it was said once, before");
        late.subscribe("/tf", 4).await;
        assert!(late.message(4).await.0 >= last);
    }

    #[tokio::test]
    async fn a_world_that_stands_is_there_too() {
        let (_server, tcp, _) = serve("foxglove-paused.sock", &["wander", "--paused"]);
        let mut bridge = Running::start(&["watch", "--connect", &tcp, "--foxglove=127.0.0.1:0"]);
        let at = bridge.lines_until("world").remove(0).replace("world wander for Foxglove: ", "");
        let mut foxglove = Foxglove::connect(&at).await;
        for (id, topic) in [(1, "/scene/arena"), (2, "/scene/robots")] {
            foxglove.subscribe(topic, id).await;
            assert_eq!(foxglove.message(id).await.0, 0, "{topic}");
        }
    }
}

#[test]
fn foxglove_is_shown_a_world_on_this_machine_only() {
    let (code, _, err) = baudbot(&["watch", "--foxglove=0.0.0.0:8765"]);
    assert_eq!(code, 2, "{err}");
    assert!(err.contains("only addresses of this machine are allowed, such as 127.0.0.1:8765"), "{err}");
}
