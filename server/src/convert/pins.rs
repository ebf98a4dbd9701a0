//! The pins of a chip, for observers.

use baudbot_proto::v1;
use baudbot_sim::chip::{ChipSpec, Level, Line, Net, Pulses, Shown, Signal, Stretch, Turns};

/// The signals of a chip.
pub(super) fn signals(chip: &ChipSpec) -> Vec<v1::PinSignal> {
    let all = chip.signals();
    all.iter().map(|own| signal(own, &all)).collect()
}

fn signal(signal: &Signal, all: &[Signal]) -> v1::PinSignal {
    let is_pin_of = |channel: u8, other: &Signal| match other.line {
        Line::Wire(net) => net.adc_channel() == Some(channel),
        Line::MainLoop | Line::Adc(_) | Line::Sent | Line::Received => false,
    };
    let (kind, channel) = match signal.line {
        Line::MainLoop => (v1::PinSignalKind::MainLoop, None),
        Line::Wire(net) if (0..2).any(|pin| Net::arduino(pin) == Some(net)) => {
            (v1::PinSignalKind::UartPin, None)
        }
        Line::Wire(_) => (v1::PinSignalKind::Pin, None),
        Line::Adc(channel) => (v1::PinSignalKind::Adc, Some(channel)),
        Line::Sent => (v1::PinSignalKind::Sent, None),
        Line::Received => (v1::PinSignalKind::Received, None),
    };
    let pin = channel.and_then(|channel| all.iter().position(|other| is_pin_of(channel, other)));
    v1::PinSignal {
        signal: signal.name(),
        on: signal.on.clone(),
        kind: kind.into(),
        pin: pin.map(|place| place as u32),
    }
}

/// Something on the signal in this place.
pub(crate) fn event(&(signal, shown): &(usize, Shown)) -> v1::PinEvent {
    use v1::PinEventKind as Kind;
    let at_ns = shown.at_ns();
    let event =
        |kind: Kind| v1::PinEvent { signal: signal as u32, at_ns, kind: kind.into(), ..Default::default() };
    match shown {
        Shown::Stretch(Stretch::Level { level, .. }) => event(match level {
            Level::Low => Kind::Low,
            Level::High => Kind::High,
            Level::Open => Kind::Open,
            Level::Short => Kind::Short,
        }),
        Shown::Stretch(Stretch::Pulses(Pulses { until_ns, count, high_ns, is_even, .. })) => {
            v1::PinEvent { until_ns, pulses: count, high_ns, even: is_even, ..event(Kind::Pulses) }
        }
        Shown::Turns(Turns { until_ns, count, cycles, are_short, .. }) => {
            let kind = if are_short { Kind::ShortRounds } else { Kind::Round };
            v1::PinEvent { until_ns, rounds: count, cycles, ..event(kind) }
        }
        Shown::Number { number, .. } => v1::PinEvent { number: number.into(), ..event(Kind::Number) },
        Shown::Over { .. } => event(Kind::Over),
    }
}
