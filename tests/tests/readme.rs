//! The test that README.md shows, word for word.

#[test]
fn the_readme_shows_this_test() {
    let (_, shown) = include_str!("readme.rs").split_once("// README.md:\n").unwrap();
    assert!(
        include_str!("../../README.md").contains(&format!("```rust\n{shown}```")),
        "README.md lacks:\n{shown}"
    );
}

// README.md:
use baudbot_brains::catalogue;
use baudbot_client::{Client, run};
use baudbot_server::{Lockstep, Pace, Server, WorldConfig};

#[tokio::test]
async fn ten_seconds_of_avoiding() -> Result<(), Box<dyn std::error::Error>> {
    let toml = std::fs::read_to_string("../scenarios/wander.toml")? + "\n[end]\nafter_s = 10.0\n";
    let scenario = baudbot_scenario::parse(&toml)?;
    let world = WorldConfig::new("w", scenario).pace(Pace::Lockstep(Lockstep::default()));
    let server = Server::builder().world(world).in_process().await?;

    let mut robot = Client::from_channel(server.channel().await?).attach("w", "robot").await?;
    let mut brain = catalogue::brain("avoid", 1, robot.body())?; // or your own
    let summary = run(&mut robot, &mut brain).await?;
    assert_eq!(summary.turns, 500); // it is asked when readings have come, every 20 ms

    server.shutdown().await;
    Ok(())
}
