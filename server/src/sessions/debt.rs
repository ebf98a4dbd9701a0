//! The answers that a brain owes in lockstep: one for each Turn that it was given.

use std::collections::VecDeque;
use std::mem;
use std::time::Instant;

use baudbot_sim::Turn;

/// A Turn without an answer.
pub(super) struct OpenTurn {
    pub(super) number: u64,
    /// The instant at which its tick began.
    pub(super) begun: Instant,
    /// The steps of its robots.
    pub(super) steps: Vec<Turn>,
}

/// The state of a brain's answers in lockstep. In other paces no answer is owed, and the state is always `Settled`.
///
/// ```text
///                 Turn                    tick ends without the answer (lookahead)
///      Settled ─────────▶ Due ──────────────────────────────────▶ Overtaken
///        ▲ ▲ ▲   answer    │ │                                       │   │
///        │ │ └─────────────┘ │ watchdog gives up                     │   │ watchdog gives up
///        │ │                 ▼                                       │   │
///        │ └───────────── Late ◀───────────────────────────────────────┘
///        │  last answer    ⟲ Turn                                    │
///        └───────────────────────────────────────────────────────────┘ answer
/// ```
///
/// A reset, and a change to a pace without lockstep, lead from each state to `Settled`.
#[derive(Default)]
pub(super) enum Debt {
    /// All Turns are answered.
    #[default]
    Settled,
    /// The world waits for the answer to the Turn of this tick.
    Due(OpenTurn),
    /// The world has ended the Turn's tick without the answer, since that could not have reached its robots in it. A brain
    /// is overtaken by one Turn only: its steps in the next tick are deferred until it has answered.
    Overtaken { turn: OpenTurn, deferred: Vec<Turn> },
    /// The watchdog has given up on the brain. The world gives it Turns, and waits for none of its answers until it has
    /// given all of them. Oldest Turn first; never empty.
    Late(VecDeque<OpenTurn>),
}

/// The answer of an overtaken brain that is no longer owed.
#[derive(Default)]
pub(crate) struct Overtaken {
    /// The steps of the Turn that the world has gone ahead of.
    pub(crate) steps: Vec<Turn>,
    /// The brain's steps in the tick that has begun since, whose Turns it has not got.
    pub(crate) deferred: Vec<Turn>,
}

/// A Turn that has just been answered.
pub(super) enum Paid {
    /// Within its tick, or late.
    Turn {
        turn: OpenTurn,
        was_only_one: bool,
    },
    Overtaken(OpenTurn, Overtaken),
}

impl Debt {
    /// A Turn is given to the brain.
    pub(super) fn add(&mut self, turn: OpenTurn) {
        *self = match mem::take(self) {
            Self::Settled => Self::Due(turn),
            Self::Late(mut turns) => {
                turns.push_back(turn);
                Self::Late(turns)
            }
            // No tick begins while an answer is due, and an overtaken brain's Turn is deferred. Were it otherwise, the world
            // would not wait for a brain that has two Turns.
            Self::Due(older) | Self::Overtaken { turn: older, .. } => Self::Late([older, turn].into()),
        };
    }

    /// An answer to the Turn of this number has come: `None` unless that is the oldest open one.
    pub(super) fn pay(&mut self, number: u64) -> Option<Paid> {
        if self.oldest()?.number != number {
            return None;
        }
        match mem::take(self) {
            Self::Settled => None,
            Self::Due(turn) => Some(Paid::Turn { turn, was_only_one: true }),
            Self::Overtaken { mut turn, deferred } => {
                let steps = mem::take(&mut turn.steps);
                Some(Paid::Overtaken(turn, Overtaken { steps, deferred }))
            }
            Self::Late(mut turns) => {
                let turn = turns.pop_front()?;
                let was_only_one = turns.is_empty();
                if !was_only_one {
                    *self = Self::Late(turns);
                }
                Some(Paid::Turn { turn, was_only_one })
            }
        }
    }

    /// The tick ends without the answer that is due. Gives the steps of its Turn.
    pub(super) fn overtake(&mut self) -> &[Turn] {
        match mem::take(self) {
            Self::Due(turn) => *self = Self::Overtaken { turn, deferred: Vec::new() },
            other @ (Self::Settled | Self::Overtaken { .. } | Self::Late(_)) => {
                *self = other;
                return &[];
            }
        }
        self.overtaken()
    }

    /// Keeps the steps of an overtaken brain in the tick that begins.
    pub(super) fn defer(&mut self, steps: Vec<Turn>) {
        match self {
            Self::Overtaken { deferred, .. } => *deferred = steps,
            Self::Settled | Self::Due(_) | Self::Late(_) => {}
        }
    }

    /// The steps that the world has gone ahead of.
    pub(super) fn overtaken(&self) -> &[Turn] {
        match self {
            Self::Overtaken { turn, .. } => &turn.steps,
            Self::Settled | Self::Due(_) | Self::Late(_) => &[],
        }
    }

    /// Takes the steps that the world has gone ahead of. The Turn stays open.
    pub(super) fn take_overtaken(&mut self) -> Vec<Turn> {
        match mem::take(self) {
            Self::Overtaken { mut turn, .. } => {
                let steps = mem::take(&mut turn.steps);
                *self = Self::Due(turn);
                steps
            }
            other @ (Self::Settled | Self::Due(_) | Self::Late(_)) => {
                *self = other;
                Vec::new()
            }
        }
    }

    /// The watchdog gives up on a brain whose answer is due. Gives what the world had gone ahead of.
    pub(super) fn give_up(&mut self) -> Overtaken {
        let (turn, overtaken) = match mem::take(self) {
            Self::Due(turn) => (turn, Overtaken::default()),
            Self::Overtaken { mut turn, deferred } => {
                let steps = mem::take(&mut turn.steps);
                (turn, Overtaken { steps, deferred })
            }
            other @ (Self::Settled | Self::Late(_)) => {
                *self = other;
                return Overtaken::default();
            }
        };
        *self = Self::Late([turn].into());
        overtaken
    }

    /// Whether the world waits for an answer, within the tick or before it goes further ahead.
    pub(super) fn is_due(&self) -> bool {
        match self {
            Self::Due(_) | Self::Overtaken { .. } => true,
            Self::Settled | Self::Late(_) => false,
        }
    }

    pub(super) fn is_settled(&self) -> bool {
        self.oldest().is_none()
    }

    /// The number of open Turns.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Settled => 0,
            Self::Due(_) | Self::Overtaken { .. } => 1,
            Self::Late(turns) => turns.len(),
        }
    }

    /// The oldest Turn that is open.
    pub(super) fn oldest(&self) -> Option<&OpenTurn> {
        match self {
            Self::Settled => None,
            Self::Due(turn) | Self::Overtaken { turn, .. } => Some(turn),
            Self::Late(turns) => turns.front(),
        }
    }
}

#[cfg(test)]
mod tests {
    use baudbot_sim::SimTime;

    use super::*;

    fn turn(number: u64) -> OpenTurn {
        let steps = vec![Turn { robot: 0, at: SimTime::from_ns(number) }];
        OpenTurn { number, begun: Instant::now(), steps }
    }

    #[test]
    fn a_turn_is_due_until_it_is_answered_and_no_other_answer_counts() {
        let mut debt = Debt::default();
        debt.add(turn(1));
        assert!(debt.is_due() && debt.pay(2).is_none() && debt.is_due());
        assert!(matches!(debt.pay(1), Some(Paid::Turn { was_only_one: true, .. })));
        assert!(debt.is_settled() && debt.pay(1).is_none());
    }

    #[test]
    fn an_overtaken_brain_gets_its_deferred_steps_with_its_answer() {
        let mut debt = Debt::default();
        debt.add(turn(1));
        assert_eq!(debt.overtake().len(), 1);
        assert!(debt.overtake().is_empty(), "it is overtaken by one Turn only");
        debt.defer(turn(2).steps);
        assert!(debt.is_due() && debt.count() == 1);
        let Some(Paid::Overtaken(_, overtaken)) = debt.pay(1) else { panic!() };
        assert_eq!((overtaken.steps, overtaken.deferred), (turn(1).steps, turn(2).steps));
        assert!(debt.is_settled());
    }

    #[test]
    fn a_late_brain_is_not_waited_for_until_it_has_answered_all_turns() {
        let mut debt = Debt::default();
        debt.add(turn(1));
        debt.overtake();
        debt.defer(turn(2).steps);
        let overtaken = debt.give_up();
        assert_eq!((overtaken.steps, overtaken.deferred), (turn(1).steps, turn(2).steps));
        debt.add(turn(2));
        assert!(!debt.is_due() && debt.overtaken().is_empty() && debt.count() == 2);
        assert!(debt.pay(2).is_none(), "the oldest comes first");
        assert!(matches!(debt.pay(1), Some(Paid::Turn { was_only_one: false, .. })));
        assert!(!debt.is_due() && !debt.is_settled());
        assert!(matches!(debt.pay(2), Some(Paid::Turn { was_only_one: true, .. })));
        debt.add(turn(3));
        assert!(debt.is_due(), "it is waited for again");
    }
}
