//! The viewer: a page for browsers, on a port of its own, and the socket that it speaks over.
//!
//! The page comes with the program ([`files`]), and connects to nothing but this server. Its calls go through one WebSocket
//! ([`socket`]) to the same gRPC services that all other clients use ([`calls`](crate::calls)), over a pipe in memory: a page can do what
//! any program can that reaches the server, and not more.
//!
//! A page is the holder of a token, which it shows once for a [`session`].
//!
//! A browser also runs the pages of strangers. So that none of these can reach a server that its user can reach, the socket is
//! opened only to pages that came from here: their origin must be the host of the request, and that host one of the server's
//! own names ([`guard`]).
//!
//! Beside the page there is `/metrics`, for monitoring, with the same guard.
//!
//! A program that wants a film of a world starts a browser that makes one; the page then posts it ([`film`]).

mod files;
mod film;
mod guard;
mod session;
mod socket;

use crate::access::{Access, Caller};
use crate::audit::{AuditLog, Record};
use crate::calls::MAX_MESSAGE;
use crate::gate::{GatedListener, PageConnection, TcpEntry};
use crate::limits::{Account, Exceeded, Peer};
use crate::metrics::{self, Metrics};
use crate::pipe::Pipes;
use axum::Router;
use axum::extract::{ConnectInfo, Request, State, WebSocketUpgrade};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::serve::Listener;
use baudbot_access::Door;
pub use film::{Film, NoFilm};
pub(crate) use guard::Guard;
use session::Sessions;
use tokio::sync::{mpsc, watch};
use tonic::Status;

/// The services for pages.
pub(crate) struct Services {
    /// The pipes to the server's own services.
    pub(crate) pipes: Pipes,
    pub(crate) access: Access,
    pub(crate) audit: Option<AuditLog>,
    pub(crate) metrics: Metrics,
}

/// The context of the page's services.
#[derive(Clone)]
struct Page {
    pipes: Pipes,
    metrics: Metrics,
    guard: Guard,
    sessions: Sessions,
    audit: Option<AuditLog>,
    stopped: watch::Receiver<bool>,
}

/// Serves the page on this listener until the server stops. Films that pages post go to `films`, if the server takes any.
pub(crate) async fn serve(
    listener: GatedListener<TcpEntry>,
    guard: Guard,
    Services { pipes, access, audit, metrics }: Services,
    films: Option<mpsc::Sender<Film>>,
    mut stopped: watch::Receiver<bool>,
) {
    let port = listener.local_addr().map_or(0, |address| address.port());
    let sessions = Sessions::new(access, guard.is_secure(), port);
    let page = Page { pipes, metrics, guard, sessions, audit, stopped: stopped.clone() };
    let router = match films {
        Some(films) => Router::new().route("/film", film::route(films)),
        None => Router::new(),
    };
    let router = router
        .route("/page", get(open_socket))
        .route("/session", post(begin_session).get(tell_session))
        .route("/metrics", get(tell_metrics))
        .fallback(get(file))
        .layer(axum::middleware::from_fn_with_state(page.clone(), check_host))
        .layer(axum::middleware::from_fn(check_protocol))
        .layer(axum::middleware::from_fn_with_state(page.clone(), check_place))
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
/// only: one that is kept for further requests would take a place for nothing. What is refused behind it is noted.
async fn check_place(
    State(page): State<Page>,
    ConnectInfo(PageConnection(admission)): ConnectInfo<PageConnection>,
    request: Request,
    next: Next,
) -> Response {
    let path = request.uri().path().to_owned();
    let mut response = match admission.note_request() {
        Ok(()) => next.run(request).await,
        Err(exceeded) => refused(&exceeded),
    };
    if let Some(refused) = response.extensions().get() {
        page.note(refused, admission.tally().account(), &path);
    }
    if response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    }
    response
}

/// The answer to a request beyond a limit.
fn refused(exceeded: &Exceeded) -> Response {
    let text = format!("{exceeded}\n");
    let Some(after) = exceeded.retry_after else {
        return (StatusCode::SERVICE_UNAVAILABLE, text).into_response();
    };
    let seconds = after.as_millis().div_ceil(1000).to_string();
    (StatusCode::TOO_MANY_REQUESTS, [(header::RETRY_AFTER, seconds)], text).into_response()
}

/// Answers calls of gRPC, which have their own address, in their own way.
async fn check_protocol(request: Request, next: Next) -> Response {
    let kind = request.headers().get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    if kind.is_some_and(|kind| kind.starts_with(b"application/grpc")) {
        return Status::unimplemented(
            "the viewer's page is at this address; brains and observers connect to the address of --listen, which \
             `baudbot serve` prints as `listening on`",
        )
        .into_http();
    }
    next.run(request).await
}

async fn check_host(State(page): State<Page>, request: Request, next: Next) -> Response {
    match page.guard.check_host(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(error) => (StatusCode::FORBIDDEN, error.to_string()).into_response(),
    }
}

/// The reason why a request is not let in, and its caller.
struct Refusal {
    who: String,
    status: StatusCode,
    text: String,
}

/// The caller whose request was refused, and the status: for the audit log, on the way out.
#[derive(Clone)]
struct Refused(String, Status);

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let told = match self.status {
            StatusCode::UNAUTHORIZED => Status::unauthenticated(self.text.trim_end()),
            _ => Status::permission_denied(self.text.trim_end()),
        };
        let mut response = (self.status, self.text).into_response();
        response.extensions_mut().insert(Refused(self.who, told));
        response
    }
}

impl Page {
    /// The caller of a request, if it may come in this way.
    ///
    /// # Errors
    /// What it is answered.
    fn admit(&self, headers: &HeaderMap, door: Door) -> Result<Caller, Refusal> {
        let refusal = |who: &str, status, text: String| Refusal { who: who.to_owned(), status, text };
        let nobody = Caller::Nobody.name();
        self.guard
            .check_origin(headers)
            .map_err(|problem| refusal(nobody, StatusCode::FORBIDDEN, problem.to_owned()))?;
        let caller = self.sessions.caller(headers);
        let caller =
            caller.map_err(|refused| refusal(nobody, StatusCode::UNAUTHORIZED, format!("{refused}\n")))?;
        if let Caller::Holder(grant) = &caller {
            grant
                .may(door.needs())
                .map_err(|denied| refusal(caller.name(), StatusCode::FORBIDDEN, format!("{denied}\n")))?;
        }
        Ok(caller)
    }

    /// Notes that a request was refused.
    fn note(&self, Refused(who, status): &Refused, from: &Account, path: &str) {
        if let Some(log) = &self.audit {
            Record::new(log, who, from.to_string(), path).refuse(status);
        }
    }
}

async fn file(request: Request) -> Response {
    files::answer(request.uri().path())
}

async fn open_socket(
    State(page): State<Page>,
    ConnectInfo(PageConnection(admission)): ConnectInfo<PageConnection>,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    let caller = match page.admit(&headers, Door::PageSocket) {
        Ok(caller) => caller,
        Err(refusal) => return refusal.into_response(),
    };
    admission.note_known();
    // The requests of a page are counted as calls of gRPC are: for its token, or for its address.
    let account = Account::of(&caller, admission.tally().account());
    let peer = Peer { caller, account };
    let Page { pipes, stopped, .. } = page;
    upgrade
        .max_message_size(MAX_MESSAGE)
        .max_frame_size(MAX_MESSAGE)
        .on_upgrade(move |socket| socket::serve(socket, pipes, peer, stopped))
}

/// A session for a page that shows its token.
async fn begin_session(State(page): State<Page>, headers: HeaderMap) -> Response {
    if let Err(problem) = page.guard.check_origin(&headers) {
        return (StatusCode::FORBIDDEN, problem).into_response();
    }
    match page.sessions.begin(&headers) {
        Ok(cookie) => (StatusCode::NO_CONTENT, [(header::SET_COOKIE, cookie)]).into_response(),
        Err(refused) => Refusal {
            who: Caller::Nobody.name().to_owned(),
            status: StatusCode::UNAUTHORIZED,
            text: format!("{refused}\n"),
        }
        .into_response(),
    }
}

/// Whether a page may open its socket: a browser does not give its scripts the reason of a refusal.
async fn tell_session(State(page): State<Page>, headers: HeaderMap) -> Response {
    match page.admit(&headers, Door::PageSocket) {
        Ok(_) => (StatusCode::NO_CONTENT, [(header::CACHE_CONTROL, "no-store")]).into_response(),
        Err(refusal) => refusal.into_response(),
    }
}

async fn tell_metrics(State(page): State<Page>, headers: HeaderMap) -> Response {
    if let Err(refusal) = page.admit(&headers, Door::Metrics) {
        return refusal.into_response();
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
