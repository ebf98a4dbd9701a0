//! The check of each call, before any service.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use baudbot_access::needs_at;
use baudbot_proto::v1::brain_link_service_server::SERVICE_NAME as BRAIN_LINK;
use baudbot_proto::v1::trainer_service_server::SERVICE_NAME as TRAINER;
use futures_util::future::{self, Either, MapOk, Ready, TryFutureExt};
use http_body::Body as _;
use tokio::task::futures::TaskLocalFuture;
use tonic::body::Body;
use tonic::codegen::http::{Request, Response};
use tonic::{Code, Status};
use tower::{Layer, Service};

use super::metered::Metered;
use super::printed::printed;
use super::{Admission, OpenOnConnection};
use crate::access::{Access, Caller, Guarded, authorization};
use crate::audit::call::Call;
use crate::audit::{AuditLog, Audited, Record};
use crate::limits::{Account, InForce, Limit, Payer, Peer, Taken};

/// Lets a call pass whose connection has a place, whose caller may make it, and who has not made too many. The caller is in its
/// extensions then, and for whom it is counted.
#[derive(Clone)]
pub(crate) struct CheckCalls {
    pub(crate) access: Access,
    pub(crate) limits: InForce,
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

/// The function that a response goes through.
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
        let (caller, open) = match self.check.check(&mut request) {
            Ok(checked) => checked,
            Err(status) => {
                if let Some(record) = self.record(&request, &name(&self.check.access, &request)) {
                    record.refuse(&status);
                }
                return Either::Left(future::ok(printed(status.into_http())));
            }
        };
        let need = needs_at(request.uri().path());
        let record = Record::is_for(need).then(|| self.record(&request, caller.name())).flatten();
        let unanswered = Unanswered(request.extensions().get::<Arc<Admission>>().cloned());
        let metered = self.metered(&request);
        let guard = self.guard(&caller, open, record.clone(), (unanswered, metered));
        request.extensions_mut().insert(caller.clone());
        Either::Right(Call { caller, record }.serve(self.inner.call(request)).map_ok(guard))
    }
}

impl<S> Checked<S> {
    /// The audit log's record of a call, if there is one.
    fn record(&self, request: &Request<Body>, who: &str) -> Option<Arc<Record>> {
        let log = self.check.audit.as_ref()?;
        let extensions = request.extensions();
        let from = match extensions.get::<Arc<Admission>>() {
            Some(admission) => admission.tally().account().to_string(),
            None => extensions.get::<Peer>().map_or(&Account::Process, |peer| &peer.account).to_string(),
        };
        Some(Record::new(log, who, from, request.uri().path()).into())
    }

    /// The counter of a response's bytes to this request while they wait.
    fn metered(&self, request: &Request<Body>) -> Guard {
        let caller = request.extensions().get().map(|Payer(tally)| Arc::clone(tally));
        let (limits, path) = (self.check.limits.clone(), request.uri().path().to_owned());
        Box::new(move |response| match caller {
            Some(caller) if *caller.account() != Account::Process && !response.body().is_end_stream() => {
                let what = path.rsplit('/').next().unwrap_or_default();
                // Brains get messages about their robots, and not about anything they ask for.
                let pays = ![BRAIN_LINK, TRAINER].iter().any(|service| path[1..].starts_with(service));
                response.map(|body| Body::new(Metered::new(body, &limits, &caller, what, pays)))
            }
            Some(_) | None => response,
        })
    }

    /// The guard between a service's response and its caller.
    fn guard(
        &self,
        caller: &Caller,
        open: Option<Open>,
        record: Option<Arc<Record>>,
        (unanswered, metered): (Unanswered, Guard),
    ) -> Guard {
        let grant = match caller {
            Caller::Trusted | Caller::Nobody => None,
            Caller::Holder(grant) => Some((self.check.access.clone(), Arc::clone(grant))),
        };
        Box::new(move |response| {
            let mut response = metered(printed(unanswered.answered(response)));
            if let Some((access, grant)) = grant {
                response = response.map(|body| Body::new(Guarded::new(body, access, grant)));
            }
            if let Some(open) = open {
                response = response.map(|body| Body::new(Kept::new(body, open)));
            }
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
    /// Notes that the call is answered. The service's answer to a request that broke off does not count, as it has no
    /// receiver.
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

/// The counters of a call while it is open.
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
        let caller = self.access.check(request.uri().path(), known, request.headers()).or_else(|status| {
            // A caller that tries tokens, or methods that are none, pays for it.
            self.limits.request(&from)?;
            Err(status)
        })?;
        if let (Some(admission), Caller::Trusted | Caller::Holder(_)) = (&admission, &caller) {
            admission.note_known();
        }
        let account = Account::of(&caller, from.account());
        let tally = if account == *from.account() { from } else { self.limits.tally(&account) };
        let open = match account {
            Account::Process => None,
            Account::User(_) | Account::Address(_) | Account::Token(..) => {
                self.limits.request(&tally)?;
                let on_connection = admission.as_ref().map(|admission| admission.open_call(&tally));
                Some((
                    on_connection.transpose()?,
                    self.limits.take(Limit::StreamsPerCaller, &tally, "open calls")?,
                ))
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

/// The name of a caller who may not do what it wants.
fn name(access: &Access, request: &Request<Body>) -> String {
    let extensions = request.extensions();
    let admission = extensions.get::<Arc<Admission>>().and_then(|admission| admission.caller().cloned());
    let known = admission.or_else(|| extensions.get::<Peer>().map(|peer| peer.caller.clone()));
    let caller = known.map_or_else(|| access.caller(authorization(request.headers())), Ok);
    caller.map_or_else(|_| Caller::Nobody.name().to_owned(), |caller| caller.name().to_owned())
}
