//! Brains that the world has gone ahead of.

use baudbot_sim::Turn;

use super::Sessions;

impl Sessions {
    /// Whether the tick can end without the answers that are owed: their brains have promised to think as long as the
    /// scenario says, and `reaches` is so of each of their steps. A brain falls behind by one Turn only.
    pub(crate) fn may_fall_behind(&self, reaches: impl Fn(&Turn) -> bool) -> bool {
        let mut owing = self.by_number.values().filter(|session| !session.open.is_empty());
        owing.all(|session| {
            let late = session.late || session.open.len() > 1;
            let steps = if session.behind.is_empty() { &session.asked } else { &session.behind };
            session.steady && !late && session.held.is_empty() && steps.iter().all(&reaches)
        })
    }

    /// The tick ends without the answers that are owed. Gives the steps that they were to.
    pub(crate) fn fall_behind(&mut self) -> Vec<Turn> {
        let owing = self
            .by_number
            .values_mut()
            .filter(|session| !session.open.is_empty() && session.behind.is_empty());
        let mut all = Vec::new();
        for session in owing {
            session.behind = std::mem::take(&mut session.asked);
            all.extend(&session.behind);
        }
        all
    }

    /// Whether the world is ahead of any brain.
    pub(crate) fn is_behind(&self) -> bool {
        self.behind().next().is_some()
    }

    /// The steps that the world has gone ahead of.
    pub(crate) fn behind(&self) -> impl Iterator<Item = &Turn> {
        self.by_number.values().flat_map(|session| &session.behind)
    }

    /// Whether the world is ahead of this brain.
    pub(crate) fn is_one_behind(&self, number: u64) -> bool {
        self.by_number.get(&number).is_some_and(|session| !session.behind.is_empty())
    }

    /// This brain is not behind any more. Gives the steps that the world went ahead of.
    pub(crate) fn take_behind(&mut self, number: u64) -> Vec<Turn> {
        self.by_number.get_mut(&number).map(|session| std::mem::take(&mut session.behind)).unwrap_or_default()
    }

    /// This brain's steps in the tick that is begun, of which it has not been told.
    pub(crate) fn take_held(&mut self, number: u64) -> Vec<Turn> {
        self.by_number.get_mut(&number).map(|session| std::mem::take(&mut session.held)).unwrap_or_default()
    }

    /// The robots of the Turn that this brain has to answer, if it has promised to think as long as the scenario says.
    pub(crate) fn promised(&self, number: u64) -> Option<Vec<usize>> {
        let session =
            self.by_number.get(&number).filter(|session| session.steady && session.open.len() == 1)?;
        let steps = if session.behind.is_empty() { &session.asked } else { &session.behind };
        Some(steps.iter().map(|turn| turn.robot).collect())
    }

    /// All brains that are behind.
    pub(crate) fn numbers_behind(&self) -> Vec<u64> {
        let behind = self.by_number.iter().filter(|(_, session)| !session.behind.is_empty());
        behind.map(|(number, _)| *number).collect()
    }
}
