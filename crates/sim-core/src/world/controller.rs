//! One controller and what its lines do to a world.

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Line, Problem};

use super::{RobotId, World};

/// A connection as the world knows it: over a socket, in an experiment, or out of a log.
#[derive(Debug, Clone, Default)]
pub struct Controller {
    /// The robots that report here, the newest last. Commands go to the newest, and only the newest leaves with
    /// the connection (BotConnection.uc:37-47, 765-787).
    robots: Vec<RobotId>,
}

impl Controller {
    /// Its robots, the newest last.
    pub fn robots(&self) -> &[RobotId] {
        &self.robots
    }

    /// Does what a line says and returns what it answers.
    pub fn execute(&mut self, text: &str, world: &mut World, problems: &mut Vec<Problem>) -> Vec<Message> {
        let line = Line::parse(text);
        let Some(command) = Command::read(&line, problems) else { return Vec::new() };
        if let Command::Init(init) = &command {
            self.robots.extend(world.init(init, problems));
            return Vec::new();
        }
        if let Some(answer) = world.ask(&command) {
            return vec![answer];
        }
        match (self.robots.last(), &command) {
            (Some(&robot), _) => world.apply(robot, &command, problems),
            (None, Command::Drive(_) | Command::Set(_) | Command::GetConf(_) | Command::GetGeo(_)) => {
                problems.push(Problem::NoRobot { verb: line.verb.to_ascii_uppercase() });
                Vec::new()
            }
            (None, _) => Vec::new(),
        }
    }

    /// Ends it: its newest robot leaves the world.
    pub fn end(self, world: &mut World) {
        if let Some(&newest) = self.robots.last() {
            world.remove(newest);
        }
    }
}
