//! Ticks of the workloads' worlds with their drivers, long after the start. An item is a robot's step.

use baudbot_bench::plan::Plan;
use baudbot_bench::rig::Rig;
use baudbot_bench::scenario::{Cable, Infrared, Laser, office, parse, plans};
use divan::Bencher;
use divan::counter::ItemsCount;

fn ticks(bencher: Bencher<'_, '_>, toml: &str) {
    let mut rig = Rig::new(parse(toml).expect("a scenario"));
    rig.run(20);
    let robots = rig.world().robots().len();
    bencher.counter(ItemsCount::new(robots)).bench_local(|| rig.tick());
}

#[divan::bench(args = [1, 10, 100, 1000])]
fn infrared(bencher: Bencher<'_, '_>, robots: usize) {
    let plan = match robots {
        1 => plans::IR_1,
        10 => plans::IR_10,
        100 => plans::IR_100,
        _ => plans::IR_1000,
    };
    let plan: Plan = plan.parse().expect("a floor plan");
    ticks(bencher, &Infrared::new(Cable::Onboard).scenario(&plan));
}

#[divan::bench]
fn laser(bencher: Bencher<'_, '_>) {
    let plan: Plan = plans::OFFICE.parse().expect("a floor plan");
    ticks(bencher, &office(&plan, 1, Laser::Still { period_ms: 10 }));
}
