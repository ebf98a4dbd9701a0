//! Spans and events for a collector that speaks OTLP.
//!
//! The endpoint, headers and timeouts are those of the environment's `OTEL_…` variables. Spans are what operators order
//! and how long brains stay; events are sent both as logs and within the spans in which they happen. All parts of this
//! program at `info` and above are exported, whatever is logged to stderr; other crates are not, as the exporter's own
//! would be events to export.

use std::time::Duration;

use anyhow::Context;
use opentelemetry::trace::TracerProvider;
use opentelemetry_appender_tracing::layer::OpenTelemetryTracingBridge;
use opentelemetry_otlp::{LogExporter, SpanExporter};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::logs::SdkLoggerProvider;
use opentelemetry_sdk::trace::SdkTracerProvider;
use tokio::runtime::{Builder, Runtime};
use tracing_subscriber::Layer;
use tracing_subscriber::filter::{LevelFilter, Targets};

use super::Listener;
use crate::text::tell;

/// The exporter. It ends with the events that are still to be sent.
pub(crate) struct Export {
    traces: SdkTracerProvider,
    logs: SdkLoggerProvider,
    /// The exporter's thread holds the connection, so the exporter outlives the program's own runtime.
    _runtime: Runtime,
}

impl Export {
    /// Adds the listener for spans and events.
    pub(crate) fn start(listeners: &mut Vec<Listener>) -> anyhow::Result<Self> {
        let runtime = Builder::new_multi_thread().worker_threads(1).thread_name("otlp").enable_all().build();
        let runtime = runtime.context("cannot start a runtime")?;
        let entered = runtime.enter();
        let spans = SpanExporter::builder().with_tonic().build()?;
        let traces =
            SdkTracerProvider::builder().with_resource(resource()).with_batch_exporter(spans).build();
        let events = LogExporter::builder().with_tonic().build()?;
        let logs = SdkLoggerProvider::builder().with_resource(resource()).with_batch_exporter(events).build();
        drop(entered);
        let ours = Targets::new().with_target("baudbot", LevelFilter::INFO);
        let layer = tracing_opentelemetry::layer().with_tracer(traces.tracer("baudbot"));
        listeners.push(layer.with_filter(ours.clone()).boxed());
        listeners.push(OpenTelemetryTracingBridge::new(&logs).with_filter(ours).boxed());
        Ok(Self { traces, logs, _runtime: runtime })
    }
}

impl Drop for Export {
    fn drop(&mut self) {
        for outcome in
            [self.traces.shutdown_with_timeout(PATIENCE), self.logs.shutdown_with_timeout(PATIENCE)]
        {
            if let Err(error) = outcome {
                tell!("note: not all spans and events were exported: {error}");
            }
        }
    }
}

/// The name of the exporter. `OTEL_SERVICE_NAME` replaces it.
fn resource() -> Resource {
    let resource = Resource::builder();
    match std::env::var_os("OTEL_SERVICE_NAME") {
        Some(_) => resource.build(),
        None => resource.with_service_name("baudbot").build(),
    }
}

/// The time that a collector has to take the remaining events.
const PATIENCE: Duration = Duration::from_secs(3);
