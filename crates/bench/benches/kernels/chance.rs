//! Random numbers of a named stream. An item is a number.

use baudbot_sim::random::Stream;
use divan::Bencher;
use divan::counter::ItemsCount;

const NUMBERS: usize = 1000;

fn draw(bencher: Bencher<'_, '_>, number: impl Fn(&mut Stream) -> f64) {
    let mut stream = Stream::new(1, "bench");
    bencher
        .counter(ItemsCount::new(NUMBERS))
        .bench_local(|| (0..NUMBERS).map(|_| number(&mut stream)).sum::<f64>());
}

#[divan::bench]
fn uniform(bencher: Bencher<'_, '_>) {
    draw(bencher, Stream::uniform);
}

#[divan::bench]
fn normal(bencher: Bencher<'_, '_>) {
    draw(bencher, Stream::normal);
}
