//! Tracks: belts that move around their rollers.

use experiments::{Course, Motion};
use gamebots_proto::Message;
use nalgebra::Vector3;
use scene::{Material, Shape, Solid, WorldDef};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Half the length of a tank's run on the ground, half its track, and the radius of its sprockets, m.
const HALF: f64 = 0.2;
const ASIDE: f64 = 0.15;
const RADIUS: f64 = 0.06;

const TANK: &str = r#"
description = "A tank"
steering = "skid"
[[part]]
name = "Chassis"
mass = 16.0
size = [0.4, 0.17, 0.07]
material = "aluminium"
[tracks]
width = 0.05
mass = 4.0
material = "rubber-tyre"
max_speed = 20.0
gain = 50.0
integral_time = 0.05
max_torque = 30.0
rollers = [[0.2, 0.0, 0.06], [-0.2, 0.0, 0.06]]
[[track]]
name = "Left"
side = "left"
y = -0.15
[[track]]
name = "Right"
side = "right"
y = 0.15
[[sensor]]
class = "Odometry"
name = "Odometry"
sliding = true
scan_interval = 0.02
"#;

/// Returns a world without rolling resistance that has the class Tank, and with these solids besides the floor.
fn world(solids: Vec<Solid>, time_step: f64) -> World {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("Tank.toml");
    std::fs::write(&file, TANK).expect("a file");
    let WorldDef { mut map, mut robots, .. } = scene_loader::load("rough", &[&file]).expect("a tank");
    map.solids.extend(solids);
    map.solids.iter_mut().for_each(|solid| solid.material.rolling_resistance = 0.0);
    robots.values_mut().flat_map(|robot| robot.wheels_mut()).for_each(|it| it.material.rolling_resistance = 0.0);
    World::new(WorldDef { map, robots, ..WorldDef::default() }, Options { time_step, ..Options::default() })
}

/// Advances a world by a time, s.
fn pass(world: &mut World, seconds: f64) -> Vec<Message> {
    let time_step = world.options().time_step;
    run(world, seconds * sim_core::TIME_STEP / time_step)
}

/// Returns the turn rate of a tank whose belts run at speeds, m/s, if its weight lies evenly on lines. It is the minimum of the power of
/// friction (arXiv 2004.05176), by nested golden sections over rate and forward speed.
fn turn_rate(left: f64, right: f64) -> f64 {
    const LINES: usize = 400;
    let power = |rate: f64, forward: f64| -> f64 {
        let of_line = |side: f64, belt: f64| -> f64 {
            let along = forward - rate * side - belt;
            (0..LINES)
                .map(|cell| (cell as f64 + 0.5) / LINES as f64 * 2.0 - 1.0)
                .map(|x| along.hypot(rate * x * HALF))
                .sum()
        };
        of_line(-ASIDE, left) + of_line(ASIDE, right)
    };
    let least = |f: &dyn Fn(f64) -> f64| -> f64 {
        let (mut low, mut high) = (-2.0, 2.0);
        for _ in 0..60 {
            let (one, other) = (low + (high - low) * 0.382, low + (high - low) * 0.618);
            if f(one) < f(other) { high = other } else { low = one }
        }
        (low + high) / 2.0
    };
    let at_best_speed = |rate: f64| power(rate, least(&|forward| power(rate, forward)));
    least(&at_best_speed)
}

#[test]
fn a_tank_drives_straight_as_far_as_its_belts_run() {
    let mut world = world(Vec::new(), 0.004);
    let robot = init(&mut world, "INIT {ClassName USARBot.Tank} {Location 0,0,0}");
    pass(&mut world, 1.0);
    apply(&mut world, robot, "DRIVE {Left 5} {Right 5}");
    // It slips until it is as fast as its belts.
    pass(&mut world, 0.5);
    let at = |world: &World| {
        let (body, wheels) = world.state(robot).expect("the tank");
        (body.pose.translation.x, wheels[0].angle)
    };
    let before = at(&world);
    pass(&mut world, 2.0);
    let (body, _) = world.state(robot).expect("the tank");
    let (went, run) = (at(&world).0 - before.0, (at(&world).1 - before.1) * RADIUS);
    assert!(run > 0.5 && (went / run - 1.0).abs() < 1e-4, "{run} {went}");
    assert!(body.pose.translation.y.abs() < 1e-6 && (body.pose.translation.z + RADIUS).abs() < 1e-4, "{}", body.pose);
}

/// On the spot and on curves the sliding of the belts balances. Two rows of wheels would turn by a third less, as their ends have the load.
#[test]
fn a_tank_turns_as_an_even_load_lets_it() {
    for (left, right) in [(1.0, -1.0), (3.0, 1.0), (2.0, 0.0)] {
        for time_step in [0.002, 0.008] {
            let mut world = world(Vec::new(), time_step);
            let robot = init(&mut world, "INIT {ClassName USARBot.Tank} {Location 0,0,0}");
            pass(&mut world, 0.5);
            apply(&mut world, robot, &format!("DRIVE {{Left {left}}} {{Right {right}}}"));
            let messages = pass(&mut world, 4.0);
            let (body, _) = world.state(robot).expect("the tank");
            let (got, expected) = (body.angular.z, turn_rate(left * RADIUS, right * RADIUS));
            println!("{left} {right} at {time_step} s: {got:.4} rad/s, expected {expected:.4}");
            assert!((got / expected - 1.0).abs() < 0.02, "{left} {right}: {got} rad/s, expected {expected}");
            let odometry =
                messages.iter().rev().map(|message| format!("{message:?}")).find(|it| it.contains("Odometry"));
            let odometry = odometry.expect("a reading");
            let theta = odometry.rsplit_once(", ").and_then(|(_, rest)| rest.split_once(']')).expect("a pose").0;
            let theta: f64 = theta.parse().expect("a number");
            let yaw = body.pose.rotation.euler_angles().2;
            assert!((theta / yaw - 1.0).abs() < 0.01, "odometry {theta}, truth {yaw}");
        }
    }
}

#[test]
fn a_kenaf_turns_as_the_friction_of_its_belts_lets_it() {
    for motion in [Motion::Forward, Motion::Clockwise, Motion::Curve] {
        let def = scene_loader::load("rough", &[]).expect("a map");
        let options = Options { time_step: 0.004, ..Options::default() };
        let mut course = Course::start(World::new(def, options), "Kenaf", 1, motion, 1.0).expect("a course");
        course.run(5.0);
        let ratio = course.travel().expect("a robot").ratio;
        assert!((ratio - 1.0).abs() < 0.002, "{}: {ratio}", motion.name());
    }
}

fn block(place: [f64; 3], size: [f64; 3]) -> Solid {
    // Plywood, as in assets/materials.toml.
    let material = Material { friction: 0.6, ..Material::default() };
    Solid { name: "block".to_owned(), shape: Shape::Box { size }, position: place, rotation: [0.0; 3], material }
}

/// Builds stairs from x = 1 m, whose steps have a depth and a height, m. The last one is 2 m deep.
fn stairs(steps: u32, [depth, height]: [f64; 2]) -> Vec<Solid> {
    let step = |number: u32| {
        let start = 1.0 + depth * f64::from(number);
        let height = height * f64::from(number + 1);
        let depth = if number + 1 == steps { 2.0 } else { depth };
        block([start + depth / 2.0, 0.0, -height / 2.0], [depth, 2.0, height])
    };
    (0..steps).map(step).collect()
}

/// Builds a step field from x = 1 m: a row of blocks 0.1 m high, and behind it blocks of 0 to 0.1 m, 0.2 m square, without a repeat.
fn step_field() -> Vec<Solid> {
    const HEIGHTS: [f64; 7] = [0.1, 0.05, 0.1, 0.02, 0.08, 0.1, 0.04];
    let field = (0..8).flat_map(|row| (0..10).map(move |column| (row, column)));
    let place = |(row, column): (usize, usize)| {
        let height = if row == 0 { 0.1 } else { HEIGHTS[(row * 3 + column * 5 + row * column) % 7] };
        block([1.1 + 0.2 * row as f64, 0.2 * column as f64 - 0.9, -height / 2.0], [0.2, 0.2, height])
    };
    field.map(place).collect()
}

/// Drives a Kenaf forward for a time with flippers at angles. Returns its place.
fn drive(world: &mut World, stages: &[([f64; 2], f64)]) -> [f64; 3] {
    let robot = init(world, "INIT {ClassName USARBot.Kenaf} {Location 0,0,0}");
    pass(world, 0.5);
    apply(world, robot, "DRIVE {Left 3} {Right 3}");
    for &([front, rear], seconds) in stages {
        let flippers = [("FR", front), ("FL", front), ("RR", rear), ("RL", rear)];
        let flippers = flippers.map(|(name, angle)| format!(" {{{name}Flipper {angle}}}")).concat();
        apply(world, robot, &format!("MULTIDRIVE{flippers}"));
        pass(world, seconds);
        let place = world.state(robot).expect("the robot").0.pose;
        let (_, pitch, _) = place.rotation.euler_angles();
        println!("{front} {rear}: {:.3?} pitch {pitch:.3}", place.translation.vector.as_slice());
    }
    world.state(robot).expect("the robot").0.pose.translation.vector.into()
}

#[test]
fn flippers_take_a_kenaf_up_a_stair() {
    let [x, y, z] = drive(&mut world(stairs(4, [0.28, 0.17]), 0.004), &[([-0.8, 0.0], 5.0), ([0.0, 0.0], 9.0)]);
    assert!((2.2..3.6).contains(&x) && y.abs() < 0.3 && z < -0.7, "{x} {y} {z}");
    let [_, _, z] = drive(&mut world(stairs(4, [0.28, 0.17]), 0.004), &[([-3.1, 3.1], 20.0)]);
    assert!(z > -0.3, "it climbs without its flippers: {z}");
}

#[test]
fn flippers_take_a_kenaf_over_a_step_field() {
    let [x, y, _] = drive(&mut world(step_field(), 0.004), &[([-0.6, 0.6], 20.0)]);
    assert!(x > 2.8 && y.abs() < 0.8, "{x} {y}");
    let [x, ..] = drive(&mut world(step_field(), 0.004), &[([-3.1, 3.1], 20.0)]);
    assert!(x < 1.2, "it climbs without its flippers: {x}");
}

/// A run of a belt lies on the edges of a stair as on a slope through them: it climbs at the belt's speed without slip along the run, and
/// its contacts, all at edges, hold its weight.
#[test]
fn a_track_climbs_on_the_edges_of_a_stair() {
    let [depth, height] = [0.12, 0.04];
    let mut world = world(stairs(12, [depth, height]), 0.002);
    let robot = init(&mut world, "INIT {ClassName USARBot.Tank} {Location 0.4,0,-0.06}");
    apply(&mut world, robot, "DRIVE {Left 3} {Right 3}");
    pass(&mut world, 7.0);
    let slope = (height / depth).atan();
    let up = Vector3::new(slope.cos(), 0.0, -slope.sin());
    let start = world.state(robot).expect("the tank").0;
    let steps = 500;
    let (mut force, mut most_slip, mut farthest) = (Vector3::zeros(), 0.0_f64, 0.0_f64);
    for _ in 0..steps {
        world.step();
        let seen = world.observe(robot).expect("the tank");
        let (_, pitch, _) = seen.body.pose.rotation.euler_angles();
        assert!((pitch - slope).abs() < 0.01, "pitch {pitch}, expected {slope}");
        for contact in seen.contacts {
            let number = ((contact.point.x - 1.0) / depth).round();
            let edge = [1.0 + depth * number, -height * (number + 1.0)];
            farthest = farthest.max((contact.point.x - edge[0]).hypot(contact.point.z - edge[1]));
            most_slip = most_slip.max(contact.slip.dot(&up).abs());
            force += contact.force / f64::from(steps);
        }
    }
    let way = world.state(robot).expect("the tank").0.pose.translation.vector - start.pose.translation.vector;
    let (speed, weight) = (way.norm() / (f64::from(steps) * 0.002), world.def().robots["Tank"].mass() as f64 * 9.81);
    println!(
        "{speed:.4} m/s, slip {most_slip:.5} m/s, {farthest:.4} m from the edges, {:.2?} of {weight} N",
        force.as_slice()
    );
    assert!((speed - 3.0 * RADIUS).abs() < 0.01 * 3.0 * RADIUS, "{speed} m/s");
    assert!(most_slip < 0.005, "{most_slip} m/s along the run");
    assert!(farthest < 0.003, "{farthest} m from the edges");
    assert!((force + Vector3::z() * weight).norm() < 0.02 * weight, "{force} for {weight} N");
}
