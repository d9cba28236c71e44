//! Scenarios: their files, what ends them, and the logs of their demos.

use logbook::write_demo;
use scene::{Setting, WorldDef};
use sessions::{News, Request, Sessions};
use sim_core::{Options, World};

fn scene(setting: Setting) -> WorldDef {
    let def = scene_loader::load("smooth", &[]).expect("a scene").on(setting);
    def.check().expect("a good scene");
    def
}

/// The lines of a demo are of a run over the wire: the same steps reach the same goals here.
#[test]
fn the_demo_of_every_scenario_reaches_its_goals_and_replays() {
    let names = scene_loader::scenario_names();
    assert!(names.len() >= 10, "{names:?}");
    let folder = tempfile::tempdir().expect("a folder");
    for listed in scene_loader::listed_scenarios(&names).expect("good files") {
        let name = &listed.card.name;
        let scene = scene(scene_loader::scenario(name).expect("a good file"));
        let [three, _] = listed.card.stars;
        let log = folder.path().join("demo.mcap");
        let took = write_demo(scene, &listed.demo.expect("a demo"), &log).expect("a log");
        let took = took.unwrap_or_else(|| panic!("the demo of {name} reaches not all goals: make it anew"));
        println!("{name}: {took:.1} s");
        assert!(took <= three, "{name}: {took} s are no three stars");
        if name == "goal" {
            let replay = logbook::replay(&recorder::read(&log).expect("a log")).expect("a replay");
            assert!(replay.is_same(), "{name}: {replay:?}");
        }
    }
}

const STAIRS: &str = "title = \"T\"\ntext = \"Go.\"\nkeys = \"W\"\nmap = \"smooth\"\ntime_limit = 20\nstars = [3, 6]\n";
const ROBOT: &str = "[[robot]]\nclass = \"P3AT\"\nposition = [0.0, 0.0, 0.0]\n";
const ZONE: &str = "[[zone]]\nname = \"there\"\nposition = [1.0, 0.0, 0.0]\nsize = [1.0, 1.0, 2.0]\n";

#[test]
fn a_wrong_scenario_is_told_what_was_expected() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scenario.toml");
    let two = "[[robot]]\nclass = \"P3AT\"\nposition = [1.0, 0.0, 0.0]\n";
    for (text, expected) in [
        (format!("{STAIRS}{ROBOT}{ZONE}"), ""),
        (format!("{STAIRS}{ROBOT}"), "no goal: expected [victims], a [[zone]] or a [[goal]]"),
        (format!("{STAIRS}{ZONE}"), "no [[robot]]: expected at least one"),
        (format!("{STAIRS}{ROBOT}{two}{ZONE}"), "`starts` has P3AT twice"),
        (
            format!("{}{ROBOT}{ZONE}", STAIRS.replace("[3, 6]", "[6, 3]")),
            "`stars` is [6, 3]: expected a first time that is less",
        ),
        (format!("{}{ROBOT}{ZONE}", STAIRS.replace("[3, 6]", "[3, 60]")), "both within 20 s"),
        (format!("{}{ROBOT}{ZONE}", STAIRS.replace("[3, 6]", "[nan, 6]")), "`stars` is [NaN, 6]: expected numbers of"),
        (format!("{}{ROBOT}{ZONE}", STAIRS.replace("time_limit = 20\n", "")), "missing `time_limit`"),
        (format!("{}{ROBOT}{ZONE}", STAIRS.replace("smooth", "smoth")), "unknown map `smoth`"),
        (format!("star = 1\n{STAIRS}{ROBOT}{ZONE}"), "unknown key `star`: expected one of title, text, keys, map,"),
        (
            format!("{STAIRS}camera = {{ from = [1.0, 0.0, 0.0], at = [1.0, 0.0, 0.0] }}\n{ROBOT}{ZONE}"),
            "camera: `from` is `at`",
        ),
        (
            format!(
                "{STAIRS}{ROBOT}[[goal]]\nname = \"x\"\npush = {{ object = \"crate\", target = [[0.0, 0.0], [0.0, 0.0]], tolerance = 0.1 }}\n"
            ),
            "the map smooth has no object `crate`",
        ),
    ] {
        std::fs::write(&file, &text).expect("a file");
        let error = scene_loader::check(&file).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(expected) && error.is_empty() == expected.is_empty(), "{text}: {error}");
    }
    let error = scene_loader::scenario("stair").expect_err("none of that name").to_string();
    assert!(error.contains("unknown scenario `stair` (did you mean `stairs`?)"), "{error}");
}

/// Runs a scenario with a robot that stands, or drives ahead from the start. Returns its time and how often the time was up.
fn play(drives: bool) -> (Option<f64>, usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scenario.toml");
    std::fs::write(&file, format!("{STAIRS}{ROBOT}{ZONE}")).expect("a file");
    let setting = scene_loader::scenario(&file.display().to_string()).expect("a good file");
    let mut sessions = Sessions::new(World::new(scene(setting), Options::default()));
    sessions.open(1, None, false, &mut |_, _| {});
    for line in ["INIT {ClassName USARBot.P3AT}", if drives { "DRIVE {Left 3} {Right 3}" } else { "DRIVE {Left 0}" }] {
        sessions.take(1, &Request::read(Ok(line.to_owned())), &mut |_, _| {});
    }
    let mut ends = 0;
    while sessions.world().time() < 25.0 {
        sessions.step(&mut |_, news| ends += usize::from(matches!(news, News::TimeUp(_))));
    }
    let standings = sessions.standings().expect("a league");
    (standings.teams[0].finished, ends)
}

#[test]
fn who_has_reached_all_goals_is_not_stopped_when_the_time_is_up() {
    let (finished, ends) = play(true);
    assert!(finished.is_some_and(|seconds| (1.0..4.0).contains(&seconds)) && ends == 0, "{finished:?} {ends}");
    assert_eq!(play(false), (None, 1));
}
