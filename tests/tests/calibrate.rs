//! Calibration: records made with known numbers give them back, and records that are none are refused.

use std::f64::consts::TAU;

use experiments::calibrate::{Calibration, Number, Record, calibrate, write_robot};
use nalgebra::Rotation2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use scene::{RobotDef, Side};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Numbers of a robot: wheel radius, effective track or lx + ly, and its turning centre, or its ratio sideways.
type Numbers = [f64; 3];

const NAMES: [[&str; 3]; 2] = [
    ["wheel radius", "effective track", "turning centre ahead of the wheels' middle"],
    ["wheel radius", "lx + ly", "way sideways over ahead"],
];
/// Encoder counts in a turn of a wheel; noise of a camera that sees the robot, m and rad; samples in a second.
const COUNTS: f64 = 2000.0;
const NOISE: [f64; 2] = [0.001, 0.002];
const RATE: f64 = 50.0;
/// Friction between tyres and floor.
const FRICTION: f64 = 0.7;

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let [one, other] = [(); 2].map(|()| rng.random_range(1e-12..1.0_f64));
    (-2.0 * one.ln()).sqrt() * (TAU * other).cos()
}

fn robot(class: &str) -> RobotDef {
    scene_loader::robot(class, &[]).expect("a robot")
}

/// Makes a record of a minute of random motions with known numbers, as a table.
fn record(robot: &RobotDef, [radius, track, third]: Numbers, rng: &mut ChaCha8Rng) -> String {
    let is_mecanum = robot.class == "YouBot";
    let is_left: Vec<bool> = robot.driven().map(|wheel| wheel.side == Side::Left).collect();
    let wheels = is_left.len();
    let (mut pose, mut angles, mut twist) = ([0.0; 3], vec![0.0; wheels], [0.0; 3]);
    let mut text = "time,x,y,yaw".to_owned();
    (1..=wheels).for_each(|wheel| text += &format!(",wheel_angle_{wheel}"));
    for sample in 0..(60.0 * RATE) as usize {
        let counted = angles.iter().map(|angle: &f64| (angle * COUNTS / TAU).floor() * TAU / COUNTS);
        let counted: Vec<String> = counted.map(|angle| angle.to_string()).collect();
        let [x, y, yaw] = [0, 1, 2].map(|axis| pose[axis] + NOISE[axis / 2] * normal(rng));
        text += &format!("\n{},{x},{y},{yaw},{}", sample as f64 / RATE, counted.join(","));
        if sample % 100 == 0 {
            let aside = if is_mecanum { 0.3 } else { 0.0 };
            twist = [0.3, aside, 0.8].map(|most| if most > 0.0 { rng.random_range(-most..most) } else { 0.0 });
        }
        let [ahead, aside, turning] = twist.map(|part| part / RATE);
        for (wheel, angle) in angles.iter_mut().enumerate() {
            *angle += if is_mecanum {
                let [across, about] = [[1.0, 1.0], [-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0]][wheel];
                (ahead + across * aside / third + about * turning * track) / radius
            } else {
                (ahead + if is_left[wheel] { 0.5 } else { -0.5 } * turning * track) / radius
            };
        }
        let aside = if is_mecanum { aside } else { third * turning };
        let way = Rotation2::new(pose[2] + turning / 2.0) * nalgebra::Vector2::new(ahead, aside);
        pose = [pose[0] + way.x, pose[1] + way.y, pose[2] + turning];
    }
    text
}

fn found(text: &str, robot: &RobotDef) -> Calibration {
    let record = Record::read(text, None).unwrap_or_else(|error| panic!("{error}"));
    calibrate(&record, robot, None, FRICTION).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns for each number if it is within its interval.
fn is_told(kind: usize, known: Numbers, found: &Calibration) -> [bool; 3] {
    [0, 1, 2].map(|number| {
        let it = found.numbers.iter().find(|it| it.name == NAMES[kind][number]);
        let it = it.unwrap_or_else(|| panic!("no {} in {found:?}", NAMES[kind][number]));
        let [low, high] = it.interval;
        assert!(high - low < 0.05 * it.value.abs().max(0.2), "{} is wide: {it:?}", it.name);
        (low..=high).contains(&known[number])
    })
}

/// Ten robots, with the noise of encoders and a camera: every number of at least nine is within its interval.
#[test]
fn ten_robots_with_known_numbers_give_them_back() {
    let mut rng = ChaCha8Rng::seed_from_u64(46);
    let mut good = 0;
    for number in 0..10 {
        let kind = usize::from(number % 2 == 1);
        let class = ["P2DX", "YouBot", "P3AT", "YouBot"][number % 4];
        let robot = robot(class);
        let known = [
            rng.random_range(0.04..0.15),
            rng.random_range(0.25..0.6),
            [rng.random_range(-0.05..0.05), rng.random_range(0.9..1.02)][kind],
        ];
        let found = found(&record(&robot, known, &mut rng), &robot);
        let told = is_told(kind, known, &found);
        println!("{class} {known:.5?}: {told:?}");
        good += usize::from(told.iter().all(|&it| it));
    }
    assert!(good >= 9, "{good} of 10");
}

/// Intervals of 95 % hold their numbers in about 95 of 100 records.
#[test]
fn intervals_hold_what_they_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(47);
    let robot = robot("YouBot");
    let known = [0.0752, 0.36, 1.0];
    let mut held = [0; 3];
    for _ in 0..100 {
        let found = found(&record(&robot, known, &mut rng), &robot);
        held.iter_mut().zip(is_told(1, known, &found)).for_each(|(held, told)| *held += usize::from(told));
    }
    println!("held: {held:?} of 100");
    assert!(held.iter().all(|&it| it >= 90), "{held:?} of 100");
}

/// Makes a record of runs that end without power, ahead and sideways in turn if a robot can: a second at a speed, then braked by what
/// rolling resistance and bearings have for each way, and a second of rest.
fn coasting(robot: &RobotDef, [resistance, bearings]: [f64; 2], runs: u32, rng: &mut ChaCha8Rng) -> String {
    let turning = |wheel: scene::MountedWheel| {
        let rotor = wheel.drive.map_or(0.0, |motor| motor.armature);
        (wheel.spin_inertia() + rotor) / (wheel.radius * wheel.radius)
    };
    let turning: f64 = robot.driven().map(turning).sum();
    let effective = 1.0 + turning / f64::from(robot.mass());
    let has_rollers = robot.class == "YouBot";
    let mut text = "time,x,y,yaw".to_owned();
    (1..=robot.driven().count()).for_each(|wheel| text += &format!(",wheel_angle_{wheel}"));
    let (mut time, mut place, yaw) = (0.0, nalgebra::Vector2::zeros(), rng.random_range(-3.0..3.0));
    for run in 0..runs {
        let is_aside = has_rollers && run % 2 == 1;
        let way = Rotation2::new(yaw) * if is_aside { nalgebra::Vector2::y() } else { nalgebra::Vector2::x() };
        let brake = (resistance + if is_aside { 2.0_f64.sqrt() * bearings } else { 0.0 }) * 9.81 / effective;
        let mut speed = rng.random_range(0.5..0.9);
        let (cut, mut rest) = (time + 1.0, 0.0);
        while rest < 1.0 {
            let [x, y] = [place.x, place.y].map(|it| it + NOISE[0] * normal(rng));
            text +=
                &format!("\n{time},{x},{y},{}{}", yaw + NOISE[1] * normal(rng), ",0".repeat(robot.driven().count()));
            let after = if time < cut { speed } else { (speed - brake / RATE).max(0.0) };
            place += way * ((speed + after) / 2.0 / RATE);
            (speed, time) = (after, time + 1.0 / RATE);
            rest += if speed > 0.0 { 0.0 } else { 1.0 / RATE };
        }
    }
    text
}

/// Runs that end without power give back rolling resistance and the bearings' friction: each is within its interval for 90 of 100 records.
#[test]
fn runs_that_end_without_power_tell_what_brakes() {
    let mut rng = ChaCha8Rng::seed_from_u64(49);
    let names = ["rolling resistance, with what else brakes", "friction of the rollers' bearings"];
    for class in ["YouBot", "P2DX"] {
        let robot = robot(class);
        let drive = Record::read(&record(&robot, [0.05, 0.36, 1.0], &mut rng), None).expect("a record");
        let names = &names[..if class == "YouBot" { 2 } else { 1 }];
        let mut held = [0; 2];
        for _ in 0..100 {
            let brakes = [rng.random_range(0.01..0.05), rng.random_range(0.02..0.08)];
            let runs = Record::read(&coasting(&robot, brakes, 12, &mut rng), None).expect("a record");
            let found = calibrate(&drive, &robot, Some(&runs), FRICTION).unwrap_or_else(|error| panic!("{error}"));
            for (number, name) in names.iter().enumerate() {
                let it = found.numbers.iter().find(|it| it.name == *name);
                let it = it.unwrap_or_else(|| panic!("no {name} in {found:?}"));
                assert!(it.interval[1] - it.interval[0] < 0.02, "{it:?}");
                held[number] += i32::from((it.interval[0]..=it.interval[1]).contains(&brakes[number]));
            }
        }
        println!("{class}: {held:?} of 100");
        assert!(held.iter().take(names.len()).all(|&it| it >= 90), "{class}: {held:?} of 100");
    }
    // Too few runs tell nothing, and none say what to do.
    let robot = robot("P3AT");
    let drive = Record::read(&record(&robot, [0.1, 0.36, 0.0], &mut rng), None).expect("a record");
    let runs = Record::read(&coasting(&robot, [0.03, 0.0], 3, &mut rng), None).expect("a record");
    for (runs, expected) in [(Some(&runs), "3 runs that end without power: expected 4"), (None, "(--coasting)")] {
        let found = calibrate(&drive, &robot, runs, FRICTION).unwrap_or_else(|error| panic!("{error}"));
        assert!(found.missing.iter().any(|it| it.contains(expected)), "{:?}, expected {expected}", found.missing);
    }
}

/// A record of turns and curves tells the stiffness of the tyres that a simulated robot has.
#[test]
fn turns_and_curves_tell_the_stiffness_of_tyres() {
    let mut rng = ChaCha8Rng::seed_from_u64(50);
    let mut robot = robot("P3AT");
    let stiffness = [5.5, 4.6];
    for wheel in robot.wheels_mut() {
        wheel.material.friction = FRICTION;
        let patch = [0.27 * wheel.radius, 0.5 * wheel.width];
        wheel.tyre = Some(scene::Tyre { stiffness, patch, relaxation: None, friction: scene::isotropic() });
    }
    // Curvatures of 0, 1, 3, 5, 8, 15 and 20, for 30 s each.
    let slower = [-1.0, 0.0, 0.5, 0.667, 0.778, 0.875, 0.905].map(|share| [4.0, 4.0 * share]);
    let lines = slower.into_iter().flat_map(|line| [line; 3]);
    let lines: Vec<String> = lines.map(|[left, right]| format!("DRIVE {{Left {left}}} {{Right {right}}}")).collect();
    let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
    let text = driven_robot(robot.clone(), &lines);
    let noisy = text.lines().enumerate().map(|(number, line)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if number > 0 {
            for (cell, noise) in cells[1..4].iter_mut().zip([NOISE[0], NOISE[0], NOISE[1]]) {
                *cell = (cell.parse::<f64>().expect("a number") + noise * normal(&mut rng)).to_string();
            }
        }
        cells.join(",")
    });
    let found = found(&noisy.collect::<Vec<_>>().join("\n"), &robot);
    for (name, known) in ["tyre stiffness along", "tyre stiffness across"].into_iter().zip(stiffness) {
        let it = found.numbers.iter().find(|it| it.name == name).unwrap_or_else(|| panic!("no {name} in {found:?}"));
        println!("{it:?}");
        assert!((it.interval[0]..it.interval[1]).contains(&known), "{it:?}, not {known}; {:?}", found.curves);
    }
}

/// Drives a robot of the world, and returns the record of its truth.
fn driven(class: &str, lines: &[&str]) -> String {
    driven_robot(robot(class), lines)
}

fn driven_robot(robot: RobotDef, lines: &[&str]) -> String {
    let mut def = scene_loader::load("smooth", &[]).expect("a map");
    let class = robot.class.clone();
    def.map.solids.iter_mut().for_each(|floor| floor.material.friction = FRICTION);
    def.robots.insert(class.clone(), robot);
    let mut world = World::new(def, Options::default());
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
    run(&mut world, 0.5);
    let mut text = String::new();
    let mut time = 0.0;
    for line in lines {
        apply(&mut world, robot, line);
        for _ in 0..500 {
            let (body, wheels) = world.state(robot).expect("a robot");
            if text.is_empty() {
                text += "time,x,y,yaw";
                (1..=wheels.len()).for_each(|wheel| text += &format!(",wheel_angle_{wheel}"));
            }
            let (place, (_, _, yaw)) = (body.pose.translation, body.pose.rotation.euler_angles());
            text += &format!("\n{time},{},{},{yaw}", place.x, place.y);
            wheels.iter().for_each(|wheel| text += &format!(",{}", wheel.angle));
            run(&mut world, 0.02);
            time += 0.02;
        }
    }
    text
}

/// A P3AT's chi and radius, and a youBot's radius and ratio of finite rollers, come from what they did.
#[test]
fn records_of_simulated_robots_tell_their_physics() {
    let text = driven("P3AT", &["DRIVE {Left 4} {Right 4}", "DRIVE {Left 3} {Right -3}", "DRIVE {Left -3} {Right -3}"]);
    let calibration = found(&text, &robot("P3AT"));
    println!("{calibration:?}");
    let value =
        |found: &Calibration, name: &str| found.numbers.iter().find(|it| it.name == name).expect("a number").value;
    assert!((value(&calibration, "wheel radius") - 0.098).abs() < 5e-4, "{calibration:?}");
    assert!((value(&calibration, "effective track") / 0.36 - 1.443).abs() < 0.015, "{calibration:?}");
    let sideways = "DRIVE {LateralVelocity 0.3}";
    let text = driven(
        "YouBot",
        &["DRIVE {AltitudeVelocity 0}{LinearVelocity 0.3}", sideways, "DRIVE {RotationalVelocity 0.5}"],
    );
    let calibration = found(&text, &robot("YouBot"));
    println!("{calibration:?}");
    assert!((value(&calibration, "wheel radius") - 0.05).abs() < 2e-4, "{calibration:?}");
    assert!((value(&calibration, "way sideways over ahead") - 0.955).abs() < 0.01, "{calibration:?}");
    // No motion ahead, no radius.
    let calibration =
        found(&driven("P3AT", &["DRIVE {Left 3} {Right -3}", "DRIVE {Left -3} {Right 3}"]), &robot("P3AT"));
    assert!(calibration.missing.iter().any(|it| it.starts_with("wheel radius: ")), "{calibration:?}");
    assert!((value(&calibration, "effective track") / 0.36 - 1.443).abs() < 0.01, "{calibration:?}");
}

/// Poses with y to the left and yaw counterclockwise tell the same numbers.
#[test]
fn poses_of_ros_tell_the_same() {
    let text = driven("P3AT", &["DRIVE {Left 4} {Right 2}", "DRIVE {Left 1} {Right -3}", "DRIVE {Left 3} {Right 3}"]);
    let mirrored = text.lines().enumerate().map(|(number, line)| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if number > 0 {
            for cell in &mut cells[2..4] {
                *cell = (-cell.parse::<f64>().expect("a number")).to_string();
            }
        }
        cells.join(",")
    });
    let (one, other) = (found(&text, &robot("P3AT")), found(&mirrored.collect::<Vec<_>>().join("\n"), &robot("P3AT")));
    assert!(!one.is_mirrored && other.is_mirrored);
    for (one, other) in one.numbers.iter().zip(&other.numbers) {
        assert!((one.value - other.value).abs() < 1e-9, "{one:?}, {other:?}");
    }
}

/// The robot's file gets the radius and, where nothing slides, the places of the wheels. The rest of its text stays.
#[test]
fn the_file_of_a_robot_gets_what_was_found() {
    let mut rng = ChaCha8Rng::seed_from_u64(48);
    let known = [0.0752, 0.36, 1.0];
    let def = robot("YouBot");
    let found = found(&record(&def, known, &mut rng), &def);
    let text =
        "# Ours\nsteering = \"omni\"\n[wheels]\nradius = 0.05  # m\n[[wheel]]\nposition = [0.2355, -0.15, 0.03]\n";
    let (written, changed) = write_robot(text, &def, &found).expect("a file");
    println!("{written}{changed:?}");
    assert!(written.contains("  # m\n"), "{written}");
    assert!(written.starts_with("# Ours\nsteering = \"omni\"\n[wheels]\nradius = 0.07"), "{written}");
    let document: toml::Table = written.parse().expect("a file");
    // Bearings and tyres have places of their own.
    let numbers = |names: &[&'static str]| {
        let number =
            |name: &&'static str| Number { name, unit: "", value: 0.054, interval: [0.05, 0.06], in_file: None };
        names.iter().map(number).collect()
    };
    let names = ["friction of the rollers' bearings", "tyre stiffness along", "tyre stiffness across"];
    let brakes = Calibration { numbers: numbers(&names), patch: Some([0.03, 0.02]), ..found };
    let text = "[wheels]\nradius = 0.05\n[rollers]\ncount = 6\nbearing_friction = 0.1 # measured\n";
    let (brakes, _) = write_robot(text, &def, &brakes).expect("a file");
    let tyre = "tyre = { stiffness = [0.054, 0.054], patch = [0.03, 0.02] }";
    assert_eq!(
        brakes,
        format!("[wheels]\nradius = 0.05\n{tyre}\n[rollers]\ncount = 6\nbearing_friction = 0.054 # measured\n")
    );
    let position = document["wheel"][0]["position"].as_array().expect("a list");
    let sum = position[0].as_float().expect("x") - position[1].as_float().expect("y");
    assert!((sum - 0.36).abs() < 0.005 && position[2].as_float() == Some(0.03), "{written}");
}

#[test]
fn a_table_that_is_no_record_is_refused_by_name() {
    let head = "time,x,y,yaw,wheel_angle_1,wheel_angle_2";
    for (text, expected) in [
        ("", "no column `time`"),
        ("time,x,y\n", "no column `yaw`"),
        ("time,x,y,yaw\n", "no column `wheel_angle_1`"),
        (&format!("{head}\n0,0,0,0,0,zero"), "line 2, column `wheel_angle_2`: \"zero\" is no number"),
        (&format!("{head}\n0,0,0,0,0,nan"), "line 2, column `wheel_angle_2`: \"nan\" is no number"),
        (&format!("{head}\n0,0,0,0,0,0\n0,0,0,0,0,0"), "line 3: the time 0 s is not after 0 s"),
        (&format!("{head}\n0,0,0,0,0"), "found record with 5 fields"),
        (&format!("robot,{head}\n1,0,0,0,0,0,0\n2,0,0,0,0,0,0"), "robots 1 and 2: choose one with --robot"),
    ] {
        let error = Record::read(text, None).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}\nexpected {expected}");
    }
    let still: String = (0..500).map(|row| format!("\n{},0,0,0,0,0", f64::from(row) * 0.02)).collect();
    let record = Record::read(&format!("{head}{still}"), None).expect("a record");
    let refused = |class: &str| calibrate(&record, &robot(class), None, FRICTION).expect_err(class).to_string();
    assert_eq!(refused("P2DX"), "0 windows of 1 s in which the wheels turn: expected 8 at least");
    assert_eq!(refused("P3AT"), "the record has 2 wheels: expected 4, as the robot has driven ones");
    assert!(refused("AirRobot").starts_with("robot `AirRobot`: expected driven wheels on two sides"));
}
