//! The check of each call, before any service.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use futures_util::future::{self, Either, MapOk, Ready, TryFutureExt};
use tonic::Status;
use tonic::body::Body;
use tonic::codegen::http::{Request, Response};
use tower::{Layer, Service};

use super::{Admission, OpenOnConnection};
use crate::access::{Access, Caller, Guarded};
use crate::limits::{Account, InForce, Payer, Peer, Taken};

/// Lets a call pass whose connection has a place, whose caller may make it, and who has not made too many. The caller is in its
/// extensions then, and for whom it is counted.
#[derive(Clone)]
pub(crate) struct CheckCalls {
    pub(crate) access: Access,
    pub(crate) limits: InForce,
}

impl<S> Layer<S> for CheckCalls {
    type Service = Checked<S>;

    fn layer(&self, inner: S) -> Checked<S> {
        Checked { check: self.clone(), inner }
    }
}

/// Services behind the check.
#[derive(Clone)]
pub(crate) struct Checked<S> {
    check: CheckCalls,
    inner: S,
}

/// What a response goes through.
type Guard = Box<dyn FnOnce(Response<Body>) -> Response<Body> + Send>;

impl<S> Service<Request<Body>> for Checked<S>
where
    S: Service<Request<Body>, Response = Response<Body>>,
{
    type Response = Response<Body>;
    type Error = S::Error;
    type Future = Either<Ready<Result<Response<Body>, S::Error>>, MapOk<S::Future, Guard>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), S::Error>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, mut request: Request<Body>) -> Self::Future {
        let (caller, open) = match self.check.check(&mut request) {
            Ok(checked) => checked,
            Err(status) => return Either::Left(future::ok(status.into_http())),
        };
        let guard: Guard = match (&caller, open) {
            (Caller::Trusted | Caller::Nobody, None) => Box::new(|response| response),
            (Caller::Trusted | Caller::Nobody, Some(open)) => {
                Box::new(|response| response.map(|body| Body::new(Kept::new(body, open))))
            }
            (Caller::Holder(grant), open) => {
                let (access, grant) = (self.check.access.clone(), Arc::clone(grant));
                Box::new(|response| {
                    response.map(|body| Body::new(Kept::new(Guarded::new(body, access, grant), open)))
                })
            }
        };
        request.extensions_mut().insert(caller);
        Either::Right(self.inner.call(request).map_ok(guard))
    }
}

/// What counts a call while it is open.
type Open = (Option<OpenOnConnection>, Taken);

impl CheckCalls {
    /// The caller of a call that may be made, and what counts it. Calls of this process need no place, and are not counted.
    fn check(&self, request: &mut Request<Body>) -> Result<(Caller, Option<Open>), Status> {
        let extensions = request.extensions();
        let admission = extensions.get::<Arc<Admission>>().cloned();
        let peer = extensions.get::<Peer>();
        let from = match (&admission, peer) {
            (Some(admission), _) => Arc::clone(admission.tally()),
            (None, Some(peer)) => self.limits.tally(&peer.account),
            (None, None) => self.limits.tally(&Account::Process),
        };
        let known = match &admission {
            Some(admission) => {
                admission.note_call()?;
                admission.caller()
            }
            None => peer.map(|peer| &peer.caller),
        };
        let caller = self.access.check(request.uri().path(), known, request.headers());
        let caller = match caller {
            Ok(caller) => caller,
            Err(status) => {
                // Who tries tokens, or methods that are none, does not do so for nothing.
                self.limits.request(&from)?;
                return Err(status);
            }
        };
        let account = Account::of(&caller, from.account());
        let tally = if account == *from.account() { from } else { self.limits.tally(&account) };
        let open = match account {
            Account::Process => None,
            Account::User(_) | Account::Address(_) | Account::Token(..) => {
                self.limits.request(&tally)?;
                let on_connection = admission.as_ref().map(|admission| admission.open_call(&tally));
                Some((on_connection.transpose()?, self.limits.call(&tally)?))
            }
        };
        request.extensions_mut().insert(Payer(tally));
        Ok((caller, open))
    }
}

/// A body that keeps something until it is dropped.
struct Kept<B, K> {
    body: B,
    _kept: K,
}

impl<B, K> Kept<B, K> {
    fn new(body: B, kept: K) -> Self {
        Self { body, _kept: kept }
    }
}

impl<B: http_body::Body + Unpin, K: Unpin> http_body::Body for Kept<B, K> {
    type Data = B::Data;
    type Error = B::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<http_body::Frame<B::Data>, B::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> http_body::SizeHint {
        self.body.size_hint()
    }
}
