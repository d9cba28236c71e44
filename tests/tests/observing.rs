//! Rollers and contacts of robots, as viewers get them.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use nalgebra::Vector3;
use scene::{DriveModel, RobotSnapshot};
use sim_core::{Options, World};
use system_tests::{apply, init, init_on_top, run};

const GRAVITY: f64 = 9.81;

fn world(map: &str, model: DriveModel) -> World {
    let mut def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mecanum = def.robots.values_mut().filter(|robot| robot.wheels().any(|wheel| wheel.rollers.is_some()));
    mecanum.for_each(|robot| robot.set_drive_model(Some(model)));
    World::new(def, Options::default())
}

/// Returns the mean force on a robot over a second, as hand-overs between rollers make single steps uneven.
fn force(world: &mut World, robot: sim_core::PawnId) -> Vector3<f64> {
    let steps = 500;
    let sum = |robot: RobotSnapshot| robot.contacts.iter().map(|contact| contact.force).sum::<Vector3<f64>>();
    let total: Vector3<f64> = (0..steps)
        .map(|_| {
            world.step();
            world.observe(robot).map_or_else(Vector3::zeros, sum)
        })
        .sum();
    total / f64::from(steps)
}

/// Checks that all contacts of a robot, with friction and rolling resistance, hold up its weight. It stands on the floor and on a slope,
/// and drives at a constant speed.
#[track_caller]
fn check_weight_is_held(class: &str, model: DriveModel) {
    for (map, start) in [("rough", "PlayerStart_0"), ("slope-4.5", "RobotStart2")] {
        let mut world = world(map, model);
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Start {start}}}"));
        let weight = world.def().robots[class].mass() as f64 * GRAVITY;
        // Wheels that stand on the ground: the tip of a flipper is above it.
        let bottom = |wheel: scene::MountedWheel| wheel.position[2] + wheel.radius;
        let lowest = world.def().robots[class].wheels().map(bottom).fold(f64::NEG_INFINITY, f64::max);
        let wheels = world.def().robots[class].wheels().filter(|&wheel| bottom(wheel) > lowest - 1e-3).count();
        for drive in ["DRIVE {Left 0}{Right 0}", "DRIVE {Left 2}{Right 2}"] {
            apply(&mut world, robot, drive);
            run(&mut world, 1.0);
            let force = force(&mut world, robot);
            let off = (force + Vector3::z() * weight).norm() / weight;
            println!(
                "{class} {model:?} on {map}, {drive}: {:.4?} of its weight, off {off:.4}",
                (force / weight).as_slice()
            );
            assert!(off < 0.001, "{class} {model:?} on {map}, {drive}: {force:?} for {weight}");
            let contacts = world.observe(robot).unwrap().contacts;
            assert!(contacts.len() >= wheels, "{class} {model:?} on {map}, {drive}: {contacts:?}");
            let pushes = |contact: &scene::Contact| contact.force.norm() > 0.0;
            assert!(contacts.iter().all(pushes), "{class} {model:?} on {map}, {drive}: {contacts:?}");
        }
    }
}

#[test]
fn forces_on_a_robot_hold_its_weight() {
    for class in
        ["BasicSkidRobot", "CasterSkidRobot", "FrontAckerman", "KUKA_YouBot", "Kenaf", "P2AT", "P2DX", "P3AT", "YouBot"]
    {
        check_weight_is_held(class, DriveModel::Bodies);
    }
    for class in ["KUKA_YouBot", "YouBot"] {
        for model in [DriveModel::Analytic, DriveModel::Kinematic, DriveModel::KinematicTextbook] {
            check_weight_is_held(class, model);
        }
    }
}

/// Puts a robot onto another: a youBot onto a plate, or onto wheels that reach above it. The forces from the ground must equal both
/// weights. Returns the height at which it stands.
#[track_caller]
fn check_carries(carrier: &str, on_wheels: bool, model: DriveModel) -> f64 {
    let wheels = [("FL", 0.2355, -0.15), ("FR", 0.2355, 0.15), ("BL", -0.2355, -0.15), ("BR", -0.2355, 0.15)];
    let below = wheels.iter().filter(|_| on_wheels).map(|(name, x, y)| {
        format!("{carrier}.wheel.{name}Wheel.position=[{x},{y},0.0]").parse().expect("an override")
    });
    let below: Vec<_> = below.collect();
    let mut def = scene_loader::load_with("rough", &[], &below).unwrap_or_else(|error| panic!("{error}"));
    def.robots.get_mut("KUKA_YouBot").unwrap().set_drive_model(Some(model));
    let weight = |class: &str| def.robots[class].mass() as f64 * GRAVITY;
    let weight = weight(carrier) + weight("KUKA_YouBot");
    let mut world = World::new(def, Options::default());
    let [carrier_id, youbot] = [carrier, "KUKA_YouBot"].map(|class| {
        let robot = init_on_top(&mut world, class, [0.0, 0.0], 0.0);
        run(&mut world, 1.0);
        robot
    });
    let steps = 500;
    let up = (0..steps).map(|_| {
        world.step();
        let contacts = world.observe(carrier_id).unwrap().contacts;
        // Contacts at the ground. Those between the robots are above it.
        contacts.iter().filter(|contact| contact.point.z > -1e-3).map(|contact| -contact.force.z).sum::<f64>()
    });
    let up = up.sum::<f64>() / f64::from(steps);
    println!("youBot {model:?} on a {carrier} (on its wheels: {on_wheels}): {up:.2} N for {weight:.2}");
    assert!((up - weight).abs() < 0.01 * weight, "{model:?} on {carrier}, {on_wheels}: {up} N for {weight}");
    -world.observe(youbot).unwrap().body.pose.translation.z
}

/// A robot feels the wheels and rollers of another one on it, in every drive model.
#[test]
fn a_robot_carries_another() {
    for (carrier, on_wheels) in [("BasicSkidRobot", false), ("BasicSkidRobot", true), ("P3AT", false)] {
        for (_, model) in DriveModel::ALL.into_iter().filter(|&(_, model)| can_stand(model, on_wheels)) {
            check_carries(carrier, on_wheels, model);
        }
    }
}

/// A wheel that carries another robot holds by its own robot's mass, not by the wheel's small one. So the upper robot does not sink in.
#[test]
fn a_robot_stands_as_high_on_another_in_every_drive_model() {
    for on_wheels in [false, true] {
        let models = DriveModel::ALL.into_iter().filter(|&(_, model)| can_stand(model, on_wheels));
        let heights: Vec<f64> = models.map(|(_, model)| check_carries("BasicSkidRobot", on_wheels, model)).collect();
        println!("on wheels: {on_wheels}: {heights:.5?} m");
        assert!(heights.iter().all(|height| (height - heights[0]).abs() < 5e-4), "{on_wheels}: {heights:?}");
    }
}

/// True if a robot can stand on wheels in a model. A wheel of free rollers on a wheel is a ball on a ball: it stands only if nothing
/// disturbs it, and the engine's contacts do.
fn can_stand(model: DriveModel, on_wheels: bool) -> bool {
    !on_wheels || model != DriveModel::Bodies
}

/// In a sideways motion the touching rollers turn alike in both models. The turning of the wheels does not count.
#[test]
fn rollers_turn_when_the_robot_goes_sideways() {
    let turned = [DriveModel::Bodies, DriveModel::Analytic].map(|model| {
        let mut world = world("rough", model);
        let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Start PlayerStart_0}");
        run(&mut world, 0.5);
        let before = world.observe(robot).unwrap();
        apply(&mut world, robot, "DRIVE {Front-Left 1}{Front-Right -1}{Back-Left -1}{Back-Right 1}");
        run(&mut world, 0.2);
        let after = world.observe(robot).unwrap();
        assert_eq!(after.targets, [1.0, -1.0, -1.0, 1.0]);
        assert_eq!(after.rollers.len(), 24);
        let turned: Vec<f64> =
            after.rollers.iter().zip(&before.rollers).map(|(after, before)| after - before).collect();
        let most = |wheel: &[f64]| wheel.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
        let most: Vec<f64> = turned.chunks(6).map(most).collect();
        println!("{model:?}: {most:.3?}");
        most
    });
    for (bodies, analytic) in turned[0].iter().zip(&turned[1]) {
        // The wheel's surface passes the ground at 50 mm/s ahead and 48 mm/s aside, across the roller. That is 4.9 rad/s at the roller's
        // middle, where it is 14 mm thick, and 8.7 rad/s at its ends.
        assert!([bodies, analytic].iter().all(|angle| (-1.9..-0.9).contains(*angle)), "{turned:?}");
    }
}

/// Friction of a contact that slides is all that it has, and pushes against the slip. The slip is the motion of the wheel's tread over the
/// ground, as the velocities of base and wheel give it.
#[test]
fn a_contact_that_slides_pushes_against_its_slip() {
    for model in [DriveModel::Articulated, DriveModel::Bodies] {
        let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
        def.robots.get_mut("P3AT").unwrap().set_drive_model(Some(model));
        let mut world = World::new(def, Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
        apply(&mut world, robot, "DRIVE {Left 1}{Right -1}");
        run(&mut world, 2.0);
        let seen = world.observe(robot).unwrap();
        let (body, speeds) = world.state(robot).unwrap();
        let class = world.def().robots["P3AT"].clone();
        let wheels: Vec<_> = class.wheels().collect();
        assert!(seen.contacts.len() >= 4, "{model:?}");
        for contact in seen.contacts {
            let number = contact.wheel.expect("only wheels touch");
            let ahead = body.pose.rotation * Vector3::x();
            let moves = body.linear + body.angular.cross(&(contact.point - body.pose.translation.vector));
            let expected = moves - ahead * (speeds[number].speed * wheels[number].radius);
            let off = (contact.slip - expected).xy().norm();
            println!("{model:?}: wheel {number} slips at {:.4?}, expected {expected:.4?}", contact.slip.as_slice());
            // The engine's wheels, softly driven, tremble.
            let is_exact = model == DriveModel::Articulated;
            assert!(!is_exact || off < 2e-4, "{:?}, expected {expected:?}", contact.slip);
            assert!(contact.friction_share > 0.99, "{model:?}: {contact:?}");
            if is_exact {
                let [force, slip] = [contact.force, contact.slip].map(|vector| vector.xy());
                let against = -force.dot(&slip) / (force.norm() * slip.norm());
                // Rolling resistance is in the forces, too.
                assert!(against > 0.99, "{contact:?} pushes {against} against its slip");
            }
        }
    }
}

/// A robot that stands on a slope needs the slope's tangent over the coefficient of the friction that it has.
#[test]
fn a_robot_on_a_slope_uses_a_part_of_its_friction() {
    let mut world = world("slope-4.5", DriveModel::Articulated);
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Start RobotStart2}");
    run(&mut world, 2.0);
    let seen = world.observe(robot).unwrap();
    let class = world.def().robots["P3AT"].clone();
    let wheel = class.wheels().next().unwrap();
    let floor = &world.def().map.solids[0].material;
    let part = 4.5_f64.to_radians().tan() / wheel.material.pair(floor).0;
    let load: f64 = seen.contacts.iter().map(|contact| contact.force.norm()).sum();
    let mean = seen.contacts.iter().map(|contact| contact.friction_share * contact.force.norm() / load).sum::<f64>();
    println!("{mean:.4} of its friction, expected {part:.4}");
    assert!((mean - part).abs() < 0.02 * part, "{mean}, expected {part}");
    assert!(seen.contacts.iter().all(|contact| contact.slip.norm() < 1e-4), "{:?}", seen.contacts);
}

/// A roller turns without slip: in a motion sideways contacts slip by far less than the wheel's surface passes the ground.
#[test]
fn rollers_that_turn_do_not_slip() {
    for model in [DriveModel::Articulated, DriveModel::Analytic] {
        let mut world = world("rough", model);
        let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Start PlayerStart_0}");
        apply(&mut world, robot, "DRIVE {Front-Left 2}{Front-Right -2}{Back-Left -2}{Back-Right 2}");
        run(&mut world, 1.0);
        let mut slips: Vec<f64> = Vec::new();
        for _ in 0..500 {
            world.step();
            slips.extend(world.observe(robot).unwrap().contacts.iter().map(|contact| contact.slip.norm()));
        }
        let mean = slips.iter().sum::<f64>() / slips.len() as f64;
        println!("{model:?}: mean slip {:.2} mm/s of {} contacts", 1000.0 * mean, slips.len());
        assert!(mean < 0.015, "{model:?}: {mean} m/s where the surface passes at 0.1 m/s");
    }
}
