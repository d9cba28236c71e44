//! Conveyors: boxes whose surfaces move, and carry what stands on them.

use std::fs;

use nalgebra::Vector3;
use scene::{DriveModel, Material, Object, Shape, Solid, WorldDef};
use sim_core::{CompiledScene, Options, PawnId, SavedWorld, World};
use system_tests::{init, problems, run, world};

/// Speed of the belt, m/s.
const SPEED: f64 = 0.24;

/// Returns a scene with a belt of 8 x 2 m, 0.3 m high, that runs along its own x axis and is turned by `yaw`, and a crate on it.
fn scene(yaw: f64, model: DriveModel) -> WorldDef {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("belt.toml");
    let text = format!(
        r#"
        description = "a belt"
        [[half_space]]
        name = "floor"
        material = "concrete"
        [[box]]
        name = "Belt"
        material = "concrete"
        position = [0.0, 0.0, -0.15]
        rotation = [0.0, 0.0, {yaw}]
        size = [8.0, 2.0, 0.3]
        conveyor = [{SPEED}, 0.0, 0.0]
        [[start]]
        name = "PlayerStart_0"
        position = [0.0, 0.0, -0.3]
        "#
    );
    fs::write(&file, text).expect("a file");
    let mut def = scene_loader::load(&file.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    def.robots.values_mut().filter(|robot| robot.wheels().any(|wheel| wheel.rollers.is_some())).for_each(|robot| {
        robot.drive_model = model;
    });
    def
}

/// Adds a crate of 20 cm that stands at a place.
fn add_crate(def: &mut WorldDef, [x, y]: [f64; 2], height: f64) {
    let solid = Solid {
        name: "crate".to_owned(),
        shape: Shape::Box { size: [0.2; 3] },
        position: [x, y, -height - 0.1],
        rotation: [0.0; 3],
        material: Material { friction: 0.6, ..Material::default() },
    };
    def.map.objects.push(Object { solid, mass: 2.0 });
}

fn crate_at(world: &World) -> Vector3<f64> {
    world.objects().next().expect("a crate").pose.translation.vector
}

/// A belt and a world controller.
struct Stage {
    world: World,
    controller: PawnId,
}

impl Stage {
    fn new(def: WorldDef) -> Self {
        let mut world = World::new(def, Options::default());
        let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController}");
        Self { world, controller }
    }

    /// Sends an order. Returns the problems with it.
    fn order(&mut self, text: &str) -> Vec<String> {
        problems(&mut self.world, self.controller, &format!("CONTROL {text}"))
    }

    /// Returns the mean velocity of the crate over a second.
    fn velocity(&mut self) -> Vector3<f64> {
        let before = crate_at(&self.world);
        run(&mut self.world, 1.0);
        crate_at(&self.world) - before
    }
}

#[test]
fn a_belt_carries_objects_and_robots_at_its_speed() {
    for yaw in [0.0, 2.0] {
        let along = Vector3::new(f64::cos(yaw), f64::sin(yaw), 0.0);
        let mut def = scene(yaw, DriveModel::Articulated);
        add_crate(&mut def, [0.0; 2], 0.3);
        let mut stage = Stage::new(def);
        run(&mut stage.world, 1.0);
        let velocity = stage.velocity();
        assert!((velocity - along * SPEED).norm() < 1e-3 * SPEED, "crate, yaw {yaw}: {velocity}");
        for (class, model) in [
            ("P3AT", DriveModel::Articulated),
            ("Kenaf", DriveModel::Articulated),
            ("YouBot", DriveModel::Articulated),
            ("YouBot", DriveModel::Analytic),
        ] {
            let mut world = World::new(scene(yaw, model), Options::default());
            let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-0.5}}"));
            run(&mut world, 2.0);
            let before = world.state(robot).expect("the robot").0.pose.translation.vector;
            run(&mut world, 2.0);
            let after = world.state(robot).expect("the robot").0.pose.translation.vector;
            let velocity = (after - before) / 2.0;
            // A youBot's free rollers give way across their axes.
            let most = if class == "YouBot" { 0.05 } else { 0.01 };
            assert!((velocity - along * SPEED).norm() < most * SPEED, "{class}, {model:?}, yaw {yaw}: {velocity}");
        }
    }
}

/// No surface moves along its own normal.
#[test]
fn the_end_of_a_belt_pushes_nothing_away() {
    let mut def = scene(0.0, DriveModel::Articulated);
    add_crate(&mut def, [4.1, 0.0], 0.0);
    let mut stage = Stage::new(def);
    run(&mut stage.world, 1.0);
    let velocity = stage.velocity();
    assert!(velocity.norm() < 1e-4, "{velocity}");
}

#[test]
fn a_world_controller_sets_the_speed_of_a_belt() {
    let mut def = scene(0.0, DriveModel::Articulated);
    add_crate(&mut def, [0.0; 2], 0.3);
    let mut stage = Stage::new(def);
    run(&mut stage.world, 0.5);
    // A crate that sleeps on a belt wakes when the belt starts.
    for factor in [0.0, 2.0, 0.0, -3.0, 1.0] {
        assert_eq!(stage.order(&format!("{{Type Conveyor}} {{Name belt}} {{Speed {factor}}}")), [""; 0]);
        run(&mut stage.world, 1.0);
        let velocity = stage.velocity();
        assert!((velocity - Vector3::x() * (SPEED * factor)).norm() < 1e-3, "{factor}: {velocity}");
    }
    for (order, why) in [
        ("{Name belts} {Speed 1}", "there is no such conveyor: expected one of Belt"),
        ("{Name Belt} {Speed 1000}", "got 240 m/s, expected at most 50"),
    ] {
        let problems = stage.order(&format!("{{Type Conveyor}} {order}"));
        assert!(problems.len() == 1 && problems[0].contains(why), "{order}: {problems:?}");
    }
}

#[test]
fn a_saved_belt_and_a_copy_go_on_with_the_same_bits() {
    let mut def = scene(0.0, DriveModel::Articulated);
    add_crate(&mut def, [0.0; 2], 0.3);
    let mut stage = Stage::new(def);
    init(&mut stage.world, "INIT {ClassName USARBot.P3AT} {Location -1.5,0,-0.5}");
    run(&mut stage.world, 1.0);
    stage.order("{Type Conveyor} {Name Belt} {Speed -2}");
    for pause in [0.0, 0.002, 1.0] {
        run(&mut stage.world, pause);
        let text = serde_json::to_string(&stage.world.save().expect("a saved world")).expect("JSON");
        let saved: SavedWorld = serde_json::from_str(&text).expect("a saved world");
        let scene: CompiledScene = stage.world.scene().clone();
        let mut others = [stage.world.clone(), World::load(scene, &saved).expect("a world")];
        let mut same = stage.world.clone();
        for step in 0..200 {
            same.step();
            for other in &mut others {
                other.step();
                assert_eq!(other.digest(), same.digest(), "step {step} after a pause of {pause} s");
            }
        }
    }
}

#[test]
fn a_parcel_of_the_factory_rides_on_both_belts_to_the_stop() {
    let mut world = world("factory", 0);
    run(&mut world, 45.0);
    let parcel = world.objects().find(|object| object.def.solid.name == "parcel").expect("a parcel");
    let place = parcel.pose.translation.vector;
    assert!((place.x - 6.44).abs() < 0.1 && (place.y + 3.0).abs() < 0.2 && place.z < -0.5, "{place}");
}
