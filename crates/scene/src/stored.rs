//! Formats of robots and leagues in logs.
//!
//! In older logs a robot is not a tree of links but a body of parts and solids with wheels, and a league has zones.

use serde::Deserialize;

use crate::goal::{Goal, Zone};
use crate::{
    Actuator, Aerial, Battery, DriveModel, Footing, Gripper, Link, Material, Motor, Part, ROOT, RobotDef, Rollers,
    ScoredGoal, SensorDef, Side, Solid, Steering, Team, ToolChanger, Vacuum, VictimRule, Wheel,
};

#[derive(Deserialize)]
pub(crate) struct Robot {
    class: String,
    description: String,
    steering: Steering,
    #[serde(default)]
    reported_steering: Option<String>,
    drive_model: DriveModel,
    one_side_drives: bool,
    #[serde(default)]
    speaks_ut2004: bool,
    #[serde(default)]
    links: Vec<Link>,
    #[serde(default)]
    parts: Vec<Part>,
    #[serde(default)]
    solids: Vec<Solid>,
    #[serde(default)]
    wheels: Vec<OldWheel>,
    sensors: Vec<SensorDef>,
    #[serde(default)]
    actuators: Vec<Actuator>,
    #[serde(default)]
    grippers: Vec<Gripper>,
    #[serde(default)]
    tool_changers: Vec<ToolChanger>,
    #[serde(default)]
    vacuums: Vec<Vacuum>,
    battery: Option<Battery>,
    reported_max_torque: f64,
    /// In older logs the steering says it, and `aerial` has the limits.
    footing: Option<Footing>,
    aerial: Option<Aerial>,
    #[serde(default)]
    assumptions: Vec<String>,
}

#[derive(Deserialize)]
struct OldWheel {
    name: String,
    side: Side,
    position: [f64; 3],
    radius: f64,
    width: f64,
    mass: f64,
    material: Material,
    drive: Option<Motor>,
    rollers: Option<Rollers>,
}

impl From<Robot> for RobotDef {
    fn from(stored: Robot) -> Self {
        let Robot { parts, solids, wheels, mut links, .. } = stored;
        if links.is_empty() {
            links.push(Link { name: ROOT.to_owned(), parts, solids, ..Link::default() });
            links.extend(wheels.into_iter().map(|it| {
                let OldWheel { name, side, position, radius, width, mass, material, drive, rollers } = it;
                Link::of_wheel(
                    name,
                    position,
                    drive,
                    Wheel { side, radius, width, mass, material, rollers, belt: None, tyre: None },
                )
            }));
        }
        Self {
            class: stored.class,
            description: stored.description,
            steering: stored.steering,
            reported_steering: stored.reported_steering,
            drive_model: stored.drive_model,
            one_side_drives: stored.one_side_drives,
            speaks_ut2004: stored.speaks_ut2004,
            links,
            sensors: stored.sensors,
            actuators: stored.actuators,
            grippers: stored.grippers,
            tool_changers: stored.tool_changers,
            vacuums: stored.vacuums,
            battery: stored.battery,
            reported_max_torque: stored.reported_max_torque,
            footing: stored.footing.unwrap_or_else(|| Footing::of(stored.steering, stored.aerial)),
            assumptions: stored.assumptions,
        }
    }
}

#[derive(Deserialize)]
pub(crate) struct League {
    name: String,
    time_limit: f64,
    teams: Vec<Team>,
    victims: Option<VictimRule>,
    #[serde(default)]
    zones: Vec<OldZone>,
    #[serde(default)]
    goals: Vec<ScoredGoal>,
}

#[derive(Deserialize)]
struct OldZone {
    name: String,
    position: [f64; 3],
    size: [f64; 3],
    points: i32,
    hold: f64,
}

impl From<League> for crate::League {
    fn from(League { name, time_limit, teams, victims, zones, mut goals }: League) -> Self {
        let zone = |OldZone { name, position, size, points, hold }| ScoredGoal {
            name,
            points,
            hold,
            goal: Goal::Zone(Zone { position, size }),
        };
        goals.extend(zones.into_iter().map(zone));
        Self { name, time_limit, teams, victims, goals }
    }
}
