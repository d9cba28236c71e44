//! The page docs/reference.md: robots with their joints and items, sensors with a line of each, actuators, commands, maps, materials and
//! objects.

use std::fs;

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Dialect, Line};
use scene::{Joint, JointKind, RobotDef, SensorDef, WorldDef, sensor};
use sim_core::{Options, TIME_STEP, World};

use super::repository;

/// Map of the sensors' lines: a victim who moans and breathes out, a tag, and a wall behind them.
const MAP: &str = r#"
description = "A victim before a wall"

[[half_space]]
name = "Floor"
material = "concrete"

[[box]]
name = "Wall"
material = "plywood"
position = [4.0, 0.0, -0.5]
size = [0.1, 12.0, 1.0]

[[victim]]
name = "Ann"
position = [2.0, 0.0, 0.0]
rotation = [0.0, 0.0, 1.5]
moves = true
volume = 0.6
co2 = 0.8

[[rfid]]
id = 7
position = [1.0, 0.5, -0.1]
memory = "room 2"

[[sound]]
name = "Horn"
position = [3.0, 1.0, -0.5]
volume = 0.8
duration = 0.5
interval = 0.4

[[start]]
name = "PlayerStart_0"
position = [0.0, 0.0, 0.0]
"#;
/// Longest shown line.
const SHOWN: usize = 200;

/// Returns the names of the folders below `assets`, in order.
fn folders(kind: &str) -> Vec<String> {
    let entries = fs::read_dir(repository().join("assets").join(kind)).unwrap().map(|entry| entry.unwrap().path());
    let mut names: Vec<String> = entries
        .filter(|path| path.is_dir())
        .map(|path| path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    names.sort_by_key(|name| name.to_ascii_lowercase());
    names
}

fn table(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let rows: String = rows.map(|cells| line(&cells)).collect();
    if rows.is_empty() { String::new() } else { format!("{}|{}\n{rows}\n", line(&head), "---|".repeat(head.len())) }
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(|value| (value * 1e4).round() / 1e4 + 0.0).map(|it| it.to_string()).collect::<Vec<_>>().join(", ")
}

/// Returns the drive of a joint: its speed and its torque or force.
fn drive(joint: &Joint) -> [String; 2] {
    let [speed, force] = if joint.kind == JointKind::Prismatic { ["m/s", "N"] } else { ["rad/s", "N m"] };
    joint.drive.as_ref().map_or([String::new(), String::new()], |motor| {
        [format!("{} {speed}", numbers(&[motor.max_speed])), format!("{} {force}", numbers(&[motor.max_torque]))]
    })
}

/// Returns the joints of a robot.
fn joints(robot: &RobotDef) -> String {
    let rows = robot.with_values().filter_map(|link| {
        let joint = link.joint.as_ref()?;
        let kind = format!("{:?}", joint.kind).to_lowercase();
        let limits = link.position_limits().map_or(String::new(), |[least, most]| {
            let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
            format!("{} to {} {unit}", numbers(&[least]), numbers(&[most]))
        });
        let [speed, torque] = drive(joint);
        Some(vec![format!("`{}`", link.name), kind, limits, speed, torque])
    });
    table(&["joint", "kind", "range", "speed", "torque or force"], rows)
}

/// Returns the items of a robot in mounting order.
fn items(robot: &RobotDef) -> String {
    let link = |number: usize| robot.links.get(number).filter(|_| number > 0).map_or("", |link| &link.name).to_owned();
    let actuators = robot.actuators.iter().map(|it| {
        let joints: Vec<&str> =
            it.links.iter().filter_map(|&link| Some(robot.links.get(link)?.name.as_str())).collect();
        ["Actuator".to_owned(), it.name.clone(), String::new(), joints.join(", ")]
    });
    let grippers =
        robot.grippers.iter().map(|it| ["Gripper".to_owned(), it.name.clone(), String::new(), String::new()]);
    let changers =
        robot.tool_changers.iter().map(|it| ["ToolChanger".to_owned(), it.name.clone(), link(it.link), String::new()]);
    let vacuums = robot
        .vacuums
        .iter()
        .map(|it| ["Gripper (vacuum)".to_owned(), it.name.clone(), link(it.link), numbers(&it.position)]);
    let sensors = robot
        .sensors
        .iter()
        .map(|it| [it.config.class().to_owned(), it.name.clone(), link(it.link), numbers(&it.position)]);
    let rows = actuators.chain(grippers).chain(changers).chain(vacuums).chain(sensors);
    let row = |[class, name, link, place]: [String; 4]| vec![class, format!("`{name}`"), link, place];
    table(&["item", "name", "on", "position, m, or joints"], rows.map(row))
}

pub(crate) fn robots() -> String {
    let section = |class: &String| {
        let robot = scene_loader::robot(class, &[]).unwrap();
        let mass = numbers(&[(f64::from(robot.mass()) * 100.0).round() / 100.0]);
        let battery = robot.battery.map_or(String::new(), |it| format!(", a battery for {} s", numbers(&[it.life])));
        let picture = format!("![{class}](robots/{class}.png)");
        format!(
            "### {class}\n\n{picture}\n\n{}. {mass} kg{battery}.\n\n{}{}",
            robot.description,
            joints(&robot),
            items(&robot)
        )
    };
    let sections: String = folders("robots").iter().map(section).collect();
    format!("\n\n{sections}")
}

pub(crate) fn actuators() -> String {
    let row = |class: String| {
        let text =
            fs::read_to_string(repository().join("assets/actuators").join(&class).join("actuator.toml")).unwrap();
        let file: toml::Table = toml::from_str(&text).unwrap();
        let names = |key: &str| {
            let list = file.get(key).and_then(toml::Value::as_array).cloned().unwrap_or_default();
            let name = |it: &toml::Value| Some(format!("`{}`", it.get("name")?.as_str()?));
            list.iter().filter_map(name).collect::<Vec<_>>().join(", ")
        };
        vec![format!("`{class}`"), file["description"].as_str().unwrap().to_owned(), names("joint"), names("sensor")]
    };
    format!("\n\n{}", table(&["class", "", "joints", "sensors"], folders("actuators").into_iter().map(row)))
}

/// Returns the line of a sensor of a class on a P3AT at rest, 2 m from a victim.
fn example(class: &str, scene: &WorldDef) -> Option<String> {
    let mut robot = scene.robots["P3AT"].clone();
    let config = sensor::Config::read(class, serde_json::json!({}))?.ok()?;
    let (_, interval) = sensor::CLASSES.iter().find(|(known, _)| *known == class)?;
    let name = if class == "Encoder" { "W1" } else { "S" }.to_owned();
    let position = [0.2, 0.0, -0.5];
    robot.sensors = vec![SensorDef { name, link: 0, position, direction: [0.0; 3], scan_interval: *interval, config }];
    let robots = [("P3AT".to_owned(), robot)].into();
    let mut world = World::new(WorldDef { robots, ..scene.clone() }, Options::default());
    let text = "INIT {ClassName USARBot.P3AT} {Location 0,0,0}";
    let Some(Command::Init(init)) = Command::read(&Line::parse(text), &mut Vec::new()) else { return None };
    world.init(&init, &mut Vec::new())?;
    let steps = (1.3 / TIME_STEP) as usize;
    let line = |_| {
        let reports = world.step();
        let mut messages = reports.into_iter().filter_map(|(_, report)| world.message(report));
        messages.find(|message| matches!(message, Message::Sen(_))).map(|message| message.write(Dialect::Udk))
    };
    (0..steps).filter_map(line).last()
}

pub(crate) fn sensors() -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.toml");
    fs::write(&file, MAP).unwrap();
    let scene = scene_loader::load(&file.display().to_string(), &[]).unwrap();
    let row = |(&(class, interval), about): (&(&str, f64), &&str)| {
        let line = example(class, &scene).map_or("sends nothing".to_owned(), |line| {
            let shown: String = line.chars().take(SHOWN).collect();
            format!("`{shown}{}`", if shown.len() < line.len() { " .." } else { "" })
        });
        vec![format!("`{class}`"), about.trim().to_owned(), format!("{interval} s"), line]
    };
    let rows = sensor::CLASSES.iter().zip(sensor::ABOUT).map(row);
    format!("\n\n{}", table(&["class", "", "interval", "a line"], rows))
}

pub(crate) fn commands() -> String {
    let rows = Command::VERBS.iter().zip(Command::ABOUT);
    format!(
        "\n\n{}",
        table(&["verb", ""], rows.map(|(verb, about)| vec![format!("`{verb}`"), about.trim().to_owned()]))
    )
}

pub(crate) fn materials() -> String {
    let text = fs::read_to_string(repository().join("assets/materials.toml")).unwrap();
    let file: toml::Table = toml::from_str(&text).unwrap();
    let row = |(name, it): (String, toml::Value)| {
        let number = |key: &str| it.get(key).map_or(String::new(), ToString::to_string);
        let source = it.get("source").and_then(toml::Value::as_str).unwrap_or_default().to_owned();
        vec![format!("`{name}`"), number("friction"), number("restitution"), number("rolling_resistance"), source]
    };
    format!(
        "\n\n{}",
        table(&["material", "friction", "restitution", "rolling resistance", "source"], file.into_iter().map(row))
    )
}

pub(crate) fn objects() -> String {
    let scene = scene_loader::load("rough", &[]).unwrap();
    let row = |(class, object): (&String, &scene::Object)| {
        let shape = match &object.solid.shape {
            scene::Shape::Box { size } => format!("box of {} m", numbers(size).replace(", ", " x ")),
            scene::Shape::Cylinder { radius, length } => format!("cylinder of {radius} m radius, {length} m long"),
            scene::Shape::Ball { radius } => format!("ball of {radius} m radius"),
            _ => "another shape".to_owned(),
        };
        vec![format!("`{class}`"), shape, format!("{} kg", numbers(&[object.mass])), object.solid.material.name.clone()]
    };
    format!("\n\n{}", table(&["class", "shape", "mass", "material"], scene.objects.iter().map(row)))
}

pub(crate) fn maps() -> String {
    let row = |name: String| {
        let map = scene_loader::map(&name, &[]).unwrap();
        let starts: Vec<String> = map.starts.iter().map(|start| format!("`{}`", start.name)).collect();
        let counts = [
            (map.solids.len(), "solids"),
            (map.objects.len(), "objects"),
            (map.conveyors.len(), "conveyors"),
            (map.victims.len(), "victims"),
            (map.tags.len(), "RFID tags"),
        ];
        let counts: Vec<String> =
            counts.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}")).collect();
        vec![format!("`{name}`"), map.description, counts.join(", "), starts.join(", ")]
    };
    format!("\n\n{}", table(&["map", "", "holds", "starts"], scene_loader::map_names().into_iter().map(row)))
}
