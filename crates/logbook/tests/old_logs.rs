//! Logs of earlier formats can be read and replayed.

use std::path::Path;

/// Replays a log of November 2026, when a robot was a body with wheels: a caster robot and a youBot drive for a second and a
/// half. Its bits are those of glibc's sine, which the world no longer uses, so they are not compared.
#[test]
fn a_log_from_before_robots_were_trees_can_be_replayed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/logs/before-trees.mcap");
    let log = recorder::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let scene = log.scene().unwrap_or_else(|error| panic!("{error}"));
    let names = |class: &str| scene.robots[class].links.iter().map(|link| link.name.clone()).collect::<Vec<_>>();
    assert_eq!(names("KUKA_YouBot"), ["body", "FLWheel", "FRWheel", "BLWheel", "BRWheel"]);
    assert_eq!(scene.robots["CasterSkidRobot"].driven().count(), 2);
    let replay = logbook::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert!(replay.states >= 100 && replay.seconds > 1.4 && replay.recorded.is_some(), "{replay:?}");
}
