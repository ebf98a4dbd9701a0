//! Fits of runs with hidden numbers: each number is within its 95 % interval for nine of ten seeds or more.
#![allow(missing_docs, unreachable_pub, reason = "tests")]

mod common;
mod recovery {
    mod compasses;
    mod curves;
    mod echoes;
    mod misfits;
    mod motors;
    mod odometers;
}
