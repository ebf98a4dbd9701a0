//! Lookahead for brains: those whose answers the world does not wait for at present.

use baudbot_sim::Turn;

use super::Sessions;
use super::debt::{Debt, Overtaken};

impl Sessions {
    /// Whether the tick can end without the answers that are owed: their brains have promised to think as long as the
    /// scenario states, and `reaches` holds for each of their steps. A brain is overtaken by one Turn only.
    pub(crate) fn can_be_overtaken(&self, reaches: impl Fn(&Turn) -> bool) -> bool {
        self.by_number.values().all(|session| match &session.debt {
            Debt::Settled => true,
            Debt::Due(turn) => session.thinks_as_scenario && turn.steps.iter().all(&reaches),
            Debt::Overtaken { turn, deferred } => deferred.is_empty() && turn.steps.iter().all(&reaches),
            Debt::Late(_) => false,
        })
    }

    /// The tick ends without the answers that are due. Gives the steps that they were to.
    pub(crate) fn overtake(&mut self) -> Vec<Turn> {
        let debts = self.by_number.values_mut().map(|session| &mut session.debt);
        debts.flat_map(|debt| debt.overtake().to_vec()).collect()
    }

    /// Whether the world is ahead of any brain.
    pub(crate) fn is_any_overtaken(&self) -> bool {
        self.overtaken().next().is_some()
    }

    /// The steps that the world has gone ahead of.
    pub(crate) fn overtaken(&self) -> impl Iterator<Item = &Turn> {
        self.by_number.values().flat_map(|session| session.debt.overtaken())
    }

    /// Takes the steps that the world has gone ahead of, of a brain that will not answer.
    pub(crate) fn take_overtaken(&mut self, number: u64) -> Vec<Turn> {
        self.by_number.get_mut(&number).map(|session| session.debt.take_overtaken()).unwrap_or_default()
    }

    /// The watchdog gives up on a brain until it has answered. Gives what the world had gone ahead of.
    pub(crate) fn give_up(&mut self, number: u64) -> Overtaken {
        self.by_number.get_mut(&number).map(|session| session.debt.give_up()).unwrap_or_default()
    }

    /// All brains that the world has gone ahead of.
    pub(crate) fn overtaken_sessions(&self) -> Vec<u64> {
        let sessions = self.by_number.iter();
        let overtaken = sessions.filter(|(_, session)| !session.debt.overtaken().is_empty());
        overtaken.map(|(number, _)| *number).collect()
    }
}
