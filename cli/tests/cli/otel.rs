//! The traces that a collector gets.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use opentelemetry_proto::tonic::collector::logs::v1 as logs;
use opentelemetry_proto::tonic::collector::logs::v1::logs_service_server::{LogsService, LogsServiceServer};
use opentelemetry_proto::tonic::collector::trace::v1 as trace;
use opentelemetry_proto::tonic::collector::trace::v1::trace_service_server::{
    TraceService, TraceServiceServer,
};
use opentelemetry_proto::tonic::common::v1::any_value::Value;
use opentelemetry_proto::tonic::common::v1::{AnyValue, KeyValue};
use opentelemetry_proto::tonic::logs::v1::LogRecord;
use opentelemetry_proto::tonic::trace::v1::Span;
use tonic::transport::Server;
use tonic::transport::server::TcpIncoming;
use tonic::{Request, Response, Status};

use crate::cli::{command, said};

/// A collector that keeps all.
#[derive(Clone, Default)]
struct Collector {
    spans: Arc<Mutex<Vec<Span>>>,
    records: Arc<Mutex<Vec<LogRecord>>>,
    services: Arc<Mutex<Vec<KeyValue>>>,
}

#[tonic::async_trait]
impl TraceService for Collector {
    async fn export(
        &self,
        request: Request<trace::ExportTraceServiceRequest>,
    ) -> Result<Response<trace::ExportTraceServiceResponse>, Status> {
        for mut resource in request.into_inner().resource_spans {
            self.services.lock().unwrap().extend(resource.resource.take().unwrap().attributes);
            let spans = resource.scope_spans.into_iter().flat_map(|scope| scope.spans);
            self.spans.lock().unwrap().extend(spans);
        }
        Ok(Response::new(trace::ExportTraceServiceResponse::default()))
    }
}

#[tonic::async_trait]
impl LogsService for Collector {
    async fn export(
        &self,
        request: Request<logs::ExportLogsServiceRequest>,
    ) -> Result<Response<logs::ExportLogsServiceResponse>, Status> {
        for resource in request.into_inner().resource_logs {
            let records = resource.scope_logs.into_iter().flat_map(|scope| scope.log_records);
            self.records.lock().unwrap().extend(records);
        }
        Ok(Response::new(logs::ExportLogsServiceResponse::default()))
    }
}

fn text(value: Option<&AnyValue>) -> Option<&str> {
    match value?.value.as_ref()? {
        Value::StringValue(text) => Some(text),
        _ => None,
    }
}

fn find<'a>(attributes: &'a [KeyValue], key: &str) -> Option<&'a AnyValue> {
    attributes.iter().find(|attribute| attribute.key == key)?.value.as_ref()
}

#[test]
fn a_collector_gets_spans_of_orders_and_brains_and_events_with_simulated_time() {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let collector = Collector::default();
    let incoming = runtime.block_on(async { TcpIncoming::bind("127.0.0.1:0".parse().unwrap()).unwrap() });
    let endpoint = format!("http://{}", incoming.local_addr().unwrap());
    let server = Server::builder()
        .add_service(TraceServiceServer::new(collector.clone()))
        .add_service(LogsServiceServer::new(collector.clone()));
    let _serving = std::thread::spawn(move || runtime.block_on(server.serve_with_incoming(incoming)));
    let run = command(&["run", "--seconds", "0.5", "--quiet"])
        .env("OTEL_EXPORTER_OTLP_ENDPOINT", endpoint)
        .output();
    assert_eq!(said(run.unwrap()), (0, String::new(), String::new()));

    let services = collector.services.lock().unwrap();
    assert_eq!(text(find(&services, "service.name")), Some("baudbot"));
    let spans = collector.spans.lock().unwrap();
    assert!(spans.iter().all(|span| text(find(&span.attributes, "world")) == Some("wander")), "{spans:?}");
    let orders = spans.iter().filter(|span| span.name == "order");
    let orders: Vec<_> = orders.filter_map(|span| text(find(&span.attributes, "order"))).collect();
    assert_eq!(orders, ["start", "pause"]);
    let brain = spans.iter().find(|span| span.name == "brain").unwrap();
    assert_eq!(text(find(&brain.attributes, "brain")), Some("avoid"));
    assert!(brain.end_time_unix_nano > brain.start_time_unix_nano + 1000);
    let records = collector.records.lock().unwrap();
    let ended = records.iter().find(|record| text(record.body.as_ref()) == Some("run ended")).unwrap();
    let time_s = find(&ended.attributes, "time_s").unwrap();
    assert_eq!(time_s.value, Some(Value::DoubleValue(0.5)), "{ended:?}");
}

#[test]
fn a_collector_that_is_not_there_holds_nobody_up() {
    let mut run = command(&["run", "--seconds", "0.5", "--quiet"]);
    let begun = std::time::Instant::now();
    let (code, _, err) = said(run.env("OTEL_EXPORTER_OTLP_ENDPOINT", "http://127.0.0.1:1").output().unwrap());
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("export"), "{err}");
    assert!(begun.elapsed() < Duration::from_secs(10), "{err}");
}
