//! Height fields: robots drive on them, rays hit them, and files make them.

use std::fs;
use std::path::Path;

use gamebots_proto::Message;
use gamebots_proto::message::Reading;
use nalgebra::{Point3, Vector3};
use scene::{HeightField, MapDef, Shape, WorldDef};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Returns the map of a file with a height field of these keys, beside files of these names.
fn read(keys: &str, files: &[(&str, &[u8])]) -> Result<MapDef, String> {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content) in files {
        fs::write(folder.path().join(name), content).expect("a file");
    }
    let file = folder.path().join("map.toml");
    let text = format!(
        "description = \"ground\"\n[[height_field]]\nname = \"ground\"\nmaterial = \"concrete\"\n{keys}\n\
         [[start]]\nname = \"PlayerStart_0\"\nposition = [0, 0, 0]\n"
    );
    fs::write(&file, text).expect("a file");
    scene_loader::map(&file.display().to_string(), &[]).map_err(|error| error.to_string())
}

#[track_caller]
fn field(keys: &str, files: &[(&str, &[u8])]) -> HeightField {
    let map = read(keys, files).unwrap_or_else(|error| panic!("{error}"));
    let Shape::HeightField(field) = &map.solids[0].shape else { panic!("{:?}", map.solids[0]) };
    field.clone()
}

fn world(keys: &str, files: &[(&str, &[u8])]) -> World {
    let map = read(keys, files).unwrap_or_else(|error| panic!("{error}"));
    let robots = scene_loader::load("rough", &[]).expect("robots").robots;
    World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default())
}

/// Returns the height of the ground at a place, on the triangle there.
fn height(field: &HeightField, x: f64, y: f64) -> f64 {
    let cells = [field.rows() - 1, field.columns - 1];
    let place = |axis: usize, at: f64| {
        let at = (at / field.size[axis] + 0.5) * cells[axis] as f64;
        let cell = (at.floor() as usize).min(cells[axis] - 1);
        (cell, at - cell as f64)
    };
    let ((row, far), (column, right)) = (place(0, x), place(1, y));
    let at = |row: usize, column: usize| field.heights[row * field.columns + column];
    let [near, ahead, beside, across] =
        [at(row, column), at(row + 1, column), at(row, column + 1), at(row + 1, column + 1)];
    if far + right <= 1.0 {
        near + far * (ahead - near) + right * (beside - near)
    } else {
        across + (1.0 - far) * (beside - across) + (1.0 - right) * (ahead - across)
    }
}

#[test]
fn robots_drive_on_uneven_ground_and_do_not_fall_through() {
    let keys = "size = [40.0, 40.0]\ncell = 0.5\nheight = 1.5\nhills = 10.0\nseed = 3";
    let ground = field(keys, &[]);
    for (class, least, line) in [
        ("P3AT", 4.0, "DRIVE {Left 4}{Right 4}"),
        ("Kenaf", 2.0, "DRIVE {Left 4}{Right 4}"),
        ("YouBot", 2.0, "DRIVE {Left 6}{Right 6}"),
        ("KUKA_YouBot", 2.0, "DRIVE {Left 6}{Right 6}"),
        ("FrontAckerman", 2.0, "DRIVE {Speed 4}{FrontSteer 0}{RearSteer 0}"),
    ] {
        let mut world = world(keys, &[]);
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location -10,1.3,0}}"));
        let place = |world: &World| world.state(robot).expect("the robot").0.pose.translation.vector;
        run(&mut world, 1.0);
        let start = place(&world);
        apply(&mut world, robot, line);
        for second in 0..15 {
            run(&mut world, 1.0);
            let at = place(&world);
            let above = -at.z - height(&ground, at.x, at.y);
            assert!((-0.05..1.0).contains(&above), "{class} is {above:.3} m above the ground after {second} s at {at}");
        }
        let way = (place(&world) - start).norm();
        assert!(way > least, "{class} drives {way:.2} m");
    }
}

/// Wheels roll over the stones of gravel: none sinks in, whatever part of its rim meets a stone, and the same seed gives the same course.
#[test]
fn wheels_roll_over_gravel_and_do_not_sink_into_it() {
    let course = |seed: u64| {
        let keys = format!("size = [6.0, 4.0]\ncell = 0.02\nheight = 0.04\nhills = 0.16\nseed = {seed}");
        let ground = field(&keys, &[]);
        let mut world = world(&keys, &[]);
        let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location -2,0,-0.3}");
        run(&mut world, 1.0);
        apply(&mut world, robot, "DRIVE {Left 3}{Right 3}");
        let class = world.def().robots["P3AT"].clone();
        let mut deepest = f64::NEG_INFINITY;
        for _ in 0..2500 {
            world.step();
            let pose = world.state(robot).expect("the robot").0.pose;
            for wheel in class.wheels() {
                let radius = wheel.radius;
                for (turn, y) in (-30..=30)
                    .flat_map(|turn| [-0.5, 0.0, 0.5].map(|side| (f64::from(turn) * 0.05, side * wheel.width)))
                {
                    let rim = Vector3::new(radius * turn.sin(), y, radius * turn.cos());
                    let at = pose * Point3::from(Vector3::from(wheel.position) + rim);
                    deepest = deepest.max(height(&ground, at.x, at.y) + at.z);
                }
            }
        }
        let place = world.state(robot).expect("the robot").0.pose.translation.vector;
        println!("seed {seed}: {:.1} mm deep at most, at {:.3?}", 1000.0 * deepest, place.as_slice());
        (deepest, place)
    };
    let courses = [7, 7, 8].map(course);
    assert_eq!(courses[0], courses[1], "the same seed");
    for (deepest, place) in courses {
        assert!(deepest < 0.003, "a wheel sinks in by {deepest} m");
        // It drives at 0.33 m/s for 5 s.
        assert!(place.x > -1.0, "it drives to {place}");
    }
    assert_ne!(courses[0].1, courses[2].1, "another seed");
}

/// Ahead of the robot the ground rises by a half of the way. The middle beam runs along a line of the grid.
#[test]
fn a_ray_hits_the_ground_at_its_height() {
    let rows: Vec<String> = (0..41)
        .rev()
        .map(|row| vec![format!("{}", (0.5 * (f64::from(row) * 0.25 - 7.0)).max(0.0)); 41].join(","))
        .collect();
    let table = rows.join("\n");
    let mut world = world("size = [10.0, 10.0]\nfile = \"rise.csv\"", &[("rise.csv", table.as_bytes())]);
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    let messages = run(&mut world, 1.0);
    let pose = world.state(robot).expect("the robot").0.pose;
    let def = world.def().robots["P3AT"].clone();
    let laser = def.sensors.iter().find(|sensor| sensor.config.fan().is_some()).expect("a laser");
    let eye = pose * Point3::from(laser.position);
    let scan = messages.into_iter().rev().find_map(|message| match message {
        Message::Sen(sen) => {
            if let Reading::RangeScanner(scan) = sen.reading {
                Some(scan)
            } else {
                None
            }
        }
        _ => None,
    });
    let ranges = scan.expect("a scan").ranges;
    for beam in [70_u8, 90, 110] {
        let angle = -std::f64::consts::FRAC_PI_2 + f64::from(beam) * std::f64::consts::PI / 180.0;
        // The rise begins at x = 2.
        let expected = (2.0 + -eye.z / 0.5 - eye.x) / angle.cos();
        let got = f64::from(ranges[usize::from(beam)]);
        assert!((got - expected).abs() < 0.03, "beam {beam}: {got}, expected {expected}");
    }
}

/// The first row of a file is the far end, and its first number is on the left.
#[test]
fn pictures_and_tables_are_seen_from_above_with_x_up() {
    let expected = HeightField { size: [2.0, 4.0], columns: 3, heights: vec![3.0, 4.0, 5.0, 0.0, 1.0, 2.0] };
    for (name, text) in [("a.csv", "0,1,2\n3,4,5\n"), ("a.txt", "# far\n0 1\t2\n\n3; 4 ,5 # near")] {
        let keys = format!("size = [2.0, 4.0]\nfile = \"{name}\"");
        assert_eq!(field(&keys, &[(name, text.as_bytes())]), expected, "{name}");
    }
    for (depth, pixels, white) in [
        (png::BitDepth::Eight, vec![0, 51, 102, 153, 204, 255], 5.0),
        (png::BitDepth::Sixteen, vec![0, 0, 51, 51, 102, 102, 153, 153, 204, 204, 255, 255], 5.0),
    ] {
        let keys = format!("size = [2.0, 4.0]\nfile = \"a.png\"\nheight = {white:.1}");
        assert_eq!(field(&keys, &[("a.png", &picture(png::ColorType::Grayscale, depth, &pixels))]), expected);
    }
}

/// Encodes a picture of 3 x 2 pixels.
fn picture(colours: png::ColorType, depth: png::BitDepth, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 3, 2);
    encoder.set_color(colours);
    encoder.set_depth(depth);
    encoder.write_header().expect("a header").write_image_data(pixels).expect("pixels");
    bytes
}

#[test]
fn a_seed_makes_the_same_ground_each_time() {
    let keys = |seed: u64| format!("size = [30.0, 20.0]\nheight = 3.0\nflat = 4.0\nseed = {seed}");
    let one = field(&keys(1), &[]);
    assert_eq!((one.rows(), one.columns), (31, 21));
    assert_eq!(one, field(&keys(1), &[]));
    assert_ne!(one, field(&keys(2), &[]));
    let least = one.heights.iter().copied().fold(f64::INFINITY, f64::min);
    let most = one.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((most - least - 3.0).abs() < 1e-3, "{least} to {most}");
    for (x, y) in [(0.0, 0.0), (3.0, 2.0), (-1.0, -3.0)] {
        assert_eq!(height(&one, x, y), 0.0, "{x} {y}");
    }
}

#[test]
fn a_wrong_height_field_is_refused_by_name() {
    let rgb = picture(png::ColorType::Rgb, png::BitDepth::Eight, &[0; 18]);
    let grey = picture(png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 6]);
    let cut = &grey[..grey.len() / 2];
    let file = |name: &str| format!("size = [2.0, 2.0]\nfile = \"{name}\"");
    let made = |keys: &str| format!("size = [20.0, 20.0]\n{keys}");
    for (keys, content, expected) in [
        (file("a.csv"), &b"1,2\n3\n"[..], "line 2: got 1 heights, expected 2 as in the lines before"),
        (file("a.csv"), b"1,2\n3,x\n", "line 2: got `x`, expected a height"),
        (file("a.csv"), b"1,2\n3,nan\n", "line 2: got `nan`, expected a height"),
        (file("a.csv"), b"1,2\n", "1 lines of 2 heights: expected at least two of two"),
        (file("a.csv"), b"1,2\n3,451\n", "`height` is 451: expected -450 to 450 m"),
        (file("a.csv") + "\nheight = 1.0", b"1,2\n3,4\n", "a table has its heights in metres: no `height`"),
        (file("a.csv") + "\nseed = 1", b"1,2\n3,4\n", "unknown key `seed`"),
        (file("b.csv"), b"", "b.csv: cannot be read"),
        (file("a.bmp"), b"", "expected a file that ends in .png, .csv or .txt"),
        (file("a.png"), &grey, "missing `height`: expected that of white over black, m"),
        (file("a.png") + "\nheight = 1.0", &rgb, "Rgb of Eight bits: expected grey of 8 or 16 bits"),
        (file("a.png") + "\nheight = 1.0", cut, "height field `a.png`: "),
        (made(""), b"", "missing `height`: expected that of the highest point over the lowest, m"),
        (made("height = -1.0"), b"", "`height` is -1: expected 0 to 450 m"),
        (made("height = 1.0\ncell = 0.001"), b"", "20001 x 20001 heights: expected at most 500000 of them"),
        (made("height = 1.0\nroughness = 2.0"), b"", "`roughness` is 2: expected 0 to 1"),
        ("height = 1.0".to_owned(), b"", "missing `size`: expected lengths [x, y] in metres"),
        ("size = [0.0, 1.0]\nheight = 1.0".to_owned(), b"", "`size` is [0, 1]: expected numbers of 0.0001 to 100000 m"),
    ] {
        let name = if keys.contains(".png") { "a.png" } else { "a.csv" };
        let error = read(&keys, &[(name, content)]).expect_err(expected);
        assert!(error.contains(expected), "{keys}: {error}");
    }
}

/// `collides`, `conveyor` and `mass` exclude each other.
#[test]
fn a_solid_has_one_use() {
    let check = |keys: &str, expected: &str| {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("map.toml");
        let text = format!(
            "description = \"use\"\n[[box]]\nname = \"box\"\nmaterial = \"concrete\"\nsize = [1, 1, 1]\n{keys}\n\
             [[start]]\nname = \"PlayerStart_0\"\nposition = [0, 0, 0]\n"
        );
        fs::write(&file, text).expect("a file");
        let map = scene_loader::map(&file.display().to_string(), &[]);
        let uses = |map: &MapDef| {
            let numbers = [map.solids.len(), map.objects.len(), map.conveyors.len(), map.markings.len()];
            format!("{numbers:?}")
        };
        let got = map.map_or_else(|error| error.to_string(), |map| uses(&map));
        assert!(got.contains(expected), "{keys}: {got}");
    };
    check("", "[1, 0, 0, 0]");
    check("mass = 1.0", "[0, 1, 0, 0]");
    check("conveyor = [1, 0, 0]", "[1, 0, 1, 0]");
    check("collides = false", "[0, 0, 0, 1]");
    check("collides = true", "[1, 0, 0, 0]");
    check("collides = false\nmass = 1.0", "expected at most one of `mass`, `conveyor` and `collides = false`");
    check("conveyor = [1, 0, 0]\nmass = 1.0", "expected at most one of `mass`, `conveyor` and `collides = false`");
    check("conveyor = [11, 0, 0]", "`conveyor` is [11, 0, 0]: expected numbers of -10 to 10 m/s");
}

#[test]
fn a_marking_is_seen_and_not_felt() {
    let mut def = scene_loader::load("soccer", &[]).expect("a map");
    assert!(def.map.markings.len() > 50, "{}", def.map.markings.len());
    let wall = scene::Solid {
        name: "curtain".to_owned(),
        shape: Shape::Box { size: [0.1, 20.0, 2.0] },
        position: [1.0, 0.0, -1.0],
        ..def.map.markings[0].clone()
    };
    def.map.markings.push(wall);
    let mut world = World::new(def, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,1.5,0}");
    apply(&mut world, robot, "DRIVE {Left 4}{Right 4}");
    run(&mut world, 5.0);
    let place = world.state(robot).expect("the robot").0.pose.translation.vector;
    assert!(place.x > 1.2, "{place}");
}

/// `maps/make.py` makes the maps that are too long to write by hand.
#[test]
fn generated_maps_are_as_their_script_makes_them() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../maps/make.py");
    let check = std::process::Command::new("python3").arg(script).arg("--check").output().expect("python3");
    assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
}
