use super::*;

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} is not {expected}");
}

#[test]
fn balls_that_meet_head_on_share_their_momentum() {
    for (e, expected) in [(1.0, (0.0, 2.0)), (0.5, (0.5, 1.5)), (0.0, (1.0, 1.0))] {
        let mut states = [state(0.0, 0.0, 2.0, 0.0), state(0.2005, 0.0, 0.0, 0.0)];
        let balls = [ball(0.1, 1.0, e), ball(0.1, 1.0, e)];
        // The gap is closed first if there is no restitution.
        for _ in 0..3 {
            run(&balls, &mut states, &empty(), &[], 0.001);
        }
        assert_near(states[0].velocity_m_s.x, expected.0);
        assert_near(states[1].velocity_m_s.x, expected.1);
    }
}

#[test]
fn a_heavy_ball_throws_a_light_one_as_the_book_says() {
    let mut states = [state(0.0, 0.0, 1.0, 0.0), state(0.2005, 0.0, 0.0, 0.0)];
    run(&[ball(0.1, 3.0, 1.0), ball(0.1, 1.0, 1.0)], &mut states, &empty(), &[], 0.001);
    assert_near(states[0].velocity_m_s.x, 0.5);
    assert_near(states[1].velocity_m_s.x, 1.5);
}

#[test]
fn a_ball_is_reflected_by_a_wall() {
    let mut states = [state(0.895, 0.0, 3.0, 1.0)];
    run(&[ball(0.1, 1.0, 0.8)], &mut states, &wall_at(1.0), &[], 0.002);
    assert_near(states[0].velocity_m_s.x, -2.4);
    assert_near(states[0].velocity_m_s.y, 1.0);
}

#[test]
fn a_robot_kicks_a_ball_and_loses_the_momentum() {
    let mut states = [state(0.3005, 0.0, 0.0, 0.0)];
    let robot = robot(0.0, 0.0, 0.0, 1.0, 0.001);
    let found = run(&[ball(0.1, 1.0, 1.0)], &mut states, &empty(), &[robot], 0.001);
    // J = (1 + e) V / (1/M + 1/m) = 2 / (1/3 + 1).
    assert_near(states[0].velocity_m_s.x, 1.5);
    assert_near(found[0].speed_m_s, 0.5);
    assert_eq!((found[0].blocked, found[0].touched), (false, Some(0)));
    assert_near(found[0].pose.position.x, 0.0005);
}

#[test]
fn a_robot_that_is_hit_from_the_side_is_a_wall_and_at_an_angle_half_of_one() {
    let mut states = [state(0.0, 0.3005, 0.0, -1.0)];
    let sideways = robot(0.0, 0.0, 0.0, 0.0, 0.001);
    let found = run(&[ball(0.1, 1.0, 1.0)], &mut states, &empty(), &[sideways], 0.001);
    assert_near(states[0].velocity_m_s.y, 1.0);
    assert_eq!(found[0].speed_m_s, 0.0);

    let mut states = [state(0.0, 0.3005, 0.0, -1.0)];
    let slanted = robot(0.0, 0.0, core::f64::consts::FRAC_PI_4, 0.0, 0.001);
    let found = run(&[ball(0.1, 1.0, 1.0)], &mut states, &empty(), &[slanted], 0.001);
    // Inverse masses 1 and (n·h)²/M = 1/6: J = 2 / (7/6).
    assert_near(states[0].velocity_m_s.y, 2.0 * 6.0 / 7.0 - 1.0);
    assert_near(found[0].speed_m_s, -(12.0 / 7.0) * 0.5_f64.sqrt() / 3.0);
}

#[test]
fn a_box_pushed_at_its_centre_does_not_turn() {
    let mut states = [state(0.4, 0.0, 0.0, 0.0)];
    let robot = robot(0.0, 0.0, 0.0, 1.0, 0.001);
    let found = run(&[crate_of(0.3998, 0.4, 1.0, 0.0)], &mut states, &empty(), &[robot], 0.001);
    assert_near(states[0].velocity_m_s.x, 0.75);
    assert_near(states[0].spin_rad_s, 0.0);
    assert_near(found[0].speed_m_s, 0.75);
}

#[test]
fn a_box_pushed_off_centre_turns() {
    let mut states = [state(0.4, 0.1, 0.0, 0.0)];
    let robot = robot(0.0, 0.0, 0.0, 1.0, 0.001);
    let found = run(&[crate_of(0.3998, 0.4, 1.0, 0.0)], &mut states, &empty(), &[robot], 0.001);
    // The contact is 0.1 m below the centre, its lever; k² = (a² + b²) / 12.
    let gyration = (0.3998 * 0.3998 + 0.16) / 12.0;
    let impulse = 1.0 / (1.0 / 3.0 + 1.0 + 0.01 / gyration);
    assert_near(states[0].velocity_m_s.x, impulse);
    assert_near(states[0].spin_rad_s, 0.1 * impulse / gyration);
    assert_near(found[0].speed_m_s, 1.0 - impulse / 3.0);
}

#[test]
fn friction_stops_after_v2_by_2_mu_g_whatever_the_step() {
    for dt in [0.0001, 0.001, 0.01, 0.05] {
        let movables = [crate_of(0.4, 0.3, 2.0, 0.4)];
        let mut states = [state(0.0, 0.0, 1.2, -0.9)];
        let mut steps = 0;
        while states[0].velocity_m_s != Vector::zeros() {
            run(&movables, &mut states, &empty(), &[], dt);
            steps += 1;
            assert!(f64::from(steps) * dt < 1.0);
        }
        let expected = 1.5 * 1.5 / (2.0 * 0.4 * GRAVITY_M_S2);
        assert_near(states[0].pose.position.coords.norm(), expected);
        assert_eq!(states[0].pose.heading, 0.0);
    }
}

#[test]
fn a_spinning_box_stops_turning_in_its_place() {
    let movables = [crate_of(0.3, 0.3, 2.0, 0.4)];
    let mut states = [MovableState { spin_rad_s: 5.0, ..state(1.0, 2.0, 0.0, 0.0) }];
    for _ in 0..1000 {
        run(&movables, &mut states, &empty(), &[], 0.001);
    }
    // The angle is k ω² / (2 μ g), with k² = a² / 6.
    let gyration = 0.3 / 6.0_f64.sqrt();
    assert_near(states[0].pose.heading, gyration * 25.0 / (2.0 * 0.4 * GRAVITY_M_S2));
    assert_eq!((states[0].spin_rad_s, states[0].pose.position), (0.0, Point::new(1.0, 2.0)));
}

#[test]
fn a_robot_weaker_than_the_friction_moves_nothing_and_a_stronger_one_does() {
    // The box of 2 kg holds with 0.5 · 2 · g = 9.8 N.
    for (force_n, moved) in [(9.0, false), (12.0, true)] {
        let (dt, movables) = (0.001, [crate_of(0.4, 0.4, 2.0, 0.5)]);
        let mut states = [state(0.4001, 0.0, 0.0, 0.0)];
        let (mut x, mut speed) = (0.0, 0.0);
        for _ in 0..1000 {
            let robot = robot(x, 0.0, 0.0, speed + force_n / 3.0 * dt, dt);
            let found = run(&movables, &mut states, &empty(), &[robot], dt);
            (x, speed) = (found[0].pose.position.x, found[0].speed_m_s);
        }
        let way = states[0].pose.position.x - 0.4001;
        if moved {
            // a = (F - μ m g) / (M + m).
            let expected = 0.5 * (force_n - GRAVITY_M_S2) / 5.0;
            assert!((way - expected).abs() < 0.01 * expected, "{way} {expected}");
            assert!(states[0].pose.heading.abs() < 1e-6 && (states[0].pose.position.x - x - 0.4) < 2e-4);
        } else {
            assert!(way < 1e-6, "{way}");
        }
    }
}

#[test]
fn a_box_between_robot_and_wall_blocks_the_robot() {
    let (dt, movables) = (0.01, [crate_of(0.4, 0.4, 2.0, 0.3)]);
    let mut states = [state(0.6, 0.03, 0.0, 0.0)];
    let (arena, mut x) = (wall_at(1.0), 0.0);
    let mut last = Vec::new();
    for _ in 0..300 {
        // The motors hold the speed whatever happens.
        last = run(&movables, &mut states, &arena, &[robot(x, 0.0, 0.0, 0.5, dt)], dt);
        x = last[0].pose.position.x;
    }
    assert!(x <= 0.4 && x > 0.399, "{x}");
    assert!(states[0].pose.position.x <= 0.8 && states[0].pose.position.x > 0.799, "{states:?}");
    assert!(last[0].speed_m_s.abs() < 0.01 && last[0].touched == Some(0), "{last:?}");
}

#[test]
fn a_polygon_robot_pushes_flat_and_turns_a_box_with_its_corner() {
    let square = rectangle(0.4, 0.4);
    let body = |pusher: Pusher<'static>| Pusher { form: Form::Polygon(&square), ..pusher };
    let movables = [crate_of(0.4, 0.4, 1.0, 0.0)];
    let mut states = [state(0.4, 0.0, 0.0, 0.0)];
    let pushing = body(robot(-0.0001, 0.0, 0.0, 1.0, 0.001));
    run(&movables, &mut states, &empty(), &[pushing], 0.001);
    assert!(
        (states[0].velocity_m_s.x - 0.75).abs() < 1e-6 && states[0].spin_rad_s.abs() < 1e-6,
        "{states:?}"
    );

    // The robot's corner, at (0.2, -0.2) from its centre, comes on at 0.2 m/s against the middle of a side.
    let mut states = [state(0.4, -0.2, 0.0, 0.0)];
    let mut turning = body(robot(-0.0001, 0.0, 0.0, 0.0, 0.001));
    (turning.turn_rate_rad_s, turning.after.heading) = (1.0, 0.001);
    let found = run(&movables, &mut states, &empty(), &[turning], 0.001);
    let impulse = 0.2 / (1.0 + 1.0 / 3.0 + 0.04 / 0.1);
    assert!((states[0].velocity_m_s.x - impulse).abs() < 1e-3, "{states:?}");
    assert!((found[0].turn_rate_rad_s - (1.0 - 0.2 * impulse / 0.1)).abs() < 1e-3, "{found:?}");
}

#[test]
fn a_fast_ball_does_not_pass_through_a_thin_wall_nor_a_door_nor_a_robot() {
    let door = [Body::Disc(disc(1.0, 0.0, 0.001))];
    for e in [0.0, 0.7] {
        for obstacle in 0..3 {
            let mut states = [state(0.0, 0.0, 90.0, 0.0)];
            let arena = if obstacle == 0 { wall_at(1.0) } else { empty() };
            let fixed = Fixed { arena: &arena, bodies: if obstacle == 1 { &door } else { &[] } };
            let parked = [robot(1.2, 0.0, 1.5, 0.0, 0.05)];
            let pushers = if obstacle == 2 { &parked[..] } else { &[] };
            for _ in 0..5 {
                step(&[ball(0.02, 0.1, e)], &mut states, &fixed, pushers, 0.05);
                assert!(states[0].pose.position.x < 1.0, "{obstacle} {states:?}");
            }
        }
    }
}

#[test]
fn a_fast_ball_goes_all_of_its_way() {
    let mut states = [state(0.0, 0.0, 60.0, 80.0)];
    run(&[ball(0.02, 0.1, 0.5)], &mut states, &empty(), &[], 0.05);
    assert_near(states[0].pose.position.x, 3.0);
    assert_near(states[0].pose.position.y, 4.0);
}

#[test]
fn a_door_that_would_hit_something_can_be_told() {
    let (thing, state) = (crate_of(0.4, 0.4, 1.0, 0.3), state(1.0, 0.0, 0.0, 0.0));
    let body = thing.shape.form().at(&state.pose);
    let leaf = rectangle(1.0, 0.05);
    let door = |angle| Form::Polygon(&leaf).at(&Pose::new(0.5, -0.4, angle));
    assert!(!door(0.0).overlaps(&body) && door(0.9).overlaps(&body));
}

#[test]
fn who_meets_nothing_is_not_changed_by_a_bit() {
    let (dt, movables) = (0.01, [crate_of(0.4, 0.4, 2.0, 0.3), ball(0.1, 1.0, 0.5)]);
    let mut states = [state(3.0, 0.1, 0.0, 0.0), state(0.0, 0.5, 0.0, 0.0)];
    let (before, pusher) = (states.clone(), robot(0.0, 0.1, 0.3, 0.7, dt));
    let found = run(&movables, &mut states, &empty(), &[pusher], dt);
    assert_eq!(states, before);
    let free =
        Reaction { pose: pusher.after, speed_m_s: 0.7, turn_rate_rad_s: 0.0, blocked: false, touched: None };
    assert_eq!(found, [free]);
}

#[test]
fn robots_in_another_order_do_the_same() {
    let (dt, movables) = (0.005, [crate_of(0.4, 0.4, 2.0, 0.3), ball(0.1, 1.0, 0.5)]);
    let robots =
        [robot(0.0, 0.0, 0.0, 1.0, dt), robot(1.1, 0.05, 3.1, 0.8, dt), robot(0.5, 1.0, -1.5, 1.0, dt)];
    let mut states = [state(0.5, 0.0, 0.0, 0.0), state(0.5, 0.4, 0.0, -1.0)];
    let mut mirrored = states.clone();
    for _ in 0..20 {
        let found = run(&movables, &mut states, &empty(), &robots, dt);
        let backwards = [robots[2], robots[1], robots[0]];
        let mut other = run(&movables, &mut mirrored, &empty(), &backwards, dt);
        other.reverse();
        for (a, b) in states.iter().zip(&mirrored) {
            assert!((a.velocity_m_s - b.velocity_m_s).norm() < 1e-9, "{a:?} {b:?}");
        }
        for (a, b) in found.iter().zip(&other) {
            assert!((a.speed_m_s - b.speed_m_s).abs() < 1e-9, "{a:?} {b:?}");
        }
        mirrored = states.clone();
    }
}

#[test]
fn nonsense_ends() {
    let movables = [crate_of(0.4, 0.4, 2.0, 0.3), ball(0.1, 1.0, 0.5)];
    let mut states = [state(f64::NAN, 0.0, 0.0, 0.0), state(0.0, 0.0, f64::INFINITY, f64::NAN)];
    for dt in [0.01, 0.0, -1.0, f64::NAN] {
        run(&movables, &mut states, &wall_at(1.0), &[robot(0.0, f64::NAN, 0.0, 1.0, 0.01)], dt);
    }
}
