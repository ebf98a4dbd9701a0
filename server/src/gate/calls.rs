//! The check of each call, before any service.

use std::sync::Arc;
use std::task::{Context, Poll};

use baudbot_access::needs_at;
use futures_util::future::{self, Either, MapOk, Ready, TryFutureExt};
use tokio::task::futures::TaskLocalFuture;
use tonic::body::Body;
use tonic::codegen::http::{Request, Response};
use tonic::{Code, Status};
use tower::{Layer, Service};

use super::Admission;
use crate::access::{Access, Caller, Guarded, authorization};
use crate::audit::call::Call;
use crate::audit::{AuditLog, Audited, Record};

/// Lets a call pass whose connection has a place, and whose caller may make it. The caller is in its extensions then.
#[derive(Clone)]
pub(crate) struct CheckCalls {
    pub(crate) access: Access,
    pub(crate) audit: Option<AuditLog>,
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

type Guard = Box<dyn FnOnce(Response<Body>) -> Response<Body> + Send>;

impl<S> Service<Request<Body>> for Checked<S>
where
    S: Service<Request<Body>, Response = Response<Body>>,
{
    type Response = Response<Body>;
    type Error = S::Error;
    type Future =
        Either<Ready<Result<Response<Body>, S::Error>>, MapOk<TaskLocalFuture<Call, S::Future>, Guard>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), S::Error>> {
        self.inner.poll_ready(context)
    }

    fn call(&mut self, mut request: Request<Body>) -> Self::Future {
        let caller = match check(&self.check.access, &request) {
            Ok(caller) => caller,
            Err(status) => {
                if let Some(record) = self.record(&request, &name(&self.check.access, &request)) {
                    record.refuse(&status);
                }
                return Either::Left(future::ok(status.into_http()));
            }
        };
        let need = needs_at(request.uri().path());
        let record = Record::is_for(need).then(|| self.record(&request, caller.name())).flatten();
        let unanswered = Unanswered(request.extensions().get::<Arc<Admission>>().cloned());
        let guard = self.guard(&caller, record.clone(), unanswered);
        request.extensions_mut().insert(caller.clone());
        Either::Right(Call { caller, record }.serve(self.inner.call(request)).map_ok(guard))
    }
}

impl<S> Checked<S> {
    /// What the audit log has of a call, if there is one.
    fn record(&self, request: &Request<Body>, who: &str) -> Option<Arc<Record>> {
        let log = self.check.audit.as_ref()?;
        Some(Record::new(log, who, request.uri().path()).into())
    }

    /// What stands between a service's response and its caller.
    fn guard(&self, caller: &Caller, record: Option<Arc<Record>>, unanswered: Unanswered) -> Guard {
        let grant = match caller {
            Caller::Trusted | Caller::Nobody => None,
            Caller::Holder(grant) => Some((self.check.access.clone(), Arc::clone(grant))),
        };
        Box::new(move |response| {
            let response = unanswered.answered(response);
            let response = match grant {
                Some((access, grant)) => response.map(|body| Body::new(Guarded::new(body, access, grant))),
                None => response,
            };
            match record {
                Some(record) => Audited::response(response, record),
                None => response,
            }
        })
    }
}

/// A call that has not been answered, and its connection, if that is not a pipe in memory.
struct Unanswered(Option<Arc<Admission>>);

impl Unanswered {
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

impl Drop for Unanswered {
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

/// The name of a caller who may not do what it wants.
fn name(access: &Access, request: &Request<Body>) -> String {
    let known = request.extensions().get::<Caller>().cloned();
    let caller = known.map_or_else(|| access.caller(authorization(request.headers())), Ok);
    caller.map_or_else(|_| Caller::Nobody.name().to_owned(), |caller| caller.name().to_owned())
}
