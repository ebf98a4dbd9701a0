//! The chip from outside: programs that it runs, its peripherals to the cycle, and other simulators beside it. One program, so that all that they share is built once.

mod any_counter;
mod any_program;
mod beside_avr8js;
mod instructions;
mod peripherals;
mod programs;
mod rounds;
mod steady_run;
mod triggers;
mod uart_sweep;
