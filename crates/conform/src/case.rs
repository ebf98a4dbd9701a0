//! The cases: each tests a sentence of the contract.

use tonic::Code;

use crate::evidence::Judge;
use crate::provocation::Provocation;
use crate::{aftermath, judge};

/// A case of the kit.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Its name, by which people and machines find it again.
    pub name: &'static str,
    /// The sentence of the contract that it tests, as it stands in the comments of `proto/baudbot/v1`.
    pub sentence: &'static str,
    /// The run that it judges.
    pub provocation: Provocation,
    pub(crate) judge: Judge,
}

const fn case(name: &'static str, provocation: Provocation, judge: Judge, sentence: &'static str) -> Case {
    Case { name, sentence, provocation, judge }
}

const fn refused(name: &'static str, code: Code, sentence: &'static str) -> Case {
    case(name, Provocation::Refused(code), aftermath::gives_up, sentence)
}

use Provocation::{
    Again, Burst, Cut, Deleted, End, Late, MissingSensor, NoEcho, NoReading, Pause, Plain, Reset, Restart,
    Reversed, Split, TwoRobots, Unknown,
};

/// All cases, in the order in which they are reported.
#[rustfmt::skip]
pub static CASES: &[Case] = &[
    case("hello-first", Plain, judge::greets_first, "The first request is a Hello, the first response a Welcome."),
    case("hello-once", Plain, judge::greets_once, "First message of the stream, sent exactly once."),
    case("welcome-before-step", Plain, judge::waits_for_welcome, "Steps follow the Welcome."),
    case("hello-world", Plain, judge::names_the_world, "Name of the world; a program that a run has started finds it in BAUDBOT_WORLD."),
    case("hello-robots", TwoRobots, judge::names_the_robots, "a program that a run has started finds them in BAUDBOT_ROBOT, with commas between them."),
    case("hello-brain", Plain, judge::has_a_name, "Name of the program for display: one line of at most 64 characters without control characters."),
    case("token", Plain, judge::shows_its_token, "Each call shows the caller's token, as metadata `authorization` with the value `Bearer TOKEN`."),
    case("token-again", Cut, aftermath::shows_its_token_again, "Each call shows the caller's token, as metadata `authorization` with the value `Bearer TOKEN`."),
    case("one-step-per-turn", Plain, judge::answers, "In lockstep the world waits for that Step"),
    case("no-second-answer", Plain, judge::answers_once, "Each Turn takes one Step."),
    case("no-step-unasked", Plain, judge::is_silent_unasked, "Number of the Turn that this answers; 0 if it answers none, which lockstep does not permit."),
    case("turn-number", Plain, judge::repeats_the_number, "Number of the Turn on this stream, from 1. The answering Step repeats it."),
    case("promised-parts", TwoRobots, judge::keeps_its_promise, "a promise that each Step has a part for every robot of its Turn and for no other, and sets neither thinking_ns nor operations."),
    case("promised-thinking", Plain, judge::sets_no_thinking_time, "a promise that each Step has a part for every robot of its Turn and for no other, and sets neither thinking_ns nor operations."),
    case("robot-index", TwoRobots, judge::has_known_robots, "Index of the robot in Hello.robots."),
    case("finite-signals", Plain, judge::sends_finite_signals, "All signals are finite numbers."),
    case("signal-limit", Plain, judge::keeps_to_the_limit, "RobotDescription.signal_limit is the largest magnitude."),
    case("other-signals", Plain, judge::counts_other_signals, "Signals for all other actuators, in the order of RobotDescription.actuators."),
    case("port-mode", Plain, judge::speaks_in_its_mode, "Form in which a brain exchanges data with its robots."),
    case("answers-what-is-readable", Plain, judge::commands_on_news, "Answer what is readable, not each Turn: a command without news behind it only fills the cable."),
    case("until-message", Plain, judge::waits_for_messages, "Wait for the next message: the robot gets no Turn before then."),
    case("at-latest", Plain, judge::waits_into_the_future, "Time, by the laptop's clock in nanoseconds, from which the next step gets a Turn in any case."),
    case("memory", Plain, judge::needs_no_memory_off_board, "Allowed only for robots whose brain runs on board"),
    case("beliefs", Plain, judge::publishes_soundly, "All numbers must be finite."),
    case("same-again", Again, judge::drives_again_alike, "the same Steps make the same run."),
    case("second-robot", TwoRobots, judge::drives_both, "Turns and Steps refer to a robot by its index in this list, from 0."),
    case("omitted-robot", TwoRobots, judge::leaves_out_the_omitted, "A robot whose brain is still thinking, in simulated time, is omitted."),
    case("order-of-sensors", Reversed, judge::goes_by_the_data_sheet, "Readings refer to a sensor by its index in this list, from 0."),
    case("unknown-kinds", Unknown, judge::goes_by_the_data_sheet, "Kind unknown to this version of the contract."),
    case("no-reading-yet", NoReading, judge::answers, "Sensors of which no reading has arrived yet are omitted."),
    case("missing-sensor", MissingSensor, judge::answers, "Sensors of which no reading has arrived yet are omitted."),
    case("no-echo", NoEcho, judge::answers, "A ray that hit nothing has the value -1."),
    case("reset", Reset, aftermath::goes_on_after_reset, "It decreases when the world is reset or a snapshot is restored."),
    case("old-turn", Reset, aftermath::answers_no_old_turn, "The answer to a Turn from before a reset or a change of pace is discarded."),
    case("ended", End, aftermath::stays_or_leaves_well, "Signals that the run is over."),
    case("silent-after-end", End, aftermath::is_silent_after_the_end, "When the run is over, the server sends Ended and leaves the stream open"),
    case("reset-after-end", End, aftermath::goes_on_after_the_end, "because an operator may reset the world."),
    case("pause", Pause, judge::answers, "While a world is paused there are no Turns."),
    case("silent-in-pause", Pause, judge::is_silent_unasked, "While a world is paused there are no Turns."),
    case("lost-connection", Cut, aftermath::comes_back, "A program that loses its stream with UNAVAILABLE attaches again, with a Hello, as often as it takes."),
    case("hello-again", Cut, aftermath::greets_again, "A program that loses its stream with UNAVAILABLE attaches again, with a Hello, as often as it takes."),
    case("server-comes-later", Late, aftermath::waits_for_the_server, "both are temporary"),
    refused("refused-token", Code::Unauthenticated, "UNAUTHENTICATED (no valid token)"),
    refused("refused-right", Code::PermissionDenied, "PERMISSION_DENIED (the token does not permit driving the robot)"),
    refused("refused-name", Code::NotFound, "NOT_FOUND (no such world or robot)"),
    refused("refused-held", Code::AlreadyExists, "ALREADY_EXISTS (the robot has a brain already)"),
    refused("refused-field", Code::InvalidArgument, "INVALID_ARGUMENT (the message names the field)"),
    refused("refused-state", Code::FailedPrecondition, "FAILED_PRECONDITION (a Step before the Hello"),
    refused("refused-limit", Code::ResourceExhausted, "RESOURCE_EXHAUSTED (the program's variables do not fit into the robot, or a limit of the server)"),
    case("deleted-world", Deleted, aftermath::gives_up, "ABORTED (the world was deleted, or an operator detached the brain)"),
    case("restart", Restart, aftermath::comes_back_if_it_can, "If an operator asks the brain to restart, ABORTED comes with the trailer `baudbot-reason: restart`."),
    case("bursts", Burst, judge::answers_in_bursts, "at other paces a brain may send Steps at any time"),
    case("no-flood", Burst, judge::does_not_flood, "Each Turn takes one Step."),
    case("split-bytes", Split, judge::survives_split_bytes, "They may start or end in the middle of a message."),
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// The words of all comments of the contract.
    fn contract() -> String {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../proto/baudbot/v1");
        let files = std::fs::read_dir(folder)
            .unwrap()
            .map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap());
        let text: String = files.collect();
        let comments = text.lines().filter_map(|line| line.trim().strip_prefix("//"));
        comments.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn each_sentence_stands_in_the_contract() {
        let contract = contract();
        for case in CASES {
            assert!(contract.contains(case.sentence), "{}: {}", case.name, case.sentence);
        }
    }

    #[test]
    fn names_are_unique_and_each_provocation_is_judged() {
        let names: BTreeSet<_> = CASES.iter().map(|case| case.name).collect();
        assert_eq!(names.len(), CASES.len());
        let is_judged = |provocation: &Provocation| CASES.iter().any(|case| case.provocation == *provocation);
        assert!(Provocation::all().all(|provocation| is_judged(&provocation)));
        assert!(
            CASES.iter().all(|case| Provocation::all().any(|provocation| provocation == case.provocation))
        );
    }
}
