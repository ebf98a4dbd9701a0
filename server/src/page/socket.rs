//! The page's WebSocket, which carries its calls ([`calls`](crate::calls)).

use std::pin::pin;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt, stream};
use prost::bytes::Bytes;
use tokio::sync::{mpsc, watch};
use tokio::time::MissedTickBehavior;

use crate::calls::{RESPONSES_AHEAD, take_calls};
use crate::limits::Peer;
use crate::pipe::Pipes;

/// The interval at which a page is pinged. A page that sends nothing for twice as long is gone.
const PING: Duration = Duration::from_secs(20);

/// The time that a page has to take the last responses.
const FAREWELL: Duration = Duration::from_secs(1);

/// Serves a page until it is gone, or the server stops.
pub(super) async fn serve(socket: WebSocket, pipes: Pipes, peer: Peer, mut stopped: watch::Receiver<bool>) {
    let Ok(channel) = pipes.channel(peer).await else { return };
    let (sink, stream) = socket.split();
    let (responses, queue) = mpsc::channel(RESPONSES_AHEAD);
    let requests = pin!(stream::unfold(stream, async |mut stream| Some((next(&mut stream).await?, stream))));
    let mut write = pin!(write(sink, queue));
    tokio::select! {
        () = take_calls(requests, channel, responses) => {}
        () = &mut write => return,
        _ = stopped.wait_for(|stopped| *stopped) => {}
    }
    // All calls are dropped by now, so nothing is written but what waits in the queue.
    let _ = tokio::time::timeout(FAREWELL, write).await;
}

/// The next request of a page; `None` once it is gone, or sends what no page sends.
async fn next(stream: &mut SplitStream<WebSocket>) -> Option<Bytes> {
    loop {
        match tokio::time::timeout(2 * PING, stream.next()).await.ok()?? {
            Ok(Message::Binary(bytes)) => return Some(bytes),
            // A pong shows that the page is still there.
            Ok(Message::Pong(_) | Message::Ping(_)) => {}
            Ok(Message::Text(_) | Message::Close(_)) | Err(_) => return None,
        }
    }
}

async fn write(mut sink: SplitSink<WebSocket, Message>, mut queue: mpsc::Receiver<Bytes>) {
    // Pings go out whatever else is sent: a page that only watches sends nothing but pongs.
    let mut ping = tokio::time::interval(PING);
    ping.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let message = tokio::select! {
            response = queue.recv() => match response {
                Some(response) => Message::Binary(response),
                None => break,
            },
            _ = ping.tick() => Message::Ping(Vec::new().into()),
        };
        if sink.send(message).await.is_err() {
            return;
        }
    }
    let close = CloseFrame { code: close_code::AWAY, reason: "the server has closed this page".into() };
    let _ = sink.send(Message::Close(Some(close))).await;
}
