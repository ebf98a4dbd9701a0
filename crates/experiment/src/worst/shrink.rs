//! Making a case plain: whatever can be left out is left out, as long as the robot still fails in it.

use toml_edit::DocumentMut;

use super::case::Court;
use super::document::{faults, remove_fault, set};
use crate::error::Error;
use crate::run_record::Ran;

/// A scenario, and its changes.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    base: DocumentMut,
    /// Changes of the base, as for `--set`.
    sets: Vec<String>,
    /// What was left out of the base, in words.
    without: Vec<String>,
}

impl Draft {
    pub(super) fn new(base: DocumentMut, sets: Vec<String>) -> Self {
        Self { base, sets, without: Vec::new() }
    }

    /// The scenario as a file.
    pub(super) fn toml(&self) -> Result<String, Error> {
        let mut document = self.base.clone();
        self.sets.iter().try_for_each(|text| set(&mut document, text))?;
        Ok(document.to_string())
    }

    /// What differs from the scenario that it was made of.
    pub(super) fn changes(&self) -> Vec<String> {
        self.sets.iter().chain(&self.without).cloned().collect()
    }

    /// Tries plainer drafts until none of them fails, and becomes the last that does. Returns its run, and whether
    /// nothing plainer fails; `None` if it was stopped.
    pub(super) fn shrink(
        &mut self,
        court: &Court<'_>,
        first: Ran,
        trials: &mut u64,
    ) -> Result<Option<(Ran, bool)>, Error> {
        let mut best = first;
        'again: loop {
            // A change may have made a place for another.
            let drafts: Vec<_> = self
                .plainer(&best)
                .into_iter()
                .filter_map(|draft| Some((draft.toml().ok()?, draft)))
                .collect();
            for some in drafts.chunks(AT_A_TIME) {
                if *trials >= MOST_TRIALS || court.is_over() {
                    return Ok(Some((best, false)));
                }
                *trials += some.len() as u64;
                let texts: Vec<_> = some.iter().map(|(toml, _)| toml.as_str()).collect();
                let Some(all) = court.run_all(&texts)? else { return Ok(None) };
                let fails = |ran: &Ran| ran.fall.is_some_and(|fall| !fall.holds);
                let first =
                    some.iter().zip(all).find_map(|((_, draft), ran)| Some((draft, ran.ok().filter(fails)?)));
                if let Some((draft, ran)) = first {
                    (*self, best) = (draft.clone(), ran);
                    continue 'again;
                }
            }
            return Ok(Some((best, true)));
        }
    }

    /// All drafts that are a step plainer, those that leave out most first.
    fn plainer(&self, ran: &Ran) -> Vec<Self> {
        let mut all = Vec::new();
        all.extend(self.sooner(ran));
        for i in 0..self.sets.len() {
            let mut sets = self.sets.clone();
            let set = sets.remove(i);
            // A run must end, and the end is made sooner above.
            if !set.starts_with("end.after_s=") {
                all.push(Self { sets, ..self.clone() });
            }
        }
        all.extend(self.without_faults());
        for i in 0..self.sets.len() {
            for rounder in rounder(&self.sets[i]) {
                let mut sets = self.sets.clone();
                sets[i] = rounder;
                all.push(Self { sets, ..self.clone() });
            }
        }
        all
    }

    /// The draft that ends just after what happened.
    fn sooner(&self, ran: &Ran) -> Option<Self> {
        let at_s = ran.fall?.at_s();
        let (place, after_s) = self
            .sets
            .iter()
            .enumerate()
            .find_map(|(i, set)| Some((Some(i), set.strip_prefix("end.after_s=")?.parse::<f64>().ok()?)))
            .or_else(|| {
                let after = self.base.get("end")?.get("after_s")?;
                Some((None, after.as_float().or_else(|| after.as_integer().map(|whole| whole as f64))?))
            })?;
        // With a tick to spare: the end itself is no longer than a millisecond away.
        let sooner_s = ((at_s + 0.05) * 10.0).ceil() / 10.0;
        let set = format!("end.after_s={sooner_s:?}");
        let mut sets = self.sets.clone();
        match place {
            _ if sooner_s >= after_s => return None,
            Some(i) => sets[i] = set,
            None => sets.push(set),
        }
        Some(Self { sets, ..self.clone() })
    }

    /// Each draft with a fault fewer.
    fn without_faults(&self) -> impl Iterator<Item = Self> {
        let places = faults(&self.base).into_iter().enumerate();
        let places = places.flat_map(|(robot, count)| (0..count).map(move |fault| (robot, fault)));
        places.map(|(robot, fault)| {
            let mut draft = self.clone();
            remove_fault(&mut draft.base, robot, fault);
            draft.without.push(format!("robots[{robot}] without its fault {fault}"));
            draft
        })
    }
}

/// A change with fewer digits, the fewest first; a seed with a smaller number.
fn rounder(set: &str) -> Vec<String> {
    let Some((path, text)) = set.split_once('=') else { return Vec::new() };
    let Ok(value) = text.parse::<f64>() else { return Vec::new() };
    if path == "end.after_s" {
        // The end that was found is as early as it can be, and rounded already.
        return Vec::new();
    }
    let is_whole = !text.contains(['.', 'e', 'E']);
    if path == "seed" {
        return (0..5).filter(|seed| f64::from(*seed) < value).map(|seed| format!("seed={seed}")).collect();
    }
    let digits =
        |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>().trim_matches('0').len();
    let mut all = vec![0.0];
    all.extend((0..3).map(|places| format!("{value:.places$e}").parse::<f64>().unwrap_or(value)));
    let written = |value: f64| if is_whole { format!("{value:.0}") } else { format!("{value:?}") };
    let mut all: Vec<_> =
        all.into_iter().map(written).filter(|rounder| digits(rounder) < digits(text)).collect();
    all.dedup();
    all.into_iter().map(|rounder| format!("{path}={rounder}")).collect()
}

/// Drafts that are tried side by side. The number is the same on any machine, and with it what comes of them.
const AT_A_TIME: usize = 6;

/// Runs that a case may take to become plain.
const MOST_TRIALS: u64 = 300;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_becomes_rounder_and_never_less_round() {
        assert_eq!(
            rounder("robots.a.start.x_m=-0.4137"),
            [
                "robots.a.start.x_m=0.0",
                "robots.a.start.x_m=-0.4",
                "robots.a.start.x_m=-0.41",
                "robots.a.start.x_m=-0.414"
            ]
        );
        assert_eq!(
            rounder("robots.a.link.baud=2417"),
            [
                "robots.a.link.baud=0",
                "robots.a.link.baud=2000",
                "robots.a.link.baud=2400",
                "robots.a.link.baud=2420"
            ]
        );
        assert_eq!(rounder("robots.a.link.baud=2000"), ["robots.a.link.baud=0"]);
        assert_eq!(rounder("robots.a.start.x_m=0.0"), Vec::<String>::new());
        assert_eq!(rounder("seed=2"), ["seed=0", "seed=1"]);
        assert_eq!(rounder("end.after_s=5.9"), Vec::<String>::new());
        assert_eq!(rounder("robots.a.link.kind=usb"), Vec::<String>::new());
    }
}
