//! Sensors measure simple scenes, compared with numbers worked out by hand.

use gamebots_proto::message::{Message, Reading, Tick};
use scene::{NamedPose, SensorDef, Shape, Solid, WorldDef};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, init, run};

/// Builds a world with the floor and boxes on it, given by centre and edge lengths.
fn scene(boxes: &[([f64; 3], [f64; 3])], seed: u64) -> World {
    let WorldDef { mut map, robots, .. } = scene_loader::load("rough", &[]).expect("a built-in map");
    let material = map.solids[0].material.clone();
    map.solids.extend(boxes.iter().map(|&(centre, size)| Solid {
        name: "box".to_owned(),
        shape: Shape::Box { size },
        position: centre,
        rotation: [0.0; 3],
        material: material.clone(),
    }));
    map.path_nodes = vec![NamedPose { name: "Far".to_owned(), position: [9.0, 9.0, 0.0], rotation: [0.0; 3] }];
    World::new(WorldDef { map, robots, ..WorldDef::default() }, Options { seed, ..Options::default() })
}

fn readings(messages: Vec<Message>) -> impl Iterator<Item = Reading> {
    messages.into_iter().filter_map(|message| match message {
        Message::Sen(sen) => Some(sen.reading),
        _ => None,
    })
}

fn last<T>(messages: Vec<Message>, pick: impl Fn(Reading) -> Option<T>) -> T {
    readings(messages).filter_map(pick).last().expect("a reading")
}

fn scan(world: &mut World) -> Vec<f32> {
    last(run(world, 0.5), |reading| match reading {
        Reading::RangeScanner(scan) => Some(scan.ranges),
        _ => None,
    })
}

#[track_caller]
fn assert_ranges(ranges: &[f32], expected: &[(usize, f32)]) {
    for &(beam, range) in expected {
        assert!((ranges[beam] - range).abs() < 0.02, "beam {beam}: {} instead of {range}", ranges[beam]);
    }
}

fn p3at(world: &mut World) -> PawnId {
    init(world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}")
}

/// The SICK of a P3AT is at x = 0.2085. Beam 90 looks ahead, 0 to the right.
#[test]
fn a_laser_sees_a_wall_ahead() {
    let mut world = scene(&[([0.2085 + 2.5, 0.0, -0.5], [1.0, 100.0, 3.0])], 0);
    p3at(&mut world);
    let ranges = scan(&mut world);
    assert_eq!(ranges.len(), 181);
    assert_ranges(
        &ranges,
        &[(90, 2.0), (45, 2.83), (135, 2.83), (30, 4.0), (60, 2.31), (120, 2.31), (0, 20.0), (180, 20.0)],
    );
}

#[test]
fn a_laser_scans_from_right_to_left() {
    let mut world = scene(&[([0.0, 1.5, -0.5], [100.0, 1.0, 3.0])], 0);
    p3at(&mut world);
    assert_ranges(&scan(&mut world), &[(0, 1.0), (90, 20.0), (180, 20.0)]);
}

#[test]
fn a_laser_reads_its_maximum_in_the_open_and_less_than_its_minimum_up_close() {
    let mut world = scene(&[], 0);
    p3at(&mut world);
    assert!(scan(&mut world).iter().all(|&range| range == 20.0));
    // The box is above the robot's bumpers, 5 cm ahead of the laser.
    let mut world = scene(&[([0.2085 + 0.55, 0.0, -0.8], [1.0, 1.0, 1.0])], 0);
    p3at(&mut world);
    assert_ranges(&scan(&mut world), &[(90, 0.05)]);
}

#[test]
fn a_laser_sees_other_robots_and_not_its_own() {
    let mut world = scene(&[], 0);
    let youbot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}");
    init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 2,0,0}");
    let of_youbot = |messages: Vec<Message>| {
        last(messages, |reading| match reading {
            Reading::RangeScanner(scan) if scan.name == "Hokuyo" => Some(scan.ranges),
            _ => None,
        })
    };
    let ranges = of_youbot(run(&mut world, 0.7));
    assert_eq!(ranges.len(), 228);
    // At the laser's height, 8 cm, it hits the P3AT's lower chassis, 0.46 m long and 0.012 m ahead of its middle.
    assert_ranges(&ranges, &[(114, 2.0 + 0.012 - 0.23 - 0.3), (0, 4.0), (227, 4.0)]);
    assert!(world.state(youbot).is_some());
}

/// Two sensors on the front of a robot without wheels, one of them 2 cm to the right of the other.
#[test]
fn a_touch_sensor_feels_what_is_less_than_0_64_mm_in_front_of_its_face() {
    for (gap, touches) in [(0.0005, true), (0.0007, false), (0.001, false), (-0.001, true)] {
        let WorldDef { mut map, mut robots, .. } = scene_loader::load("rough", &[]).expect("a built-in map");
        let robot = robots.get_mut("P3AT").expect("a P3AT");
        let sensor = |name: &str, y: f64| SensorDef {
            name: name.to_owned(),
            link: 0,
            position: [0.3, y, -0.3],
            direction: [0.0; 3],
            scan_interval: 0.1,
            config: scene::sensor::Config::Touch(scene::sensor::touch::Config::default()),
        };
        robot.sensors = vec![sensor("Left", 0.0), sensor("Right", 0.02)];
        // The post covers half of the left face, and stands above the robot's bumpers.
        let material = map.solids[0].material.clone();
        let shape = Shape::Box { size: [0.2, 0.2, 0.05] };
        let mut world = World::new(
            WorldDef { map: map.clone(), robots: robots.clone(), ..WorldDef::default() },
            Options::default(),
        );
        let id = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        run(&mut world, 1.0);
        let pose = world.state(id).expect("the robot").0.pose;
        let face = pose * nalgebra::Point3::new(0.3, 0.0, -0.3);
        let position = [face.x + gap + 0.1, face.y - 0.1, face.z];
        map.solids.push(Solid { name: "post".to_owned(), shape, position, rotation: [0.0; 3], material });
        let mut world = World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default());
        let id = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        let touched = |name: &'static str, messages: &[Message]| {
            last(messages.to_vec(), |reading| match reading {
                Reading::Touch(touch) if touch.name == name => Some(touch.touch),
                _ => None,
            })
        };
        let messages = run(&mut world, 1.0);
        assert_eq!((touched("Left", &messages), touched("Right", &messages)), (touches, false), "{gap} m");
        assert_eq!(
            apply(&mut world, id, "GETCONF {Type Touch}"),
            ["CONF {Type Touch} {Name Left} {Diameter 0.0100} {Name Right} {Diameter 0.0100}"]
        );
    }
}

fn front_sonar(boxes: &[([f64; 3], [f64; 3])]) -> f32 {
    let mut world = scene(boxes, 0);
    init(&mut world, "INIT {ClassName USARBot.P2DX} {Location 0,0,0} {Rotation 0,0,0.174533}");
    last(run(&mut world, 0.5), |reading| match reading {
        // F4 points 10 degrees to the left, so with the robot turned 10 degrees to the right it points along x.
        Reading::Sonar(sonar) if sonar.name == "F4" => Some(sonar.range),
        _ => None,
    })
}

#[test]
fn a_sonar_reads_the_nearest_echo_within_its_cone() {
    // F4 is at (0.170, -0.025) on the robot: in the world at x = 0.1718.
    let x = 0.170 * 10f64.to_radians().cos() + 0.025 * 10f64.to_radians().sin();
    let wall = |distance: f64| [([x + distance + 0.5, 0.0, -0.5], [1.0, 20.0, 3.0])];
    assert!((front_sonar(&wall(2.0)) - 2.0).abs() < 0.01);
    assert_eq!(front_sonar(&wall(0.05)), 0.1);
    assert_eq!(front_sonar(&[]), 5.0);
    // A post 5 degrees off the axis. Its face is square to the axis, and 5 degrees are within the 10 of the echo.
    let post = [([x + 1.0 + 0.02, 0.0875, -0.5], [0.04, 0.04, 3.0])];
    assert!((front_sonar(&post) - 1.0).abs() < 0.02, "{}", front_sonar(&post));
}

#[test]
fn odometry_follows_the_wheels() {
    let mut world = scene(&[], 0);
    let robot = init(&mut world, "INIT {ClassName USARBot.P2DX} {Location 0,0,0}");
    run(&mut world, 0.5);
    apply(&mut world, robot, "DRIVE {Left 1} {Right 1}");
    let pose = |messages| {
        last(messages, |reading| match reading {
            Reading::Odometry(odometry) => Some(odometry.pose),
            _ => None,
        })
    };
    let straight = pose(run(&mut world, 10.0));
    assert!((straight[0] - 0.825).abs() < 0.003, "{straight:?}");
    // Without slip odometry equals the true pose.
    let (body, _) = world.state(robot).expect("the robot");
    let (_, _, yaw) = body.pose.rotation.euler_angles();
    let truth = [body.pose.translation.x, body.pose.translation.y, yaw];
    for (odometry, truth) in straight.iter().zip(truth) {
        assert!((f64::from(*odometry) - truth).abs() < 0.003, "{straight:?} is at {truth:?}");
    }
    apply(&mut world, robot, "SET {Type Odometry} {Opcode RESET}");
    apply(&mut world, robot, "DRIVE {Left 1} {Right 0}");
    let turned = pose(run(&mut world, 1.0));
    assert!((turned[2] - 0.25).abs() < 0.01 && turned[1] > 0.0, "clockwise: {turned:?}");
}

#[test]
fn odometry_of_the_youbot_follows_its_ground_truth_forward_and_turning() {
    let mut world = scene(&[], 0);
    let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}");
    apply(&mut world, robot, "DRIVE {Left 2} {Right 2}");
    let pose = last(run(&mut world, 5.0), |reading| match reading {
        Reading::Odometry(odometry) => Some(odometry.pose),
        _ => None,
    });
    let (body, _) = world.state(robot).expect("the robot");
    assert!((f64::from(pose[0]) - body.pose.translation.x).abs() < 0.01, "{pose:?} {:?}", body.pose.translation);
}

/// To the side, six rollers lose 4.5 %. The finite-roller kinematics includes this, the textbook's does not.
#[test]
fn odometry_can_count_the_rollers() {
    for (finite, expected) in [(false, 1.0 / 0.955), (true, 1.0)] {
        let WorldDef { map, mut robots, .. } = scene_loader::load("rough", &[]).expect("a built-in map");
        for sensor in &mut robots.get_mut("KUKA_YouBot").expect("the youBot").sensors {
            if let scene::sensor::Config::Odometry(config) = &mut sensor.config {
                config.finite_rollers = finite;
            }
        }
        let mut world = World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}");
        apply(&mut world, robot, "DRIVE {LateralVelocity 0.1}");
        let pose = last(run(&mut world, 10.0), |reading| match reading {
            Reading::Odometry(odometry) => Some(odometry.pose),
            _ => None,
        });
        let truth = world.state(robot).expect("the robot").0.pose.translation.y;
        let ratio = f64::from(pose[1]) / truth;
        println!("odometry over truth, finite rollers {finite}: {ratio:.4}");
        assert!((ratio / expected - 1.0).abs() < 0.006, "finite {finite}: {ratio}");
    }
}

/// Odometry of two wheels without slip overestimates the turn of a skid robot by nearly half. The balance of friction is right.
#[test]
fn odometry_can_know_that_wheels_slide() {
    for (class, sliding, expected, tolerance) in [
        ("P3AT", true, 1.0, 0.005),
        ("P3AT", false, 1.445, 0.005),
        ("Kenaf", true, 1.0, 0.005),
        ("P2DX", true, 1.0, 0.005),
    ] {
        let WorldDef { mut map, mut robots, .. } = scene_loader::load("rough", &[]).expect("a built-in map");
        map.solids.iter_mut().for_each(|solid| solid.material.rolling_resistance = 0.0);
        let mut sensor = robots["P3AT"].sensors[0].clone();
        let robot = robots.get_mut(class).expect("the robot");
        robot.wheels_mut().for_each(|wheel| wheel.material.rolling_resistance = 0.0);
        let config = scene::sensor::Config::Odometry(scene::sensor::odometry::Config { sliding, ..Default::default() });
        (sensor.name, sensor.scan_interval, sensor.config) = ("Odometry".to_owned(), 0.02, config);
        robot.sensors = vec![sensor];
        let mut world = World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default());
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
        run(&mut world, 0.5);
        apply(&mut world, robot, "DRIVE {Left 1} {Right -1}");
        // The run is less than half a turn.
        let pose = last(run(&mut world, 5.0), |reading| match reading {
            Reading::Odometry(odometry) => Some(odometry.pose),
            _ => None,
        });
        let (_, _, truth) = world.state(robot).expect("the robot").0.pose.rotation.euler_angles();
        let ratio = f64::from(pose[2]) / truth;
        println!("{class}, odometry over truth, sliding {sliding}: {ratio:.4}");
        assert!((ratio - expected).abs() < tolerance, "{class}, sliding {sliding}: {ratio}");
    }
}

#[test]
fn encoders_and_tachometers_agree_with_the_wheels() {
    let mut world = scene(&[], 0);
    let robot = p3at(&mut world);
    apply(&mut world, robot, "DRIVE {Left 1} {Right -1}");
    let messages = run(&mut world, 2.0);
    let (_, wheels) = world.state(robot).expect("the robot");
    let ticks: Vec<Tick> = readings(messages.clone())
        .filter_map(|reading| match reading {
            Reading::Encoder(encoder) => encoder.ticks.into_iter().next(),
            _ => None,
        })
        .collect();
    // W1 is the front left wheel, W2 the back right one. The noise is half a percent of the angle.
    for (name, wheel) in [("W1", 1), ("W2", 2)] {
        let tick = ticks.iter().rev().find(|tick| tick.name == name).expect("a tick").tick;
        let expected = wheels[wheel].angle / 0.01745;
        assert!((f64::from(tick) - expected).abs() < 2.0, "{name}: {tick} instead of {expected:.1}");
    }
    let (velocities, positions) = last(messages, |reading| match reading {
        Reading::Tachometer(tachometer) => Some((tachometer.velocities, tachometer.positions)),
        _ => None,
    });
    let signs: Vec<f32> = velocities.iter().map(|velocity| velocity.signum()).collect();
    assert_eq!(signs, [-1.0, 1.0, -1.0, 1.0]);
    // The reading is one interval late.
    assert!((f64::from(positions[1]) - (wheels[1].angle - 0.2 * wheels[1].speed)).abs() < 0.05, "{positions:?}");
}

/// At rest the estimate is constant. After 5 m in 50 readings its error has a standard deviation of 0.05 x 0.1 x sqrt(50) = 0.035 m on each
/// axis.
#[test]
fn inertial_navigation_drifts_with_the_distance() {
    let ins = |messages| {
        last(messages, |reading| match reading {
            Reading::Ins(ins) => Some(ins.location),
            _ => None,
        })
    };
    let mut errors = Vec::new();
    for seed in 0..12 {
        let mut world = scene(&[], seed);
        let robot = p3at(&mut world);
        let (start, later) = (ins(run(&mut world, 1.0)), ins(run(&mut world, 1.0)));
        assert!(start.iter().zip(later).all(|(a, b)| (a - b).abs() < 1e-5), "at rest: {start:?} {later:?}");
        apply(&mut world, robot, "DRIVE {Left 5.1} {Right 5.1}");
        let estimate = ins(run(&mut world, 10.0));
        let (body, _) = world.state(robot).expect("the robot");
        let mount = body.pose * nalgebra::Point3::new(0.0, 0.0, -0.2);
        errors.extend((0..2).map(|axis| f64::from(estimate[axis]) - mount[axis]));
    }
    let spread = (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    assert!((0.015..0.07).contains(&spread), "standard deviation {spread:.4}: {errors:.3?}");
}

/// In the air velocities change at once, so the whole change is within one reading.
#[test]
fn an_imu_reads_changes_of_velocity_with_z_up_and_rates_of_roll_pitch_and_yaw() {
    let mut world = scene(&[], 0);
    let robot = init(&mut world, "INIT {ClassName USARBot.AirRobot} {Location 0,0,-2}");
    run(&mut world, 1.0);
    let mut imu = |line: &str| {
        apply(&mut world, robot, line);
        let near = |vector: [f32; 3]| vector.map(|it| (f64::from(it) * 100.0).round() / 100.0);
        let reading = readings(run(&mut world, 0.1)).find_map(|reading| match reading {
            Reading::Imu(it) => {
                Some([it.acceleration, it.angular_velocity, it.angular_acceleration, it.rotation].map(near))
            }
            _ => None,
        });
        reading.expect("a reading")
    };
    let still = [0.0; 3];
    assert_eq!(imu("DRIVE {AltitudeVelocity 0.5}"), [[0.0, 0.0, 5.0], still, still, still]);
    assert_eq!(imu("DRIVE {AltitudeVelocity 0.5}"), [still; 4]);
    let turned = imu("DRIVE {RotationalVelocity 90}");
    assert_eq!(turned, [still, [0.0, 0.0, 1.57], [0.0, 0.0, 15.71], [0.0, 0.0, 0.16]]);
    imu("DRIVE {RotationalVelocity 0} {AltitudeVelocity 0}");
    // The robot is pitched by 9 degrees, and moves and measures along its own axes.
    let [acceleration, ..] = imu("DRIVE {LinearVelocity 1} {PitchAngle 0}");
    assert_eq!(acceleration, [10.0, 0.0, 0.0]);
}

/// Numbers worked out by hand: a robot in the air that climbs at 0.5 m/s and turns by 40 degrees a second.
#[test]
fn instruments_of_the_air_robot_and_the_nao_read_what_they_should() {
    let mut world = World::new(scene_loader::load("rough", &[]).expect("a map"), Options::default());
    let air = init(&mut world, "INIT {ClassName USARBot.AirRobot} {Location 1,2,-1.5} {Rotation 0,0,0.5}");
    apply(&mut world, air, "DRIVE {AltitudeVelocity 0.5} {RotationalVelocity 40}");
    let readings_of = |world: &mut World, seconds: f64| readings(run(world, seconds)).collect::<Vec<_>>();
    let found = readings_of(&mut world, 2.0);
    let truth = world.state(air).expect("the robot").0.pose;
    let altitude = found.iter().rev().find_map(|it| match it {
        Reading::AltitudeSensor(it) => Some((it.relative, it.absolute)),
        _ => None,
    });
    let (relative, absolute) = altitude.expect("an altitude");
    assert!((relative - 1.0).abs() < 0.06 && (absolute - relative - 111.0).abs() < 1e-3, "{relative} {absolute}");
    let compass = found.iter().rev().find_map(|it| match it {
        Reading::MagneticCompass(it) => Some(f64::from(it.angle)),
        _ => None,
    });
    let yaw = truth.rotation.euler_angles().2;
    assert!((compass.expect("an angle") + yaw).abs() < 0.1 && yaw > 1.5, "{compass:?}, yaw {yaw}");
    let minutes = |found: &[Reading]| {
        found.iter().rev().find_map(|it| match it {
            Reading::MissionTime(it) => Some(it.minutes),
            _ => None,
        })
    };
    assert_eq!(minutes(&found), Some(0));
    assert_eq!(minutes(&readings_of(&mut world, 58.2)), Some(1));
    let mut world = World::new(scene_loader::load("rough", &[]).expect("a map"), Options::default());
    init(&mut world, "INIT {ClassName USARBot.Nao} {Location 0,0,0}");
    let felt = readings_of(&mut world, 2.0).iter().rev().find_map(|it| match it {
        Reading::AcceleroMeter(it) => Some(it.acceleration),
        _ => None,
    });
    let [x, y, z] = felt.expect("an acceleration");
    assert!(x.abs() < 0.2 && y.abs() < 0.05 && (z - 9.81).abs() < 0.05, "{x} {y} {z}");
}

/// Case 69: the timer's scans stay, and one more comes at once.
#[test]
fn a_scan_on_demand_comes_at_once() {
    let mut world = scene(&[], 0);
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    run(&mut world, 0.5);
    let scans = |world: &mut World, text: &str| {
        let executed = world.execute(Some(robot), &system_tests::command(text), &mut Vec::new());
        let is_scan = |report: &sim_core::Report| matches!(report, sim_core::Report::Sensed(sensed) if sensed.reading.type_name() == "RangeScanner");
        executed.answers.iter().filter(|report| is_scan(report)).count()
    };
    assert_eq!(scans(&mut world, "SET {Type RangeScanner} {Opcode scan}"), 1);
    assert_eq!(scans(&mut world, "SET {Type rangescanner} {Name lms200} {Opcode SCAN}"), 1);
    assert_eq!(scans(&mut world, "SET {Type RangeScanner} {Opcode other}"), 0);
    assert_eq!(scans(&mut world, "SET {Type RangeScanner} {Name Nobody} {Opcode SCAN}"), 0);
}
