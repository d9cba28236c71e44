//! The server's messages to a client, one file each. Each message is a table of its fields (see [`Field`]). The writers of both
//! dialects and the reader follow from the table.

mod asta;
mod avatar;
mod conf;
mod geo;
mod nfo;
mod object;
mod res;
mod sen;
mod sta;

pub use asta::{Asta, Eff, JointSta};
pub use avatar::{AvatarBone, AvatarBones, AvatarSta};
pub use conf::*;
pub use geo::{ActuatorGeo, Geo, GroundGeo, ItemGeo, JointGeo, MountedGeo, RobotGeo, VehicleGeo};
pub use nfo::{Greeting, NamedPose, Nfo, PathNode};
pub use object::{MAX_OBJECTS_BYTES, ObjectSta, objects_that_fit};
pub use res::{Nothing, Res, ViewportsRes};
pub use sen::*;
pub use sta::{GroundSta, Sta, StaHead, Vehicle};

use crate::command::Set;
use crate::field::{self, Record};
pub use crate::field::{Field, Format, Table};
use crate::{Command, Dialect, Line};

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
    /// State of an avatar, twenty times a second.
    Avatar(AvatarSta),
    /// Arms of an avatar, twenty times a second.
    Bones(AvatarBones),
    /// Configuration, the answer to GETCONF.
    Conf(Conf),
    /// Geometry, the answer to GETGEO.
    Geo(Geo),
    /// States of the objects of a world controller, the answer to its GetSTA.
    Objects(Vec<ObjectSta>),
    /// The result of a SET; UT2004 only.
    Res(Res),
    /// The result of a SET that chooses viewports; UT2004 only.
    Viewports(ViewportsRes),
    /// The answer to a GETCONF that nothing matches; UT2004 only.
    NoConf(Nothing),
    /// The answer to a GETGEO that nothing matches; UT2004 only.
    NoGeo(Nothing),
}

/// Verbs of periodic lines.
const PERIODIC_VERBS: [&str; 6] = ["SEN", "STA", "ASTA", "MISSTA", "EFF", "BSTA"];

/// True if a line of a server is a periodic message. A `STA` of a world controller's objects is an answer.
pub fn is_periodic_line(line: &str) -> bool {
    let (verb, rest) = line.split_once(' ').unwrap_or((line, ""));
    let is_of_objects = verb == "STA" && (rest.is_empty() || rest.starts_with("{Name "));
    PERIODIC_VERBS.contains(&verb) && !is_of_objects
}

/// A line, and the messages in it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenLine<'a> {
    /// The line without its CR LF.
    pub line: String,
    /// One message, or the readings that share the line.
    pub messages: Vec<&'a Message>,
}

/// Writes one robot's messages of one step as lines. In UT2004's dialect, the readings of all sonars, or of all encoders, share
/// one line. Messages that a dialect does not have are left out.
pub fn lines<'a>(messages: impl IntoIterator<Item = &'a Message>, dialect: Dialect) -> Vec<WrittenLine<'a>> {
    let group = |message: &Message| match message {
        Message::Sen(sen) if sen.reading.is_grouped(dialect) => Some(sen.reading.type_name()),
        _ => None,
    };
    let mut groups: Vec<(Option<&str>, Vec<&Message>)> = Vec::new();
    let is_sent = |message: &&Message| message.is_of(dialect);
    for message in messages.into_iter().filter(is_sent) {
        let own = group(message);
        match groups.iter_mut().find(|(other, _)| own.is_some() && *other == own) {
            Some((_, together)) => together.push(message),
            None => groups.push((own, vec![message])),
        }
    }
    let written = |(_, messages): (_, Vec<&'a Message>)| {
        let line = match messages.as_slice() {
            [alone] => alone.write(dialect),
            together => {
                let sen = |message: &&'a Message| if let Message::Sen(sen) = message { Some(sen) } else { None };
                Sen::write_together(&together.iter().filter_map(sen).collect::<Vec<_>>(), dialect)
            }
        };
        WrittenLine { line, messages }
    };
    groups.into_iter().map(written).collect()
}

/// Returns every table, with the beginning of its lines. The field is the time, if that stands before the type.
pub fn tables() -> Vec<(String, Option<Field>, Table)> {
    let of = |line: &str, table: Table| (line.to_owned(), None, table);
    let sensors = sen::TABLES.iter();
    let sensors = sensors.map(|(type_name, time, table)| (format!("SEN {{Type {type_name}}}"), Some(*time), *table));
    let items = conf::TABLES.iter().map(|table| of("CONF {Type ..}", *table));
    let mut tables = vec![
        of("NFO {Gametype BotDeathMatch}", Greeting::TABLE),
        of("NFO {StartPoses n}", NamedPose::TABLE),
        of("NFO {Pathnode n}", PathNode::TABLE),
        of("STA", StaHead::TABLE),
        of("STA {Type GroundVehicle}", GroundSta::TABLE),
    ];
    tables.extend(sensors);
    tables.extend([of("STA {Type USARAvatar..}", AvatarSta::TABLE), of("BSTA", AvatarBones::TABLE)]);
    tables.extend([of("ASTA", Asta::TABLE), of("EFF", Eff::TABLE), of("CONF", GroundConf::TABLE)]);
    tables.extend(items);
    tables.extend([
        of("GEO {Type GroundVehicle}", GroundGeo::TABLE),
        of("GEO {Type ..}", MountedGeo::TABLE),
        of("GEO {Type Actuator}", ActuatorGeo::TABLE),
        of("RES", Res::TABLE),
        of("CONF, GEO", Nothing::TABLE),
    ]);
    tables
}

impl Message {
    /// Returns the reply to a command that a dialect adds to the answers. UT2004 answers every SET, and echoes a question that
    /// nothing matches. `found` is true if the robot has the item that the command names; the simulated time is in seconds.
    pub fn receipt(command: &Command, found: bool, time: f32, dialect: Dialect) -> Option<Self> {
        if dialect == Dialect::Udk {
            return None;
        }
        let name = |name: &String| Some(name.clone()).filter(|name| !name.is_empty());
        let nothing = |type_name: &String, asked| Nothing { type_name: type_name.clone(), name: name(asked) };
        match command {
            // Joints are set without an answer, and viewports have one of their own (KRobot.uc).
            Command::Set(set) if ["Joint", "Viewports"].iter().any(|it| it.eq_ignore_ascii_case(&set.type_name)) => {
                None
            }
            Command::Set(Set { type_name, name, .. }) => {
                Some(Self::Res(Res { time, type_name: type_name.clone(), name: name.clone(), found }))
            }
            Command::GetConf(ask) if !found => Some(Self::NoConf(nothing(&ask.type_name, &ask.name))),
            Command::GetGeo(ask) if !found => Some(Self::NoGeo(nothing(&ask.type_name, &ask.name))),
            _ => None,
        }
    }

    /// Writes the line in a dialect, without its CR LF.
    pub fn write(&self, dialect: Dialect) -> String {
        let blocks = |verb: &str, blocks| format!("{verb}{}", field::blocks(blocks));
        match self {
            Self::Nfo(message) => message.write(dialect),
            Self::Sta(message) => message.write(dialect),
            Self::Sen(message) => message.write(dialect),
            Self::Asta(message) => blocks(dialect.of(["ASTA", "MISSTA"]), message.write(dialect)),
            Self::Eff(message) => blocks("EFF", message.write(dialect)),
            Self::Avatar(message) => blocks("STA", message.write(dialect)),
            Self::Bones(message) => blocks("BSTA", message.write(dialect)),
            Self::Conf(message) => message.write(dialect),
            Self::Geo(message) => message.write(dialect),
            Self::Objects(objects) => object::write(objects),
            Self::Res(message) => blocks("RES", message.write(dialect)),
            Self::Viewports(message) => message.write(),
            Self::NoConf(message) => blocks("CONF", message.write(dialect)),
            Self::NoGeo(message) => blocks("GEO", message.write(dialect)),
        }
    }

    /// Reads a line of a server, in either dialect; `None` if it is not one of these messages. If the line has readings of
    /// several sensors, returns the first, see [`Message::read_all`].
    pub fn read(text: &str) -> Option<Self> {
        Self::read_all(text).into_iter().next()
    }

    /// Reads all messages in a line of a server, in either dialect; empty if it is not one of these messages.
    pub fn read_all(text: &str) -> Vec<Self> {
        let line = Line::parse(text);
        let one = match line.verb.as_str() {
            "SEN" => return Sen::read(&line).unwrap_or_default().into_iter().map(Self::Sen).collect(),
            "NFO" => Nfo::read(&line).map(Self::Nfo),
            "STA" if line.get("Walking").is_some() => AvatarSta::read(&line).map(Self::Avatar),
            "STA" => Sta::read(&line).map(Self::Sta),
            "BSTA" => AvatarBones::read(&line).map(Self::Bones),
            "ASTA" | "MISSTA" => Asta::read(&line).map(Self::Asta),
            "EFF" => Eff::read(&line).map(Self::Eff),
            "CONF" => Conf::read(&line).map(Self::Conf),
            "GEO" => Geo::read(&line).map(Self::Geo),
            "RES" if line.get("Status").is_some() => Res::read(&line).map(Self::Res),
            _ => None,
        };
        one.into_iter().collect()
    }

    /// True if a dialect has this message. UT2004's cameras have no SEN: a capture of a robot with a camera has none. UDK calls questions for
    /// the geometry of mission packages deprecated, and does not answer them (BotConnection.uc).
    fn is_of(&self, dialect: Dialect) -> bool {
        match self {
            Self::Sen(Sen { reading: Reading::Camera(_), .. }) => dialect == Dialect::Udk,
            Self::Viewports(_) => dialect == Dialect::Ut2004,
            Self::Geo(Geo::Items { type_name, .. }) if type_name.eq_ignore_ascii_case("MisPkg") => {
                dialect == Dialect::Ut2004
            }
            _ => true,
        }
    }

    /// True for periodic messages. The next one replaces this one, so a client that does not keep up may lose it. Answers are
    /// never lost.
    pub fn is_periodic(&self) -> bool {
        matches!(self, Self::Sta(_) | Self::Sen(_) | Self::Asta(_) | Self::Eff(_) | Self::Avatar(_) | Self::Bones(_))
    }
}

#[cfg(test)]
mod tests;
