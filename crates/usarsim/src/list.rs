//! `usarsim maps`, `usarsim scenarios` and `usarsim robots`.

use scene::{RobotDef, ScenarioCard};
use scene_loader::{FAMILIES, LoadError};
use serde_json::json;

use crate::{Failure, exit, print};

/// Options of the lists.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn maps(arguments: &Arguments) -> Result<(), Failure> {
    let maps: Result<Vec<_>, _> = scene_loader::map_names().iter().map(|name| scene_loader::map(name, &[])).collect();
    let maps = maps.map_err(broken)?;
    if arguments.json {
        let list = maps.iter().map(|map| {
            let starts: Vec<&str> = map.starts.iter().map(|start| start.name.as_str()).collect();
            json!({"name": map.name, "description": map.description, "starts": starts})
        });
        print(serde_json::Value::from_iter(list));
        return Ok(());
    }
    for map in maps {
        let starts: Vec<&str> = map.starts.iter().map(|start| start.name.as_str()).collect();
        print(format_args!("{:<10} {}; starts {}", map.name, map.description, starts.join(", ")));
    }
    Ok(())
}

pub(crate) fn scenarios(arguments: &Arguments) -> Result<(), Failure> {
    let listed = scene_loader::listed_scenarios(&scene_loader::scenario_names()).map_err(broken)?;
    let cards = listed.into_iter().map(|listed| listed.card);
    if arguments.json {
        let list = cards.map(|card| {
            json!({
                "name": card.name, "title": card.title, "text": card.text, "keys": card.keys, "map": card.map,
                "robots": card.robots, "time_limit": card.time_limit, "stars": card.stars,
            })
        });
        print(serde_json::Value::from_iter(list));
        return Ok(());
    }
    for ScenarioCard { name, title, text, map, robots, time_limit, .. } in cards {
        print(format_args!("{name:<10} {title}: {text}; {} on {map}, {time_limit} s", robots.join(", ")));
    }
    Ok(())
}

pub(crate) fn robots(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.json {
        let robots = load(scene_loader::robot_names())?;
        let list = robots.iter().map(|robot| {
            json!({
                "class": format!("USARBot.{}", robot.class),
                "description": robot.description,
                "steering": robot.steering.wire_name(),
                "mass": robot.mass(),
                "wheel_radius": robot.wheel_geometry().radius,
                "sensors": sensors(robot),
            })
        });
        print(serde_json::Value::from_iter(list));
        return Ok(());
    }
    let (names, further): (Vec<String>, Vec<Vec<String>>) = scene_loader::robot_folders().into_iter().unzip();
    let robots = load(names)?;
    for (number, family) in FAMILIES.iter().enumerate() {
        let gap = if number == 0 { "" } else { "\n" };
        print(format_args!("{gap}{}. {}", family.title, family.driving));
        for (robot, further) in robots.iter().zip(&further).filter(|(robot, _)| family.has(robot)) {
            let also = folded(&robot.class, further);
            let also = if also.is_empty() { also } else { format!("; also {also}") };
            print(format_args!("USARBot.{:<16} {}{also}", robot.class, robot.description));
            let sensors = sensors(robot);
            if !sensors.is_empty() {
                print(format_args!("{:<24} {}", "", sensors.join(", ")));
            }
        }
    }
    Ok(())
}

fn load(names: Vec<String>) -> Result<Vec<RobotDef>, Failure> {
    names.iter().map(|name| scene_loader::robot(name, &[])).collect::<Result<_, _>>().map_err(broken)
}

/// Lists further names of a class. Those that add an ending, such as the colours `_b _g _r _y`, are given by it.
fn folded(class: &str, further: &[String]) -> String {
    let ending = |name: &String| {
        let (begin, end) = name.split_at_checked(class.len())?;
        (begin.eq_ignore_ascii_case(class) && end.starts_with('_')).then(|| end.to_owned())
    };
    let mut parts: Vec<String> = further.iter().filter(|name| ending(name).is_none()).cloned().collect();
    let endings: Vec<String> = further.iter().filter_map(ending).collect();
    match endings.as_slice() {
        [] => {}
        [one] => parts.push(format!("{class}{one}")),
        many => parts.push(format!("with {}", many.join(" "))),
    }
    parts.join(", ")
}

fn sensors(robot: &RobotDef) -> Vec<&str> {
    robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect()
}

fn broken(error: LoadError) -> Failure {
    Failure::new(exit::BAD_CONFIGURATION, error)
}
