//! The right that each call asks of its caller.
//!
//! This is the one place that decides what a right is good for: [`Right::gives`](crate::Right::gives) has the needs
//! that a right meets, and [`RPCS`] the need of each call. A call that is not in the table is refused, so that one that
//! is added to the contract is closed until its need is decided.

use std::fmt;

/// A demand on a caller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Need {
    /// Every caller may make the call.
    Nothing,
    /// Any valid token, whatever its rights.
    AnyToken,
    /// The right to see what is true.
    Observe,
    /// The right to make worlds and run them.
    Operate,
    /// The right to get the truth while driving.
    Train,
    /// The right to drive a robot. Which one is in the call, or comes with it later: see
    /// [`Grant::may_drive`](crate::Grant::may_drive).
    Drive,
}

/// A way into the server that is not an RPC.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Door {
    /// The page's files, which are the same everywhere and reveal nothing of this server.
    PageFiles,
    /// The page's socket. Each call that comes over it needs what the RPC of that name needs.
    PageSocket,
    /// A film that a page has made and hands in.
    Film,
    /// Metrics for Prometheus.
    Metrics,
    /// A serial port that programs open: it drives its robot.
    SerialPort,
}

impl Door {
    /// All doors.
    pub const ALL: [Self; 5] =
        [Self::PageFiles, Self::PageSocket, Self::Film, Self::Metrics, Self::SerialPort];

    /// The demand on a caller who comes this way.
    pub fn needs(self) -> Need {
        match self {
            Self::PageFiles => Need::Nothing,
            Self::PageSocket => Need::AnyToken,
            // The film was made for the operator's command that started the page.
            Self::Film => Need::Operate,
            Self::Metrics => Need::Observe,
            Self::SerialPort => Need::Drive,
        }
    }
}

/// The demand of this method's calls; `None` if there is no such method, and then the call is to be refused. The
/// service has its full name: `needs("baudbot.v1.ControlService", "ListWorlds")`.
pub fn needs(service: &str, method: &str) -> Option<Need> {
    let (_, methods) = RPCS.iter().find(|(name, _)| *name == service)?;
    methods.iter().find(|(name, _)| *name == method).map(|(_, need)| *need)
}

/// The same by the path of the HTTP request, such as `/baudbot.v1.ControlService/ListWorlds`.
pub fn needs_at(path: &str) -> Option<Need> {
    let (service, method) = path.strip_prefix('/')?.split_once('/')?;
    needs(service, method)
}

/// A service by its full name, with what each of its methods needs.
pub type Service = (&'static str, &'static [(&'static str, Need)]);

/// All services, and what each of their methods needs.
pub const RPCS: &[Service] = &[
    ("baudbot.v1.ControlService", CONTROL),
    ("baudbot.v1.ObserveService", OBSERVE),
    ("baudbot.v1.BrainLinkService", &[("Attach", Need::Drive)]),
    ("baudbot.v1.TrainerService", &[("Train", Need::Train)]),
    ("grpc.health.v1.Health", HEALTH),
    ("grpc.reflection.v1.ServerReflection", REFLECTION),
    ("grpc.reflection.v1alpha.ServerReflection", REFLECTION),
];

/// An observer reads; whatever changes a world, or takes its whole state away, is the operator's.
const CONTROL: &[(&str, Need)] = &[
    ("CreateWorld", Need::Operate),
    ("ListWorlds", Need::Observe),
    ("GetWorld", Need::Observe),
    ("StartWorld", Need::Operate),
    ("PauseWorld", Need::Operate),
    ("StepWorld", Need::Operate),
    ("SetPace", Need::Operate),
    ("ResetWorld", Need::Operate),
    ("SnapshotWorld", Need::Operate),
    ("RestoreWorld", Need::Operate),
    ("Intervene", Need::Operate),
    ("GetBudget", Need::Observe),
    ("SaveWorld", Need::Operate),
    ("CloneWorld", Need::Operate),
    ("StartRecording", Need::Operate),
    ("StopRecording", Need::Operate),
    ("ListRecordings", Need::Observe),
    ("OpenRecording", Need::Operate),
    ("DescribeReplay", Need::Observe),
    ("SeekReplay", Need::Operate),
    ("ForkReplay", Need::Operate),
    ("DeleteWorld", Need::Operate),
    ("GetLimits", Need::Observe),
];

const OBSERVE: &[(&str, Need)] = &[
    ("DescribeWorld", Need::Observe),
    ("Watch", Need::Observe),
    ("GetCoverage", Need::Observe),
    ("WatchCable", Need::Observe),
];

/// Probes of an orchestrator have no token, and `Check` reveals only that services are served. `Watch` keeps a stream
/// open, which costs the server a place.
const HEALTH: &[(&str, Need)] = &[("Check", Need::Nothing), ("Watch", Need::AnyToken)];

/// The contract is no secret, but a stranger need not learn what this server offers.
const REFLECTION: &[(&str, Need)] = &[("ServerReflectionInfo", Need::AnyToken)];

impl fmt::Display for Need {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nothing => "nothing",
            Self::AnyToken => "any token",
            Self::Observe => "observe",
            Self::Operate => "operate",
            Self::Train => "train",
            Self::Drive => "drive",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_in_the_table_is_refused() {
        assert_eq!(needs("baudbot.v1.ControlService", "ListWorlds"), Some(Need::Observe));
        assert_eq!(needs_at("/baudbot.v1.ControlService/DeleteWorld"), Some(Need::Operate));
        let (service, methods) = RPCS[0];
        for wrong in ["", "listworlds", "ListWorlds/", "ListWorlds ", "Attach"] {
            assert_eq!(needs(service, wrong), None, "{wrong}");
        }
        assert_eq!(needs("ControlService", methods[0].0), None);
        for wrong in
            ["", "/", "//", "baudbot.v1.ControlService/GetWorld", "//baudbot.v1.ControlService/GetWorld"]
        {
            assert_eq!(needs_at(wrong), None, "{wrong}");
        }
        assert_eq!(needs_at("/baudbot.v1.ControlService/GetWorld/"), None);
        assert_eq!(needs_at("/baudbot.v1.ControlService/GetWorld?"), None);
    }
}
