//! Lines with times into a world of robots that touch.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{LazyLock, Mutex, PoisonError};

use gamebots_proto::{Command, Dialect};
use scene::{DriveModel, WorldDef};
use sim_core::{CompiledScene, Options, PawnId, World};

use crate::assert_finite;

/// Maps that an input can choose, the first unless it names one.
const MAPS: [&str; 4] = ["rough", "arena", "slope-4.5", "hall"];
/// Most steps of one input; and most at once.
const MAX_STEPS: u32 = 200;
/// Most robots in the world at once.
const MAX_ROBOTS: usize = 3;
/// Most lines of one input: what counts is what happens between them.
const MAX_LINES: usize = 200;

/// Multiplications that a step may take: the budget of as many systems of two as there may be robots and objects, with a step of Newton's
/// method beyond it.
const MAX_WORK: u64 = 10_000_000;

static WORLDS: LazyLock<Vec<WorldDef>> = LazyLock::new(|| {
    let load = |map: &&str| scene_loader::load(map, &[]).expect("a built-in map");
    MAPS.iter().map(load).collect()
});

/// Scenes that inputs have asked for: to compile one takes longer than most inputs.
static SCENES: Mutex<BTreeMap<(usize, Option<&str>), CompiledScene>> = Mutex::new(BTreeMap::new());

/// A text such as
///
/// ```text
/// arena analytic
/// a INIT {ClassName USARBot.P3AT} {Location 0,0,0}
/// b INIT {ClassName KUKA_YouBot} {Location 0.5,0,0}
/// a DRIVE {Left 5} {Right 5}
/// 40
/// b
/// ```
///
/// says the map and the drive model of Mecanum robots, then what the connections a, b and c send, how many steps pass, and
/// which connection ends.
///
/// Every number in a message and in what is seen of a robot is finite, no robot has to be taken out because its state is not,
/// a step's work has a bound, time goes on by steps, and the same input again gives the same lines and the same digest.
pub fn world(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let first = run(&text);
    let second = run(&text);
    assert!(first == second, "two runs differ:\n{}\nand\n{}", first.1, second.1);
}

/// The digest of the world at the end and everything that was sent.
fn run(text: &str) -> (u64, String) {
    let (scene, lines) = text.split_once('\n').unwrap_or((text, ""));
    let mut world = World::new(compiled(scene), Options::default());
    // The robots of three clients, the newest last.
    let mut clients: [Vec<PawnId>; 3] = Default::default();
    let (mut steps, mut sent) = (0, String::new());
    for line in lines.lines().take(MAX_LINES) {
        if let Ok(wanted) = line.trim().parse::<u32>() {
            let wanted = wanted.min(MAX_STEPS - steps);
            (0..wanted).for_each(|_| step(&mut world, &mut sent));
            steps += wanted;
        } else {
            act(line, &mut clients, &mut world, &mut sent);
        }
    }
    assert_eq!(world.time(), f64::from(steps) * world.time_step());
    (world.digest(), sent)
}

fn compiled(scene: &str) -> CompiledScene {
    let mut words = scene.split_whitespace();
    let map = words.next().and_then(|name| MAPS.iter().position(|map| *map == name)).unwrap_or_default();
    let model = words.next().and_then(|name| name.parse::<DriveModel>().ok());
    let mut scenes = SCENES.lock().unwrap_or_else(PoisonError::into_inner);
    let compile = || {
        let mut definition = WORLDS[map].clone();
        definition.robots.values_mut().for_each(|robot| robot.set_drive_model(model));
        CompiledScene::from(definition)
    };
    scenes.entry((map, model.map(DriveModel::name))).or_insert_with(compile).clone()
}

fn act(line: &str, clients: &mut [Vec<PawnId>; 3], world: &mut World, sent: &mut String) {
    let connection = line.bytes().next().unwrap_or_default();
    let text = line.get(1..).unwrap_or_default().trim();
    let robots = &mut clients[usize::from(connection) % 3];
    let full = world.robots().count() >= MAX_ROBOTS;
    if text.is_empty() {
        robots.drain(..).for_each(|robot| world.remove(robot));
    } else if let Some(command) = Command::parse(text, &mut Vec::new())
        && !(full && matches!(command, Command::Init(_)))
    {
        let executed = world.execute(robots.last().copied(), &command, &mut Vec::new());
        robots.extend(executed.spawned);
        for answer in executed.answers {
            assert_finite("an answer", &answer);
            let message = world.message(answer).expect("a message");
            let _ = writeln!(sent, "{}", message.write(Dialect::Udk));
        }
        see(world);
    }
}

fn step(world: &mut World, sent: &mut String) {
    let before = world.time();
    for (PawnId(robot), report) in world.step() {
        assert_finite("a report", &report);
        let message = world.message(report).expect("a message");
        let _ = writeln!(sent, "{robot} {}", message.write(Dialect::Udk));
    }
    assert!(world.time() > before);
    assert!(world.work() <= MAX_WORK, "a step of {} multiplications", world.work());
    assert_eq!(world.take_lost(), []);
    see(world);
}

/// Looks at everything that can be seen.
fn see(world: &World) {
    for (id, class, _) in world.robots() {
        assert_finite(class, &world.observe(id));
    }
    assert_finite("the objects", &world.objects().map(|object| object.pose).collect::<Vec<_>>());
}
