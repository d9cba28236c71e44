//! What a viewer is told of a robot: its rollers and what pushes it.

use nalgebra::Vector3;
use sim_core::scene::DriveModel;
use sim_core::{Observation, Options, World};
use system_tests::{apply, init, run};

const GRAVITY: f64 = 9.81;

fn world(map: &str, model: DriveModel) -> World {
    let mut def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    def.robots.values_mut().for_each(|robot| robot.set_drive_model(Some(model)));
    // It acts at the hub, not where the wheel touches.
    let wheels = def.robots.values_mut().flat_map(|robot| &mut robot.wheels);
    wheels.flat_map(|wheel| wheel.rollers.as_mut()).for_each(|rollers| rollers.material.rolling_resistance = 0.0);
    def.map.solids.iter_mut().for_each(|solid| solid.material.rolling_resistance = 0.0);
    World::new(def, Options::default())
}

/// The mean force on a robot over a tenth of a second: hand-overs between rollers make single steps uneven.
fn force(world: &mut World, robot: sim_core::RobotId) -> Vector3<f64> {
    let steps = 50;
    let sum = |observation: Observation| observation.contacts.iter().map(|contact| contact.force).sum::<Vector3<f64>>();
    let total: Vector3<f64> = (0..steps)
        .map(|_| {
            world.step();
            world.observe(robot).map_or_else(Vector3::zeros, sum)
        })
        .sum();
    total / f64::from(steps)
}

/// On a slope everything that pushes a standing robot holds up its weight, friction included.
#[test]
fn forces_on_a_standing_robot_hold_its_weight() {
    for (map, start) in [("rough", "PlayerStart_0"), ("slope-4.5", "RobotStart2")] {
        for model in [DriveModel::Bodies, DriveModel::Analytic] {
            let mut world = world(map, model);
            let robot = init(&mut world, &format!("INIT {{ClassName USARBot.KUKA_YouBot}} {{Start {start}}}"));
            run(&mut world, 1.0);
            let force = force(&mut world, robot);
            let weight = world.def().robots["KUKA_YouBot"].mass() as f64 * GRAVITY;
            let off = (force + Vector3::z() * weight).norm() / weight;
            let tilt = world.observe(robot).unwrap().body.pose.rotation.angle().to_degrees();
            println!("{map} {model:?}, {tilt:.2} degrees: {force:?}, weight {weight:.2}, off {off:.4}");
            assert!(off < 0.001, "{map} {model:?}: {force:?} for {weight}");
            let contacts = world.observe(robot).unwrap().contacts;
            assert!(contacts.len() >= 4, "{contacts:?}");
        }
    }
}

/// Sideways the rollers that touch turn, in both models alike; that the wheels turn does not count.
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
        // The wheel's surface passes the ground at 50 mm/s ahead and 48 mm/s aside, across the roller: 4.9 rad/s at its
        // middle, where it is 14 mm thick, 8.7 at its ends.
        assert!([bodies, analytic].iter().all(|angle| (-1.9..-0.9).contains(*angle)), "{turned:?}");
    }
}
