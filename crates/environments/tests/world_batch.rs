//! A batch of worlds does what each world does alone.

use environments::{BatchError, Column, Orders, WorldBatch};
use gamebots_proto::command::Init;
use scene::{DriveModel, Options};
use sim_core::{Order, PawnId, World};
use thread_pool::ThreadPool;

/// A world with a youBot and a P3AT beside it.
fn world(classes: &[&str]) -> (World, Vec<PawnId>) {
    let mut def = scene_loader::load("hall", &[]).expect("a map");
    def.robots.values_mut().for_each(|robot| robot.set_drive_model(Some(DriveModel::Analytic)));
    let mut world = World::new(def, Options { time_step: 0.004, ..Options::default() });
    let spawn = |(number, class): (usize, &&str)| {
        let location = [0.0, number as f64 - 1.0, 0.0];
        world.init(&Init { class_name: (*class).to_owned(), location, ..Init::default() }, &mut Vec::new())
    };
    let robots = classes.iter().enumerate().filter_map(spawn).collect();
    (world, robots)
}

fn columns(names: &[&str]) -> Vec<Column> {
    names.iter().map(|name| name.parse().expect("a column")).collect()
}

#[test]
fn worlds_in_a_batch_have_the_bits_of_worlds_alone() {
    let (world, robots) = world(&["KUKA_YouBot", "P3AT"]);
    let names =
        ["position", "orientation", "rotation", "velocity", "angular_velocity", "joint_positions", "joint_speeds"];
    let all = [&names[..], &["wheel_angles", "wheel_speeds", "objects", "sensor:GndTruth"]].concat();
    for threads in [1, 2, 3] {
        let pool = ThreadPool::new(threads).expect("threads");
        let mut batch = WorldBatch::new(&world, 20, Orders::Wheels, columns(&all), pool).expect("a batch");
        assert_eq!(batch.order_width(), 8);
        let mut seen = vec![0.0; 20 * batch.observation_width()];
        let speed = |world: usize, wheel: usize, time: usize| ((world + wheel * 5 + time) as f64).sin() * 8.0;
        let mut alone: Vec<World> = vec![world.clone(); 20];
        for time in 0..10 {
            let orders: Vec<f64> = (0..160).map(|it| speed(it / 8, it % 8, time)).collect();
            batch.step(&orders, 5, &mut seen).expect("a step");
            for (number, world) in alone.iter_mut().enumerate() {
                for (robot, &id) in robots.iter().enumerate() {
                    let speeds = (0..4).map(|wheel| Some(speed(number, robot * 4 + wheel, time))).collect();
                    assert!(world.order(id, &Order::Wheels(speeds)));
                }
                (0..5).for_each(|_| drop(world.step()));
            }
        }
        for (number, world) in alone.iter().enumerate() {
            assert_eq!(batch.world(number).expect("a world").digest(), world.digest(), "{number} on {threads}");
            let (body, _) = world.state(robots[1]).expect("a robot");
            let (_, _, range) =
                batch.layout().into_iter().find(|it| (it.0, &it.1) == (1, &Column::Position)).expect("it");
            let row = &seen[number * batch.observation_width()..][range];
            assert_eq!(row, body.pose.translation.vector.as_slice());
        }
        let (_, _, truth) = batch.layout().into_iter().rfind(|it| it.0 == 0).expect("the truth");
        assert!(seen[truth].iter().any(|number| *number != 0.0), "the sensor has measured");
        let mut marks = [false; 20];
        marks[7] = true;
        batch.reset(Some(&marks), &mut seen).expect("a reset");
        let times: Vec<f64> = (6..9).map(|number| batch.world(number).expect("a world").time()).collect();
        assert_eq!(times, [0.2, 0.0, 0.2]);
    }
}

#[test]
fn twists_and_joints_are_ordered_too() {
    let (world, _) = world(&["YouBotArm"]);
    let pool = ThreadPool::one;
    let mut batch =
        WorldBatch::new(&world, 2, Orders::TwistAndJoints, columns(&["position", "joint_positions"]), pool());
    let batch = batch.as_mut().expect("a batch");
    assert_eq!(batch.order_width(), 3 + 7);
    let mut seen = vec![0.0; 2 * batch.observation_width()];
    let mut orders = vec![0.0; 20];
    (orders[1], orders[13]) = (0.3, 0.5);
    batch.step(&orders, 500, &mut seen).expect("a step");
    let width = batch.observation_width();
    assert!(seen[1] + 1.0 > 0.4, "the first one went to the right: {}", seen[1]);
    let turned = seen[width + 3..].iter().filter(|angle| (**angle - 0.5).abs() < 0.01).count();
    assert_eq!(turned, 1, "a joint of the second one moved: {:?}", &seen[width + 3..]);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let (youbot, _) = world(&["KUKA_YouBot"]);
    let (p3at, _) = world(&["P3AT"]);
    let (kinect, _) = world(&["P3AT", "StaticPlatform"]);
    let (nobody, _) = world(&[]);
    let make = |world: &World, count, orders: &str, column: &str| {
        let columns = vec![column.parse::<Column>()?];
        WorldBatch::new(world, count, orders.parse()?, columns, ThreadPool::one()).map(drop)
    };
    for (world, count, orders, column, expected) in [
        (&youbot, 1, "wheel", "position", "unknown orders `wheel` (did you mean `wheels`?)"),
        (&youbot, 1, "wheels", "positon", "unknown observation `positon` (did you mean `position`?)"),
        (&youbot, 1, "wheels", "sensor:Eye", "unknown sensor `Eye`"),
        (&youbot, 0, "wheels", "position", "got 0 worlds"),
        (&youbot, usize::MAX / 64, "wheels", "position", "at most"),
        (&youbot, 1, "joints", "position", "KUKA_YouBot takes no orders `joints`: it has no joints besides wheels"),
        (&p3at, 1, "twist", "position", "P3AT takes no orders `twist`: it has no Mecanum base"),
        (&kinect, 1, "wheels", "position", "StaticPlatform takes no orders `wheels`: it has no driven wheels"),
        (&nobody, 1, "wheels", "position", "the world has no robots"),
    ] {
        let refused = make(world, count, orders, column).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(refused.contains(expected), "{orders} {column}: {refused}");
    }
    let mut batch =
        WorldBatch::new(&youbot, 2, Orders::Wheels, columns(&["position"]), ThreadPool::one()).expect("one");
    let mut seen = vec![0.0; 6];
    assert_eq!(batch.step(&[0.0; 7], 1, &mut seen), Err(BatchError::Size { array: "orders", got: 7, expected: 8 }));
    let lazy = batch.step(&[1.0, 1.0, 1.0, 1.0, 1.0, f64::NAN, 1.0, 1.0], 1, &mut seen);
    assert_eq!(lazy, Err(BatchError::NotFollowed { worlds: 1, first: 1 }));
    assert_eq!(batch.world(1).map(World::time), Some(0.004), "it was stepped all the same");
}
