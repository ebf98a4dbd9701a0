//! A fixed piece of work whose speed distinguishes machines, and the hours of a shared machine.
//!
//! A round is one step of a 64-bit linear congruential generator, the conversion of its upper 53 bits to a number in
//! [0, 1), a square root, and one term of a geometric sum: integers and floating point in registers, each round waiting
//! for the one before, no memory. It says nothing about caches, and nothing about vector units. A figure divided by the
//! rounds a second that the same processor did just before compares between machines as far as that goes.

use std::hint::black_box;

use crate::process::Clock;

/// Rounds in a second of a processor, now.
pub fn rounds_per_second() -> f64 {
    let start_s = Clock::Processor.now_s();
    black_box(rounds(black_box(1), ROUNDS));
    ROUNDS as f64 / (Clock::Processor.now_s() - start_s)
}

fn rounds(mut state: u64, rounds: u64) -> f64 {
    let mut sum = 0.0;
    for _ in 0..rounds {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let uniform = (state >> 11) as f64 * (1.0 / (1_u64 << 53) as f64);
        sum = 0.5 * sum + uniform.sqrt();
    }
    sum
}

/// Some 50 ms.
const ROUNDS: u64 = 10_000_000;

#[cfg(test)]
mod tests {
    #[test]
    fn the_work_is_done_and_is_always_the_same() {
        assert_eq!(super::rounds(1, 1000).to_bits(), super::rounds(1, 1000).to_bits());
        let sum = super::rounds(1, 1000);
        assert!(sum > 0.5 && sum < 2.0, "{sum}");
    }
}
