//! A copy of a world, and a world that was saved and loaded, go on as the world does. Neither disturbs the other.

use gamebots_proto::Command;
use scene::{Conveyor, DriveModel, WorldDef};
use sim_core::{LoadError, ObjectId, PawnId, SaveError, SavedWorld, World};
use system_tests::{apply, busy_scene, busy_world, command, init, world};

/// Steps for which a world and its copy are compared.
const STEPS: usize = 60;

/// Advances by one step. Returns the digest and every report with all digits.
fn step(world: &mut World) -> (u64, Vec<String>) {
    let reports = world.step();
    (world.digest(), reports.into_iter().map(|report| format!("{report:?}")).collect())
}

/// Compares a world with its copy over the coming steps.
#[track_caller]
fn check_alike(world: &mut World, copy: &mut World, name: &str) {
    for number in 0..STEPS {
        let (own, its) = (step(world), step(copy));
        assert_eq!(own.0, its.0, "{name}: digest of step {number} after the copy");
        assert_eq!(own.1, its.1, "{name}: reports of step {number} after the copy");
    }
}

/// Robots that stand on each other, are moved by the engine, fly, push crates and measure.
#[test]
fn a_copy_of_a_busy_world_goes_on_with_the_same_bits() {
    let mut world = busy_world(busy_scene());
    let mut has_scan = false;
    for pause in [0, 1, 3, 17, 100, 300] {
        for _ in 0..pause {
            has_scan |= step(&mut world).1.iter().any(|line| line.contains("RangeScanner"));
        }
        let mut copy = world.clone();
        check_alike(&mut world, &mut copy, &format!("after {pause} more steps"));
    }
    assert!(has_scan, "no laser measured before a copy");
}

/// Spawns a robot that drives, if there is room for it: the rooms of some maps are too small for the largest.
fn enter(world: &mut World, text: &str) {
    let Command::Init(init) = command(text) else { panic!("not INIT: {text}") };
    if let Some(robot) = world.init(&init, &mut Vec::new()) {
        apply(world, robot, "DRIVE {Left 2}{Right 1}");
    }
}

/// Checks that nearly all classes have come.
#[track_caller]
fn check_full(world: &World, map: &str) {
    let (came, all) = (world.robots().count(), scene_loader::robot_names().len());
    assert!(came * 10 >= all * 9, "{map}: {came} of {all} classes");
}

#[test]
fn a_copy_of_any_class_on_any_map_goes_on_with_the_same_bits() {
    for map in scene_loader::map_names() {
        let mut world = world(&map, 3);
        for (number, class) in scene_loader::robot_names().into_iter().enumerate() {
            let (row, column) = (number / 9, number % 9);
            let place = format!("{},{},-0.3", 5.0 * row as f64 - 17.5, 5.0 * column as f64 - 17.5);
            enter(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}"));
        }
        check_full(&world, &map);
        (0..45).for_each(|_| drop(step(&mut world)));
        let mut copy = world.clone();
        check_alike(&mut world, &mut copy, &map);
    }
}

/// Classes are compiled, and materials numbered, in the order in which worlds of a scene first need them.
#[test]
fn a_world_does_not_depend_on_what_others_of_its_scene_have_compiled() {
    let enter_all = |world: &mut World, classes: &[&str]| {
        for (number, class) in classes.iter().enumerate() {
            enter(
                world,
                &format!("INIT {{ClassName USARBot.{class}}} {{Location {},0,-0.3}}", 0.7 * number as f64 - 2.0),
            );
        }
    };
    let mut first = world("hall", 3);
    let mut earlier = world("factory", 3);
    enter_all(&mut earlier, &["Kenaf", "KUKA_YouBot", "YouBotArm"]);
    let scene = earlier.scene().on(first.def().map.clone());
    let mut second = World::new(scene, first.options());
    for world in [&mut first, &mut second] {
        enter_all(world, &["YouBotArm", "P3AT", "KUKA_YouBot", "Kenaf"]);
    }
    (0..4).for_each(|_| check_alike(&mut first, &mut second, "hall"));
}

/// A controller's objects fall, are held, follow paths and turn; one of the map is gone.
#[test]
fn a_world_with_a_controller_goes_on_with_the_same_bits() {
    let mut world = world("hall", 3);
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.9}");
    let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController} {Location 0,0,0}");
    for order in [
        "{Type Create} {ClassName WCCrate} {Name falls} {Location 1.5,0,-2} {Physics RigidBody}",
        "{Type Create} {ClassName WCPallet} {Name lift} {Location 0,0,-0.2}",
        "{Type Create} {ClassName gear} {Name turns} {Location 3,0,-0.2} {Physics RigidBody}",
        "{Type AddWP} {Name lift} {WP 0,0,-0.2;0.5,0,-0.2}",
        "{Type SetWP} {Name lift} {Speed 0.2}",
        "{Type Rotate} {Name turns} {Speed 0,0,1}",
    ] {
        apply(&mut world, controller, &format!("CONTROL {order}"));
    }
    let of_map = world.objects().nth(1).expect("an object of the map").def.solid.name.clone();
    apply(&mut world, controller, &format!("CONTROL {{Type Kill}} {{Name {of_map}}}"));
    apply(&mut world, robot, "DRIVE {Left 1}{Right 1}");
    for pause in [0, 1, 200, 700, 1500] {
        (0..pause).for_each(|_| drop(step(&mut world)));
        let text = serde_json::to_string(&world.save().expect("a saved world")).expect("JSON");
        let saved: SavedWorld = serde_json::from_str(&text).expect("a saved world");
        let mut loaded = World::load(world.scene().clone(), &saved).expect("a world");
        assert_eq!(loaded.objects().collect::<Vec<_>>(), world.objects().collect::<Vec<_>>());
        let mut copy = world.clone();
        check_alike(&mut world.clone(), &mut copy, &format!("a copy after {pause} more steps"));
        check_alike(&mut world, &mut loaded, &format!("loaded after {pause} more steps"));
        let asked = "CONTROL {Type GetSTA}";
        assert_eq!(apply(&mut world, controller, asked), apply(&mut loaded, controller, asked));
    }
}

/// Robots come, leave, drive and are configured in a copy, and the world does not notice; one that gets the same goes the same way.
#[test]
fn a_copy_is_a_world_of_its_own() {
    let mut world = busy_world(busy_scene());
    (0..30).for_each(|_| drop(step(&mut world)));
    let (mut untouched, mut copy, mut other) = (world.clone(), world.clone(), world.clone());
    let change = |world: &mut World| {
        world.remove(PawnId(3));
        world.remove(PawnId(7));
        let robot = init(world, "INIT {ClassName USARBot.YouBot} {Location 3,3,-0.2}");
        apply(world, robot, "DRIVE {Left 3}{Right 3}");
        apply(world, PawnId(0), "SET {Type Odometry} {Name Odometry} {Opcode RESET}");
    };
    change(&mut copy);
    change(&mut other);
    check_alike(&mut copy, &mut other, "two copies with the same changes");
    check_alike(&mut world, &mut untouched, "the world after its copies changed");
    assert_ne!(world.digest(), copy.digest());
}

/// Returns the busy scene with a drive model that can be saved for every robot.
fn scene_without_engine() -> WorldDef {
    let mut scene = busy_scene();
    scene.robots.get_mut("KUKA_YouBot").expect("the thesis's youBot").drive_model = DriveModel::Articulated;
    scene
}

fn through_json(saved: &SavedWorld) -> SavedWorld {
    let text = serde_json::to_string(saved).expect("JSON");
    serde_json::from_str(&text).expect("a saved world")
}

#[test]
fn a_saved_world_goes_on_with_the_same_bits() {
    let mut world = busy_world(scene_without_engine());
    for pause in [0, 1, 3, 17, 100, 300] {
        (0..pause).for_each(|_| drop(step(&mut world)));
        let saved = through_json(&world.save().expect("no robot of the engine"));
        let mut loaded = World::load(scene_without_engine(), &saved).expect("its own scene");
        assert_eq!(loaded.digest(), world.digest(), "after {pause} more steps");
        assert_eq!(loaded.save().as_ref(), Ok(&saved), "after {pause} more steps");
        check_alike(&mut world, &mut loaded, &format!("after {pause} more steps"));
    }
}

/// Objects that lie, roll and sleep, every class that can be saved, and a robot that has left.
#[test]
fn a_saved_world_of_any_map_goes_on_with_the_same_bits() {
    for map in scene_loader::map_names() {
        let mut world = world(&map, 3);
        for (number, class) in
            scene_loader::robot_names().into_iter().filter(|class| class != "KUKA_YouBot").enumerate()
        {
            let (row, column) = (number / 9, number % 9);
            let place = format!("{},{},-0.3", 5.0 * row as f64 - 17.5, 5.0 * column as f64 - 17.5);
            enter(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}"));
        }
        check_full(&world, &map);
        (0..245).for_each(|_| drop(step(&mut world)));
        world.remove(PawnId(2));
        let saved = through_json(&world.save().expect("no robot of the engine"));
        let mut loaded = World::load(world.scene().clone(), &saved).expect("its own scene");
        check_alike(&mut world, &mut loaded, &map);
        let late = "INIT {ClassName USARBot.P3AT} {Location 4,4,-0.3}";
        assert_eq!(init(&mut world, late), init(&mut loaded, late), "{map}");
        check_alike(&mut world, &mut loaded, &map);
    }
}

#[test]
fn a_robot_of_the_engine_is_not_saved() {
    let world = busy_world(busy_scene());
    assert_eq!(world.save(), Err(SaveError::OfEngine { id: PawnId(7), class: "KUKA_YouBot".to_owned() }));
}

/// Changes an object of a controller in a saved world. Each makes it one that no order gives.
#[test]
fn an_object_of_a_controller_that_no_order_gives_is_refused() {
    let mut world = world("hall", 3);
    let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController} {Location 0,0,0}");
    for order in [
        "{Type Create} {ClassName WCPallet} {Name lift} {Location 0,0,-0.2}",
        "{Type AddWP} {Name lift} {WP 0,0,-0.2;0.5,0,-0.2}",
        "{Type SetWP} {Name lift} {Speed 0.2}",
    ] {
        apply(&mut world, controller, &format!("CONTROL {order}"));
    }
    let saved = serde_json::to_value(world.save().expect("a saved world")).expect("JSON");
    let check = |key: &str, value: serde_json::Value, is_good: bool| {
        let mut saved = saved.clone();
        *saved.pointer_mut(&format!("/created/0/{key}")).unwrap_or_else(|| panic!("no {key}")) = value.clone();
        let saved: SavedWorld = serde_json::from_value(saved).unwrap_or_else(|error| panic!("{key}: {error}"));
        let loaded = World::load(world.scene().clone(), &saved);
        let is_refused = matches!(loaded, Err(LoadError::Created { .. }));
        assert!(loaded.is_ok() == is_good && is_refused != is_good, "{key} {value}: {:?}", loaded.err());
    };
    for (key, value) in [
        ("id", 0.into()),
        ("id", 1_000_000.into()),
        ("by", 1_000_000.into()),
        ("name", "x".repeat(1000).into()),
        ("memory", "x".repeat(1000).into()),
        ("start/0/0", 1e300.into()),
        ("spin/2", 1e9.into()),
        ("path/speed", (-1e9).into()),
        ("path/length", (-1.0).into()),
        ("path/progress", (-1.0).into()),
        ("path/points/0/1", 1e300.into()),
        ("path/points", serde_json::json!(vec![[0.0; 3]; 5000])),
    ] {
        check(key, value, false);
    }
    check("path/speed", 50.0.into(), true);
    check("name", "another".into(), true);
}

/// Every change makes the saved world one of another scene, or of none.
#[test]
fn a_saved_world_that_does_not_fit_is_refused() {
    type Row = (&'static str, fn(&mut serde_json::Value, &mut WorldDef), fn(&LoadError) -> bool);
    let changes: [Row; 20] = [
        (
            "a class is gone",
            |_, scene| drop(scene.robots.remove("Kenaf")),
            |it| matches!(it, LoadError::UnknownClass { .. }),
        ),
        (
            "a sensor is gone",
            |_, scene| scene.robots.get_mut("P3AT").expect("a P3AT").sensors.truncate(1),
            |it| matches!(it, LoadError::OtherClass { .. }),
        ),
        (
            "another model",
            |_, scene| scene.robots.get_mut("P2AT").expect("a P2AT").drive_model = DriveModel::Bodies,
            |it| matches!(it, LoadError::OtherClass { .. }),
        ),
        (
            "a crate is gone",
            |_, scene| drop(scene.map.objects.pop()),
            |it| matches!(it, LoadError::OtherMap { id: ObjectId(2) }),
        ),
        (
            "a conveyor too many",
            |saved, _| saved["conveyors"] = vec![1.0].into(),
            |it| matches!(it, LoadError::OtherConveyors { got: 1, expected: 0 }),
        ),
        (
            "a conveyor too few",
            |saved, scene| {
                saved["conveyors"] = vec![1.0].into();
                let velocity = [0.0; 3];
                scene.map.conveyors = vec![Conveyor { solid: 1, velocity }, Conveyor { solid: 2, velocity }];
            },
            |it| matches!(it, LoadError::OtherConveyors { got: 1, expected: 2 }),
        ),
        (
            "a number twice",
            |saved, _| saved["robots"][1]["id"] = 0.into(),
            |it| matches!(it, LoadError::OutOfOrder { id: PawnId(0) }),
        ),
        (
            "a number to come",
            |saved, _| saved["robots"][13]["id"] = 99.into(),
            |it| matches!(it, LoadError::OutOfOrder { id: PawnId(99) }),
        ),
        (
            "a wheel too few",
            |saved, _| drop(saved["robots"][0]["bodies"]["tree"]["servos"].as_array_mut().and_then(Vec::pop)),
            |it| matches!(it, LoadError::OtherClass { id: PawnId(0), .. }),
        ),
        (
            "a step of no length",
            |saved, _| saved["options"]["time_step"] = 0.0.into(),
            |it| matches!(it, LoadError::BadOption { .. }),
        ),
        (
            "a step of half a second",
            |saved, _| saved["options"]["time_step"] = 0.5.into(),
            |it| matches!(it, LoadError::BadOption { .. }),
        ),
        (
            "an endless unit",
            |saved, _| saved["options"]["speed_unit"] = 1e300.into(),
            |it| matches!(it, LoadError::BadOption { .. }),
        ),
        (
            "steps at the end of the counter",
            |saved, _| saved["steps"] = u64::MAX.into(),
            |it| matches!(it, LoadError::TooHigh { name: "steps", .. }),
        ),
        (
            "numbers at the end of the counter",
            |saved, _| saved["next_id"] = u64::MAX.into(),
            |it| matches!(it, LoadError::TooHigh { name: "next_id", .. }),
        ),
        (
            "objects at the end of the counter",
            |saved, _| saved["next_object"] = u64::MAX.into(),
            |it| matches!(it, LoadError::TooHigh { name: "next_object", .. }),
        ),
        (
            "names at the end of the counter",
            |saved, _| saved["engine_names"]["counts"]["P3AT"] = u64::MAX.into(),
            |it| matches!(it, LoadError::TooHigh { name: "engine_names", .. }),
        ),
        (
            "a long name",
            |saved, _| saved["robots"][0]["name"] = "x".repeat(1000).into(),
            |it| matches!(it, LoadError::LongName { id: PawnId(0), got: 1000, .. }),
        ),
        (
            "a controller with the number of a robot",
            |saved, _| saved["controllers"]["0"] = serde_json::json!({ "name": "C" }),
            |it| matches!(it, LoadError::OutOfOrder { id: PawnId(0) }),
        ),
        (
            "too many pawns",
            |saved, _| {
                saved["next_id"] = 1000.into();
                (100..400).for_each(|id| saved["controllers"][id.to_string()] = serde_json::json!({ "name": "C" }));
            },
            |it| matches!(it, LoadError::TooMany { what: "pawns", .. }),
        ),
        (
            "a robot of the future",
            |saved, _| saved["robots"][0]["spawned"] = 1_000_000.into(),
            |it| matches!(it, LoadError::OtherClass { id: PawnId(0), .. }),
        ),
    ];
    let mut world = busy_world(scene_without_engine());
    (0..30).for_each(|_| drop(step(&mut world)));
    let saved = serde_json::to_value(world.save().expect("no robot of the engine")).expect("JSON");
    for (name, change, is_expected) in changes {
        let (mut saved, mut scene) = (saved.clone(), scene_without_engine());
        change(&mut saved, &mut scene);
        let saved: SavedWorld = serde_json::from_value(saved).unwrap_or_else(|error| panic!("{name}: {error}"));
        let error = World::load(scene, &saved).err();
        assert!(error.as_ref().is_some_and(is_expected), "{name}: {error:?}");
    }
}
