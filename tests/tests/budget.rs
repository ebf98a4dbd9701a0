//! The budget as an operator asks for it.

use baudbot_proto::v1;
use baudbot_proto::v1::get_budget_request::Scenario as Given;
use baudbot_server::{Lockstep, Pace};
use baudbot_tests::system::{operator, serve};
use baudbot_tests::{KHEPERA, WANDER, scenario};
use tonic::{Code, Status};

use crate::self_driving::{alone, with_another};

async fn ask(
    server: &baudbot_server::Server,
    request: v1::GetBudgetRequest,
) -> Result<Vec<v1::RobotBudget>, Status> {
    let mut operator = operator(server).await;
    operator.get_budget(request).await.map(|response| response.into_inner().robots)
}

fn request(given: Given, overrides: &[&str]) -> v1::GetBudgetRequest {
    let overrides = overrides.iter().map(|&text| text.to_owned()).collect();
    v1::GetBudgetRequest { scenario: Some(given), overrides, robots: Vec::new() }
}

#[tokio::test]
async fn an_operator_asks_what_a_cycle_costs_and_what_would_mend_it() {
    let server = serve(scenario(WANDER, &[]), Pace::Stepped(Lockstep::default())).await;
    let of_world = ask(&server, request(Given::World("w".into()), &[])).await.unwrap();
    let of_text = ask(&server, request(Given::ScenarioToml(WANDER.into()), &[])).await.unwrap();
    assert_eq!(of_world, of_text);
    let [robot] = &of_world[..] else { panic!("{of_world:?}") };
    assert_eq!((robot.robot.as_str(), robot.step_ns), ("robot", 10_000_000));
    assert_eq!(robot.verdict(), v1::BudgetVerdict::Misses);
    let sum: u64 = robot.rows.iter().map(|row| row.span.unwrap().typical_ns.unwrap()).sum();
    assert_eq!(robot.total.unwrap().typical_ns, Some(sum));
    assert_eq!(robot.ages.len(), 5);

    // The first remedy is tried.
    let remedy = &robot.remedies[0];
    assert_eq!(remedy.overrides, ["robots.robot.link.baud=38400"]);
    let mended = request(Given::ScenarioToml(WANDER.into()), &[&remedy.overrides[0]]);
    let mended = ask(&server, mended).await.unwrap().remove(0);
    assert_eq!((mended.total, mended.verdict()), (remedy.total, remedy.verdict()));
    assert!(mended.remedies.is_empty(), "{mended:?}");
    server.shutdown().await;
}

#[tokio::test]
async fn what_cannot_be_asked_is_refused_by_name() {
    let server = serve(scenario(KHEPERA, &[]), Pace::Stepped(Lockstep::default())).await;
    let world = || Given::World("w".into());
    let unknown = v1::GetBudgetRequest { robots: vec!["bob".into()], ..request(world(), &[]) };
    let cases = [
        (v1::GetBudgetRequest::default(), Code::InvalidArgument, "scenario: must be set"),
        (request(world(), &["step_ms=1"]), Code::InvalidArgument, "overrides: apply to a scenario_toml"),
        (request(Given::World("v".into()), &[]), Code::NotFound, "`v`"),
        (request(Given::ScenarioToml("x".into()), &[]), Code::InvalidArgument, "scenario_toml: "),
        (unknown, Code::NotFound, "robots: there is no robot `bob`"),
    ];
    for (request, code, text) in cases {
        let refused = ask(&server, request).await.unwrap_err();
        assert!(refused.code() == code && refused.message().contains(text), "{refused:?}");
    }
    server.shutdown().await;
}

#[tokio::test]
async fn what_a_program_costs_is_not_measured_on_request_and_the_answer_names_the_command() {
    let server = serve(with_another(1.0), Pace::Stepped(Lockstep::default())).await;
    let world = || Given::World("w".into());
    let others = ask(&server, request(world(), &[])).await.unwrap();
    assert_eq!(others.iter().map(|robot| robot.robot.as_str()).collect::<Vec<_>>(), ["other"]);
    let named = v1::GetBudgetRequest { robots: vec!["robot".into()], ..request(world(), &[]) };
    let refused = ask(&server, named).await.unwrap_err();
    assert_eq!(refused.code(), Code::FailedPrecondition);
    assert!(refused.message().contains("baudbot budget SCENARIO --robot robot"), "{refused:?}");
    server.shutdown().await;
    let server = serve(alone(1.0), Pace::Stepped(Lockstep::default())).await;
    let refused = ask(&server, request(world(), &[])).await.unwrap_err();
    assert!(
        refused.message().contains("baudbot budget SCENARIO --robot robot"),
        "there is no other: {refused:?}"
    );
    server.shutdown().await;
}
