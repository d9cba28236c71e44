//! The port of the wireless simulator, 50000 (USARTools/WSS; protocol.md 7.5): robots register, ask for the strength of a radio link, and for
//! ports at which they reach each other.

use crate::Line;
use crate::number::general;

/// A line of a robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WirelessCommand {
    /// `INIT {Robot n} {Port p,p}`: the robot's name and the ports at which it listens.
    Init {
        /// Name of the robot.
        robot: String,
        /// Its ports; `None` if one is no number.
        ports: Option<Vec<u16>>,
    },
    /// `GETSS {Robot n}`: the strength of the signal of another robot.
    Strength(String),
    /// `DNS {Robot n} {Port p}`: a port at which another robot's port is reached.
    Dns {
        /// Name of the robot.
        robot: String,
        /// Its port; 0 for its first one, and `None` if it is no number.
        port: Option<u16>,
    },
    /// `REVERSEDNS {Port p}`: the robot behind a connection, by the port that it comes from; `None` if it is no number.
    ReverseDns(Option<u16>),
    /// Another line.
    Unknown,
}

/// The strength of a signal between two robots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Strength {
    /// To the robot itself.
    ToSelf,
    /// To a robot that is not registered.
    NoRobot,
    /// Strength by the model of propagation, dBm.
    Model(f64),
}

/// Reasons of an `ERROR`, in the words of RobotManagementConnection.cpp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WirelessError {
    /// Another line came before INIT.
    InitFirst,
    /// A second INIT, or an unknown word.
    Unknown,
    /// A port of INIT is no number.
    PortsOfInit,
    /// There is no name.
    NoName,
    /// The name is taken. The spelling is the original's.
    Taken,
    /// A port is no number.
    PortOfLine,
    /// There is no port left.
    NoPort,
}

impl WirelessCommand {
    /// Reads a line. Numbers are read up to their first other character, and large ones lose their higher bits, as in the original.
    pub fn read(line: &str) -> Self {
        let line = Line::parse(line);
        let part = |key| line.get(key).unwrap_or_default();
        let robot = || part("Robot").to_owned();
        let port = || line.get("Port").filter(|text| !text.is_empty()).map_or(Some(0), port);
        match line.verb.to_ascii_uppercase().as_str() {
            "INIT" => {
                let name = line.get("Robot").or_else(|| line.get("Name")).unwrap_or_default();
                let ports = part("Port").split(',').filter(|text| !text.trim().is_empty()).take(MAX_PORTS);
                Self::Init { robot: name.to_owned(), ports: ports.map(self::port).collect() }
            }
            // A word alone is unknown, as in the original.
            "GETSS" | "DNS" | "REVERSEDNS" if line.blocks.is_empty() => Self::Unknown,
            "GETSS" => Self::Strength(robot()),
            "DNS" => Self::Dns { robot: robot(), port: port() },
            "REVERSEDNS" => Self::ReverseDns(port()),
            _ => Self::Unknown,
        }
    }
}

/// Most ports of a robot.
const MAX_PORTS: usize = 16;

/// Reads a port.
fn port(text: &str) -> Option<u16> {
    let text = text.trim();
    let digits = text.split(|letter: char| !letter.is_ascii_digit()).next().unwrap_or_default();
    // Digits alone overflow only.
    (!digits.is_empty()).then(|| digits.parse::<u64>().unwrap_or_default() as u16)
}

/// Returns the answer to an INIT that is accepted.
pub fn registered() -> String {
    "INITREPLY {Status OK}\r\n".to_owned()
}

/// Returns the answer to GETSS.
pub fn strength(robot: &str, strength: Strength) -> String {
    let rest = match strength {
        Strength::ToSelf => "{Strength INF} {Error SS.To.Self}".to_owned(),
        Strength::NoRobot => "{Strength NaN} {Error Robot.Does.Not.Exist}".to_owned(),
        Strength::Model(f64::INFINITY) => "{Strength INF} {Error Model.Returned.INF}".to_owned(),
        Strength::Model(value) if value.is_nan() || value > 0.0 => {
            "{Strength NaN} {Error Model.Returned.NaN}".to_owned()
        }
        Strength::Model(value) => format!("{{Strength {}}}", general(value)),
    };
    format!("SS {{Robot {robot}}} {rest}\r\n")
}

/// Returns the answer to DNS: the port, or an error.
pub fn route(robot: &str, port: Result<u16, &str>) -> String {
    match port {
        Ok(port) => format!("DNSREPLY {{Robot {robot}}} {{Port {port}}}\r\n"),
        Err(error) => format!("DNSREPLY {{Robot {robot}}} {{Port -1}} {{Error {error}}}\r\n"),
    }
}

/// Returns the answer to REVERSEDNS.
pub fn origin(port: u16, robot: Option<&str>) -> String {
    let rest = robot.map_or("{Error UnknownOrIllegalPort}".to_owned(), |robot| format!("{{Robot {robot}}}"));
    format!("REVERSEDNSREPLY {{Port {port}}} {rest}\r\n")
}

impl WirelessError {
    /// Returns the line that says it.
    pub fn line(self) -> String {
        let reason = match self {
            Self::InitFirst => "Must.Use.INIT.Method.First",
            Self::Unknown => "Method.Unknown.Or.Can.INIT.only.once",
            Self::PortsOfInit => "Ports.List.Must.Be.Integer",
            Self::NoName => "Robot.Name.Must.Not.Be.Empty",
            Self::Taken => "Robot.Alread.Exists",
            Self::PortOfLine => "Port.Must.Be.Integer",
            Self::NoPort => "Could.Not.Allocate.Port",
        };
        format!("ERROR {{Reason {reason}}}\r\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_as_the_original_does() {
        use WirelessCommand::{Dns, Init, ReverseDns, Strength, Unknown};
        let name = || "R1".to_owned();
        let rows = [
            ("INIT {Robot R1} {Port 6000}", Init { robot: name(), ports: Some(vec![6000]) }),
            ("INIT {Port 7000, 7010,} {Robot R1}", Init { robot: name(), ports: Some(vec![7000, 7010]) }),
            ("INIT {Robot R1}", Init { robot: name(), ports: Some(vec![]) }),
            ("INIT {Robot R1} {Port 6000x,y}", Init { robot: name(), ports: None }),
            ("INIT {Name R1} {Port 1000666}", Init { robot: name(), ports: Some(vec![17626]) }),
            ("GETSS {Robot R1}", Strength(name())),
            ("DNS {Robot R1}", Dns { robot: name(), port: Some(0) }),
            ("dns {Robot R1} {Port 7010}", Dns { robot: name(), port: Some(7010) }),
            ("DNS {Robot R1} {Port x}", Dns { robot: name(), port: None }),
            ("REVERSEDNS {Port 51000}", ReverseDns(Some(51000))),
            ("REVERSEDNS {Port -1}", ReverseDns(None)),
            ("HELLO", Unknown),
        ];
        for (text, expected) in rows {
            assert_eq!(WirelessCommand::read(text), expected, "{text}");
        }
    }

    #[test]
    fn strengths_have_six_digits() {
        let rows = [
            (Strength::Model(-49.67), "SS {Robot B} {Strength -49.67}\r\n"),
            (Strength::Model(-53.649400086720), "SS {Robot B} {Strength -53.6494}\r\n"),
            (Strength::Model(0.0), "SS {Robot B} {Strength 0}\r\n"),
            (Strength::Model(-1e10), "SS {Robot B} {Strength -1e+10}\r\n"),
            (Strength::Model(f64::INFINITY), "SS {Robot B} {Strength INF} {Error Model.Returned.INF}\r\n"),
            (Strength::Model(f64::NAN), "SS {Robot B} {Strength NaN} {Error Model.Returned.NaN}\r\n"),
            (Strength::Model(3.0), "SS {Robot B} {Strength NaN} {Error Model.Returned.NaN}\r\n"),
            (Strength::ToSelf, "SS {Robot B} {Strength INF} {Error SS.To.Self}\r\n"),
            (Strength::NoRobot, "SS {Robot B} {Strength NaN} {Error Robot.Does.Not.Exist}\r\n"),
        ];
        for (given, expected) in rows {
            assert_eq!(strength("B", given), expected);
        }
    }
}
