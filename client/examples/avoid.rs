//! A whole brain: drives on, slower as something comes near; turns away from what is too near, and keeps
//! turning that way until all is clear. `cargo run -p baudbot-client --example avoid [ADDRESS]`, with robot
//! `robot` of world `wander`.

use baudbot_client::{Action, Brain, Error, Turn, connect, run};

#[derive(Default)]
struct Avoid {
    turning: f64,
}

impl Brain for Avoid {
    fn step(&mut self, turn: &Turn) -> Action {
        let near = |sensor| turn.value(sensor).unwrap_or(1.0);
        let left = near("ir_left").max(near("ir_front_left"));
        let right = near("ir_right").max(near("ir_front_right"));
        let nearest = left.max(right).max(near("ir_front"));
        if nearest < 0.2 {
            self.turning = 0.0;
        } else if nearest > 0.28 && self.turning == 0.0 {
            self.turning = if left > right { 0.4 } else { -0.4 };
        }
        let forward = if self.turning == 0.0 { 0.5 - nearest } else { 0.0 };
        Action::drive(forward + self.turning, forward - self.turning)
    }
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Error> {
    let address = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:7400".to_owned());
    let mut robot = connect(&address).await?.brain("avoid").attach("wander", "robot").await?;
    let summary = run(&mut robot, &mut Avoid::default()).await?;
    println!("the run is over after {} turns", summary.turns);
    Ok(())
}
