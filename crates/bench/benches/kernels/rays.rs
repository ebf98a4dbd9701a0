//! Rays among the 100 segments of the office. An item is a ray.

use baudbot_bench::plan::Plan;
use baudbot_bench::scenario::plans;
use baudbot_geometry::{Fan, Index, Point, Pose, Ray, Segment};
use divan::Bencher;
use divan::counter::ItemsCount;

/// The office, and where its robots stand.
fn office() -> (Index, Vec<Pose>) {
    let plan: Plan = plans::OFFICE.parse().expect("a floor plan");
    let segment = |[x0, y0, x1, y1]: [f64; 4]| Segment { start: Point::new(x0, y0), end: Point::new(x1, y1) };
    let mut segments: Vec<_> = plan.walls.iter().copied().map(segment).collect();
    for &[x, y, width, height] in &plan.boxes {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let corners = corners.map(|(i, j)| Point::new(x + 0.5 * i * width, y + 0.5 * j * height));
        segments.extend(baudbot_geometry::polygon::edges(&corners));
    }
    assert_eq!(segments.len(), 100);
    let poses = plan.robots.iter().map(|&[x, y, heading]| Pose::new(x, y, heading)).collect();
    (Index::new(segments, Vec::new()), poses)
}

/// A fan from each of the 100 places, ray by ray.
fn fans(bencher: Bencher<'_, '_>, opening_rad: f64, rays: usize, range_m: f64) {
    let (index, poses) = office();
    let fan = Fan::new(opening_rad, rays);
    bencher.counter(ItemsCount::new(rays * poses.len())).bench_local(|| {
        let distance = |ray: Ray| index.cast(&ray, range_m).map_or(range_m, |hit| hit.distance);
        let sum = |pose: &Pose| fan.rays(pose.position, pose.direction()).map(distance).sum::<f64>();
        poses.iter().map(sum).sum::<f64>()
    });
}

#[divan::bench]
fn one_ray(bencher: Bencher<'_, '_>) {
    fans(bencher, 0.0, 1, 4.0);
}

#[divan::bench]
fn fan_of_3_over_30_degrees(bencher: Bencher<'_, '_>) {
    fans(bencher, 30_f64.to_radians(), 3, 0.12);
}

#[divan::bench]
fn fan_of_683_over_240_degrees(bencher: Bencher<'_, '_>) {
    fans(bencher, 240_f64.to_radians(), 683, 4.0);
}
