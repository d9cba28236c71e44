//! Logs of earlier formats can be read, and replay to the same bits.

use std::path::Path;

/// Replays a log of November 2026, when a robot was a body with wheels: a caster robot and a youBot drive for a second and a
/// half. (A change of how robots move will end the equal bits. Then only the reading must be kept.)
#[test]
fn a_log_from_before_robots_were_trees_replays_to_the_same_bits() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/logs/before-trees.mcap");
    let log = recorder::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let scene = log.scene().unwrap_or_else(|error| panic!("{error}"));
    let names = |class: &str| scene.robots[class].links.iter().map(|link| link.name.clone()).collect::<Vec<_>>();
    assert_eq!(names("KUKA_YouBot"), ["body", "FLWheel", "FRWheel", "BLWheel", "BRWheel"]);
    assert_eq!(scene.robots["CasterSkidRobot"].driven().count(), 2);
    let replay = replay::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert!(replay.states >= 100 && replay.is_same(), "{replay:?}");
}
