//! What the server says to a client: one file a message, with its writing and its reading side by side.
//!
//! Writing is byte for byte USARSim's (UDK), spaces and decimals included; reading serves clients and tests.

mod asta;
mod conf;
mod geo;
mod nfo;
mod sen;
mod sta;

pub use asta::{Asta, Eff};
pub use conf::{Conf, ItemConf, JointConf, RobotConf, VehicleConf};
pub use geo::{ActuatorGeo, Geo, ItemGeo, JointGeo, RobotGeo, VehicleGeo};
pub use nfo::{NamedPose, Nfo};
pub use sen::{
    Camera, Encoder, GroundTruth, Imu, Ins, Odometry, RangeScanner, ReadWrite as ReadingReadWrite, Reading, Sen, Sonar,
    Tachometer,
};
pub use sta::{Sta, Vehicle};

use crate::Line;

/// One line from the server to a client.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// Greeting, start poses, path nodes.
    Nfo(Nfo),
    /// State of the robot, ten times a second.
    Sta(Sta),
    /// One reading of one sensor.
    Sen(Sen),
    /// State of an actuator, ten times a second.
    Asta(Asta),
    /// State of a gripper, ten times a second.
    Eff(Eff),
    /// Configuration, the answer to GETCONF.
    Conf(Conf),
    /// Geometry, the answer to GETGEO.
    Geo(Geo),
}

impl Message {
    /// The line, without its CR LF.
    pub fn write(&self) -> String {
        match self {
            Self::Nfo(message) => message.write(),
            Self::Sta(message) => message.write(),
            Self::Sen(message) => message.write(),
            Self::Asta(message) => message.write(),
            Self::Eff(message) => message.write(),
            Self::Conf(message) => message.write(),
            Self::Geo(message) => message.write(),
        }
    }

    /// Reads a line of a server; `None` if it is not one of these messages.
    pub fn read(text: &str) -> Option<Self> {
        let line = Line::parse(text);
        match line.verb.as_str() {
            "NFO" => Nfo::read(&line).map(Self::Nfo),
            "STA" => Sta::read(&line).map(Self::Sta),
            "SEN" => Sen::read(&line).map(Self::Sen),
            "ASTA" => Asta::read(&line).map(Self::Asta),
            "EFF" => Eff::read(&line).map(Self::Eff),
            "CONF" => Conf::read(&line).map(Self::Conf),
            "GEO" => Geo::read(&line).map(Self::Geo),
            _ => None,
        }
    }

    /// True for the lines that come on a timer: the next one replaces it, so a client that does not keep up
    /// may lose it. Answers are never lost.
    pub fn is_periodic(&self) -> bool {
        matches!(self, Self::Sta(_) | Self::Sen(_) | Self::Asta(_) | Self::Eff(_))
    }
}

/// Numbers separated by commas.
fn floats(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|part| part.trim().parse().ok()).collect()
}

fn float_array<const N: usize>(text: &str) -> Option<[f32; N]> {
    floats(text)?.try_into().ok()
}

fn number<T: std::str::FromStr>(line: &Line, key: &str) -> Option<T> {
    line.get(key)?.parse().ok()
}

/// Booleans are written `True` and `False`.
fn boolean(value: bool) -> &'static str {
    if value { "True" } else { "False" }
}

fn read_boolean(line: &Line, key: &str) -> Option<bool> {
    match line.get(key)? {
        "True" => Some(true),
        "False" => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
