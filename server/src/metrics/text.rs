//! Prometheus' text format, one family of metrics after the other, so that only one at a time is in memory twice.

use prometheus::TextEncoder;
use prometheus::proto::{
    Bucket, Counter, Gauge, Histogram, LabelPair, Metric, MetricFamily, MetricType, Quantile, Summary,
};

/// Names and values of a metric's labels.
pub(super) type Labels<'a> = &'a [(&'static str, &'a str)];

/// A family of metrics that is being written.
pub(super) struct Family {
    name: &'static str,
    help: &'static str,
    kind: MetricType,
    metrics: Vec<Metric>,
}

impl Family {
    /// A family of values that only grow.
    pub(super) fn counter(name: &'static str, help: &'static str) -> Self {
        Self { name, help, kind: MetricType::COUNTER, metrics: Vec::new() }
    }

    /// A family of values that go up and down.
    pub(super) fn gauge(name: &'static str, help: &'static str) -> Self {
        Self { kind: MetricType::GAUGE, ..Self::counter(name, help) }
    }

    /// A family of counts by size.
    pub(super) fn histogram(name: &'static str, help: &'static str) -> Self {
        Self { kind: MetricType::HISTOGRAM, ..Self::counter(name, help) }
    }

    /// A family of quantiles.
    pub(super) fn summary(name: &'static str, help: &'static str) -> Self {
        Self { kind: MetricType::SUMMARY, ..Self::counter(name, help) }
    }

    /// Adds a counter or a gauge.
    pub(super) fn add(&mut self, labels: Labels<'_>, value: f64) {
        let mut metric = metric(labels);
        if self.kind == MetricType::COUNTER {
            let mut counter = Counter::default();
            counter.set_value(value);
            metric.set_counter(counter);
        } else {
            let mut gauge = Gauge::default();
            gauge.set_value(value);
            metric.set_gauge(gauge);
        }
        self.metrics.push(metric);
    }

    /// Adds a histogram: `counts` has an upper bound and how many there are in this bucket alone; `count` is of all,
    /// those above the last bound too.
    pub(super) fn add_histogram(
        &mut self,
        labels: Labels<'_>,
        counts: impl Iterator<Item = (f64, u64)>,
        count: u64,
        sum: f64,
    ) {
        let mut up_to = 0;
        let buckets = counts.map(|(bound, n)| {
            up_to += n;
            let mut bucket = Bucket::default();
            bucket.set_upper_bound(bound);
            bucket.set_cumulative_count(up_to);
            bucket
        });
        let mut histogram = Histogram::default();
        histogram.set_bucket(buckets.collect());
        histogram.set_sample_count(count);
        histogram.set_sample_sum(sum);
        let mut metric = metric(labels);
        metric.set_histogram(histogram);
        self.metrics.push(metric);
    }

    /// Adds a summary with some quantiles and their values.
    pub(super) fn add_summary(
        &mut self,
        labels: Labels<'_>,
        quantiles: impl Iterator<Item = (f64, f64)>,
        count: u64,
        sum: f64,
    ) {
        let quantiles = quantiles.map(|(q, value)| {
            let mut quantile = Quantile::default();
            quantile.set_quantile(q);
            quantile.set_value(value);
            quantile
        });
        let mut summary = Summary::default();
        summary.set_quantile(quantiles.collect());
        summary.set_sample_count(count);
        summary.set_sample_sum(sum);
        let mut metric = metric(labels);
        metric.set_summary(summary);
        self.metrics.push(metric);
    }

    /// Writes it, if there is anything in it.
    pub(super) fn write(self, text: &mut String) {
        if self.metrics.is_empty() {
            return;
        }
        let mut family = MetricFamily::default();
        family.set_name(self.name.to_owned());
        family.set_help(self.help.to_owned());
        family.set_field_type(self.kind);
        family.set_metric(self.metrics);
        let written = TextEncoder::new().encode_utf8(&[family], text);
        written.expect("a family with a name and a metric is written to memory");
    }
}

fn metric(labels: Labels<'_>) -> Metric {
    let pairs = labels.iter().map(|&(name, value)| {
        let mut pair = LabelPair::default();
        pair.set_name(name.to_owned());
        pair.set_value(value.to_owned());
        pair
    });
    Metric::from_label(pairs.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(family: Family) -> String {
        let mut text = String::new();
        family.write(&mut text);
        text
    }

    #[test]
    fn a_name_cannot_leave_its_label() {
        let mut family = Family::gauge("m", "Help.");
        family.add(&[("world", "a\"} 1\nm{world=\"b\\")], 0.5);
        let expected = "# HELP m Help.\n# TYPE m gauge\nm{world=\"a\\\"} 1\\nm{world=\\\"b\\\\\"} 0.5\n";
        assert_eq!(written(family), expected);
    }

    #[test]
    fn buckets_are_counted_up_and_what_is_beyond_them_is_in_the_last() {
        let mut family = Family::histogram("h", "Help.");
        family.add_histogram(&[], [(0.25, 2), (0.5, 3)].into_iter(), 6, 4.5);
        let expected = "h_bucket{le=\"0.25\"} 2\nh_bucket{le=\"0.5\"} 5\nh_bucket{le=\"+Inf\"} 6\nh_sum 4.5\nh_count 6\n";
        assert_eq!(written(family).split_once("histogram\n").unwrap().1, expected);
    }

    #[test]
    fn a_family_without_metrics_is_not_written() {
        assert_eq!(written(Family::summary("s", "Help.")), "");
    }
}
