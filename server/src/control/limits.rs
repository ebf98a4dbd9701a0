//! The limits of the server, for a client.

use baudbot_proto::v1;

use crate::limits::{InForce, Payer, Unit, Usage};

/// All limits, as they hold for who pays for the call.
pub(super) fn response(limits: &InForce, payer: Option<&Payer>) -> v1::GetLimitsResponse {
    let usage = limits.usage().map(|usage| match payer {
        Some(Payer(tally)) => limits.of_caller(usage, tally),
        None => usage,
    });
    v1::GetLimitsResponse { limits: usage.map(message).collect() }
}

fn message(Usage { info, value, used, refused }: Usage) -> v1::ServerLimit {
    let unit = match info.unit {
        Unit::Things(..) => v1::LimitUnit::Count,
        Unit::Seconds(..) => v1::LimitUnit::Seconds,
        Unit::Bytes => v1::LimitUnit::Bytes,
    };
    v1::ServerLimit {
        name: info.name.to_owned(),
        option: info.option.to_owned(),
        meaning: info.help.lines().next().unwrap_or_default().to_owned(),
        unit: unit.into(),
        value,
        used,
        refused,
    }
}
