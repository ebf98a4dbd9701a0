//! x
fn main(){ println!("{}", serde_json::to_string_pretty(&baudbot_scenario::schema()).unwrap()); }
