//! The viewer: a page for browsers, on a port of its own, and the socket that it speaks over.
//!
//! The page comes with the program ([`files`]), and connects to nothing but this server. Its calls go through one WebSocket
//! ([`socket`]) to the same gRPC services that all other clients use ([`method`]), over a pipe in memory: a page can do what
//! any program can that reaches the server, and not more.
//!
//! A browser also runs the pages of strangers. So that none of these can reach a server on the same machine, the socket is
//! opened only to pages that came from here: their origin must be the host of the request, and on loopback that host must
//! be a name of loopback ([`guard`]).
//!
//! Beside the page there is `/metrics`, for monitoring, with the same guard.
//!
//! A program that wants a film of a world starts a browser that makes one; the page then posts it ([`film`]).

mod files;
mod film;
mod guard;
mod method;
mod requests;
mod socket;

use crate::gate::{GatedListener, PageConnection};
use crate::metrics::{self, Metrics};
use crate::pipe::Pipes;
use axum::Router;
use axum::extract::{ConnectInfo, Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::serve::Listener;
pub use film::{Film, NoFilm};
use guard::Guard;
use tokio::net::TcpListener;
use tokio::sync::{mpsc, watch};

/// Bytes of the longest message of the socket: a scenario, and a little around it.
const MAX_MESSAGE: usize = baudbot_scenario::MAX_BYTES + (1 << 16);

/// The context of the page's services.
#[derive(Clone)]
struct Page {
    pipes: Pipes,
    metrics: Metrics,
    guard: Guard,
    stopped: watch::Receiver<bool>,
}

/// Serves the page on this listener until the server stops. `pipes` lead to the server's own services; films that pages post
/// go to `films`, if the server takes any.
pub(crate) async fn serve(
    listener: GatedListener<TcpListener>,
    pipes: Pipes,
    metrics: Metrics,
    films: Option<mpsc::Sender<Film>>,
    mut stopped: watch::Receiver<bool>,
) {
    let guard =
        Guard { loopback_only: listener.local_addr().is_ok_and(|address| address.ip().is_loopback()) };
    let page = Page { pipes, metrics, guard, stopped: stopped.clone() };
    let router = match films {
        Some(films) => Router::new().merge(film::router(films, guard)),
        None => Router::new(),
    };
    let router = router
        .route("/page", get(open_socket))
        .route("/metrics", get(tell_metrics))
        .fallback(get(file))
        .layer(axum::middleware::from_fn_with_state(page.clone(), check_host))
        .layer(axum::middleware::from_fn(check_place))
        .with_state(page)
        .into_make_service_with_connect_info::<PageConnection>();
    let stop = async move {
        let _ = stopped.wait_for(|stopped| *stopped).await;
    };
    if let Err(error) = axum::serve(listener, router).with_graceful_shutdown(stop).await {
        tracing::error!(%error, "the viewer's listener stopped");
    }
}

/// Lets a request pass if its connection has a place at the gate. The connection is for this request, or for its socket,
/// only: one that is kept for further requests would take a place for nothing.
async fn check_place(
    ConnectInfo(PageConnection(admission)): ConnectInfo<PageConnection>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match admission.note_call() {
        Ok(()) => next.run(request).await,
        Err(problem) => (StatusCode::SERVICE_UNAVAILABLE, format!("{problem}\n")).into_response(),
    };
    if response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

async fn check_host(State(page): State<Page>, request: Request, next: Next) -> Response {
    match page.guard.check_host(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(problem) => (StatusCode::FORBIDDEN, problem).into_response(),
    }
}

async fn file(request: Request) -> Response {
    files::answer(request.uri().path())
}

async fn open_socket(State(page): State<Page>, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    if let Err(problem) = page.guard.check_origin(&headers) {
        return (StatusCode::FORBIDDEN, problem).into_response();
    }
    let Page { pipes, stopped, .. } = page;
    upgrade
        .max_message_size(MAX_MESSAGE)
        .max_frame_size(MAX_MESSAGE)
        .on_upgrade(move |socket| socket::serve(socket, pipes, stopped))
}

async fn tell_metrics(State(page): State<Page>, headers: HeaderMap) -> Response {
    if let Err(problem) = page.guard.check_origin(&headers) {
        return (StatusCode::FORBIDDEN, problem).into_response();
    }
    let kind = [
        (header::CONTENT_TYPE, metrics::CONTENT_TYPE),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    match page.metrics.text().await {
        Ok(text) => (kind, text).into_response(),
        Err(problem) => (StatusCode::SERVICE_UNAVAILABLE, format!("{problem}\n")).into_response(),
    }
}
