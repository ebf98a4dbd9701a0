//! The table of needs has each RPC that a server can serve, and no other.

use std::collections::BTreeSet;

use baudbot_access::{Door, Need, RPCS, Right, needs, needs_at};
use prost::Message;
use prost_types::FileDescriptorSet;

/// All RPCs of the contract, and of the services that come with its server.
fn rpcs() -> BTreeSet<(String, String)> {
    let sets = [
        baudbot_proto::DESCRIPTORS,
        tonic_health::pb::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1::FILE_DESCRIPTOR_SET,
        tonic_reflection::pb::v1alpha::FILE_DESCRIPTOR_SET,
    ];
    let mut rpcs = BTreeSet::new();
    for set in sets {
        for file in FileDescriptorSet::decode(set).unwrap().file {
            for service in &file.service {
                let name = format!("{}.{}", file.package(), service.name());
                rpcs.extend(service.method.iter().map(|method| (name.clone(), method.name().to_owned())));
            }
        }
    }
    rpcs
}

#[test]
fn each_rpc_has_a_line_in_the_table() {
    let rpcs = rpcs();
    assert!(rpcs.len() > 30, "{}", rpcs.len());
    let missing: Vec<_> = rpcs.iter().filter(|(service, method)| needs(service, method).is_none()).collect();
    assert!(missing.is_empty(), "crates/access/src/need.rs does not say what these need: {missing:?}");
    for (service, method) in &rpcs {
        assert_eq!(needs_at(&format!("/{service}/{method}")), needs(service, method));
    }
}

#[test]
fn each_line_of_the_table_has_an_rpc() {
    let rpcs = rpcs();
    let mut lines = 0;
    for (service, methods) in RPCS {
        for (method, _) in *methods {
            let rpc = ((*service).to_owned(), (*method).to_owned());
            assert!(rpcs.contains(&rpc), "there is no {service}/{method}");
            lines += 1;
        }
    }
    assert_eq!(lines, rpcs.len(), "an RPC has two lines");
}

/// The calls that each right allows, by hand: a line that moves in the table moves here, too.
#[test]
fn a_right_allows_what_it_says() {
    let allowed = |right: &str| -> BTreeSet<String> {
        let right: Right = right.parse().unwrap();
        let all = rpcs().into_iter().filter(|(service, method)| right.gives(needs(service, method).unwrap()));
        all.filter(|(service, _)| service.starts_with("baudbot")).map(|(_, method)| method).collect()
    };
    let set = |names: &str| names.split_whitespace().map(str::to_owned).collect::<BTreeSet<_>>();
    let reading = "ListWorlds GetWorld GetBudget ListRecordings DescribeReplay GetLimits DescribeWorld Watch GetCoverage WatchCable";
    assert_eq!(allowed("observe"), set(reading));
    assert_eq!(allowed("train"), set(&format!("{reading} Train")));
    assert_eq!(allowed("drive wander/alice"), set("Attach"));
    let others = rpcs().into_iter().filter(|(service, _)| service == "baudbot.v1.ControlService");
    let operating: BTreeSet<_> = others.map(|(_, method)| method).chain(set(reading)).collect();
    assert_eq!(allowed("operate"), operating);
}

#[test]
fn without_a_token_there_are_the_probe_and_the_files_of_the_page() {
    let rpcs = rpcs();
    let free: Vec<_> =
        rpcs.iter().filter(|(service, method)| needs(service, method) == Some(Need::Nothing)).collect();
    assert_eq!(free, [&("grpc.health.v1.Health".to_owned(), "Check".to_owned())]);
    let free: Vec<_> = Door::ALL.into_iter().filter(|door| door.needs() == Need::Nothing).collect();
    assert_eq!(free, [Door::PageFiles]);
}

#[test]
fn the_documentation_has_the_same_table() {
    let documented = include_str!("../../../docs/reference/trust.md");
    let mut rows = String::new();
    for (service, methods) in RPCS {
        for need in [Need::Nothing, Need::AnyToken, Need::Observe, Need::Operate, Need::Train, Need::Drive] {
            let these = methods.iter().filter(|(_, needed)| *needed == need);
            let calls: Vec<_> = these.map(|(method, _)| format!("`{method}`")).collect();
            let words = match need {
                Need::Nothing | Need::AnyToken => need.to_string(),
                Need::Observe | Need::Operate | Need::Train | Need::Drive => format!("`{need}`"),
            };
            if !calls.is_empty() {
                rows += &format!("| `{service}` | {words} | {} |\n", calls.join(", "));
            }
        }
    }
    assert!(documented.contains(&rows), "docs/reference/trust.md lacks:\n{rows}");
}
