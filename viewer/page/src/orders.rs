//! What a page asks of its own program, as JSON: `{"id": 1, "order": {"scenario": "wander"}}`.
//!
//! Answers are `{"id": 1, "result": …}` or `{"id": 1, "error": "…"}`. When a brain does not drive any more, there is
//! `{"over": {"world": …, "robots": […], "brain": …, "error": …}}`.

use baudbot_brains::catalogue;
use baudbot_import::embedded;
use baudbot_import::source::Source;
use baudbot_server::Services;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::brains::{Assignment, Driver};

/// An order, with the number of its answer.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Numbered {
    id: u32,
    order: Order,
}

/// What can be asked.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Order {
    /// Which scenarios, presets and brains there are.
    Catalogue {},
    /// The text of a scenario, with all that it refers to in it.
    Scenario(String),
    /// The text of a brain that is described in TOML.
    Brain(String),
    /// That a brain drives robots from now on.
    Attach(Assignment),
}

/// Carries out an order. Answers go to `tell`, now and later.
pub async fn carry_out(order: &[u8], services: Services, tell: impl Fn(Value)) {
    let Numbered { id, order } = match serde_json::from_slice(order) {
        Ok(order) => order,
        Err(error) => return tell(json!({ "id": 0, "error": format!("order: {error}") })),
    };
    match answer(order, services).await {
        Ok(Answer::Value(result)) => tell(json!({ "id": id, "result": result })),
        Ok(Answer::Drives(driver)) => {
            let assignment = driver.assignment().clone();
            tell(json!({ "id": id, "result": { "brain": assignment.brain() } }));
            let error = driver.drive().await.err().map(|error| error.to_string());
            let (world, robots, brain) = (assignment.world(), assignment.robots(), assignment.brain());
            tell(json!({ "over": { "world": world, "robots": robots, "brain": brain, "error": error } }));
        }
        Err(error) => tell(json!({ "id": id, "error": error.to_string() })),
    }
}

enum Answer {
    Value(Value),
    Drives(Box<Driver>),
}

type AnyError = Box<dyn std::error::Error + Send + Sync>;

async fn answer(order: Order, services: Services) -> Result<Answer, AnyError> {
    Ok(match order {
        Order::Catalogue {} => Answer::Value(catalogue()),
        Order::Scenario(name) => {
            embedded::scenario(&name).ok_or_else(|| format!("there is no scenario `{name}`"))?;
            Answer::Value(Source::find(&name)?.text.into())
        }
        Order::Brain(name) => Answer::Value(catalogue::described(&name)?.into()),
        Order::Attach(assignment) => Answer::Drives(Box::new(Driver::attach(services, assignment).await?)),
    })
}

fn catalogue() -> Value {
    let scenarios: Vec<_> = embedded::scenarios()
        .map(|(name, text)| json!({ "name": name, "about": embedded::summary(text) }))
        .collect();
    let brains: Vec<_> = catalogue::catalogue()
        .into_iter()
        .map(|entry| {
            let parameters: Vec<_> = entry.parameters.iter().map(|setting| setting.name).collect();
            json!({ "name": entry.name, "about": entry.summary, "parameters": parameters })
        })
        .collect();
    let presets: Vec<_> = baudbot_scenario::presets::presets()
        .map(|preset| json!({ "name": preset.name, "kind": preset.kind.word(), "about": preset.description }))
        .collect();
    json!({ "scenarios": scenarios, "brains": brains, "presets": presets })
}
