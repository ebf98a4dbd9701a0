//! The check of each call, before any service.

use std::sync::Arc;
use std::task::{Context, Poll};

use futures_util::future::{self, Either, MapOk, Ready, TryFutureExt};
use tonic::body::Body;
use tonic::codegen::http::{Request, Response};
use tonic::{Code, Status};
use tower::{Layer, Service};

use super::Admission;
use crate::access::{Access, Caller, Guarded};

/// Lets a call pass whose connection has a place, and whose caller may make it. The caller is in its extensions then.
#[derive(Clone)]
pub(crate) struct CheckCalls(pub(crate) Access);

impl<S> Layer<S> for CheckCalls {
    type Service = Checked<S>;

    fn layer(&self, inner: S) -> Checked<S> {
        Checked { access: self.0.clone(), inner }
    }
}

/// Services behind the check.
#[derive(Clone)]
pub(crate) struct Checked<S> {
    access: Access,
    inner: S,
}

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
        let caller = match check(&self.access, &request) {
            Ok(caller) => caller,
            Err(status) => return Either::Left(future::ok(status.into_http())),
        };
        let call = Call(request.extensions().get::<Arc<Admission>>().cloned());
        let guard: Guard = match &caller {
            Caller::Trusted | Caller::Nobody => Box::new(|response| call.answered(response)),
            Caller::Holder(grant) => {
                let (access, grant) = (self.access.clone(), Arc::clone(grant));
                let guarded = |body| Body::new(Guarded::new(body, access, grant));
                Box::new(|response| call.answered(response).map(guarded))
            }
        };
        request.extensions_mut().insert(caller);
        Either::Right(self.inner.call(request).map_ok(guard))
    }
}

/// A call that has not been answered, and its connection, if that is not a pipe in memory.
struct Call(Option<Arc<Admission>>);

impl Call {
    /// What a service says of a request that broke off is an answer for nobody.
    fn answered(mut self, response: Response<Body>) -> Response<Body> {
        let code = response
            .headers()
            .get(&Status::GRPC_STATUS)
            .map_or(Code::Ok, |code| Code::from_bytes(code.as_bytes()));
        if !matches!(code, Code::Cancelled | Code::Internal)
            && let Some(admission) = self.0.take()
        {
            admission.note_answered();
        }
        response
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        if let Some(admission) = &self.0 {
            admission.note_abandoned();
        }
    }
}

/// Calls through pipes in memory need no place, and bring their caller along.
fn check(access: &Access, request: &Request<Body>) -> Result<Caller, Status> {
    let extensions = request.extensions();
    let admission = extensions.get::<Arc<Admission>>();
    if let Some(admission) = admission {
        admission.note_call().map_err(|error| Status::unavailable(error.to_string()))?;
    }
    let known = match admission {
        Some(admission) => admission.caller(),
        None => extensions.get::<Caller>(),
    };
    access.check(request.uri().path(), known, request.headers())
}
