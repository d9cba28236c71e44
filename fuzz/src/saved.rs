//! Saved worlds with changed values.

use std::sync::LazyLock;

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Dialect};
use scene::PawnId;
use serde_json::Value;
use sim_core::{CompiledScene, LoadError, Options, SavedWorld, World};

use crate::assert_finite;
use crate::world::MAX_WORK;

/// Steps that a loaded world takes.
const STEPS: u32 = 60;
/// Most changes of one input.
const MAX_CHANGES: usize = 20;
/// Classes of the scene: fewer compile sooner.
const CLASSES: [&str; 2] = ["P3AT", "YouBot"];
/// Lines of the clients of the saved world.
const LINES: [(usize, &str); 9] = [
    (0, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.2} {Name Pioneer}"),
    (1, "INIT {ClassName USARBot.YouBot} {Location 1.5,0,-0.2}"),
    (2, "INIT {ClassName USARBotAPI.WorldController} {Location 0,0,0}"),
    (3, "INIT {ClassName USARAvatar.GenericMale} {Location 0,3,-1}"),
    (0, "DRIVE {Left 2} {Right 1}"),
    (2, "CONTROL {Type Create} {ClassName WCPallet} {Name lift} {Location 3,0,-0.2}"),
    (2, "CONTROL {Type AddWP} {Name lift} {WP 3,0,-0.2;3.5,0,-0.2}"),
    (2, "CONTROL {Type SetWP} {Name lift} {Speed 0.2}"),
    (3, "GOTO {Location 2,3,0}"),
];

/// A scene and the state of a world in it, as JSON.
static SAVED: LazyLock<(CompiledScene, Value)> = LazyLock::new(|| {
    let mut scene = scene_loader::load("hall", &[]).expect("a built-in map");
    scene.robots.retain(|class| CLASSES.contains(&class));
    let scene = CompiledScene::from(scene);
    let mut world = World::new(scene.clone(), Options::default());
    let mut pawns: [Option<PawnId>; 4] = [None; 4];
    for (client, line) in LINES {
        let command = Command::parse(line, &mut Vec::new()).expect("a command");
        let spawned = world.execute(pawns[client], &command, &mut Vec::new()).spawned;
        pawns[client] = spawned.or(pawns[client]);
    }
    (0..30).for_each(|_| drop(world.step()));
    let state = world.save().expect("a world without a robot of the engine");
    (scene, serde_json::to_value(state).expect("JSON"))
});

/// Lines such as
///
/// ```text
/// /options/time_step 0.5
/// 17 -1e300
/// ```
///
/// say which value of a saved world is replaced by what: by its JSON pointer, or by its number among all values.
///
/// A changed world is refused, or it steps: time goes on, a step's work has a bound, every number that is seen is finite, and the world
/// can be saved and loaded again.
pub fn saved(bytes: &[u8]) {
    let (scene, state) = &*SAVED;
    let mut state = state.clone();
    for line in String::from_utf8_lossy(bytes).lines().take(MAX_CHANGES) {
        if let Some((place, value)) = line.split_once(' ')
            && let Ok(value) = serde_json::from_str(value)
        {
            change(&mut state, place, value);
        }
    }
    let Ok(saved) = serde_json::from_value::<SavedWorld>(state) else { return };
    let Ok(mut world) = World::load(scene.clone(), &saved) else { return };
    for _ in 0..STEPS {
        let before = world.time();
        for (_, report) in world.step() {
            if let Some(message) = world.message(report) {
                assert_finite("a message", &Message::read_all(&message.write(Dialect::Udk)));
            }
        }
        assert!(world.time() > before);
        assert!(world.work() <= MAX_WORK, "a step of {} multiplications", world.work());
        for (id, class, _) in world.robots() {
            assert_finite(class, &world.observe(id));
        }
        assert_finite("the objects", &world.objects().map(|object| object.pose).collect::<Vec<_>>());
    }
    let again = world.save().expect("a world that was saved");
    match World::load(scene.clone(), &again) {
        // A counter was loaded at its end, and went on.
        Ok(_) | Err(LoadError::TooHigh { .. }) => {}
        Err(error) => panic!("a world that was loaded cannot be loaded again: {error}"),
    }
}

fn change(state: &mut Value, place: &str, value: Value) {
    if let Some(found) = state.pointer_mut(place) {
        *found = value;
    } else if let Ok(number) = place.parse::<usize>() {
        let count = leaves(state);
        if let Some(leaf) = leaf(state, &mut (number % count.max(1))) {
            *leaf = value;
        }
    }
}

/// Counts the values that hold no others.
fn leaves(value: &Value) -> usize {
    match value {
        Value::Array(values) => values.iter().map(leaves).sum(),
        Value::Object(values) => values.values().map(leaves).sum(),
        _ => 1,
    }
}

/// Returns the value with a number among those that hold no others.
fn leaf<'a>(value: &'a mut Value, number: &mut usize) -> Option<&'a mut Value> {
    match value {
        Value::Array(values) => values.iter_mut().find_map(|value| leaf(value, number)),
        Value::Object(values) => values.values_mut().find_map(|value| leaf(value, number)),
        _ if *number == 0 => Some(value),
        _ => {
            *number -= 1;
            None
        }
    }
}
