//! A run needs no memory. What other threads allocate meanwhile does not count.

use baudbot_avr::usart::{BitLength, Frame};
use baudbot_avr::{Bare, Chip, External, Fuses, Part, Pin, Port, Program, Supply};

#[test]
fn a_run_allocates_nothing() {
    for file in
        ["adc.hex", "echo_9600.hex", "pwm.hex", "capture.hex", "watchdog.hex", "sleep.hex", "compute.hex"]
    {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/programs").join(file);
        let program = Program::parse(Part::Atmega328P, &std::fs::read(path).unwrap()).unwrap();
        let mut chip = Chip::new(&program, Fuses::external_clock(Part::Atmega328P), Supply::ARDUINO);
        let allocated = allocation_counter::measure(|| {
            for millisecond in 1..50 {
                let now = chip.now();
                chip.receive(Frame::byte(0x55), now, BitLength::of_baud(16_000_000, 9600).unwrap()).ok();
                chip.set_pin(Pin::new(Port::B, 0).unwrap(), External::High, now + 100).ok();
                chip.set_pin(Pin::new(Port::D, 7).unwrap(), External::Low, now + 200).ok();
                chip.run(16_000 * millisecond, &mut Bare);
            }
        });
        assert_eq!(allocated.count_total, 0, "{file}");
    }
}
