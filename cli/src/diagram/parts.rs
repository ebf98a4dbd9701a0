//! The behaviour of lamps, buzzers and servos, from the signals of their wires: the brightness of a lamp, a tone's
//! frequency, the length of a servo's pulses.

use baudbot_plot::quantity::{count, handy};
use baudbot_plot::timing::{Shot, hz_in_words, percent};
use baudbot_sim::chip::{ChipSpec, Condenser, Kind, Level, Line, LitBy, Pulses, Shown, Stretch, add};

/// Something that a part does.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Deed {
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
    /// The part's name.
    pub(super) who: String,
    pub(super) what: String,
}

/// The behaviour of the parts on a signal's wire until an instant.
pub(super) fn deeds(chip: &ChipSpec, shot: &Shot, until_ns: u64) -> Vec<Deed> {
    let Line::Wire(net) = shot.signal.line else { return Vec::new() };
    let wiring = chip.board().wiring();
    let on_wire = wiring.wires().filter(|(_, other)| *other == net).map(|(terminal, _)| terminal.part);
    let mut deeds = Vec::new();
    for part in on_wire {
        let kind = wiring.parts().find(|(id, _)| *id == part).map(|(_, placed)| *placed.kind());
        let spans = match kind {
            Some(Kind::Led(led)) => lights(&condensed(shot, FLICKER_NS), led.lit_by, until_ns),
            Some(Kind::Piezo(_)) => tones(&condensed(shot, SLOWEST_TONE_NS)),
            Some(Kind::Servo(_)) => pulses(&condensed(shot, 0)),
            Some(
                Kind::Voltage(_)
                | Kind::Reflectance(_)
                | Kind::Switch(_)
                | Kind::Encoder(_)
                | Kind::Ping(_)
                | Kind::HcSr04(_)
                | Kind::Bridge(_)
                | Kind::Compass(_)
                | Kind::RangeFinder(_),
            )
            | None => Vec::new(),
        };
        let who = wiring.name(part);
        let deed = |(start_ns, end_ns, what)| Deed { start_ns, end_ns, who: who.to_owned(), what };
        deeds.extend(spans.into_iter().map(deed));
    }
    deeds
}

/// The state of a part from an instant to another.
type Span = (u64, u64, String);

/// The stretches of a wire, pulses with a period below a limit together.
fn condensed(shot: &Shot, finest_ns: u64) -> Vec<Stretch> {
    let (mut condenser, mut out) = (Condenser::new(finest_ns), Vec::new());
    for shown in &shot.shown {
        match *shown {
            Shown::Stretch(Stretch::Level { at_ns, level }) => condenser.take(at_ns, level, &mut out),
            Shown::Stretch(pulses @ Stretch::Pulses(_)) => {
                condenser.finish(&mut out);
                add(&mut out, pulses);
            }
            Shown::Turns(_) | Shown::Number { .. } | Shown::Over { .. } => {}
        }
    }
    condenser.finish(&mut out);
    out
}

/// The brightness of a lamp.
fn lights(wave: &[Stretch], lit_by: LitBy, until_ns: u64) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for (i, stretch) in wave.iter().enumerate() {
        let next_ns = wave.get(i + 1).map_or(until_ns, Stretch::at_ns);
        let (end_ns, brightness) = match stretch {
            Stretch::Level { level, .. } => (next_ns, if is_lit(*level, lit_by) { 1.0 } else { 0.0 }),
            Stretch::Pulses(pulses) if lit_by == LitBy::High => (pulses.until_ns, pulses.duty()),
            Stretch::Pulses(pulses) => (pulses.until_ns, 1.0 - pulses.duty()),
        };
        let what = match brightness {
            0.0 => "dark".to_owned(),
            1.0 => "lit".to_owned(),
            part => format!("lit {}", percent(part)),
        };
        match spans.last_mut() {
            Some((_, end, last)) if *end == stretch.at_ns() && *last == what => *end = end_ns,
            _ => spans.push((stretch.at_ns(), end_ns, what)),
        }
    }
    spans
}

fn is_lit(level: Level, lit_by: LitBy) -> bool {
    match level {
        Level::High => lit_by == LitBy::High,
        Level::Low => lit_by == LitBy::Low,
        Level::Open | Level::Short => false,
    }
}

/// The tones of a buzzer.
fn tones(wave: &[Stretch]) -> Vec<Span> {
    let tone = |stretch: &Stretch| match stretch {
        Stretch::Pulses(pulses @ Pulses { is_even: true, .. }) => {
            Some((pulses.from_ns, pulses.until_ns, format!("tone of {}", hz_in_words(pulses.frequency_hz()))))
        }
        Stretch::Pulses(Pulses { from_ns, until_ns, count: clicks, is_even: false, .. }) => {
            Some((*from_ns, *until_ns, format!("noise of {}", count(*clicks as usize, "click"))))
        }
        Stretch::Level { .. } => None,
    };
    wave.iter().filter_map(tone).collect()
}

/// The pulses of a servo.
fn pulses(wave: &[Stretch]) -> Vec<Span> {
    let micros = |ns: u64| handy((ns as f64 / 100.0).round() / 10.0);
    let pulse = |(i, stretch): (usize, &Stretch)| match (stretch, wave.get(i + 1)) {
        (
            Stretch::Level { at_ns, level: Level::High },
            Some(Stretch::Level { at_ns: end_ns, level: Level::Low }),
        ) => Some((*at_ns, *end_ns, format!("pulse of {} µs", micros(end_ns - at_ns)))),
        (Stretch::Pulses(Pulses { from_ns, until_ns, count: n, high_ns, .. }), _) => {
            let mean = micros(high_ns / u64::from((*n).max(1)));
            Some((*from_ns, *until_ns, format!("{} of {mean} µs", count(*n as usize, "pulse"))))
        }
        (Stretch::Level { .. }, _) => None,
    };
    wave.iter().enumerate().filter_map(pulse).collect()
}

/// A lamp that is lit more often than this is seen as one that is less bright.
const FLICKER_NS: u64 = 20_000_000;
/// Slower pulses of a buzzer are clicks and no tone, as in `baudbot_board`.
const SLOWEST_TONE_NS: u64 = 50_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn wave(from_ms: u64, high_us: u64, long_us: u64, count: u64) -> Vec<Stretch> {
        let at = |at_us: u64, level| Stretch::Level { at_ns: from_ms * MS + at_us * 1000, level };
        (0..count)
            .flat_map(|i| [at(i * long_us, Level::High), at(i * long_us + high_us, Level::Low)])
            .collect()
    }

    fn shot(wave: Vec<Stretch>) -> Shot {
        let signal = baudbot_sim::chip::Signal { line: Line::Sent, on: Vec::new() };
        Shot { signal, shown: wave.into_iter().map(Shown::Stretch).collect() }
    }

    fn words(spans: Vec<Span>) -> Vec<(u64, u64, String)> {
        spans.into_iter().map(|(from, until, what)| (from / MS, until / MS, what)).collect()
    }

    #[test]
    fn a_lamp_is_lit_or_dark_and_less_bright_if_it_flickers() {
        let mut levels = vec![Stretch::Level { at_ns: 0, level: Level::Open }];
        levels.push(Stretch::Level { at_ns: MS, level: Level::Low });
        levels.extend(wave(100, 50_000, 100_000, 2));
        levels.extend(wave(400, 500, 2000, 10));
        let shot = shot(levels);
        let lit = |lit_by| words(lights(&condensed(&shot, FLICKER_NS), lit_by, 500 * MS));
        let text = |(from, until, what): (u64, u64, &str)| (from, until, what.to_owned());
        let expected = [
            (0, 100, "dark"),
            (100, 150, "lit"),
            (150, 200, "dark"),
            (200, 250, "lit"),
            (250, 400, "dark"),
            (400, 418, "lit 25 %"),
            (418, 418, "lit"),
            (418, 500, "dark"),
        ];
        assert_eq!(lit(LitBy::High), expected.map(text));
        let low = lit(LitBy::Low);
        assert_eq!(low[..2], [text((0, 1, "dark")), text((1, 100, "lit"))]);
        assert!(low.contains(&text((400, 418, "lit 75 %"))), "{low:?}");
    }

    #[test]
    fn a_buzzer_has_tones_and_a_servo_has_pulses() {
        let mut levels = wave(0, 500, 1000, 101);
        levels.extend(wave(200, 250, 500, 41));
        let shown = tones(&condensed(&shot(levels), SLOWEST_TONE_NS));
        let expected = [(0, 100, "tone of 1 kHz".to_owned()), (200, 220, "tone of 2 kHz".to_owned())];
        assert_eq!(words(shown), expected);
        let shown = pulses(&condensed(&shot(wave(0, 1500, 20_000, 2)), 0));
        let expected = [(0, 1, "pulse of 1500 µs".to_owned()), (20, 21, "pulse of 1500 µs".to_owned())];
        assert_eq!(words(shown), expected);
        let shown = pulses(&condensed(&shot(wave(0, 1300, 20_000, 50)), 30 * MS));
        assert_eq!(words(shown)[0], (0, 980, "49 pulses of 1300 µs".to_owned()));
    }
}
