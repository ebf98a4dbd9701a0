//! Films that a page posts: `POST /film` with the film's bytes, or `POST /film?failed=1` with why there is none.

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, RawQuery, State};
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, post};
use baudbot_access::Door;
use tokio::sync::mpsc;

use super::Page;

/// The film of a page: its bytes, or why there is none.
pub type Film = Result<Vec<u8>, NoFilm>;

/// The reason why a page has made no film, in its own words.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoFilm(pub String);

/// The route for films.
pub(super) fn route(films: mpsc::Sender<Film>) -> MethodRouter<Page> {
    let hand_in = move |headers: HeaderMap, query: RawQuery, State(page): State<Page>, body: Bytes| async move {
        match page.admit(&headers, Door::Film) {
            Ok(_) => take(&films, query, body).await,
            Err(refusal) => refusal.into_response(),
        }
    };
    post(hand_in).layer(DefaultBodyLimit::max(MAX_BYTES))
}

async fn take(films: &mpsc::Sender<Film>, RawQuery(query): RawQuery, body: Bytes) -> Response {
    let failed = query.is_some_and(|query| query.split('&').any(|part| part == "failed=1"));
    let film = match failed {
        true => Err(NoFilm(String::from_utf8_lossy(&body[..body.len().min(MAX_REASON)]).trim().to_owned())),
        false => Ok(Vec::from(body)),
    };
    match films.send(film).await {
        Ok(()) => StatusCode::NO_CONTENT.into_response(),
        Err(_) => (StatusCode::GONE, "the server accepts no more films\n").into_response(),
    }
}

/// The longest film, in bytes: it is held in memory.
const MAX_BYTES: usize = 1 << 30;
/// The longest reason why there is none, in bytes.
const MAX_REASON: usize = 4096;
