//! Time of a step of the world and of a line of the wire: `cargo bench -p usarsim --bench hot_paths`.

use std::sync::Arc;

use divan::Bencher;
use gamebots_proto::command::{Drive, Init};
use gamebots_proto::{Command, Line};
use scene::sensor::camera;
use scene::{DriveModel, Sensed};
use scene_loader::{Changes, Equipment};
use sim_core::{CompiledScene, Options, World};
use thread_pool::ThreadPool;

fn main() {
    divan::main();
}

/// Builds a world with robots of a class that drive side by side on carpet.
fn world(class: &str, model: DriveModel, robots: u32) -> World {
    let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
    def.robots.get_mut("KUKA_YouBot").expect("a youBot").drive_model = model;
    let mut world = World::new(def, Options::default());
    for index in 0..robots {
        let location = [0.0, 2.0 * f64::from(index), 0.0];
        let init = Init { class_name: class.to_owned(), location, ..Init::default() };
        let robot = world.init(&init, &mut Vec::new()).expect("a robot");
        let drive = Drive::default().with("Left", 1.0).with("Right", 1.0);
        world.execute(Some(robot), &Command::Drive(drive), &mut Vec::new());
    }
    (0..500).for_each(|_| drop(world.step()));
    world
}

#[divan::bench(args = [1, 10])]
fn step_of_bodies(bencher: Bencher, robots: u32) {
    let mut world = world("KUKA_YouBot", DriveModel::Bodies, robots);
    bencher.bench_local(|| world.step());
}

#[divan::bench(args = [1, 10, 50])]
fn step_of_the_analytic_model(bencher: Bencher, robots: u32) {
    let mut world = world("KUKA_YouBot", DriveModel::Analytic, robots);
    bencher.bench_local(|| world.step());
}

#[divan::bench(args = [1, 10])]
fn step_of_the_kinematic_model(bencher: Bencher, robots: u32) {
    let mut world = world("KUKA_YouBot", DriveModel::Kinematic, robots);
    bencher.bench_local(|| world.step());
}

#[divan::bench(args = [1, 10])]
fn step_of_plain_wheels(bencher: Bencher, robots: u32) {
    let mut world = world("P3AT", DriveModel::Bodies, robots);
    bencher.bench_local(|| world.step());
}

#[divan::bench]
fn one_laser_scan(bencher: Bencher) {
    let mut world = world("KUKA_YouBot", DriveModel::Analytic, 1);
    let robot = world.robots().next().map(|(id, ..)| id).expect("a robot");
    let line = Line::parse("SET {Type RangeScanner} {Name Hokuyo} {Opcode SCAN}");
    let scan = Command::read(&line, &mut Vec::new()).expect("a command");
    bencher.bench_local(|| world.execute(Some(robot), &scan, &mut Vec::new()));
}

/// A reading of a sensor of a robot on the map `rescue`, by its SET.
#[divan::bench(args = [("P3AT", "RangeScanner"), ("KinectBot", "RangeImager")])]
fn a_reading_on_rescue(bencher: Bencher, (class, sensor): (&str, &str)) {
    let def = scene_loader::load("rescue", &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(def, Options::default());
    let init = Init { class_name: class.to_owned(), start: "RobotStart1".to_owned(), ..Init::default() };
    let robot = world.init(&init, &mut Vec::new()).expect("a robot");
    let line = Line::parse(&format!("SET {{Type {sensor}}} {{Opcode SCAN}}"));
    let scan = Command::read(&line, &mut Vec::new()).expect("a command");
    if sensor == "RangeScanner" {
        bencher.bench_local(|| world.execute(Some(robot), &scan, &mut Vec::new()));
    } else {
        // A part of a picture, 3840 points, every 0.1 s.
        world.execute(Some(robot), &scan, &mut Vec::new());
        bencher.bench_local(|| (0..50).for_each(|_| drop(world.step())));
    }
}

/// A simulated second of twenty P3ATs with laser, eight sonars and INS on the map `rescue`.
#[divan::bench(args = [1, 2])]
fn a_second_of_twenty_on_rescue(bencher: Bencher, threads: usize) {
    let equipment = Equipment::load("robocup2014").unwrap_or_else(|error| panic!("{error}"));
    let changes = Changes { overrides: &[], equipment: &equipment };
    let def = scene_loader::load_equipped("rescue", &[], changes).unwrap_or_else(|error| panic!("{error}"));
    let pool = Arc::new(ThreadPool::new(threads).expect("threads"));
    let mut world = World::new(def, Options::default()).on_threads(pool.clone());
    let drive = Command::parse("DRIVE {Left 1} {Right 1.2}", &mut Vec::new()).expect("a command");
    for _ in 0..20 {
        let init = Init { class_name: "P3AT".to_owned(), start: "RobotStart1".to_owned(), ..Init::default() };
        let robot = world.init(&init, &mut Vec::new()).expect("a robot");
        world.execute(Some(robot), &drive, &mut Vec::new());
    }
    bencher.bench_local(|| pool.run(|| (0..500).for_each(|_| drop(world.step()))));
}

#[divan::bench]
fn a_drive_line_read_and_executed(bencher: Bencher) {
    let line = "DRIVE {Front-Left 1,00} {Front-Right 1,00} {Back-Left 1,00} {Back-Right 1,00}";
    let mut world = world("KUKA_YouBot", DriveModel::Analytic, 1);
    let robot = world.robots().next().map(|(id, ..)| id).expect("a robot");
    bencher.bench_local(|| {
        let mut problems = Vec::new();
        let drive = Command::read(&Line::parse(divan::black_box(line)), &mut problems).expect("a command");
        world.execute(Some(robot), &drive, &mut problems)
    });
}

#[divan::bench]
fn a_world_of_the_arena(bencher: Bencher) {
    let scene = CompiledScene::from(scene_loader::load("arena", &[]).unwrap_or_else(|error| panic!("{error}")));
    bencher.bench_local(|| World::new(scene.clone(), Options::default()));
}

#[divan::bench]
fn a_world_of_the_arena_with_a_youbot(bencher: Bencher) {
    let scene = CompiledScene::from(scene_loader::load("arena", &[]).unwrap_or_else(|error| panic!("{error}")));
    let init = Init { class_name: "KUKA_YouBot".to_owned(), ..Init::default() };
    bencher.bench_local(|| {
        let mut world = World::new(scene.clone(), Options::default());
        world.init(&init, &mut Vec::new()).expect("a robot");
        world
    });
}

/// A planner copies a world for each of its tries.
#[divan::bench(args = ["YouBot", "YouBotArm", "KUKA_YouBot"])]
fn copy_of_the_arena(bencher: Bencher, class: &str) {
    let def = scene_loader::load("arena", &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(def, Options::default());
    let init = Init { class_name: class.to_owned(), location: [-3.0, 1.0, -0.2], ..Init::default() };
    world.init(&init, &mut Vec::new()).expect("a robot");
    (0..500).for_each(|_| drop(world.step()));
    bencher.bench_local(|| world.clone());
}

/// Draws what the camera of a P3AT sees of the hall.
#[divan::bench]
fn camera_of_a_p3at(bencher: divan::Bencher) {
    let mut world = World::new(scene_loader::load("hall", &[]).expect("a map"), Options::default());
    let init = Init { class_name: "P3AT".to_owned(), location: [-3.0, 0.0, -0.2], ..Init::default() };
    let robot = world.init(&init, &mut Vec::new()).expect("a robot");
    (0..200).for_each(|_| drop(world.step()));
    let (stage, snapshot) = (picture::Stage::new(world.def()), world.snapshot());
    let sensors = &world.robot(robot).expect("a robot").sensors;
    let sensor = sensors.iter().position(|sensor| sensor.name == "Camera").expect("a camera");
    let sensed = Sensed { robot, sensor, reading: camera::Reading { field_of_view: 1.3963 }.into() };
    let size = picture::SENSOR_SIZE;
    bencher.bench_local(|| picture::of_sensor(&stage, world.def(), &snapshot, &sensed, size));
}
