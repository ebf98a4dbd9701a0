//! Drives of the brain in a simulated world, in this process.

use baudbot_scenario::parse;
use baudbot_server::drive;
use wall_follower::Follow;

const ARENA: &str = include_str!("../../../catalogue/scenarios/wander.toml");

type Tested = Result<(), Box<dyn std::error::Error>>;

#[test]
fn it_goes_round_the_room_and_touches_nothing() -> Tested {
    for seed in 1..=5 {
        let mut arena = parse(ARENA)?;
        arena.seed = seed;
        let drive = drive(&arena, Follow::default(), 60.0)?;
        assert!(drive.collisions.is_empty(), "seed {seed}: {:?}", drive.collisions);
        assert!(drive.distance_m() > 10.0, "seed {seed}: {} m", drive.distance_m());
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let is_there = drive.path.iter().any(|point| {
                let position = point.pose.position;
                position.x * x > 0.8 && position.y * y > 0.8
            });
            assert!(is_there, "seed {seed}: it was never in the corner at {x}, {y}");
        }
    }
    Ok(())
}

#[test]
fn the_same_arena_gives_the_same_drive() -> Tested {
    let drive =
        || -> Result<_, Box<dyn std::error::Error>> { Ok(drive(&parse(ARENA)?, Follow::default(), 60.0)?) };
    assert_eq!(drive()?.state_hash(), drive()?.state_hash());
    Ok(())
}

#[test]
fn a_brain_that_ignores_walls_runs_into_one() -> Tested {
    let careless = Follow { wanted: 1.0, gain: 0.0, ..Follow::default() };
    let drive = drive(&parse(ARENA)?, careless, 60.0)?;
    assert_eq!(drive.collisions.len(), 1, "{:?} at the end: {}", drive.collisions, drive.ending);
    assert_eq!(drive.collisions[0].with, "wall_right");
    Ok(())
}
