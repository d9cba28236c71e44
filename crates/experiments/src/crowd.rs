//! Robots on a grid that all drive to its middle, where they push, climb and heap up.

use gamebots_proto::command::Init;
use sim_core::World;

use crate::{Motion, MotionError};

/// Distance between neighbours on the grid, m.
const SPACING: f64 = 0.75;
/// Speed of all wheels, rad/s.
const SPEED: f64 = 5.0;

/// A world with a crowd of robots in motion.
pub struct Crowd {
    world: World,
}

impl Crowd {
    /// Spawns `count` robots on a square grid around the first start of the map, and drives them ahead. Their classes take turns.
    /// Each robot faces the middle of the grid; a single one faces along the start's x axis.
    ///
    /// # Errors
    /// When a class is unknown or there is no room.
    pub fn start(mut world: World, classes: &[String], count: u32) -> Result<Self, MotionError> {
        let [x, y, z] = world.def().map.starts.first().map_or([0.0; 3], |start| start.position);
        let side = f64::from(count).sqrt().ceil();
        for (number, class) in (0..count).zip(classes.iter().cycle()) {
            let robot = world.def().robots.get(class).ok_or_else(|| MotionError::UnknownRobot(class.clone()))?;
            let drive = Motion::Forward.command(robot, SPEED);
            let place = |line: f64| (line - (side - 1.0) / 2.0) * SPACING;
            let (row, column) = ((f64::from(number) / side).floor(), f64::from(number) % side);
            let [ahead, aside] = [place(column), place(row)];
            let is_middle = ahead == 0.0 && aside == 0.0;
            let yaw = if is_middle { 0.0 } else { (-aside).atan2(-ahead) };
            let location = [x + ahead, y + aside, z];
            let init = Init { class_name: class.clone(), location, rotation: [0.0, 0.0, yaw], ..Init::default() };
            let mut problems = Vec::new();
            let id = world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?;
            world.execute(Some(id), &drive, &mut Vec::new());
        }
        Ok(Self { world })
    }

    /// Advances by one step.
    pub fn step(&mut self) {
        self.world.step();
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        &self.world
    }
}
