//! Heaps, towers and impacts: their cost grows in proportion, they come to rest and gain no energy.

use experiments::Crowd;
use nalgebra::Vector3;
use scene::{Object, Shape, Solid, WorldDef};
use sim_core::{Options, World};
use system_tests::{apply, init, init_on_top, run};

/// Multiplications per body by which a step may exceed its budget: one more step of Newton's method.
const SLACK: u64 = 40_000;

fn def(map: &str) -> WorldDef {
    scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn world(map: &str, time_step: f64) -> World {
    World::new(def(map), Options { time_step, ..Options::default() })
}

/// Adds boxes of 0.2 m and 1 kg on top of each other, the lowest at a place on the floor.
fn tower(def: &mut WorldDef, count: u32, [x, y]: [f64; 2]) {
    let like = def.map.solids[0].clone();
    for number in 0..count {
        let position = [x, y, -0.1 - 0.2 * f64::from(number)];
        let name = format!("box-{number}");
        let solid = Solid { name, shape: Shape::Box { size: [0.2; 3] }, position, ..like.clone() };
        def.map.objects.push(Object { solid, mass: 1.0 });
    }
}

/// Adds a slope of 0.1, 20 m long, that rises along x. Its middle is at a height, m.
fn slope(def: &mut WorldDef, height: f64) {
    let like = def.map.solids[0].clone();
    let (shape, position) = (Shape::Box { size: [20.0, 4.0, 0.2] }, [0.0, 0.0, -height]);
    def.map.solids.push(Solid { name: "slope".into(), shape, position, rotation: [0.0, 0.1, 0.0], ..like });
}

/// Steps a world until a time, s.
fn run_until(world: &mut World, end: f64) {
    while world.time() < end {
        world.step();
    }
}

fn fastest(world: &World) -> f64 {
    world.snapshot().robots.iter().map(|robot| robot.body.linear.norm()).fold(0.0, f64::max)
}

/// Classes of each kind of wheels and tracks that other robots can stand on. On a camera's head or a car's bonnet they roll for longer.
const BROAD: [&str; 12] = [
    "BasicAckermanRobot",
    "BasicSkidRobot",
    "CasterSkidRobot",
    "FrontAckerman",
    "KUKA_YouBot",
    "Kenaf",
    "Kiva4Wheel",
    "Matilda",
    "P2DX",
    "P3AT",
    "YouBot",
    "YouBotArm",
];

/// If wheels roll on a roof, it takes longer than 7 s. A tower of P2DX falls over, the last of them after 4 s.
#[test]
fn six_robots_on_each_other_rest() {
    let mut moving = Vec::new();
    for time_step in [0.002, 0.008] {
        for class in BROAD {
            let mut world = world("rough", time_step);
            for _ in 0..6 {
                init_on_top(&mut world, class, [0.0, 0.0], 0.0);
            }
            run(&mut world, 7.0);
            let (speed, unsettled) = (fastest(&world), world.unsettled_steps());
            println!("six {class} at {time_step} s: {speed:.1e} m/s, {unsettled} unsettled");
            // The engine's robot creeps.
            let most = if class == "KUKA_YouBot" { 2e-3 } else { 5e-4 };
            if speed >= most {
                moving.push(format!("{class} at {time_step} s: {speed:.1e} m/s"));
            }
        }
    }
    assert!(moving.is_empty(), "{moving:?}");
}

#[test]
fn a_tower_of_ten_boxes_stands_until_a_robot_drives_into_it() {
    for time_step in [0.002, 0.008] {
        let mut def = def("rough");
        tower(&mut def, 10, [1.0, 0.0]);
        let start: Vec<f64> = def.map.objects.iter().map(|object| object.solid.position[2]).collect();
        let mut world = World::new(def, Options { time_step, ..Options::default() });
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        run(&mut world, 5.0);
        let stands: Vec<Vector3<f64>> = world.objects().map(|object| object.pose.translation.vector).collect();
        for (place, start) in stands.iter().zip(start) {
            assert!((place - Vector3::new(1.0, 0.0, start)).norm() < 2e-3, "at {time_step} s: {stands:?}");
        }
        run(&mut world, 1.0);
        let after: Vec<Vector3<f64>> = world.objects().map(|object| object.pose.translation.vector).collect();
        assert_eq!(after, stands, "what sleeps does not move");
        apply(&mut world, robot, "DRIVE {Left 8} {Right 8}");
        run(&mut world, 6.0);
        let highest = world.objects().map(|object| object.pose.translation.z).fold(f64::INFINITY, f64::min);
        let foot = world.objects().next().map_or(0.0, |object| object.pose.translation.x);
        // In long steps the robot pushes the tower along.
        let is_pushed = time_step > 0.002 && foot > 3.0;
        assert!(
            highest > -1.5 || is_pushed,
            "at {time_step} s the highest box is still at {highest} m, the lowest at {foot} m"
        );
    }
}

/// Friction of the impact does not hold the robot at the tower.
#[test]
fn a_robot_that_runs_into_a_tower_drives_on() {
    for (time_step, speed) in [(0.002, 4), (0.004, 6), (0.008, 8)] {
        let mut def = def("rough");
        tower(&mut def, 10, [1.0, 0.0]);
        let mut world = World::new(def, Options { time_step, ..Options::default() });
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        apply(&mut world, robot, &format!("DRIVE {{Left {speed}}} {{Right {speed}}}"));
        run_until(&mut world, 6.0);
        let way = world.snapshot().robots[0].body.pose.translation.x;
        assert!(way > 1.0, "at {time_step} s and {speed} rad/s it is still at {way} m");
    }
}

/// A robot that leans on another on a slope of 0.1 creeps by less than 0.1 mm in an hour.
#[test]
fn robots_parked_on_a_slope_in_contact_do_not_creep() {
    for time_step in [0.002, 0.008] {
        let mut def = def("rough");
        slope(&mut def, 1.0);
        let mut world = World::new(def, Options { time_step, ..Options::default() });
        let place = |x: f64| format!("INIT {{ClassName USARBot.P3AT}} {{Location {x},0,{}}}", -1.15 - 0.1 * x);
        let robots = [0.0, 0.8].map(|x| init(&mut world, &place(x)));
        apply(&mut world, robots[0], "DRIVE {Left 2} {Right 2}");
        run_until(&mut world, 3.0);
        apply(&mut world, robots[0], "DRIVE {Left 0} {Right 0}");
        run_until(&mut world, 13.0);
        let places = |world: &World| -> Vec<Vector3<f64>> {
            world.snapshot().robots.iter().map(|robot| robot.body.pose.translation.vector).collect()
        };
        let before = places(&world);
        let gap = (before[1] - before[0]).norm();
        assert!(gap < 0.58, "at {time_step} s they do not touch: {gap} m");
        assert!(before[1].z < before[0].z - 0.04, "at {time_step} s they are not on the slope: {before:?}");
        run_until(&mut world, 33.0);
        for (now, before) in places(&world).iter().zip(before) {
            let crept = (now - before).norm() * 180.0;
            assert!(crept < 1e-4, "at {time_step} s: {crept:.1e} m in an hour");
        }
    }
}

/// A crate stays where it lies on a robot that drives up a slope.
#[test]
fn a_crate_on_a_robot_that_drives_does_not_creep() {
    for time_step in [0.002, 0.008] {
        let mut def = def("rough");
        slope(&mut def, 2.0);
        tower(&mut def, 1, [0.0, 0.0]);
        def.map.objects[0].solid.position[2] = -2.6;
        let mut world = World::new(def, Options { time_step, ..Options::default() });
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-2.15}");
        run_until(&mut world, 2.0);
        apply(&mut world, robot, "DRIVE {Left 3} {Right 3}");
        let place = |world: &World| {
            let crate_at = world.objects().next().map_or_else(Vector3::zeros, |object| object.pose.translation.vector);
            let robot = world.snapshot().robots[0].body.pose;
            robot.rotation.inverse() * (crate_at - robot.translation.vector)
        };
        run_until(&mut world, 4.0);
        let before = place(&world);
        run_until(&mut world, 12.0);
        let crept = (place(&world) - before).norm();
        assert!(before.z < -0.1, "at {time_step} s it lies at {before:?}");
        assert!(crept < 1e-4, "at {time_step} s it crept by {crept:.1e} m");
    }
}

/// A sleeping object wakes when its support moves or leaves.
#[test]
fn a_box_falls_when_the_robot_below_it_leaves() {
    let mut def = def("rough");
    tower(&mut def, 1, [0.0, 0.0]);
    def.map.objects[0].solid.position[2] = -0.6;
    let mut world = World::new(def, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    let height = |world: &World| -world.objects().next().map_or(0.0, |object| object.pose.translation.z);
    run(&mut world, 3.0);
    let on_robot = height(&world);
    assert!(on_robot > 0.3, "it lies on the robot, at {on_robot} m");
    world.remove(robot);
    run(&mut world, 1.0);
    assert!((height(&world) - 0.1).abs() < 1e-3, "it lies on the floor, at {} m", height(&world));
}

/// Robots that fall from kilometres, on the floor and on others, gain no energy and stay in the map.
#[test]
fn a_fall_from_kilometres_gains_no_energy() {
    let alone = |class: &str, height: f64, rotation: &str| {
        vec![format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-{height}}} {{Rotation {rotation}}}")]
    };
    let mut falls = vec![
        (5000.0, alone("P3AT", 5000.0, "0.3,0.2,0")),
        (4000.0, alone("P3AT", 4000.0, "0.8,0.5,0")),
        (3000.0, alone("YouBotArm", 3000.0, "0.8,0.5,0")),
        (2000.0, [alone("P3AT", 0.0, "0,0,0"), alone("P3AT", 2000.0, "0.3,0.2,0")].concat()),
        (1000.0, [alone("YouBot", 0.0, "0,0,0"), alone("Kenaf", 1000.0, "0.3,0.2,0")].concat()),
        (500.0, [alone("Kenaf", 0.0, "0,0,0"), alone("YouBotArm", 500.0, "0.8,0.5,0")].concat()),
        (100.0, [alone("P2AT", 0.0, "0,0,0"), alone("FrontAckerman", 100.0, "0,0.2,1")].concat()),
    ];
    let classes = ["P3AT", "YouBot", "Kenaf", "P2AT", "P2DX", "BasicSkidRobot", "CasterSkidRobot", "FrontAckerman"];
    let apart = |number: usize| {
        let (class, x, y) = (classes[number % classes.len()], 40 * (number % 4), 40 * (number / 4));
        format!("INIT {{ClassName USARBot.{class}}} {{Location {x},{y},-200}} {{Rotation 0.3,0.2,{number}}}")
    };
    falls.push((200.0, (0..16).map(apart).collect()));
    for time_step in [0.002, 0.016] {
        for (height, lines) in &falls {
            let mut world = world("smooth", time_step);
            for line in lines {
                init(&mut world, line);
            }
            // The bound assumes no damping by air.
            let falling = (2.0 * height / 9.81_f64).sqrt();
            let most = 9.81 * (height + 2.0);
            for _ in 0..((falling + 8.0) / time_step) as u64 {
                world.step();
                for robot in world.snapshot().robots {
                    let energy = robot.body.linear.norm_squared() / 2.0 - 9.81 * robot.body.pose.translation.z;
                    assert!(energy < most, "{lines:?} at {time_step} s: {energy} J/kg of {most}");
                }
            }
            assert_eq!(world.take_lost(), [], "{lines:?} at {time_step} s");
        }
    }
}

/// Towers of robots of four classes fall on each other: the work of a step is bounded.
#[test]
fn robots_dropped_at_one_place_cost_no_more_than_their_budget() {
    let classes = ["KUKA_YouBot", "YouBot", "P3AT", "Kenaf"];
    for count in [10, 20, 40] {
        let mut world = world("rough", 0.002);
        for (number, class) in classes.iter().cycle().take(count).enumerate() {
            let height = 1.0 + 0.6 * number as f64;
            init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-{height}}}"));
        }
        check_work(&mut world, 2.0, count);
    }
}

#[test]
fn crowds_of_every_size_cost_no_more_than_their_budget() {
    for count in [5, 20, 80] {
        let classes = ["P3AT", "YouBot"].map(str::to_owned);
        let mut crowd = Crowd::start(world("rough", 0.002), &classes, count).expect("a crowd");
        let mut most = 0;
        for _ in 0..1000 {
            crowd.step();
            most = most.max(crowd.world().work());
        }
        let each = most / u64::from(count);
        println!("{count}: {each} multiplications a robot at most, {} unsettled", crowd.world().unsettled_steps());
        assert!(each <= articulated::most_work(1) + SLACK, "{count}: {each} a robot");
        assert_eq!(crowd.world().robots().count() as u32, count);
    }
}

#[track_caller]
fn check_work(world: &mut World, seconds: f64, bodies: usize) {
    let mut most = 0;
    for _ in 0..(seconds / world.time_step()) as u64 {
        world.step();
        most = most.max(world.work());
    }
    println!("{bodies}: {most} multiplications in a step at most, {} unsettled", world.unsettled_steps());
    // Each of several systems has its own budget.
    let bar = bodies as u64 * (articulated::most_work(1) + SLACK);
    assert!(most <= bar, "{bodies} bodies: {most} multiplications of {bar}");
}
