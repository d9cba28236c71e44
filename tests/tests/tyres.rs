//! Tyres in the world, against closed forms of the whole robot.

use experiments::real::{self, Measured};
use scene::{DriveModel, RobotDef, Tyre, WorldDef};
use sim_core::{Options, SavedWorld, World};
use system_tests::{apply, init, run};

const TYRE: Tyre = Tyre { stiffness: [6.0, 5.0], patch: [0.03, 0.025], relaxation: None, friction: scene::isotropic() };

/// Returns the effective over the geometric track of a robot with a wheelbase of 0.3 m and a track of 0.4 m.
fn chi(tyre: Tyre, curvature: f64) -> f64 {
    let text = format!(
        "name = 'Robot'\nsource = 'a test'\n[robot]\nmass = 30\nwheelbase = 0.3\ntrack = 0.4\nradius = 0.1\nwidth = 0.06\n\
         [floor]\nfriction = 0.6\nrolling_resistance = 0.03\n[[turn]]\ncurvature = {curvature}\nchi = 1\n"
    );
    let mut measured: Measured = toml::from_str(&text).unwrap_or_else(|error| panic!("{error}"));
    measured.robot.tyre = Some(tyre);
    real::run(&measured).unwrap_or_else(|error| panic!("{error}"))[0].ours
}

/// In wide curves tyres hardly slide: chi - 1 = (stiffness across / along) (wheelbase / track)^2.
#[test]
fn in_wide_curves_stiffness_decides_how_far_a_robot_turns() {
    for across in [4.0, 6.0, 9.0] {
        let found =
            chi(Tyre { stiffness: [6.0, across], patch: [0.002, 0.002], relaxation: Some(0.02), ..TYRE }, 400.0);
        let expected = 1.0 + across / 6.0 * (0.3_f64 / 0.4).powi(2);
        println!("{across}: {found:.4}, expected {expected:.4}");
        assert!((found - expected).abs() < 0.01 * (expected - 1.0), "{across}: {found}, expected {expected}");
    }
}

/// On the spot tyres slide: chi - 1 = (friction across / along)^2 (wheelbase / track)^2, for a patch that is a point.
#[test]
fn on_the_spot_friction_decides_how_far_a_robot_turns() {
    for across in [0.8, 1.0, 1.2] {
        let found = chi(
            Tyre { friction: [1.0, across], patch: [0.001; 2], stiffness: [60.0; 2], relaxation: Some(0.002) },
            0.0,
        );
        let expected = 1.0 + (across * 0.3_f64 / 0.4).powi(2);
        println!("{across}: {found:.4}, expected {expected:.4}");
        assert!((found - expected).abs() < 0.01 * (expected - 1.0), "{across}: {found}, expected {expected}");
    }
}

/// Returns the definition of a world of a floor, turned about x, y and z, rad, and a P3AT with tyres.
fn def(turn: [f64; 3], tyre: Option<Tyre>) -> WorldDef {
    let mut def: WorldDef = scene_loader::load("smooth", &[]).expect("a map");
    for solid in &mut def.map.solids {
        (solid.material.friction, solid.material.rolling_resistance) = (0.6, 0.0);
        (solid.position, solid.rotation) = ([0.0; 3], turn);
    }
    let mut robot: RobotDef = scene_loader::robot("P3AT", &[]).expect("a robot");
    robot.set_drive_model(Some(DriveModel::Articulated));
    robot.wheels_mut().for_each(|wheel| (wheel.tyre, wheel.material.friction) = (tyre, 0.6));
    def.robots = [("P3AT".to_owned(), robot)].into();
    def
}

fn world(turn: [f64; 3], tyre: Option<Tyre>) -> World {
    World::new(def(turn, tyre), Options::default())
}

const INIT: &str = "INIT {ClassName USARBot.P3AT} {Location 0,0,0}";

/// A parked robot holds below atan(mu) and slides above, ahead and aside, and does not creep.
#[test]
fn a_parked_robot_holds_on_a_slope_up_to_its_friction() {
    let limit = 0.6_f64.atan();
    for (turn, name) in [([0.0, 1.0, 0.0], "ahead"), ([1.0, 0.0, 0.0], "aside")] {
        for share in [0.3, 0.9, 1.05] {
            let mut world = world(turn.map(|part| part * limit * share), Some(TYRE));
            init(&mut world, INIT);
            let place = |world: &World| world.snapshot().robots[0].body.pose.translation.vector;
            // The servos of the axles share the load for some seconds.
            run(&mut world, 8.0);
            let before = place(&world);
            run(&mut world, 10.0);
            let moved = (place(&world) - before).norm();
            println!("{name}, {share} of the limit: {moved:.2e} m");
            assert_eq!(moved > 1.0, share > 1.0, "{name}, {share} of the limit: {moved} m");
            assert!(share > 1.0 || moved < 1e-5, "{name}, {share} of the limit creeps: {moved} m");
        }
    }
}

/// Deflections are a part of the state: a copy and a saved world go on with the same bits.
#[test]
fn a_saved_world_keeps_bent_tyres() {
    let mut one = world([0.0; 3], Some(TYRE));
    let robot = init(&mut one, INIT);
    apply(&mut one, robot, "DRIVE {Left 4} {Right 2}");
    run(&mut one, 1.0);
    let text = serde_json::to_string(&one.save().expect("a state")).expect("a text");
    let saved: SavedWorld = serde_json::from_str(&text).expect("the state");
    let mut other = World::load(def([0.0; 3], Some(TYRE)), &saved).expect("the same world");
    let rigid = text.replace("\"deflections\":[[", "\"other\":[[");
    assert_ne!(rigid, text, "the state has no deflections");
    let mut copy = one.clone();
    for world in [&mut one, &mut other, &mut copy] {
        run(world, 1.0);
    }
    assert_eq!(one.digest(), other.digest());
    assert_eq!(one.digest(), copy.digest());
}

/// Numbers at the ends of their ranges neither break a robot nor throw it.
#[test]
fn tyres_at_the_ends_of_their_ranges_drive() {
    for stiffness in [1.0, 30.0, 1e4] {
        for relaxation in [1e-3, (stiffness * 0.098 / 3.0_f64).min(1.0)] {
            for friction in [[0.1, 10.0], [1.0, 1.0], [10.0, 0.1]] {
                let tyre = Tyre { stiffness: [stiffness; 2], relaxation: Some(relaxation), friction, ..TYRE };
                let mut world = world([0.0; 3], Some(tyre));
                let robot = init(&mut world, INIT);
                for line in ["DRIVE {Left 8} {Right 8}", "DRIVE {Left -8} {Right 8}", "DRIVE {Left 0} {Right 0}"] {
                    apply(&mut world, robot, line);
                    for _ in 0..200 {
                        run(&mut world, 0.01);
                        let body = world.snapshot().robots[0].body;
                        let (speed, spin) = (body.linear.norm(), body.angular.norm());
                        // A soft tread is a spring, which throws a robot beyond the 0.8 m/s of its wheels.
                        assert!(speed < 1.6 && spin < 10.0, "{tyre:?}, {line}: {speed} m/s, {spin} rad/s");
                    }
                }
                assert!(world.take_restored().is_empty(), "{tyre:?}");
            }
        }
    }
}

/// In a wide curve a tyre holds by a part of its friction, where a rigid disc slides.
#[test]
fn a_tyre_in_a_curve_uses_a_part_of_its_friction() {
    let used = [None, Some(TYRE)].map(|tyre| {
        let mut world = world([0.0; 3], tyre);
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.2}");
        apply(&mut world, robot, "DRIVE {Left 3.03}{Right 2.97}");
        run(&mut world, 3.0);
        let contacts = world.observe(robot).expect("the robot").contacts;
        assert!(contacts.len() >= 4 && contacts.iter().all(|contact| contact.wheel.is_some()), "{contacts:?}");
        contacts.iter().map(|contact| contact.friction_share).fold(0.0, f64::max)
    });
    println!("{used:.3?}");
    assert!(used[0] > 0.99 && (0.02..0.5).contains(&used[1]), "{used:?}");
}
