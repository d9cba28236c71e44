//! Lines of sensors in scenes worked out by hand (sensors.md 7, checks 36 to 49), on a robot that stands still at the origin.

use gamebots_proto::Dialect;
use gamebots_proto::message::Message;
use scene::{MapDef, RfidTag, SensorDef, Shape, Smoke, Solid, Sound, Victim, WorldDef};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, init, run};

/// Height of the sensors above the floor, m: above the robot.
const HEIGHT: f64 = 1.0;

fn base() -> WorldDef {
    scene_loader::load("rough", &[]).expect("a built-in map")
}

fn solid(map: &MapDef, name: &str, centre: [f64; 3], size: [f64; 3]) -> Solid {
    let material = map.solids[0].material.clone();
    Solid { name: name.to_owned(), shape: Shape::Box { size }, position: centre, rotation: [0.0; 3], material }
}

/// Builds a world with a robot of one sensor at the origin, [`HEIGHT`] above the floor.
fn world(class: &str, change: impl FnOnce(&mut MapDef)) -> (World, PawnId) {
    let WorldDef { mut map, mut robots, .. } = base();
    change(&mut map);
    let mut robot = robots.remove("StaticPlatform").expect("a platform");
    let (_, scan_interval) =
        scene::sensor::CLASSES.iter().find(|(known, _)| *known == class).expect("a class of sensors");
    let config = scene::sensor::Config::read(class, serde_json::json!({})).expect("a class").expect("no settings");
    let sensor = SensorDef {
        name: "S".to_owned(),
        link: 0,
        position: [0.0; 3],
        direction: [0.0; 3],
        scan_interval: *scan_interval,
        config,
    };
    robot.sensors = vec![sensor];
    let robots = [("StaticPlatform".to_owned(), robot)].into();
    let mut world = World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default());
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.StaticPlatform}} {{Location 0,0,-{HEIGHT}}}"));
    (world, robot)
}

/// Returns the lines of the sensor within some seconds.
fn lines(world: &mut World, seconds: f64) -> Vec<String> {
    let sen = |message: &Message| matches!(message, Message::Sen(_));
    run(world, seconds).iter().filter(|it| sen(it)).map(|message| message.write(Dialect::Udk)).collect()
}

/// Compares the first line of a sensor, after its time.
#[track_caller]
fn check(class: &str, change: impl FnOnce(&mut MapDef), expected: &str) {
    let (mut world, _) = world(class, change);
    let lines = lines(&mut world, 1.2);
    let first = lines.first().unwrap_or_else(|| panic!("{class} sends nothing"));
    let line = first.split_once("{Type ").map_or("", |(_, rest)| rest);
    // Rounded numbers keep the sign of a zero, as in the original.
    assert_eq!(line.replace("-0.00,", "0.00,").replace("-0.00}", "0.00}"), expected, "{class}");
}

fn wall(distance: f64) -> impl FnOnce(&mut MapDef) {
    move |map| {
        let wall = solid(map, "Wall", [distance + 0.5, 0.0, -HEIGHT], [1.0, 40.0, 1.9]);
        map.solids.push(wall);
    }
}

/// Puts a pane half a metre ahead of what `change` adds.
fn pane(change: impl FnOnce(&mut MapDef)) -> impl FnOnce(&mut MapDef) {
    move |map| {
        change(map);
        let mut pane = solid(map, "Pane", [0.505, 0.0, -HEIGHT], [0.01, 4.0, 1.9]);
        pane.material.transparent = true;
        map.solids.push(pane);
    }
}

fn nothing(_: &mut MapDef) {}

/// Check 39. A laser stops at the pane.
#[test]
fn infrared_light_passes_through_glass() {
    check("IRSensor", wall(1.0), "IR} {Name S} {Range 1.0000}");
    check("IRSensor", wall(0.1), "IR} {Name S} {Range 0.2000}");
    check("IRSensor", wall(3.0), "IR} {Name S} {Range 1.5000}");
    check("IRSensor", pane(wall(1.25)), "IR} {Name S} {Range 1.2500}");
    check("IRSensor", pane(nothing), "IR} {Name S} {Range 1.5000}");
    let (mut behind_glass, _) = world("SICK", pane(wall(1.2)));
    assert_eq!(middle(&lines(&mut behind_glass, 0.3)[0]), "0.50");
    let (mut infrared, _) = world("IRScanner", pane(wall(1.2)));
    assert_eq!(middle(&lines(&mut infrared, 0.3)[0]), "1.20");
}

/// Returns the middle one of a line's ranges.
fn middle(line: &str) -> &str {
    let ranges = line.split_once("{Range ").expect("ranges").1.trim_end_matches('}');
    let count = ranges.split(',').count();
    ranges.split(',').nth(count / 2).expect("a range")
}

/// Sensors.md 4.5: 37 rays with whole rotation units.
#[test]
fn an_infrared_scanner_has_the_beams_that_the_original_means() {
    let (mut world, robot) = world("IRScanner", nothing);
    let line = lines(&mut world, 0.15).remove(0);
    assert!(line.contains("{Type IRScanner} {Name S} {Resolution 0.0869} {FOV 3.1399} {Range 10.00,"), "{line}");
    assert_eq!(line.matches("10.00").count(), 37);
    let conf = apply(&mut world, robot, "GETCONF {Type IRScanner}").remove(0);
    assert!(conf.starts_with("CONF {Type IRScanner} {Name S} {MaxRange 10.0000} {MinRange 0.2000"), "{conf}");
}

/// A beam of 0.00575 1/m of smoke reads 0; a SICK passes any.
#[test]
fn smoke_blinds_a_hokuyo_and_not_a_sick() {
    let smoke = |density: f64| {
        move |map: &mut MapDef| {
            wall(3.0)(map);
            let [position, size] = [[2.0, 0.0, -HEIGHT], [0.5, 8.0, 2.0]];
            map.smoke.push(Smoke { name: "Smoke".to_owned(), position, size, density });
        }
    };
    for (class, density, expected) in [
        ("HokuyoURG04LX", 0.5, "0.00"),
        ("HokuyoURG04LX", 0.01, "2.99"),
        ("SICK", 0.5, "2.99"),
        ("RangeScanner", 0.5, "2.99"),
    ] {
        let (mut world, _) = world(class, smoke(density));
        let line = lines(&mut world, 0.4).remove(0);
        let near = |text: &str| text.parse::<f64>().expect("a number");
        assert!((near(middle(&line)) - near(expected)).abs() < 0.015, "{class} in {density}: {}", middle(&line));
    }
}

/// Check 40: 119 points from the left, and the plane of the wall.
#[test]
fn a_line_laser_returns_points_in_the_world() {
    let (mut world, robot) = world("LineLaser", wall(2.0));
    let line = lines(&mut world, 0.15).remove(0);
    assert!(line.starts_with("SEN {Type LineLaser} {Name S} {Location 0.0000,0.0000,-1.0000} "), "{line}");
    let points = line.split_once("{Points [").expect("points").1.trim_end_matches("]}");
    let points: Vec<Vec<f64>> =
        points.split("][").map(|point| point.split(',').map(|it| it.parse().expect("a number")).collect()).collect();
    assert_eq!(points.len(), 119);
    assert!(points.iter().all(|point| (point[0] - 2.0).abs() < 0.002 && (point[2] + 1.0).abs() < 0.002), "{line}");
    assert!(points.is_sorted_by(|a, b| a[1] < b[1]) && points[0][1] < -1.9, "{line}");
    let conf = apply(&mut world, robot, "GETCONF {Type LineLaser}").remove(0);
    assert_eq!(
        conf,
        "CONF {Type LineLaser} {Name S} {MaxRange 5.0000} {MinRange 0.1000} {FOV 1.5707} {Resolution 120}"
    );
}

/// Check 41.
#[test]
fn a_kinect_sends_a_picture_in_twenty_lines() {
    let (mut world, robot) = world("KinectDepth", wall(2.0));
    let idle = "{Type RangeImager} {Name S} {Resolution 320,240} {FOV 1.0122,0.7853} {Frames 0} {Frame 0}";
    assert!(lines(&mut world, 0.3).iter().all(|line| line.ends_with(idle)));
    apply(&mut world, robot, "SET {Type RangeImager} {Name S} {Opcode SCAN}");
    let frames = lines(&mut world, 2.3);
    let mut count = 0;
    for (number, line) in frames.iter().take(20).enumerate() {
        assert!(line.contains(&format!("{{Frames 20}} {{Frame {number}}} {{Range ")), "{line}");
        let depths = line.split_once("{Range ").expect("depths").1.trim_end_matches('}');
        for depth in depths.split(',').map(|depth| depth.parse::<f64>().expect("a number")) {
            // The wall ends 0.95 m above and below the middle, within the picture.
            assert!((depth - 2.0).abs() < 0.011, "{depth} in {number}");
            count += 1;
        }
    }
    assert_eq!(count, 320 * 240);
    assert!(frames[20].ends_with(idle));
}

/// Check 42.
#[test]
fn point_clouds_show_a_wall_as_a_plane() {
    for (class, count, separator) in [("RotatingPointCloudScanner", 256, ';'), ("ExampleSonarArray", 900, ' ')] {
        let (mut world, _) = world(class, wall(5.0));
        let line = lines(&mut world, 0.7).pop().expect("a line");
        let points = line.trim_end_matches('}').rsplit_once('{').expect("points").1;
        let x: Vec<f64> =
            points.split(separator).map(|point| point.split(',').next().expect("x").parse().expect("x")).collect();
        assert_eq!(x.len(), count, "{line}");
        // Some beams of the fan meet the floor or pass above the wall.
        let at_wall = x.iter().filter(|x| (*x - 5.0).abs() < 0.006).count();
        assert!(at_wall > count / 2, "{at_wall} of {count}: {line}");
    }
    check_start("ExampleSonarArray", "{Type PCL}{Name S}{");
    check_start("RotatingPointCloudScanner", "{Type PCL} {Name S} {");
}

#[track_caller]
fn check_start(class: &str, expected: &str) {
    let (mut world, _) = world(class, wall(5.0));
    let line = lines(&mut world, 0.3).remove(0);
    assert!(line.contains(expected), "{line}");
}

/// Check 44.
#[test]
fn a_bow_of_bumpers_feels_2_cm_around_it() {
    for (place, touches) in
        [([0.17 + 0.01 + 0.05, 0.0], true), ([0.17 + 0.03 + 0.05, 0.0], false), ([-0.23, 0.0], false)]
    {
        let post = |map: &mut MapDef| {
            let post = solid(map, "Post", [place[0], place[1], -HEIGHT], [0.1, 0.1, 0.2]);
            map.solids.push(post);
        };
        let word = if touches { "True" } else { "False" };
        check("BumperArray", post, &format!("TouchArray}} {{Name S}} {{Touch {word}}}"));
    }
    let (mut world, robot) = world("BumperArray", nothing);
    let conf = apply(&mut world, robot, "GETCONF {Type TouchArray}").remove(0);
    let arc = "{ArcRotation Pitch 0.0000 Roll 0.0000 Yaw 0.0000} {ArcRadius 0.1700} {ArcAngle 3.1400}";
    assert_eq!(conf, format!("CONF {{Type TouchArray}} {{Name S}} {{Diameter 0.0100}} {arc}"));
}

/// Checks 45 to 47: the origin within the noise, directions, and a closed room.
#[test]
fn gps_knows_the_place_under_an_open_sky_alone() {
    let minutes = |line: &str, key: &str| {
        let text = line.split_once(key).expect(key).1.split_once('}').expect("an end").0;
        let parts: Vec<&str> = text.trim().split(',').collect();
        (parts[0].to_owned(), parts[1].parse::<f64>().expect("minutes"), parts[2].to_owned())
    };
    let (mut world, _) = world("GPSSensor", nothing);
    let first = lines(&mut world, 0.3).remove(0);
    assert!(first.ends_with("{Fix 1} {Satellites 11}"), "{first}");
    let (degrees, at, letter) = minutes(&first, "{Latitude");
    assert_eq!((&*degrees, &*letter), ("39", "N"));
    // Four standard deviations of 0.31 m; a minute is 1853.33 m.
    assert!((at - 8.0273).abs() < 0.0008, "{first}");
    let (degrees, at, letter) = minutes(&first, "{Longitude");
    assert_eq!((&*degrees, &*letter), ("77", "W"));
    assert!((at - 12.998).abs() < 0.0012, "{first}");
    let room = |map: &mut MapDef| {
        let roof = solid(map, "Roof", [0.0, 0.0, -3.0], [4000.0, 4000.0, 0.2]);
        map.solids.push(roof);
    };
    check("GPSSensor", room, "GPS} {Name S} {Fix 0} {Satellites 0}");
}

/// Check 48: 117 dB at 1 m, 97 at 10 m, and 29.2 ms.
#[test]
fn sounds_fade_with_distance_and_behind_walls() {
    let sound = |distance: f64| {
        move |map: &mut MapDef| {
            let position = [0.0, distance, -HEIGHT];
            map.sounds.push(Sound { name: "Horn".to_owned(), position, volume: 1.0, duration: 0.5, interval: 1.0 });
        }
    };
    let hidden = |map: &mut MapDef| {
        sound(10.0)(map);
        let wall = solid(map, "Wall", [0.0, 5.0, -HEIGHT], [4.0, 0.1, 1.9]);
        map.solids.push(wall);
    };
    check("AcousticArraySensor", nothing, "Acoustic} {Name S} {None}");
    let heard = "{Direction 0.00,1.00,0.00} {Volume 97.0000} {Duration 0.5000} {Delay 0.0292}";
    check("AcousticArraySensor", sound(10.0), &format!("Acoustic}} {{Name S}} {heard}"));
    let heard = "{Direction 0.00,1.00,0.00} {Volume 90.9794} {Duration 0.5000} {Delay 0.0292}";
    check("AcousticArraySensor", hidden, &format!("Acoustic}} {{Name S}} {heard}"));
    check("AcousticArraySensor", sound(5000.0), "Acoustic} {Name S} {Far}");
    let (mut world, _) = world("SoundSensor", sound(10.0));
    let lines = lines(&mut world, 1.7);
    assert_eq!(lines[0], "SEN {Type Sound} {Name S} {Loudness 0.00} {Duration 0.00}");
    assert_eq!(lines[5], "SEN {Type Sound} {Name S} {Loudness 97.00} {Duration 0.50}");
    assert_eq!(lines[7], lines[0]);
}

/// Check 49: each object once, the right one first, and another robot by its number.
#[test]
fn an_object_sensor_names_each_object_once() {
    let boxes = |map: &mut MapDef| {
        for (name, y) in [("Left", -0.2), ("Right", 0.2)] {
            let it = solid(map, name, [4.0, y, -HEIGHT], [0.2, 0.3, 0.4]);
            map.solids.push(it);
        }
    };
    let line = "ObjectSensor} {Name S} {Object Right}{Location 4.00,0.20,-1.00}{Orientation 0.00,0.00,0.00}{HitLoc 3.90,0.34,-1.00}\
        {Material carpet} {Object Left}{Location 4.00,-0.20,-1.00}{Orientation 0.00,0.00,0.00}{HitLoc 3.90,-0.06,-1.00}{Material carpet}";
    check("ObjectSensor", boxes, line);
}

fn lying(name: &str, x: f64, map: &mut MapDef) {
    let victim = Victim { name: name.to_owned(), position: [x, 0.0, 0.0], rotation: [0.0; 3], moves: true, co2: 0.8 };
    let [head, leg] = [("Head", [x, 0.0, -HEIGHT]), ("Leg-right", [x, 0.5, -HEIGHT])];
    for (part, centre) in [head, leg] {
        let part = solid(map, &format!("{name}/{part}"), centre, [0.2; 3]);
        map.solids.push(part);
    }
    map.victims.push(victim);
}

#[test]
fn victims_are_seen_in_the_open_and_not_behind_a_wall() {
    let seen =
        "VictSensor} {Name S} {PartName Head} {Location 3.00,0.00,0.00} {PartName Leg} {Location 3.00,0.50,0.00}";
    check("VictSensor", |map| lying("Ann", 3.0, map), seen);
    check("VictSensor", nothing, "VictSensor} {Name S} {Status NoVictims}");
    let hidden = |map: &mut MapDef| {
        lying("Ann", 3.0, map);
        wall(1.0)(map);
    };
    check("VictSensor", hidden, "VictSensor} {Name S} {Status NoVictims}");
    check("VictSensor", |map| lying("Ann", -3.0, map), "VictSensor} {Name S} {Status NoVictims}");
    check("VictSensor", |map| lying("Ann", 7.0, map), "VictSensor} {Name S} {Status NoVictims}");
    check("HumanMotionSensor", |map| lying("Ann", 3.0, map), "HumanMotion} {Name S} {Prob 0.50}");
    check("HumanMotionSensor", nothing, "HumanMotion} {Name S} {Prob 0.00}");
    check("CO2Sensor", |map| lying("Ann", 0.5, map), "CO2Sensor} {Name S} {Gas CO2} {Density 0.40}");
    check("INUSensor", nothing, "INU} {Name S} {Orientation 0.00,0.00,0.00}");
}

#[test]
fn rfid_tags_are_read_written_and_released() {
    let tag = |map: &mut MapDef| {
        for (id, x) in [(7, 2.0), (3, 1.0), (9, 5.0)] {
            map.tags.push(RfidTag { id, position: [x, 0.0, -HEIGHT], memory: String::new() });
        }
    };
    let seen = "RFID} {Name S} {ID 3} {Location 1.00,0.00,0.00} {ID 7} {Location 2.00,0.00,0.00}";
    check("RFIDSensor", tag, seen);
    let (mut readable, robot) = world("RFIDSensor", tag);
    apply(&mut readable, robot, "SET {Type RFID} {Name S} {Opcode Write} {Params 7 victim here}");
    apply(&mut readable, robot, "SET {Type RFID} {Name S} {Opcode Write} {Params 9 too far}");
    let line = lines(&mut readable, 0.3).remove(0);
    assert!(line.ends_with("{ID 7} {Location 2.00,0.00,0.00} {Mem victim here}"), "{line}");
    assert!(lines(&mut world("RFIDSensor", nothing).0, 1.0).is_empty(), "nothing is in reach");
    let (mut releasing, robot) = world("RFIDReleaser", tag);
    apply(&mut releasing, robot, "SET {Type RFIDReleaser} {Name Gun} {Opcode Release}");
    apply(&mut releasing, robot, "SET {Type RFIDReleaser} {Name S} {Opcode Release}");
    let saved = serde_json::to_value(releasing.save().expect("a world without an engine's robot")).expect("JSON");
    let ids: Vec<u64> = saved["tags"].as_array().expect("tags").iter().filter_map(|tag| tag["id"].as_u64()).collect();
    assert_eq!(ids, [7, 3, 9, 10]);
}
