//! The page's files, which are built from `viewer/` and are part of the program.

use axum::http::{HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Path, type and content.
const FILES: [(&str, &str, &[u8]); 3] = [
    ("/", "text/html; charset=utf-8", include_bytes!("../../../viewer/dist/index.html")),
    ("/viewer.js", "text/javascript; charset=utf-8", include_bytes!("../../../viewer/dist/viewer.js")),
    ("/viewer.css", "text/css; charset=utf-8", include_bytes!("../../../viewer/dist/viewer.css")),
];

/// The page loads nothing from elsewhere, no text becomes a script, and no other page shows this one in a frame.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const HEADERS: [(HeaderName, &str); 4] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::REFERRER_POLICY, "no-referrer"),
    // The next program may have another page.
    (header::CACHE_CONTROL, "no-cache"),
];

pub(super) fn answer(path: &str) -> Response {
    match FILES.iter().find(|(own, ..)| *own == path) {
        Some((_, kind, content)) => (HEADERS, [(header::CONTENT_TYPE, *kind)], *content).into_response(),
        None => {
            (StatusCode::NOT_FOUND, HEADERS, "there is no such file; the viewer is at /\n").into_response()
        }
    }
}
