//! The parts that a tick's time goes to, each by itself. Run with `cargo bench -p baudbot-bench`, or only those of a
//! file with `cargo bench -p baudbot-bench -- rays`.

mod chance;
mod codec;
mod link;
mod rays;
mod tick;

fn main() {
    divan::main();
}
