//! Rolling resistance of driven plain wheels against its closed forms: a moment N c R about the axle.

use scene::{DriveModel, Motor, RobotDef, WorldDef};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

const GRAVITY: f64 = 9.81;
/// Step of the tests, s.
const STEP: f64 = 0.002;

/// Returns a world of a flat floor that rises ahead by an angle, rad, with one class. All wheels on it have this coefficient, and its motors
/// are changed.
fn world(class: &str, slope: f64, coefficient: f64, change: impl FnMut(&mut Motor)) -> World {
    World::new(def(class, [0.0, slope, 0.0], coefficient, change), Options { time_step: STEP, ..Options::default() })
}

/// Returns the definition of such a world, of a floor that is turned about x, y and z, rad.
fn def(class: &str, turn: [f64; 3], coefficient: f64, change: impl FnMut(&mut Motor)) -> WorldDef {
    let mut def: WorldDef = scene_loader::load("smooth", &[]).expect("a map");
    for solid in &mut def.map.solids {
        solid.material.rolling_resistance = coefficient;
        solid.material.friction = 1.0;
        (solid.position, solid.rotation) = ([0.0; 3], turn);
    }
    let mut robot: RobotDef = scene_loader::robot(class, &[]).expect("a robot");
    robot.wheels_mut().for_each(|wheel| (wheel.material.rolling_resistance, wheel.material.friction) = (0.0, 1.0));
    robot.set_drive_model(Some(DriveModel::Articulated));
    robot.motors_mut().for_each(change);
    // Air brakes nothing here.
    for solid in &mut robot.links[0].solids {
        (solid.material.linear_damping, solid.material.angular_damping) = (0.0, 0.0);
    }
    def.robots = [(class.to_owned(), robot)].into();
    def
}

/// Spawns the class and returns the way that it goes ahead in some seconds after a second of rest, m, for a command.
fn way(mut world: World, class: &str, command: Option<&str>, seconds: f64) -> (f64, f64) {
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
    let state = |world: &World| world.snapshot().robots[0].body;
    if command.is_some() {
        run(&mut world, 1.0);
    }
    let before = state(&world);
    command.into_iter().for_each(|line| drop(apply(&mut world, robot, line)));
    run(&mut world, seconds);
    let after = state(&world);
    let ahead = (before.pose.inverse() * after.pose).translation.x;
    (ahead, (after.pose.rotation.inverse() * after.linear).x)
}

/// Takes a motor from a wheel. Its rotor turns on.
fn without_torque(motor: &mut Motor) {
    (motor.gain, motor.integral_time) = (1e-9, None);
}

/// A free wheel is braked: a robot whose motors have no torque rolls down by (sin a - c cos a) g m / (m + sum of I / R^2), or stays.
#[test]
fn a_free_robot_rolls_down_a_slope_by_what_its_wheels_leave() {
    for class in ["P3AT", "P2AT", "Zerg"] {
        let robot: RobotDef = scene_loader::robot(class, &[]).expect("a robot");
        let of_wheel = |wheel: scene::MountedWheel| {
            let rotor = wheel.drive.map_or(0.0, |motor| motor.armature);
            (wheel.wheel.mass * wheel.radius.powi(2) / 2.0 + rotor) / wheel.radius.powi(2)
        };
        let heavier = 1.0 + robot.driven().map(of_wheel).sum::<f64>() / f64::from(robot.mass());
        for (slope, coefficient) in [(0.05_f64, 0.0), (0.05, 0.02), (0.05, 0.04), (0.1, 0.03)] {
            let (_, speed) = way(world(class, slope, coefficient, without_torque), class, None, 2.0);
            let (_, later) = way(world(class, slope, coefficient, without_torque), class, None, 3.0);
            let expected = (slope.sin() - coefficient * slope.cos()) * GRAVITY / heavier;
            let found = -(later - speed);
            println!("{class} on {slope} rad with {coefficient}: {found:.4} m/s2, {expected:.4} expected");
            assert!((found - expected).abs() < 0.002 * expected + 1e-3, "{class}, {slope}, {coefficient}: {found}");
        }
        // It slides when it touches down, and stays then.
        let [(before, _), (after, speed)] =
            [3.0, 13.0].map(|seconds| way(world(class, 0.05, 0.06, without_torque), class, None, seconds));
        let moved = after - before;
        println!("{class} on 0.05 rad with 0.06: {moved:.6} m, {speed:.2e} m/s");
        assert!(moved.abs() < 1e-4 && speed.abs() < 1e-5, "{class} stays: {moved} m, {speed} m/s");
    }
}

/// A driven wheel costs torque: a robot sets out if its motors have more than N c R, and not if they have less.
#[test]
fn a_driven_robot_sets_out_with_more_torque_than_its_wheels_take() {
    for class in ["P3AT", "P2AT", "Talon", "Kenaf"] {
        let robot: RobotDef = scene_loader::robot(class, &[]).expect("a robot");
        let wheels: Vec<f64> = robot.driven().map(|wheel| wheel.radius).collect();
        let coefficient = 0.05;
        // Of the weight every wheel takes its moment, and every motor gives as much.
        let needed = f64::from(robot.mass()) * GRAVITY * coefficient * wheels.iter().sum::<f64>()
            / wheels.len() as f64
            / wheels.len() as f64;
        for (share, goes) in [(0.8, false), (1.3, true)] {
            let set = |motor: &mut Motor| motor.max_torque = share * needed;
            let (moved, _) = way(world(class, 0.0, coefficient, set), class, Some("DRIVE {Left 1} {Right 1}"), 2.0);
            println!("{class} with {share} of {needed:.3} N m: {moved:.4} m");
            assert_eq!(moved > 0.05, goes, "{class} with {share}: {moved} m");
            // A step is blind to the motor's part of it, so the wheel gives way by 3 mm/s at most.
            assert!(goes || moved.abs() < 6e-3, "{class} with {share}: {moved} m");
        }
    }
}

/// A turn on the spot keeps its chi, as a moment on a wheel spends no friction.
#[test]
fn a_turn_on_the_spot_does_not_depend_on_rolling_resistance() {
    for class in ["P3AT", "P2AT", "Talon"] {
        let turned = |coefficient: f64| {
            let mut world = world(class, 0.0, coefficient, |motor| motor.max_torque *= 10.0);
            let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
            apply(&mut world, robot, "DRIVE {Left 1} {Right -1}");
            run(&mut world, 2.0);
            let rate = |world: &World| world.snapshot().robots[0].body.angular.z;
            let rates: Vec<f64> = (0..100).map(|_| (run(&mut world, 0.01), rate(&world)).1).collect();
            rates.iter().sum::<f64>() / rates.len() as f64
        };
        let [without, with] = [0.0, 0.05].map(turned);
        println!("{class}: {without:.5} rad/s, with resistance {with:.5}");
        assert!((with / without - 1.0).abs() < 2e-3, "{class}: {without}, {with}");
    }
}

/// Rollers turn at sqrt(2) times the speed of a robot that goes sideways, and stand still ahead. So dry friction of their bearings brakes it
/// by sqrt(2) times the coefficient, sideways alone.
#[test]
fn rollers_that_turn_brake_a_robot_that_coasts_sideways() {
    let slope = 0.1_f64;
    for model in [DriveModel::Articulated, DriveModel::Analytic] {
        // Speed gained between 1 and 2 s, as a share of g sin a, for a slope ahead and one to the side.
        let gained = |bearing_friction: f64| {
            let class = "YouBot";
            let ways = [[0.0, slope, 0.0], [slope, 0.0, 0.0]];
            ways.map(|turn| {
                let mut def = def(class, turn, 0.0, without_torque);
                let robot = def.robots.get_mut(class).expect("a class");
                robot.set_drive_model(Some(model));
                for rollers in robot.wheels_mut().filter_map(|wheel| wheel.rollers.as_mut()) {
                    (rollers.bearing_friction, rollers.damping) = (bearing_friction, 1e-9);
                    rollers.material.rolling_resistance = 0.0;
                    // A roller that lands is at rest, and a heavy one takes energy to turn. Few rollers lose some at every change.
                    (rollers.mass, rollers.count, rollers.last_phase) = (0.001, 24, std::f64::consts::PI / 24.0);
                }
                let mut world = World::new(def, Options { time_step: STEP, ..Options::default() });
                init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
                let mut speed =
                    |seconds: f64| (run(&mut world, seconds), world.snapshot().robots[0].body.linear.norm()).1;
                let before = speed(1.0);
                (speed(1.0) - before) / (GRAVITY * slope.sin())
            })
        };
        let free = gained(0.0);
        for coefficient in [0.01, 0.03, 0.05] {
            let braked = gained(coefficient);
            let shares = [0, 1].map(|way| (1.0 - braked[way] / free[way]) * slope.tan());
            println!("{model:?}, {coefficient}: {shares:.5?} of g, free {free:.4?}");
            assert!(shares[0].abs() < 2e-4, "{model:?} ahead: {}", shares[0]);
            let expected = 2.0_f64.sqrt() * coefficient;
            assert!((shares[1] - expected).abs() < 5e-4, "{model:?} sideways: {}, not {expected}", shares[1]);
        }
    }
}
