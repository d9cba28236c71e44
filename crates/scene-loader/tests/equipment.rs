//! Equipment: sets, and the ini files of USARSim.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use scene::{RobotDef, SensorDef, sensor::Config};
use scene_loader::{Changes, Equipment, Override, robot_equipped};
use tempfile::TempDir;

/// An ini with each form of a line that USARSim has.
const INI: &str = include_str!("equipment/forms.ini");

/// Loads ini files with these contents.
fn inis(texts: &[&[u8]]) -> Equipment {
    let folder = tempfile::tempdir().unwrap();
    let write = |(number, text): (usize, &&[u8])| {
        let path = folder.path().join(format!("{number}.ini"));
        fs::write(&path, text).unwrap();
        path
    };
    let files: Vec<PathBuf> = texts.iter().enumerate().map(write).collect();
    Equipment::of_inis(&files).unwrap_or_else(|error| panic!("{error}"))
}

fn robot(class: &str, equipment: &Equipment) -> RobotDef {
    let changes = Changes { overrides: &[], equipment };
    robot_equipped(class, changes).unwrap_or_else(|error| panic!("{error}"))
}

/// Loads a class with one ini.
fn with(class: &str, text: &str) -> RobotDef {
    robot(class, &inis(&[text.as_bytes()]))
}

/// Lists the sensors by name.
fn names(robot: &RobotDef) -> String {
    robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>().join(" ")
}

/// Returns the warnings without the files' names.
fn warnings(equipment: &Equipment) -> Vec<String> {
    let robots = scene_loader::robot_names();
    let warnings = equipment.warnings(robots.iter().map(String::as_str));
    warnings.iter().map(|it| format!("{}:{}: {}", it.line, it.column, it.message)).collect()
}

fn sensor<'a>(robot: &'a RobotDef, name: &str) -> &'a SensorDef {
    robot.sensors.iter().find(|sensor| sensor.name == name).unwrap_or_else(|| panic!("no {name}: {}", names(robot)))
}

#[test]
fn an_ini_replaces_the_items_of_its_classes() {
    let equipment = inis(&[INI.as_bytes()]);
    let p3at = robot("P3AT", &equipment);
    assert_eq!(names(&p3at), "GndTruth S1 lms200 laser cam battery");
    let laser = sensor(&p3at, "lms200");
    assert_eq!((laser.position, laser.direction), ([0.2, 0.0, -0.2], [0.0, 0.0, 3.0]));
    assert_eq!(p3at.battery.unwrap().life, 600.0);
    assert!(p3at.actuators.iter().any(|it| it.name == "Fork"), "{:?}", p3at.actuators);
    // Another class keeps its own.
    assert_eq!(names(&robot("Kiva4Wheel", &equipment)), names(&robot("Kiva4Wheel", &Equipment::default())));
    // A further name of a class has what the class has.
    let atlanta = robot("P2AT_ATLANTA", &equipment);
    assert_eq!(names(&atlanta), "Scanner1 Camera");
    assert_eq!(atlanta.actuators.iter().map(|it| it.name.as_str()).collect::<Vec<_>>(), ["Pan"]);
}

#[test]
fn settings_come_down_the_chain_of_classes() {
    let Config::Sick(own) = &sensor(&robot("P3AT", &Equipment::default()), "lms200").config.clone() else { panic!() };
    for (ini, expected) in [
        ("[USARSensor.SICK]\nMaxRange=8", (8.0, own.min_range)),
        ("[usarsensor.sick]\nmaxrange=8.5;", (8.5, own.min_range)),
        ("[USARBot.SICKLMS]\nMaxRange=8.", (8.0, own.min_range)),
        ("[USARSensor.RangeScanner]\nMinRange=.2", (own.max_range, 0.2)),
        // DefaultUSAR.ini gives SICK a range of its own.
        ("[USARSensor.RangeScanner]\nMaxRange=7", (own.max_range, own.min_range)),
        // And RangeScanner a least range of its own.
        ("[USARSensor.RangeSensor]\nMinRange=0.3", (own.max_range, own.min_range)),
        ("[USARSensor.SICK]\nMaxRange=8\n[USARSensor.SICK]\nMaxRange=9", (9.0, own.min_range)),
    ] {
        let Config::Sick(laser) = &sensor(&with("P3AT", ini), "lms200").config.clone() else { panic!() };
        assert_eq!((laser.max_range, laser.min_range), expected, "{ini}");
    }
    let interval = |ini, class, name| sensor(&with(class, ini), name).scan_interval;
    assert_eq!(interval("[USARSensor.Sensor]\nScanInterval=0.5", "P3AT", "Camera"), 0.5);
    assert_eq!(interval("[USARSensor.Sensor]\nScanInterval=0.5", "P3AT", "GndTruth"), 0.1);
    let gps = "[USARBot.GPSSensor]\nmaxNoise=1\nminNoise=.5\n\
               ZeroZeroLocation=(LatitudeDegree=47,LatitudeMinute=30,LongitudeDegree=-122,LongitudeMinute=15)";
    let Config::Gps(gps) = &sensor(&with("AirRobot", gps), "GPS").config.clone() else { panic!() };
    assert_eq!([gps.max_noise, gps.min_noise, gps.latitude, gps.longitude], [1.0, 0.5, 47.5, -122.25]);
    // A number in robot.toml is that robot's own.
    let own = with("P2AT", "[USARSensor.SICK]\nScanFov=3.0");
    let Config::Sick(laser) = &sensor(&own, "Scanner1").config else { panic!() };
    assert_eq!((laser.field_of_view * 1e4).round(), 31416.0);
    let life = |class| with(class, "[USARSensor.Battery]\nbatteryLife=60").battery.unwrap().life;
    assert_eq!((life("P3AT"), life("pioneer3at_with_sensors")), (60.0, 3600.0));
}

#[test]
fn later_files_come_after_earlier_ones() {
    let item = |name: &str| format!("AddParts=(ItemClass=class'USARSensor.IMU',ItemName=\"{name}\")\n");
    let first = format!("[USARBot.P3AT]\n{}{}[USARSensor.SICK]\nMaxRange=8\nMinRange=0.2", item("A"), item("B"));
    for (second, expected) in [
        (String::new(), "A B"),
        (format!("[USARBot.P3AT]\n{}", item("C")), "C"),
        (format!("[USARBot.P3AT]\n+{}+{}", item("B"), item("C")), "A B C"),
        (format!("[USARBot.P3AT]\n.{}", item("B")), "A B B"),
        (format!("[USARBot.P3AT]\n-{}", item("A")), "B"),
        (format!("[USARBot.P3AT]\n!AddParts=\n+{}", item("C")), "C"),
    ] {
        let equipment = inis(&[first.as_bytes(), second.as_bytes()]);
        assert_eq!(names(&robot("P3AT", &equipment)), expected, "{second}");
    }
    let equipment = inis(&[first.as_bytes(), b"[USARSensor.SICK]\nMaxRange=9"]);
    let scanner = robot("Kiva4Wheel", &equipment);
    let Config::Sick(laser) = &sensor(&scanner, "lms200").config else { panic!() };
    assert_eq!((laser.max_range, laser.min_range), (9.0, 0.2));
    // Items are added to those of the robot.toml, if no file replaces them.
    let added = with("P3AT", &format!("[USARBot.P3AT]\n+{}", item("C")));
    assert_eq!(names(&added), format!("{} C", names(&robot("P3AT", &Equipment::default()))));
    assert!(added.battery.is_some());
}

#[test]
fn an_item_is_on_its_parent_part() {
    let text = "[USARBot.Nao]\nAddParts=(ItemClass=class'USARSensor.USARCamera',ItemName=\"a\",Parent=\"head\")\n\
                AddParts=(ItemClass=class'USARSensor.USARCamera',ItemName=\"b\",Parent=\"Tail\")";
    let nao = with("Nao", text);
    assert_eq!(nao.links[sensor(&nao, "a").link].name, "HeadPitch");
    assert_eq!(sensor(&nao, "b").link, 0);
    assert_eq!(nao.assumptions, ["it has no part `Tail`: `b` is on its body"]);
}

#[test]
fn what_usarsim_would_ignore_is_a_warning() {
    let item = "AddParts=(ItemClass=class'USARSensor.";
    for (text, expected) in [
        ("[USARBot.P3AT]\nAddParts=\n".to_owned(), "2:10: expected `(`: the item is left out"),
        ("[USARBot.P3AT]\nAddParts=(X=1\n".to_owned(), "2:14: expected `)`: the item is left out"),
        (
            format!("[USARBot.P3AT]\n{item}SIK')"),
            "2:1: no sensor or actuator `SIK` (did you mean `SICK`?): it is left out",
        ),
        (format!("[USARBot.P3AT]\n{item}Sensor')"), "2:1: `Sensor` cannot be mounted: it is left out"),
        (format!("[USARBot.P3AT]\n{item}SICK',Colour=1)"), "2:44: `Colour` of an item has no effect"),
        (format!("[USARBot.P3AT]\n{item}SICK',Position=(X=a))"), "2:54: `X` is no number: it is 0"),
        (format!("[USARBot.P3AT]\n{item}SICK',Position=(W=1))"), "2:54: `W` is none of X, Y and Z"),
        (
            format!("[USARBot.P3AT]\n{item}SICK',startAttached=false)"),
            "2:1: `SICK` is not attached at first: it is left out",
        ),
        (format!("[USARBot.P3AT]\nColour=red\n{item}SICK')"), "2:1: `Colour` of P3AT has no effect"),
        (
            format!("[USARBot.P3TA]\n{item}SICK')"),
            "2:1: no class `P3TA` (did you mean `P3AT`?): its items are left out",
        ),
        (format!("[USARBot.P3AT]\n-{item}SICK')"), "2:1: no earlier line has this item: nothing is removed"),
        (
            format!("[USARBot.P2AT]\nbMountByUU=True\n{item}SICK')"),
            "2:1: its items are read in metres and radians all the same",
        ),
        ("[USARSensor.SICK]\nMaxRnge=1".to_owned(), "2:1: `MaxRnge` of SICK has no effect (did you mean `MaxRange`?)"),
        ("[USARSensor.SICK]\nMaxRange=far".to_owned(), "2:10: `MaxRange` is `far`: it is left out"),
        (
            "[USARSensor.SIK]\nMaxRange=1".to_owned(),
            "2:1: no class of sensors `SIK` (did you mean `SICK`?): its settings are left out",
        ),
        ("[USARSensor.INS]\nSigma=0.0".to_owned(), "2:1: `Sigma` of INS has no effect"),
        ("[USARBot.P3AT\nword".to_owned(), "1:1: expected `]` at the end of the section's name"),
    ] {
        let equipment = inis(&[text.as_bytes()]);
        assert_eq!(warnings(&equipment).first().map(String::as_str), Some(expected), "{text}");
    }
    assert_eq!(warnings(&inis(&[INI.as_bytes()])), Vec::<String>::new());
    let forms = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/equipment/forms.ini");
    assert_eq!(scene_loader::check(&forms).unwrap(), Vec::<String>::new());
    assert_eq!(
        warnings(&inis(&[b"[Engine.GameInfo]\nX=1\n[USARBotAPI.BotServer]\nListenPort=3000"])),
        Vec::<String>::new()
    );
}

#[test]
fn what_cannot_be_read_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let error = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let equipment = Equipment::of_inis(&[path]);
        let loaded = equipment.and_then(|it| robot_equipped("P3AT", Changes { overrides: &[], equipment: &it }));
        loaded.unwrap_err().to_string()
    };
    let far = b"[USARBot.P3AT]\nAddParts=(ItemClass=class'USARSensor.SICK',ItemName=\"a\",Position=(X=1e9))";
    for (name, bytes, expected) in [
        ("a.ini", b"\0\0".as_slice(), "a.ini: cannot be read: expected text"),
        ("b.ini", &vec![b' '; (1 << 20) + 1], "larger than 1048576 bytes"),
        ("c.ini", b"[USARSensor.SICK]\nMaxRange=-5", "c.ini:2:1: SICK: expected min_range <= max_range"),
        ("d.ini", far, "d.ini:2:1: `position` is [1e9, 0, 0]"),
    ] {
        let error = error(name, bytes);
        assert!(error.contains(expected), "{error}");
    }
    assert!(Equipment::of_inis(&[folder.path().join("none.ini")]).is_err());
}

/// Actuators that carry each other again and again end with an error before they fill the memory.
#[test]
fn actuators_that_carry_themselves_are_refused() {
    let line = |class: &str| format!("AddParts=(ItemClass=class'USARActuator.{class}')\n");
    let many = |class: &str| line(class).repeat(300);
    for (text, expected) in [
        (format!("[USARBot.P3AT]\n{0}[USARActuator.Hand]\n{0}", many("Hand")), "an actuator on 5 others"),
        (format!("[USARBot.P3AT]\n{}", many("KR60Arm")), "links: expected at most 150"),
    ] {
        let equipment = inis(&[text.as_bytes()]);
        let error = robot_equipped("P3AT", Changes { overrides: &[], equipment: &equipment }).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let mounts = |owner: &str| format!("[[{owner}.mount]]\nclass = \"Hand\"\n").repeat(300);
    let equipment = set(&format!("description = \"mine\"\n{}{}", mounts("P3AT"), mounts("Hand"))).unwrap();
    let error = robot_equipped("P3AT", Changes { overrides: &[], equipment: &equipment }).unwrap_err().to_string();
    assert!(error.contains("an actuator on 5 others") && error.contains("more mounts than 256"), "{error}");
}

/// Writes a set and loads it.
fn set(text: &str) -> Result<Equipment, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    fs::write(&path, text).unwrap();
    Equipment::load(path.to_str().unwrap()).map_err(|error| error.to_string())
}

#[test]
fn a_set_replaces_sensors_mounts_and_battery() {
    let text = "description = \"mine\"\n[[p3at.sensor]]\nclass = \"SICK\"\nname = \"a\"\nmax_range = 5\n\
                [[P3AT.mount]]\nclass = \"Hand\"\n[P3AT.battery]\nmax_energy = 1.0\nlife = 2.0\n";
    let error = set(text).unwrap_err();
    assert!(error.contains("second table of class `"), "{error}");
    let equipment = set(&text.replace("p3at", "P3AT")).unwrap();
    let p3at = robot("P3AT", &equipment);
    assert_eq!((names(&p3at).as_str(), p3at.battery.unwrap().life), ("a", 2.0));
    assert!(
        p3at.grippers.iter().map(|it| &it.name).chain(p3at.actuators.iter().map(|it| &it.name)).any(|it| it == "Hand")
    );
    // A class that is like another, and takes the other's place in the set.
    let text = "description = \"mine\"\n[[StereoP2AT.sensor]]\nclass = \"IMU\"\nname = \"a\"\n";
    let stereo = robot("StereoP2AT", &set(text).unwrap());
    assert_eq!((names(&stereo).as_str(), stereo.class.as_str()), ("a", "StereoP2AT"));
    // An actuator.
    let text =
        "description = \"mine\"\n[[AirRobotCameraAct.sensor]]\nclass = \"IMU\"\nname = \"a\"\nlink = \"RotateJoint\"\n";
    assert!(names(&robot("AirRobot", &set(text).unwrap())).ends_with(" a"));
}

#[test]
fn a_mistake_in_a_set_has_its_place() {
    let load = |text: &str| {
        let equipment = set(&format!("description = \"mine\"\n{text}"))?;
        let changes = Changes { overrides: &[], equipment: &equipment };
        scene_loader::load_equipped("hall", &[], changes).map(|_| ()).map_err(|error| error.to_string())
    };
    for (text, expected) in [
        ("[[P3TA.sensor]]", "mine.toml:2:3: unknown class `P3TA`"),
        ("[P3AT]\nsensors = 1", "mine.toml:3:1: unknown key `sensors`: expected one of sensor, mount, battery"),
        ("[[P3AT.sensor]]\nclass = \"SIK\"\nname = \"a\"", "mine.toml:2:1: unknown sensor class `SIK`"),
        ("[[P3AT.sensor]]\nclass = \"SICK\"\nname = \"a\"\nlink = \"b\"", "mine.toml:2:1: `link` is `b`"),
        ("[[P3AT.mount]]\nclass = \"Hnd\"", "mine.toml:2:1: unknown actuator `Hnd`"),
        ("P3AT = 1", "mine.toml:2:8: expected a table, got integer"),
    ] {
        let error = load(text).unwrap_err();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let error = Equipment::load("robocup2015").unwrap_err().to_string();
    assert!(error.contains("(did you mean `robocup2014`?): expected a file or one of robocup2014, shipped"), "{error}");
}

#[test]
fn robots_of_2014_carry_what_they_carried() {
    let equipment = Equipment::load("RoboCup2014").unwrap();
    let sonars = "Sonar1 Sonar2 Sonar3 Sonar4 Sonar5 Sonar6 Sonar7 Sonar8";
    for (class, expected) in [
        ("P3AT", format!("GndTruth InsTest lms200 Camera battery {sonars}")),
        ("Kenaf", "InsTest Hokuyo Camera fishEyeCamera Encoder".to_owned()),
        ("AirRobot", "GPS Time GPS IMU Compass cams".to_owned()),
    ] {
        assert_eq!(names(&robot(class, &equipment)), expected);
    }
    for file in fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/equipment")).unwrap() {
        scene_loader::check(&file.unwrap().path()).unwrap();
    }
}

/// A number of a sensor that the equipment replaces is not there to be set.
#[test]
fn a_replaced_number_cannot_be_overridden() {
    let equipment = Equipment::load("robocup2014").unwrap();
    let load = |equipment| {
        let overrides: [Override; 1] = ["P3AT.sensor.TachTest.scan_interval=1".parse().unwrap()];
        scene_loader::load_equipped("hall", &[], Changes { overrides: &overrides, equipment })
    };
    let shipped = Equipment::default();
    assert!(load(&shipped).is_ok());
    let error = load(&equipment).unwrap_err().to_string();
    assert!(error.contains("--set P3AT.sensor.TachTest"), "{error}");
}

/// Classes whose own files differ from DefaultUSAR.ini, and why.
const DEPARTURES: [(&str, &str); 2] = [
    (
        "AirRobot",
        "it has GndTruth, so that a controller knows where it is; its camera tilts, which the original's parent `Topitem` prevents",
    ),
    ("ATRV2", "its ForkLift was not published; ForkliftArm hangs lower, so that it reaches the floor"),
];

/// Lists what a robot carries, with numbers to a millimetre or a milliradian.
fn carried(robot: &RobotDef) -> Vec<String> {
    let round = |numbers: [f64; 3]| numbers.map(|number| (number * 1000.0).round() + 0.0);
    let sensor = |it: &SensorDef| {
        let SensorDef { name, link, position, direction, scan_interval, config } = it;
        format!("{name} {link} {:?} {:?} {scan_interval} {config:?}", round(*position), round(*direction))
    };
    let mut all: Vec<String> = robot.sensors.iter().map(sensor).collect();
    all.extend(robot.battery.map(|battery| format!("{battery:?}")));
    all.extend(robot.actuators.iter().map(|it| format!("{} {:?} {:?}", it.name, it.links, round(it.tip))));
    all.extend(robot.grippers.iter().map(|it| format!("{} {:?}", it.name, it.links)));
    let joint = |link: &scene::Link| Some(format!("{} {:?}", link.name, round(link.joint.as_ref()?.anchor)));
    all.extend(robot.links.iter().filter_map(joint));
    all.sort();
    all
}

/// DefaultUSAR.ini is not part of this repository: `USARSIM_CONFIG` names its folder.
#[test]
#[ignore = "needs USARSIM_CONFIG"]
fn the_original_configuration_gives_robots_their_own_items() {
    let folder = std::env::var_os("USARSIM_CONFIG");
    let folder = folder.expect("USARSIM_CONFIG names no folder: expected that of DefaultUSAR.ini");
    let equipment = Equipment::of_inis(&[Path::new(&folder).join("DefaultUSAR.ini")]).unwrap();
    let mut wrong = Vec::new();
    for class in scene_loader::robot_names() {
        let (own, original) = (carried(&robot(&class, &Equipment::default())), carried(&robot(&class, &equipment)));
        let departure = DEPARTURES.iter().find(|(known, _)| *known == class);
        if departure.is_some() && own == original {
            wrong.push(format!("{class} does not differ: it is no departure"));
        }
        if departure.is_none() && own != original {
            wrong.extend(own.iter().filter(|it| !original.contains(it)).map(|it| format!("{class}: ours     {it}")));
            wrong.extend(original.iter().filter(|it| !own.contains(it)).map(|it| format!("{class}: original {it}")));
        }
    }
    let all = warnings(&equipment).join("\n");
    println!("{all}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        try_bytes(&bytes);
    }

    #[test]
    fn any_change_of_an_ini_is_read_without_a_panic(
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0usize..20, "[\\[\\]()=,;'\"+.!A-Za-z0-9\r\n -]{0,8}"), 1..6),
    ) {
        let mut bytes = INI.as_bytes().to_vec();
        for (place, removed, put) in edits {
            let from = place.index(bytes.len() + 1);
            let to = (from + removed).min(bytes.len());
            bytes.splice(from..to, put.into_bytes());
        }
        try_bytes(&bytes);
    }
}

/// Reads bytes as an ini, and loads a robot with it. Either works or has a reason.
fn try_bytes(bytes: &[u8]) {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.ini");
    fs::write(&path, bytes).unwrap();
    if let Ok(equipment) = Equipment::of_inis(&[path]) {
        warnings(&equipment);
        let _ = robot_equipped("P3AT", Changes { overrides: &[], equipment: &equipment });
    }
}
