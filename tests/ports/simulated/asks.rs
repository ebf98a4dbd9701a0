//! Asks a Khepera for its sensors in Rust, with `stty` as a child that sets the port. Prints as asks.c. Argument: the port.

use std::fs::OpenOptions;
use std::io::{Read, Write};
use std::process::Command;
use std::time::{Duration, Instant};

fn main() {
    let port = std::env::args().last().unwrap();
    let mut file = OpenOptions::new().read(true).write(true).open(&port).unwrap();
    let set = ["-F", &port, "9600", "raw", "-echo", "cs8", "cstopb", "clocal", "min", "1"];
    assert!(Command::new("stty").args(set).status().unwrap().success());
    for _ in 0..5 {
        let (begun, mut answered, mut last) = (Instant::now(), 0, [0]);
        file.write_all(b"N\r").unwrap();
        while last != [b'\n'] {
            file.read_exact(&mut last).unwrap();
            answered += 1;
        }
        println!("{answered} {}", begun.elapsed().as_nanos());
        std::thread::sleep(Duration::from_millis(20));
    }
}
