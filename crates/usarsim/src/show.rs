//! `usarsim show`: prints every number of a robot or a map, as the world uses it.

use clap::ValueEnum;
use scene::DriveModel;
use scene_loader::{Changes, Override};
use serde::Serialize;
use serde_json::Value;

use crate::{Failure, equipment, exit, print};

/// Longest list that is shown.
const MAX_SHOWN: usize = 64;

/// Options of `show`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim show robot KUKA_YouBot\n  usarsim show map rough --set material.carpet.friction=0.5\n  \
    usarsim show robot my/robot.toml --set robot.wheels.gain=2.5 --json\n\nPrints TOML, every number in SI units in effect: \
    defaults, URDF and overrides included. The paths of --set are those of the files, which \
    `usarsim copy` writes, not of this list."
)]
pub(crate) struct Arguments {
    /// Kind of the definition.
    what: What,
    /// Its name, or the path of its file.
    #[arg(value_name = "NAME|FILE")]
    name: String,
    /// Replace a number: robot.PATH, CLASS.PATH, map.PATH or material.PATH=VALUE. May be given several times.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Override>,
    #[command(flatten)]
    equipment: equipment::Choice,
    /// Drive model of a Mecanum robot, instead of the one in its file.
    #[arg(long, value_name = "MODEL", value_parser = crate::values::drive_model)]
    drive_model: Option<DriveModel>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum What {
    Robot,
    Map,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { what, name, set, equipment, drive_model, json } = arguments;
    let broken = |error| Failure::new(exit::BAD_CONFIGURATION, error);
    let text = match what {
        What::Robot => {
            let equipment = equipment.load()?;
            let changes = Changes { overrides: set, equipment: &equipment };
            let mut robot = scene_loader::robot_equipped(name, changes).map_err(broken)?;
            let robots = scene_loader::robot_names();
            equipment::warn(&equipment.warnings(robots.iter().chain([&robot.class]).map(String::as_str)));
            robot.set_drive_model(*drive_model);
            text(&robot, *json)
        }
        What::Map => text(&scene_loader::map(name, set).map_err(broken)?, *json),
    };
    scene_loader::check_used(set).map_err(broken)?;
    print(text?.trim_end());
    Ok(())
}

fn text(value: &impl Serialize, json: bool) -> Result<String, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(exit::FAILURE, error);
    let mut value = serde_json::to_value(value).map_err(|error| failed(&error))?;
    shorten(&mut value);
    if json {
        serde_json::to_string_pretty(&value).map_err(|error| failed(&error))
    } else {
        toml::to_string(&value).map_err(|error| failed(&error))
    }
}

/// Removes entries without a value, and replaces long lists, such as a mesh's vertices, by their length.
fn shorten(value: &mut Value) {
    match value {
        Value::Array(list) if list.len() > MAX_SHOWN => *value = Value::from(list.len()),
        Value::Array(list) => list.iter_mut().for_each(shorten),
        Value::Object(entries) => {
            entries.retain(|_, entry| !entry.is_null());
            entries.values_mut().for_each(shorten);
        }
        _ => {}
    }
}
