//! Helpers of the system tests: worlds in this process, servers on a socket or as a process, clients and transcripts.

mod busy;
mod honest;
mod measuring;
mod program;
mod recordings;
mod server;
pub mod sessions;
mod stage;
mod transcript;
mod watch;

pub use busy::{busy_scene, busy_world};
pub use honest::Honest;
pub use measuring::{alone, setting};
pub use program::{Program, Usage};
pub use recordings::{recordings, server_lines};
pub use server::{PATIENCE, Peer, Server, time_of};
pub use stage::Stage;
pub use transcript::{Transcript, run_transcript};
pub use watch::{Seen, Watch};

use std::path::Path;
use std::time::{Duration, Instant};

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Dialect, Line};
use scene::WorldDef;
use sim_core::{FreePlace, Options, PawnId, TIME_STEP, World};

/// Builds a world on a built-in map.
///
/// # Panics
/// If the map or a built-in robot does not load.
pub fn world(map: &str, seed: u64) -> World {
    let def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    World::new(def, Options { seed, ..Options::default() })
}

/// Loads the map `rough` with a robot of `tests/robots`.
///
/// # Panics
/// If it does not load.
pub fn scene_with_test_robot(class: &str) -> WorldDef {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(class).join("robot.toml");
    scene_loader::load("rough", &[&file]).unwrap_or_else(|error| panic!("{error}"))
}

/// Waits until a condition holds.
///
/// # Panics
/// If it does not hold within [`PATIENCE`].
#[track_caller]
pub fn wait_until(condition: impl FnMut() -> bool) {
    look_until(condition, |&holds| holds);
}

/// Looks until what is seen fits, and returns it.
///
/// # Panics
/// If nothing fits within [`PATIENCE`]. The message has what was seen last.
#[track_caller]
pub fn look_until<T: std::fmt::Debug>(mut look: impl FnMut() -> T, fits: impl Fn(&T) -> bool) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        let seen = look();
        if fits(&seen) {
            return seen;
        }
        assert!(Instant::now() < end, "did not happen; last seen: {seen:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Copies the folder of a shipped robot, with the meshes that its file names.
///
/// # Panics
/// If the copy fails.
pub fn copy_robot(class: &str, into: &Path) {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets/robots").join(class);
    let files = std::fs::read_dir(&shipped).unwrap_or_else(|error| panic!("{}: {error}", shipped.display()));
    for file in files.map(|file| file.unwrap_or_else(|error| panic!("{error}"))) {
        let copy = into.join(file.file_name());
        std::fs::copy(file.path(), &copy).unwrap_or_else(|error| panic!("{}: {error}", copy.display()));
    }
}

/// Reads a command from a line.
///
/// # Panics
/// If the line is not a command.
pub fn command(text: &str) -> Command {
    Command::read(&Line::parse(text), &mut Vec::new()).unwrap_or_else(|| panic!("not a command: {text}"))
}

/// Executes a line of a pawn. Returns the problems with it.
///
/// # Panics
/// If the line is not a command.
pub fn problems(world: &mut World, pawn: PawnId, text: &str) -> Vec<String> {
    let mut problems = Vec::new();
    let command = Command::parse(text, &mut problems).unwrap_or_else(|| panic!("not a command: {text}"));
    world.execute(Some(pawn), &command, &mut problems);
    problems.iter().map(ToString::to_string).collect()
}

/// Spawns a robot in a world.
///
/// # Panics
/// If the world refuses it.
pub fn init(world: &mut World, text: &str) -> PawnId {
    let Command::Init(init) = command(text) else { panic!("not INIT: {text}") };
    let mut problems = Vec::new();
    world.init(&init, &mut problems).unwrap_or_else(|| panic!("{problems:?}"))
}

/// Spawns a robot on top of the objects and robots at a place, or on the floor.
///
/// # Panics
/// If there is no free place up to 20 m above.
pub fn init_on_top(world: &mut World, class: &str, [x, y]: [f64; 2], yaw: f64) -> PawnId {
    let mut is_free =
        |up: f64| matches!(world.fit(class, [x, y, -up], [0.0, 0.0, yaw]), Some(Ok(FreePlace { beside: None, .. })));
    let coarse = (0..2_000).map(|number| 0.01 * f64::from(number)).find(|&up| is_free(up));
    let coarse = coarse.unwrap_or_else(|| panic!("no room for a {class} at {x}, {y}"));
    let fine = (0..20).map(|number| coarse - 5e-4 * f64::from(number));
    let up = fine.take_while(|&up| up >= 0.0 && is_free(up)).last().unwrap_or(coarse);
    init(world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {x},{y},{}}} {{Rotation 0,0,{yaw}}}", -up))
}

/// Gives a robot a command line and returns the answers.
pub fn apply(world: &mut World, robot: PawnId, text: &str) -> Vec<String> {
    let answers = world.execute(Some(robot), &command(text), &mut Vec::new()).answers.into_iter();
    answers.filter_map(|answer| Some(world.message(answer)?.write(Dialect::Udk))).collect()
}

/// Runs a world for a time and returns every message.
pub fn run(world: &mut World, seconds: f64) -> Vec<Message> {
    let steps = (seconds / TIME_STEP).round() as u64;
    let mut step = || world.step().into_iter().filter_map(|(_, report)| world.message(report)).collect::<Vec<_>>();
    (0..steps).flat_map(|_| step()).collect()
}
