//! Reports of robots: readings of their sensors, and messages about everything else.

use gamebots_proto::message::Message;
use scene::Sensed;

use super::World;
use crate::sensor::wire;

/// A report of a robot, after a step or in answer to a command.
#[derive(Debug, Clone, PartialEq)]
pub enum Report {
    /// A reading of a sensor.
    Sensed(Sensed),
    /// A message that is no reading.
    Message(Message),
}

impl From<Message> for Report {
    fn from(message: Message) -> Self {
        Self::Message(message)
    }
}

impl World {
    /// Returns a report of this moment as a message for the robot's client. `None` if the robot that measured is gone.
    pub fn message(&self, report: Report) -> Option<Message> {
        let Sensed { robot, sensor, reading } = match report {
            Report::Sensed(sensed) => sensed,
            Report::Message(message) => return Some(message),
        };
        let robot = self.robot(robot)?;
        let reading = wire(robot, robot.sensors.get(sensor)?, &reading, self.options.speed_unit);
        Some(Message::Sen(reading.at(self.time() as f32)))
    }
}
