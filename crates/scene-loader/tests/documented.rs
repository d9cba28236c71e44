//! Checks that the book documents every key of a file.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

/// Headings of `docs/files.md`, the kind of file, and the header of such a table.
const TABLES: &[(&str, &str, &str)] = &[
    ("## map.toml", "map.toml", ""),
    ("### `[material.NAME]`", "map.toml", "[material.NAME]"),
    ("### `[[half_space]]`", "map.toml", "[[half_space]]"),
    ("### `[[box]]`", "map.toml", "[[box]]"),
    ("### `[[ramp]]`", "map.toml", "[[ramp]]"),
    ("### `[[cylinder]]`", "map.toml", "[[cylinder]]"),
    ("### `[[ball]]`", "map.toml", "[[ball]]"),
    ("### `[[mesh]]`", "map.toml", "[[mesh]]"),
    ("### `[[height_field]]`", "map.toml", "[[height_field]]"),
    ("### `[[start]]` and `[[path_node]]`", "map.toml", "[[start]]"),
    ("### `[[start]]` and `[[path_node]]`", "map.toml", "[[path_node]]"),
    ("### `[[victim]]`", "map.toml", "[[victim]]"),
    ("### `[[rfid]]`", "map.toml", "[[rfid]]"),
    ("### `[[smoke]]`", "map.toml", "[[smoke]]"),
    ("### `[[sound]]`", "map.toml", "[[sound]]"),
    ("## robot.toml", "robot.toml", ""),
    ("### `[[link]]`", "robot.toml", "[[link]]"),
    ("### `[[part]]`", "robot.toml", "[[part]]"),
    ("### `[[joint]]`", "robot.toml", "[[joint]]"),
    ("### `coupling` of a joint", "robot.toml", "[[joint]]\n[joint.coupling]"),
    ("### `[[wheel]]`", "robot.toml", "[[wheel]]"),
    ("### `[[wheel]]`", "robot.toml", "[wheels]"),
    ("### `[rollers]`", "robot.toml", "[rollers]"),
    ("### `[[track]]`", "robot.toml", "[[track]]"),
    ("### `[[track]]`", "robot.toml", "[tracks]"),
    ("### `[[mount]]`", "robot.toml", "[[mount]]"),
    ("### `[[caster]]`", "robot.toml", "[[caster]]"),
    ("### `[[visual]]`", "robot.toml", "[[visual]]"),
    ("### `[[actuator]]`", "robot.toml", "[[actuator]]"),
    ("### `[[gripper]]`", "robot.toml", "[[gripper]]"),
    ("### `[battery]`", "robot.toml", "[battery]"),
    ("### `[aerial]`", "robot.toml", "[aerial]"),
    ("## Equipment", "equipment.toml", "description = \"\"\n[P3AT]"),
];

/// Sensors without settings.
const PLAIN: [&str; 10] = [
    "IMU",
    "Tachometer",
    "Battery",
    "Acceleration",
    "Accelerometer",
    "AltitudeSensor",
    "MagneticCompass",
    "MissionTime",
    "RFIDReleaser",
    "INUSensor",
];

/// Returns the text under a heading, up to the next one.
fn section<'a>(book: &'a str, heading: &str) -> &'a str {
    let (_, rest) = book.split_once(&format!("\n{heading}\n")).unwrap_or_else(|| panic!("no heading {heading}"));
    rest.split("\n#").next().unwrap_or(rest)
}

/// Returns the keys that the error for an unknown key lists.
fn keys(file: &str, table: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(file);
    fs::write(&path, format!("{table}\nunheard-of = 1\n")).unwrap();
    let problems = scene_loader::check(&path).unwrap_err().to_string();
    let line = problems.lines().find(|line| line.contains("unknown") && line.contains("unheard-of"));
    let line = line.unwrap_or_else(|| panic!("{table}: {problems}"));
    let (_, keys) = line.rsplit_once("expected one of ").or(line.rsplit_once("expected ")).unwrap();
    keys.split(", ").flat_map(|key| key.split(" or ")).map(|key| key.trim_matches('`').to_owned()).collect()
}

fn check(book: &str, heading: &str, file: &str, table: &str) {
    // The keys common to all solids are documented once.
    let solids = ["half_space", "box", "ramp", "cylinder", "ball", "mesh", "height_field"];
    let is_solid = solids.iter().any(|solid| *table == format!("[[{solid}]]"));
    let every = if is_solid { section(book, "### Every solid") } else { "" };
    let text = [section(book, heading), every].concat();
    for key in keys(file, table) {
        let named = [format!("`{key}`"), format!("`[[{key}]]`"), format!("`[{key}]`"), format!("`[{key}.NAME]`")];
        assert!(named.iter().any(|name| text.contains(name)), "docs/files.md, {heading}: no `{key}`");
    }
}

#[test]
fn every_key_of_a_file_is_in_the_book() {
    let book = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/files.md");
    let book = fs::read_to_string(book).unwrap();
    for (heading, file, table) in TABLES {
        check(&book, heading, file, table);
    }
    for (class, _) in scene::sensor::CLASSES {
        let heading = "### `[[sensor]]`";
        assert!(section(&book, heading).contains(&format!("`{class}`")), "{class}");
        let sensor = format!("[[sensor]]\nclass = \"{class}\"\nname = \"S\"");
        if !PLAIN.contains(class) {
            check(&book, heading, "robot.toml", &sensor);
        }
    }
}

/// Overrides in the book name materials that exist: shipped ones, or those of a map on the same page.
#[test]
fn the_book_names_no_material_that_does_not_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let shipped = fs::read_to_string(root.join("assets/materials.toml")).unwrap();
    let pages = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages = pages.chain([root.join("README.md")]).filter(|path| path.extension().is_some_and(|it| it == "md"));
    let mut found = 0;
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        for part in text.split("material.").skip(1) {
            let Some((name, rest)) = part.split_once('.') else { continue };
            let is_name = !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '-');
            if is_name && rest.starts_with(|c: char| c.is_ascii_lowercase()) && rest.contains('=') {
                let is_known = shipped.contains(&format!("\n[{name}]")) || text.contains(&format!("[material.{name}]"));
                assert!(is_known, "{}: no material `{name}`", page.display());
                found += 1;
            }
        }
    }
    assert!(found > 3, "{found}");
}
