//! `usarsim maps` and `usarsim robots`.

use scene::RobotDef;
use scene_loader::LoadError;
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

pub(crate) fn robots(arguments: &Arguments) -> Result<(), Failure> {
    let robots: Result<Vec<_>, _> =
        scene_loader::robot_names().iter().map(|name| scene_loader::robot(name, &[])).collect();
    let robots = robots.map_err(broken)?;
    if arguments.json {
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
    for robot in robots {
        print(format_args!("USARBot.{:<16} {}", robot.class, robot.description));
        let sensors = sensors(&robot);
        if !sensors.is_empty() {
            print(format_args!("{:<24} {}", "", sensors.join(", ")));
        }
    }
    Ok(())
}

fn sensors(robot: &RobotDef) -> Vec<&str> {
    robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect()
}

fn broken(error: LoadError) -> Failure {
    Failure::new(exit::BAD_CONFIGURATION, error)
}
