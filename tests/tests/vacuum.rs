//! Objects stick to a robot's vacuum, and come off.

use gamebots_proto::Problem;
use gamebots_proto::message::Message;
use nalgebra::Vector3;
use scene::{ObjectId, ObjectSnapshot, WorldDef};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, command, init, run, scene_with_test_robot};

const CLOSE: &str = "SET {Type Gripper} {Name KR60gripper} {Opcode Close}";
const OPEN: &str = "SET {Type Gripper} {Name KR60gripper} {Opcode Open}";
/// Way of the slide down, so that the mouth is 33 mm above a crate, m.
const DOWN: f64 = 0.22;

/// A world with a robot whose vacuum is above something that a controller made.
struct Scene {
    world: World,
    robot: PawnId,
    controller: PawnId,
}

impl Scene {
    fn new(create: &str) -> Self {
        Self::of(scene_with_test_robot("KR60"), create)
    }

    fn of(def: WorldDef, create: &str) -> Self {
        let mut world = World::new(def, Options::default());
        let robot = init(&mut world, "INIT {ClassName KR60} {Location 0,0,-0.1}");
        let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController}");
        apply(&mut world, controller, &format!("CONTROL {{Type Create}} {{Name box}} {create}"));
        let mut scene = Self { world, robot, controller };
        scene.slide(DOWN);
        scene
    }

    fn slide(&mut self, down: f64) {
        apply(&mut self.world, self.robot, &format!("ACT {{Name KR60Arm}} {{Link 1}} {{Value {down}}}"));
        run(&mut self.world, 3.0);
    }

    fn apply(&mut self, text: &str) {
        apply(&mut self.world, self.robot, text);
    }

    /// Returns the reason why a command does nothing.
    fn refusal(&mut self, text: &str) -> String {
        let mut problems = Vec::new();
        self.world.execute(Some(self.robot), &command(text), &mut problems);
        match &problems[..] {
            [Problem::ToolRefused { why, .. }] => why.clone(),
            other => panic!("{text}: {other:?}"),
        }
    }

    fn thing(&self) -> ObjectSnapshot {
        self.world.objects().find(|object| object.def.solid.name == "box").expect("a box")
    }

    fn height(&self) -> f64 {
        -self.thing().pose.translation.z
    }

    /// Returns the state of the vacuum as EFF says it.
    fn is_closed(&mut self) -> bool {
        let messages = run(&mut self.world, 0.2);
        let of_vacuum = |message: &Message| match message {
            Message::Eff(it) if !it.is_tool_changer && it.name == "KR60gripper" => Some(it.closed),
            _ => None,
        };
        messages.iter().rev().find_map(of_vacuum).expect("EFF")
    }
}

const CRATE: &str = "{ClassName WCCrate} {Location 1,0,-0.25} {Physics RigidBody}";

#[test]
fn a_crate_is_lifted_and_put_down() {
    let mut scene = Scene::new(CRATE);
    let id = scene.thing().id;
    assert!((scene.height() - 0.25).abs() < 1e-3, "{}", scene.height());
    assert!(!scene.is_closed());
    scene.apply(CLOSE);
    assert!(scene.is_closed());
    scene.slide(0.0);
    // The slide gives way below the crate's 5 kg.
    let sag = 5.0 * 9.81 / 5000.0;
    assert!((scene.height() - (0.25 + DOWN - sag)).abs() < 2e-3, "{}", scene.height());
    scene.apply("ACT {Name KR60Arm} {Link 0} {Value 1.5707963}");
    run(&mut scene.world, 4.0);
    let place = scene.thing().pose.translation.vector;
    assert!((place.xy() - Vector3::new(0.0, 1.0, 0.0).xy()).norm() < 0.01, "{place}");
    scene.apply(OPEN);
    assert!(!scene.is_closed());
    run(&mut scene.world, 1.0);
    assert!((scene.height() - 0.25).abs() < 1e-3, "{}", scene.height());
    assert_eq!(scene.thing().id, id);
}

/// Each row is an object, an order to the robot before the vacuum closes, and the reason why nothing sticks.
#[test]
fn a_vacuum_says_why_nothing_sticks() {
    let rows = [
        ("{ClassName WCCrate} {Location 3,0,-0.25} {Physics RigidBody}", "", "nothing is within 0.125 m ahead of it"),
        (CRATE, "ACT {Name KR60Arm} {Link 1} {Value 0}", "nothing is within 0.125 m ahead of it"),
        ("{ClassName WCCrate} {Location 1,0,-0.25}", "", "an order of a world controller holds the object"),
        (
            "{ClassName WCPallet} {Location 1,0,-0.432} {Physics RigidBody}",
            "ACT {Name KR60Arm} {Link 1} {Value 0.6}",
            "the object weighs 176.6 N: expected at most 100 N",
        ),
        (
            "{ClassName WCCrate} {Location 3,0,-0.25} {Physics RigidBody}",
            "ACT {Name KR60Arm} {Link 1} {Value 0.7}",
            "what is ahead of it cannot be lifted",
        ),
        (
            CRATE,
            "SET {Type ToolChanger} {Name toolchange} {Opcode Open}",
            "the robot does not hold the tool KR60gripper",
        ),
    ];
    for (create, order, expected) in rows {
        let mut scene = Scene::new(create);
        if !order.is_empty() {
            scene.apply(order);
            run(&mut scene.world, 3.0);
        }
        let before = scene.thing().pose;
        assert_eq!(scene.refusal(CLOSE), expected, "{create} {order}");
        assert_eq!(scene.thing().pose, before, "{create}");
        assert!(!scene.is_closed(), "{create}");
    }
}

#[test]
fn a_crate_falls_when_its_tool_is_dropped_or_its_robot_leaves() {
    for leave in [false, true] {
        let mut scene = Scene::new(CRATE);
        scene.apply(CLOSE);
        scene.slide(0.0);
        if leave {
            scene.world.remove(scene.robot);
        } else {
            scene.apply("SET {Type ToolChanger} {Name toolchange} {Opcode Open}");
        }
        run(&mut scene.world, 1.0);
        assert!((scene.height() - 0.25).abs() < 2e-3, "{}", scene.height());
    }
}

#[test]
fn a_crate_falls_with_its_tool_however_the_vacuum_spells_that() {
    let mut def = scene_with_test_robot("KR60");
    def.robots.get_mut("KR60").expect("the robot").vacuums[0].tool = Some("kr60GRIPPER".to_owned());
    let mut scene = Scene::of(def, CRATE);
    scene.apply(CLOSE);
    scene.slide(0.0);
    scene.apply("SET {Type ToolChanger} {Name toolchange} {Opcode Open}");
    run(&mut scene.world, 1.0);
    assert!((scene.height() - 0.25).abs() < 2e-3, "{}", scene.height());
}

#[test]
fn a_crate_that_sticks_goes_with_its_controller_and_the_vacuum_opens() {
    for kill in [false, true] {
        let mut scene = Scene::new(CRATE);
        scene.apply(CLOSE);
        assert!(scene.is_closed());
        if kill {
            apply(&mut scene.world, scene.controller, "CONTROL {Type Kill} {Name box}");
        } else {
            scene.world.remove(scene.controller);
        }
        assert!(scene.world.objects().all(|object| object.def.solid.name != "box"));
        assert!(!scene.is_closed());
    }
}

#[test]
fn a_controller_hears_where_its_stuck_crate_is() {
    let mut scene = Scene::new(CRATE);
    scene.apply(CLOSE);
    scene.slide(0.0);
    let executed =
        scene.world.execute(Some(scene.controller), &command("CONTROL {Type GetSTA} {Name box}"), &mut Vec::new());
    let Some(sim_core::Report::Message(Message::Objects(states))) = executed.answers.first() else {
        panic!("{:?}", executed.answers)
    };
    assert!((f64::from(-states[0].location[2]) - scene.height()).abs() < 1e-4, "{:?}", states[0].location);
    assert!((states[0].size[2] - 0.5).abs() < 0.01, "{:?}", states[0].size);
}

/// The object of the map is the map's again after it was put down, and saved worlds with it go on with the same bits.
#[test]
fn a_saved_world_goes_on_with_what_sticks_to_a_robot() {
    let mut def = scene_with_test_robot("KR60");
    let crate_of_map = Scene::new(CRATE).thing();
    let mut object = (*crate_of_map.def).clone();
    object.solid.position = [1.0, 0.0, -0.25];
    def.map.objects.push(object);
    let mut original = World::new(def.clone(), Options::default());
    let robot = init(&mut original, "INIT {ClassName KR60} {Location 0,0,-0.1}");
    apply(&mut original, robot, &format!("ACT {{Name KR60Arm}} {{Link 1}} {{Value {DOWN}}}"));
    run(&mut original, 3.0);
    let id = ObjectId(def.map.objects.len() as u64 - 1);
    for text in [CLOSE, "ACT {Name KR60Arm} {Link 0} {Value 0.5}", OPEN] {
        apply(&mut original, robot, text);
        run(&mut original, 0.3);
        assert!(original.objects().any(|object| object.id == id));
        let saved = serde_json::to_string(&original.save().expect("a state")).expect("JSON");
        let mut loaded = World::load(def.clone(), &serde_json::from_str(&saved).expect("a state")).expect("a world");
        for _ in 0..200 {
            original.step();
            loaded.step();
            assert_eq!(loaded.digest(), original.digest(), "{text}");
        }
        assert_eq!(loaded.snapshot(), original.snapshot());
    }
}
