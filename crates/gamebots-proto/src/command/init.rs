//! `INIT {ClassName pkg.Class} {Name s} {Location x,y,z} {Rotation r,p,y} {Start tag}` (protocol.md 3.1). `{Team s}` is ours.

use super::{ReadWrite, note_keys, text, with_text, with_vector};
use crate::{Line, Problem, shown, value};

/// Puts a robot into the world. No reply.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Init {
    /// Class, as in `USARBot.P3AT`; without a package, `USARBot` is meant.
    pub class_name: String,
    /// Name of the robot; may be empty.
    pub name: String,
    /// Name of a start pose. If it is not empty, [`Self::location`] and [`Self::rotation`] are ignored.
    pub start: String,
    /// Position, m, world frame (z down).
    pub location: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
    /// Name of its team in a league; may be empty.
    pub team: String,
}

impl Init {
    /// Names of the class of world controllers, with its package and without.
    pub const CONTROLLER: [&'static str; 2] = ["USARBotAPI.WorldController", "WorldController"];

    /// True if it asks for a world controller, which has no body.
    pub fn is_controller(&self) -> bool {
        Self::CONTROLLER.iter().any(|class| class.eq_ignore_ascii_case(&self.class_name))
    }

    /// Names of the classes of avatars, without their package, USARAvatar. The first four walk to places, the others to path nodes, too.
    pub const AVATARS: [&'static str; 6] = [
        "USARAvatarTallMaleA",
        "USARAvatarTallMaleB",
        "USARAvatarTallMaleC",
        "USARAvatarTallMaleD",
        "USARAvatarNewMale",
        "USARAvatarNewFemale",
    ];

    /// Returns the name of the class of avatars that it asks for, if it asks for one.
    pub fn avatar(&self) -> Option<&'static str> {
        Self::AVATARS.into_iter().find(|class| class.eq_ignore_ascii_case(self.class()))
    }

    /// True if it asks for a robot, or for nothing that is known.
    pub fn is_of_robot(&self) -> bool {
        !self.is_controller() && self.avatar().is_none()
    }

    /// Returns the class without its package: `P3AT` for `USARBot.P3AT`.
    pub fn class(&self) -> &str {
        self.class_name.rsplit('.').next().unwrap_or_default()
    }
}

impl ReadWrite for Init {
    const KEYS: &'static [&'static str] = &["ClassName", "Name", "Location", "Rotation", "Start", "Team"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("INIT", line, Self::KEYS, problems);
        let start = text(line, "Start");
        let [location, rotation] = if start.is_empty() {
            ["Location", "Rotation"].map(|key| value::vector(line, key, problems))
        } else {
            let given = ["Location", "Rotation"].map(|key| (key, text(line, key)));
            for (key, value) in given.iter().filter(|(_, value)| !value.is_empty()) {
                let why = format!("{{Start {}}} says where the robot is put", shown(&start));
                problems.push(Problem::Ignored { what: format!("{{{key} {}}}", shown(value)), why });
            }
            [[0.0; 3]; 2]
        };
        let team = text(line, "Team");
        Self { class_name: text(line, "ClassName"), name: text(line, "Name"), start, location, rotation, team }
    }

    fn write(&self) -> Line {
        let line = with_text(Line::new("INIT"), "ClassName", &self.class_name);
        let line = with_text(line, "Name", &self.name);
        let line = if self.start.is_empty() {
            with_vector(with_vector(line, "Location", self.location), "Rotation", self.rotation)
        } else {
            line.with("Start", &self.start)
        };
        with_text(line, "Team", &self.team)
    }
}
