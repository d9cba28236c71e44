//! Maps that are offered, and classes of robots that suit them.

use std::fs;

#[test]
fn robots_that_suit_a_shipped_map_are_shipped() {
    let known = scene_loader::robot_names();
    let mut named = 0;
    for map in scene_loader::map_names() {
        let robots = scene_loader::map(&map, &[]).expect("a shipped map").robots;
        named += robots.len();
        for robot in robots {
            assert!(known.contains(&robot), "{map}: {robot}");
        }
    }
    assert!(named > 0);
}

#[test]
fn the_description_of_a_shipped_map_is_read_without_the_rest() {
    for map in scene_loader::map_names() {
        let description = scene_loader::map(&map, &[]).expect("a shipped map").description;
        assert_eq!(scene_loader::map_description(&map), Some(description), "{map}");
    }
    assert_eq!(scene_loader::map_description("nowhere"), None);
}

#[test]
fn a_class_with_a_space_suits_no_map() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("map.toml");
    for (robots, expected) in [
        (r#"["P3AT", "Kenaf"]"#, None),
        (r#"["P3 AT"]"#, Some("robots `P3 AT`: expected a name without spaces and braces")),
        (r#""P3AT""#, Some("expected a sequence")),
    ] {
        let start = "[[start]]\nname = \"S\"\nposition = [0, 0, 0]\n";
        fs::write(&path, format!("description = \"m\"\nrobots = {robots}\n{start}")).expect("a file");
        let error = scene_loader::check(&path).err().map(|error| error.to_string());
        match expected {
            None => assert_eq!(error, None),
            Some(expected) => assert!(error.as_ref().is_some_and(|it| it.contains(expected)), "{robots}: {error:?}"),
        }
    }
}
