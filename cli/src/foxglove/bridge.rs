//! A bridge from an observer's frames to the clients of Foxglove's protocol.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::{Context, bail};
use baudbot_proto::v1;
use baudbot_recording::foxglove::{FoxgloveEncoder, FoxgloveMessage};
use foxglove::websocket::{Capability, ChannelView, Client, ServerListener};
use foxglove::{PartialMetadata, RawChannel, SinkId, WebSocketServerHandle};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use crate::args::ConnectArgs;
use crate::error::from_server;
use crate::{connect, text};

/// Passes a world on until the server is gone.
pub(super) async fn serve(server: &ConnectArgs, at: SocketAddr) -> anyhow::Result<()> {
    let channel = connect::channel(server).await?;
    let v1::WorldStatus { world, time_ns, .. } = connect::world(channel.clone(), server).await?;
    let mut observe = connect::observe(channel);
    let described = observe.describe_world(v1::DescribeWorldRequest { world: world.clone() }).await;
    let described = described.map_err(|status| from_server(&status))?.into_inner();
    let details = described.robots.iter().take(DETAILS).map(|robot| robot.robot.clone()).collect();
    let request = v1::WatchRequest { world: world.clone(), details, ..Default::default() };
    let frames = observe.watch(request).await;
    let mut frames = frames.map_err(|status| from_server(&status))?.into_inner();

    let (subscribed, mut subscriptions) = unbounded_channel();
    let mut show = Show::start(&world, &described, at, Subscribed(subscribed)).await?;
    show.open(time_ns);
    loop {
        tokio::select! {
            // A new subscriber gets the next frame anyway: the last one goes before it, or would come twice.
            biased;
            Some((who, topic)) = subscriptions.recv() => show.again(who, &topic),
            frame = frames.message() => match frame.map_err(|status| from_server(&status))? {
                Some(frame) => show.frame(&frame),
                None => bail!("the server closed the connection"),
            },
        }
    }
}

/// The data that clients are shown.
struct Show {
    context: Arc<foxglove::Context>,
    server: WebSocketServerHandle,
    messages: FoxgloveEncoder,
    channels: BTreeMap<Arc<str>, Arc<RawChannel>>,
    /// The last message of each topic, for clients that connect late.
    last: BTreeMap<Arc<str>, FoxgloveMessage>,
    time_ns: u64,
    has_ended: bool,
}

impl Show {
    async fn start(
        world: &str,
        described: &v1::DescribeWorldResponse,
        at: SocketAddr,
        subscribed: Subscribed,
    ) -> anyhow::Result<Self> {
        let context = foxglove::Context::new();
        let server = context.websocket_server().name(format!("baudbot: {world}"));
        let server = server.capabilities([Capability::Time]).listener(Arc::new(subscribed));
        let server = server.bind(at.ip().to_string(), at.port()).start().await;
        let server = server.with_context(|| format!("--foxglove={at}: cannot listen there"))?;
        let at = SocketAddr::new(at.ip(), server.port());
        text::print(&format!("world {world} for Foxglove: ws://{at}\nin a browser: {}\n", server.app_url()))?;
        let messages = FoxgloveEncoder::new(described);
        let (channels, last) = (BTreeMap::new(), BTreeMap::new());
        Ok(Self { context, server, messages, channels, last, time_ns: 0, has_ended: false })
    }

    /// Everything that stands still, and the shapes of robots.
    fn open(&mut self, time_ns: u64) {
        self.messages.opening(time_ns).into_iter().for_each(|message| self.log(message));
    }

    fn frame(&mut self, frame: &v1::WatchResponse) {
        if frame.time_ns < self.time_ns {
            // A reset: what was shown of the time that is to come is wrong.
            self.last.clear();
            self.has_ended = false;
            self.server.clear_session(None);
            self.open(frame.time_ns);
        }
        self.time_ns = frame.time_ns;
        self.server.broadcast_time(frame.time_ns);
        self.log(FoxgloveMessage::of_frame(frame));
        let messages = self.messages.frame(frame);
        messages.into_iter().for_each(|message| self.log(message));
        for (kind, text) in self.events(frame) {
            let message = self.messages.event(frame.time_ns, kind, &text);
            self.log(message);
        }
    }

    fn events(&mut self, frame: &v1::WatchResponse) -> Vec<(v1::ReplayEventKind, String)> {
        let hits = frame.collisions.iter();
        let hits =
            hits.map(|hit| (v1::ReplayEventKind::Collision, format!("{} ran into {}", hit.robot, hit.with)));
        let mut events: Vec<_> = hits.collect();
        let has_ended = !frame.ending.is_empty();
        if has_ended && !std::mem::replace(&mut self.has_ended, has_ended) {
            events.push((v1::ReplayEventKind::Ending, frame.ending.clone()));
        }
        events
    }

    fn log(&mut self, message: FoxgloveMessage) {
        let channel = self.channels.entry(Arc::clone(&message.topic)).or_insert_with(|| {
            let channel = self.context.channel_builder(&*message.topic).schema(message.schema.clone());
            let channel = channel.message_encoding(&message.schema.encoding).build_raw();
            channel.expect("a channel with a schema and an encoding")
        });
        channel.log_with_meta(&message.data, PartialMetadata::with_log_time(message.time_ns));
        self.last.insert(Arc::clone(&message.topic), message);
    }

    /// The last message of a topic, for a client that has just subscribed to it: it would otherwise miss messages that are
    /// sent once, and a world that stands sends none.
    fn again(&self, who: Option<SinkId>, topic: &str) {
        if let (Some(channel), Some(message)) = (self.channels.get(topic), self.last.get(topic)) {
            let time = PartialMetadata::with_log_time(message.time_ns);
            channel.log_with_meta_to_sink(&message.data, time, who);
        }
    }
}

/// Reports which client has subscribed to which topic.
struct Subscribed(UnboundedSender<(Option<SinkId>, String)>);

impl ServerListener for Subscribed {
    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        // The send fails only if the receiver is gone, and then there is nothing to show.
        let _ = self.0.send((client.sink_id(), channel.topic().to_owned()));
    }
}

/// The most robots for which a server sends details.
const DETAILS: usize = 64;
