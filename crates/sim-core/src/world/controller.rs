//! One controller and what its lines do to a world.

use gamebots_proto::message::Message;
use gamebots_proto::{Command, Line, Problem};

use super::{RobotId, World};

/// A connection as the world knows it: over a socket, in an experiment, or out of a log.
#[derive(Debug, Clone, Default)]
pub struct Controller {
    /// The robots that report here, the newest last. Commands go to the newest (BotConnection.uc:37-47).
    robots: Vec<RobotId>,
}

impl Controller {
    /// Its robots, the newest last.
    pub fn robots(&self) -> &[RobotId] {
        &self.robots
    }

    /// Does what a line says and returns what it answers.
    pub fn execute_line(&mut self, text: &str, world: &mut World, problems: &mut Vec<Problem>) -> Vec<Message> {
        let command = Command::read(&Line::parse(text), problems);
        command.map_or(Vec::new(), |command| self.execute(&command, world, problems))
    }

    /// Does what a command says and returns what it answers.
    pub fn execute(&mut self, command: &Command, world: &mut World, problems: &mut Vec<Problem>) -> Vec<Message> {
        if let Command::Init(init) = command {
            self.robots.extend(world.init(init, problems));
            return Vec::new();
        }
        if let Some(answer) = world.ask(command) {
            return vec![answer];
        }
        match (self.robots.last(), command) {
            (Some(&robot), _) => world.apply(robot, command, problems),
            (
                None,
                Command::Drive(_)
                | Command::MultiDrive(_)
                | Command::Act(_)
                | Command::MisPkg(_)
                | Command::Set(_)
                | Command::GetConf(_)
                | Command::GetGeo(_),
            ) => {
                problems.push(Problem::NoRobot { verb: command.verb() });
                Vec::new()
            }
            (None, _) => Vec::new(),
        }
    }

    /// Ends it: its robots leave the world, or only the newest one if the world keeps robots.
    pub fn end(self, world: &mut World) {
        let leaving = if world.options().keep_robots { self.robots.len().saturating_sub(1) } else { 0 };
        self.robots[leaving..].iter().for_each(|&robot| world.remove(robot));
    }
}
