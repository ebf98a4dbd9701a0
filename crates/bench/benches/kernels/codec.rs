//! A message of eight infra-red readings: numbers, payload, frame, and back. An item is a byte of the payload, or of the
//! frame where there is one.

use baudbot_wire::{Decoder, Encoding, Layout, Message, Sample, frame, write_readings};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

const SENSORS: usize = 8;

/// The layout of robots without `bits`.
const LAYOUT: Layout<'_> = Layout {
    components: &[Encoding::Float64; SENSORS],
    counts: &[1; SENSORS],
    motors: &[Encoding::Float64; 2],
    ages: true,
};

fn payload() -> Vec<u8> {
    let mut payload = vec![0; LAYOUT.readings_len_max()];
    let len = write(&mut payload);
    payload.truncate(len);
    payload
}

fn write(out: &mut [u8]) -> usize {
    let sample = |_| Some(Sample { age_100us: 1, values: &[0.25] });
    write_readings(&LAYOUT, 7, 1234, sample, out).expect("room for a message")
}

fn framed() -> Vec<u8> {
    let mut framed = vec![0; frame::MAX_FRAME];
    let len = frame::encode(&payload(), &mut framed).expect("room for a frame");
    framed.truncate(len);
    framed
}

#[divan::bench]
fn message_write(bencher: Bencher<'_, '_>) {
    let mut out = payload();
    bencher.counter(ItemsCount::new(out.len())).bench_local(|| write(black_box(&mut out)));
}

#[divan::bench]
fn frame_encode(bencher: Bencher<'_, '_>) {
    let (payload, mut out) = (payload(), [0; frame::MAX_FRAME]);
    bencher
        .counter(ItemsCount::new(framed().len()))
        .bench_local(|| frame::encode(black_box(&payload), &mut out));
}

#[divan::bench]
fn frame_decode(bencher: Bencher<'_, '_>) {
    let (framed, mut decoder) = (framed(), Decoder::new());
    bencher.counter(ItemsCount::new(framed.len())).bench_local(|| {
        let whole = |byte: &u8| matches!(decoder.push(*byte), Some(Ok(_)));
        assert_eq!(black_box(&framed).iter().map(whole).filter(|whole| *whole).count(), 1);
    });
}

#[divan::bench]
fn message_parse(bencher: Bencher<'_, '_>) {
    let payload = payload();
    bencher.counter(ItemsCount::new(payload.len())).bench_local(|| {
        let Ok(Message::Readings(readings)) = Message::parse(black_box(&payload), &LAYOUT) else {
            panic!("a message of readings")
        };
        readings.entries().flat_map(|entry| entry.values).sum::<f64>()
    });
}
