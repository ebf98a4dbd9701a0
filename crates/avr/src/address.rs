//! The data addresses of the registers.
//!
//! Source: data sheet, chapter *Register Summary*.

use crate::pin::Port;
use crate::timer::Which;
use crate::{adc, eeprom, external, ports, spi, system, timer, twi, usart};

/// The register at an address.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    Reserved,
    Core(Core),
    Port(Port, ports::Register),
    Timer(Which, timer::Register),
    Usart(usart::Register),
    Adc(adc::Register),
    Eeprom(eeprom::Register),
    External(external::Register),
    Spi(spi::Register),
    Twi(twi::Register),
    System(system::Register),
    Comparator,
    Watchdog,
    SelfProgramming,
}

/// A register of the processor itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Core {
    StackLow,
    StackHigh,
    Flags,
}

impl Place {
    /// The register at a data address from 0x20 to 0xFF.
    #[inline]
    pub(crate) fn at(address: u8) -> Self {
        PLACES[usize::from(address)]
    }

    /// Whether a one clears a bit or toggles a pin, and a zero does nothing. `SBI` and `CBI` write such registers without
    /// reading them.
    pub(crate) const fn takes_ones(self) -> bool {
        matches!(
            self,
            Self::Port(_, ports::Register::Pin)
                | Self::Timer(_, timer::Register::Flags)
                | Self::External(external::Register::Flags | external::Register::ChangeFlags)
        )
    }
}

static PLACES: [Place; 256] = {
    let mut places = [Place::Reserved; 256];
    let mut address = 0x20;
    while address < 0x100 {
        places[address] = place(address);
        address += 1;
    }
    places
};

const fn place(address: usize) -> Place {
    match address {
        0x23..=0x2B => port(address),
        0x35..=0x5F => low(address),
        0x60..=0x7F => extended(address),
        0x80..=0x8B => timer1(address),
        0xB0..=0xB6 => timer2(address),
        0xB8..=0xBD => Place::Twi(match address {
            0xB8 => twi::Register::BitRate,
            0xB9 => twi::Register::Status,
            0xBA => twi::Register::Address,
            0xBB => twi::Register::Data,
            0xBC => twi::Register::Control,
            _ => twi::Register::Mask,
        }),
        0xC0 => Place::Usart(usart::Register::ControlA),
        0xC1 => Place::Usart(usart::Register::ControlB),
        0xC2 => Place::Usart(usart::Register::ControlC),
        0xC4 => Place::Usart(usart::Register::Baud),
        0xC5 => Place::Usart(usart::Register::BaudHigh),
        0xC6 => Place::Usart(usart::Register::Data),
        _ => Place::Reserved,
    }
}

const fn port(address: usize) -> Place {
    let port = Port::ALL[(address - 0x23) / 3];
    Place::Port(
        port,
        match (address - 0x23) % 3 {
            0 => ports::Register::Pin,
            1 => ports::Register::Direction,
            _ => ports::Register::Port,
        },
    )
}

/// Registers that `IN` and `OUT` reach.
const fn low(address: usize) -> Place {
    match address {
        0x35 => Place::Timer(Which::T0, timer::Register::Flags),
        0x36 => Place::Timer(Which::T1, timer::Register::Flags),
        0x37 => Place::Timer(Which::T2, timer::Register::Flags),
        0x3B => Place::External(external::Register::ChangeFlags),
        0x3C => Place::External(external::Register::Flags),
        0x3D => Place::External(external::Register::Mask),
        0x3E => Place::System(system::Register::General(0)),
        0x3F => Place::Eeprom(eeprom::Register::Control),
        0x40 => Place::Eeprom(eeprom::Register::Data),
        0x41 => Place::Eeprom(eeprom::Register::Address),
        0x42 => Place::Eeprom(eeprom::Register::AddressHigh),
        0x43 => Place::System(system::Register::TimerControl),
        0x44 => Place::Timer(Which::T0, timer::Register::ControlA),
        0x45 => Place::Timer(Which::T0, timer::Register::ControlB),
        0x46 => Place::Timer(Which::T0, timer::Register::Count),
        0x47 => Place::Timer(Which::T0, timer::Register::CompareA),
        0x48 => Place::Timer(Which::T0, timer::Register::CompareB),
        0x4A => Place::System(system::Register::General(1)),
        0x4B => Place::System(system::Register::General(2)),
        0x4C => Place::Spi(spi::Register::Control),
        0x4D => Place::Spi(spi::Register::Status),
        0x4E => Place::Spi(spi::Register::Data),
        0x50 => Place::Comparator,
        0x53 => Place::System(system::Register::Sleep),
        0x54 => Place::System(system::Register::Status),
        0x55 => Place::System(system::Register::Control),
        0x57 => Place::SelfProgramming,
        0x5D => Place::Core(Core::StackLow),
        0x5E => Place::Core(Core::StackHigh),
        0x5F => Place::Core(Core::Flags),
        _ => Place::Reserved,
    }
}

const fn extended(address: usize) -> Place {
    match address {
        0x60 => Place::Watchdog,
        0x61 => Place::System(system::Register::Prescaler),
        0x64 => Place::System(system::Register::PowerReduction),
        0x66 => Place::System(system::Register::OscillatorCalibration),
        0x68 => Place::External(external::Register::ChangeControl),
        0x69 => Place::External(external::Register::Sense),
        0x6B..=0x6D => Place::External(external::Register::ChangeMask(address - 0x6B)),
        0x6E => Place::Timer(Which::T0, timer::Register::Mask),
        0x6F => Place::Timer(Which::T1, timer::Register::Mask),
        0x70 => Place::Timer(Which::T2, timer::Register::Mask),
        0x78 => Place::Adc(adc::Register::Low),
        0x79 => Place::Adc(adc::Register::High),
        0x7A => Place::Adc(adc::Register::ControlA),
        0x7B => Place::Adc(adc::Register::ControlB),
        0x7C => Place::Adc(adc::Register::Multiplexer),
        0x7E | 0x7F => Place::System(system::Register::DigitalOff(address - 0x7E)),
        _ => Place::Reserved,
    }
}

const fn timer1(address: usize) -> Place {
    Place::Timer(
        Which::T1,
        match address {
            0x80 => timer::Register::ControlA,
            0x81 => timer::Register::ControlB,
            0x82 => timer::Register::ControlC,
            0x84 => timer::Register::Count,
            0x85 => timer::Register::CountHigh,
            0x86 => timer::Register::Capture,
            0x87 => timer::Register::CaptureHigh,
            0x88 => timer::Register::CompareA,
            0x89 => timer::Register::CompareAHigh,
            0x8A => timer::Register::CompareB,
            0x8B => timer::Register::CompareBHigh,
            _ => return Place::Reserved,
        },
    )
}

const fn timer2(address: usize) -> Place {
    Place::Timer(
        Which::T2,
        match address {
            0xB0 => timer::Register::ControlA,
            0xB1 => timer::Register::ControlB,
            0xB2 => timer::Register::Count,
            0xB3 => timer::Register::CompareA,
            0xB4 => timer::Register::CompareB,
            0xB6 => return Place::System(system::Register::AsynchronousStatus),
            _ => return Place::Reserved,
        },
    )
}
