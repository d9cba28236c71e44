//! Lines with times into a world of robots that touch.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::{LazyLock, Mutex, PoisonError};

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Dialect};
use scene::{DriveModel, WorldDef};
use sessions::{News, Request, SessionId, Sessions};
use sim_core::{CompiledScene, Options, World};

use crate::assert_finite;

/// Maps that an input can choose, the first unless it names one.
const MAPS: [&str; 6] = ["rough", "arena", "slope-4.5", "hall", "rescue", "factory"];
/// Most steps of one input; and most at once.
const MAX_STEPS: u32 = 200;
/// Most robots in the world at once.
const MAX_ROBOTS: usize = 3;
/// Most lines of one input: what counts is what happens between them.
const MAX_LINES: usize = 200;

/// Multiplications that a step may take: the budget of as many systems of two as there may be robots and objects, with a step of Newton's
/// method beyond it.
pub(crate) const MAX_WORK: u64 = 10_000_000;

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
    let mut sessions = Sessions::new(World::new(compiled(scene), Options::default()));
    let (mut steps, mut sent) = (0, String::new());
    for line in lines.lines().take(MAX_LINES) {
        if let Ok(wanted) = line.trim().parse::<u32>() {
            let wanted = wanted.min(MAX_STEPS - steps);
            (0..wanted).for_each(|_| step(&mut sessions, &mut sent));
            steps += wanted;
        } else {
            act(line, &mut sessions, &mut sent);
        }
    }
    let world = sessions.world();
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

fn act(line: &str, sessions: &mut Sessions, sent: &mut String) {
    let session = SessionId::from(line.bytes().next().unwrap_or_default()) % 3;
    let text = line.get(1..).unwrap_or_default().trim();
    if text.is_empty() {
        return sessions.close(session, &mut |_, news| note(news, sent));
    }
    if !sessions.is_open(session) {
        sessions.open(session, Some(Dialect::Udk), false, &mut |_, news| note(news, sent));
    }
    let request = Request::read(Ok(text.to_owned()));
    let is_full = sessions.world().robots().count() >= MAX_ROBOTS;
    if !(is_full && matches!(request.command, Some(Command::Init(_)))) {
        sessions.take(session, &request, &mut |_, news| note(news, sent));
        see(sessions.world());
    }
}

fn step(sessions: &mut Sessions, sent: &mut String) {
    let before = sessions.world().time();
    sessions.step(&mut |_, news| note(news, sent));
    let world = sessions.world();
    assert!(world.time() > before);
    assert!(world.work() <= MAX_WORK, "a step of {} multiplications", world.work());
    see(world);
}

fn note(news: News, sent: &mut String) {
    match news {
        News::Sensed(sensed) => assert_finite("a reading", sensed),
        News::Sent { session, line, .. } => {
            assert_finite("a message", &Message::read_all(&line));
            let _ = writeln!(sent, "{session} {line}");
        }
        News::Lost(lost) => panic!("{lost}"),
        _ => {}
    }
}

/// Looks at everything that can be seen.
fn see(world: &World) {
    for (id, class, _) in world.robots() {
        assert_finite(class, &world.observe(id));
    }
    assert_finite("the objects", &world.objects().map(|object| object.pose).collect::<Vec<_>>());
}
