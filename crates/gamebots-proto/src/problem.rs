//! Mistakes in the lines that clients send.

use crate::command::{Drive, ReadWrite};

/// A mistake in a line. The rest of the line still counts. The server sends it to the client only if it reports errors.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The line is over the length limit.
    #[error("line of {got} bytes discarded; the limit is {limit}")]
    LineTooLong {
        /// Length of the line, bytes.
        got: usize,
        /// The limit, bytes.
        limit: usize,
    },
    /// The line has too many blocks.
    #[error("line has more than {limit} blocks; the rest is ignored")]
    TooManyBlocks {
        /// The limit.
        limit: usize,
    },
    /// A verb that is not known.
    #[error("unknown verb `{got}`{meant}; expected one of {expected}")]
    UnknownVerb {
        /// The unknown verb.
        got: String,
        /// " (did you mean ..?)", or empty if no name is near.
        meant: String,
        /// The verbs that are known, separated by commas.
        expected: String,
    },
    /// A value that should be a number but is not.
    #[error("{{{key} {got}}}: expected a number; read as {read_as}")]
    NotANumber {
        /// The key of the block.
        key: String,
        /// Its value.
        got: String,
        /// The value used instead.
        read_as: f64,
    },
    /// A number outside of the range that makes sense.
    #[error("{{{key} {got}}}: expected a number within ±{limit}; read as {read_as}")]
    OutOfRange {
        /// The key of the block.
        key: String,
        /// Its value.
        got: String,
        /// Largest magnitude accepted, in the unit of the key.
        limit: f64,
        /// The value used instead.
        read_as: f64,
    },
    /// A value that is neither true nor false.
    #[error("{{{key} {got}}}: expected true or false; read as false")]
    NotABool {
        /// The key of the block.
        key: String,
        /// Its value.
        got: String,
    },
    /// A vector that has not three numbers.
    #[error("{{{key} {got}}}: expected three numbers x,y,z; read as {},{},{}", read_as[0], read_as[1], read_as[2])]
    NotAVector {
        /// The key of the block.
        key: String,
        /// Its value.
        got: String,
        /// The value used instead.
        read_as: [f64; 3],
    },
    /// A last block without its closing brace.
    #[error("`{{{got}`: the brace is not closed; the block is ignored")]
    Unclosed {
        /// The block without its brace.
        got: String,
    },
    /// A block in which another one begins.
    #[error("`{{{got}}}`: a brace is not closed before the next one; all of it is one block")]
    Nested {
        /// The text of the block.
        got: String,
    },
    /// A part of a line that has no effect.
    #[error("{what} is ignored: {why}")]
    Ignored {
        /// The part, as it was sent.
        what: String,
        /// The reason, in words.
        why: String,
    },
    /// A key that the command does not have.
    #[error("{verb} has no key `{got}`{meant}; expected {expected}; the block is ignored")]
    UnknownKey {
        /// The verb.
        verb: &'static str,
        /// The key.
        got: String,
        /// " (did you mean ..?)", or empty if no name is near.
        meant: String,
        /// The keys that it has, separated by commas.
        expected: String,
    },
    /// A key of DRIVE that a robot does not take.
    #[error("DRIVE: {class} takes no key `{got}`{meant}; expected {expected}; the block is ignored")]
    NoDriveKey {
        /// The robot's class.
        class: String,
        /// The key.
        got: String,
        /// " (did you mean ..?)", or empty if no name is near.
        meant: String,
        /// The keys that it takes, separated by commas.
        expected: String,
    },
    /// A DRIVE that says nothing.
    #[error("DRIVE without a value does nothing; {class} takes {expected}")]
    EmptyDrive {
        /// The robot's class.
        class: String,
        /// The keys that it takes, separated by commas.
        expected: String,
    },
    /// A required block is missing.
    #[error("{verb} needs {key}")]
    MissingKey {
        /// The verb.
        verb: &'static str,
        /// The missing key or keys.
        key: &'static str,
    },
    /// A link that an actuator does not have.
    #[error("{{Link {got}}}: the actuator `{name}` has links {first} to {last}; nothing is moved")]
    NoLink {
        /// The number that was sent.
        got: usize,
        /// Name of the actuator.
        name: String,
        /// Its first number.
        first: usize,
        /// Its last number.
        last: usize,
    },
    /// An item that a robot does not have.
    #[error("{asked}: the robot has no such {what}{meant}; {expected}")]
    NoItem {
        /// Verb, type and name that were sent, as a line.
        asked: String,
        /// `item`, or `item or opcode` for a SET.
        what: &'static str,
        /// " (did you mean ..?)", or empty if no name is near.
        meant: String,
        /// Types and names of its items, in words.
        expected: String,
    },
    /// A robot that cannot be driven.
    #[error("a {class} has no drive; move its joints with SET {{Type Joint}}")]
    NotDriven {
        /// Its class.
        class: String,
    },
    /// A name that is not known.
    #[error("{{{key} {got}}} is unknown{meant}; {expected}; {instead}")]
    UnknownName {
        /// The key of the block.
        key: &'static str,
        /// Its value.
        got: String,
        /// " (did you mean ..?)", or empty if no name is near.
        meant: String,
        /// The names that are known, in words.
        expected: String,
        /// The consequence, in words.
        instead: &'static str,
    },
    /// A name that is too long to keep.
    #[error("{{{key} ..}} has {got} characters; the first {limit} are kept")]
    NameTooLong {
        /// The key of the block.
        key: &'static str,
        /// Its length.
        got: usize,
        /// The limit.
        limit: usize,
    },
    /// The world is full.
    #[error("INIT refused: the world holds {limit} robots already")]
    TooManyRobots {
        /// The limit.
        limit: usize,
    },
    /// A start pose that is occupied. The robot is put beside it.
    #[error("{wanted}: {why}; the robot is put beside it, at {got}")]
    Beside {
        /// The requested pose, as a block.
        wanted: String,
        /// The reason, in words.
        why: String,
        /// Position of the robot instead: x, y, z, m.
        got: String,
    },
    /// A start pose without room.
    #[error("{wanted}: {why}; no robot is spawned; GETSTARTPOSES names places to start at")]
    NoRoom {
        /// The requested pose, as a block.
        wanted: String,
        /// The reason.
        why: String,
    },
    /// A robot that a league does not admit.
    #[error("INIT: {why}; no robot is spawned")]
    NotAdmitted {
        /// The reason, with what was expected.
        why: String,
    },
    /// A command for a robot on a connection that has none.
    #[error("{verb} ignored: there is no robot on this connection; send INIT first")]
    NoRobot {
        /// The verb.
        verb: &'static str,
    },
    /// A command for a robot whose battery is flat.
    #[error("{verb} ignored: the robot's battery is flat")]
    FlatBattery {
        /// The verb.
        verb: &'static str,
    },
    /// An order for an avatar to another pawn.
    #[error("{verb} ignored: only an avatar walks; send INIT {{ClassName USARAvatar.USARAvatarTallMaleA}} first")]
    NoAvatar {
        /// The verb.
        verb: &'static str,
    },
    /// An order that an avatar cannot follow.
    #[error("{verb}: {why}; the avatar goes on as before")]
    NoWay {
        /// The verb.
        verb: &'static str,
        /// The reason, with what was expected.
        why: String,
    },
    /// An order of a world controller from another pawn.
    #[error(
        "CONTROL ignored: only a world controller can send it; send INIT {{ClassName USARBotAPI.WorldController}} first"
    )]
    NoController,
    /// An order about an object that cannot be followed.
    #[error("CONTROL {{Type {order}}} {{Name {name}}}: {why}; nothing is done")]
    ObjectRefused {
        /// The type of the order.
        order: String,
        /// The name that was sent.
        name: String,
        /// The reason, in words.
        why: String,
    },
    /// An order about an object that is followed in part.
    #[error("CONTROL {{Type {order}}} {{Name {name}}}: {why}")]
    ObjectChanged {
        /// The type of the order.
        order: String,
        /// The name that was sent.
        name: String,
        /// The departure from the order, in words.
        why: String,
    },
    /// A tool changer that cannot take or drop a tool.
    #[error("tool changer {name}: {why}; nothing is done")]
    ToolRefused {
        /// Its name.
        name: String,
        /// The reason, in words.
        why: String,
    },
    /// An RFID tag that cannot be released or written.
    #[error("RFID tag {id}: {why}; nothing is done")]
    TagRefused {
        /// Its number.
        id: u32,
        /// The reason, in words.
        why: String,
    },
    /// A name that another robot has.
    #[error(
        "{{Name {got}}} is the name of another robot too: both are spawned; choose another name to tell them apart"
    )]
    NameTaken {
        /// The name.
        got: String,
    },
    /// An HTTP request of a browser, not a line of the protocol. Any web page can make a browser send it.
    #[error("an HTTP request on the controllers' port: the connection is closed; the page has a port of its own")]
    Http,
}

/// Longest text of a client that a message repeats, characters.
const MAX_SHOWN: usize = 60;

impl Problem {
    /// Reports a name that is not known. `owner` is the thing that has the known names, as in `this robot`. `instead` is the
    /// consequence, in words.
    pub fn unknown_name<'a>(
        key: &'static str,
        got: &str,
        known: impl Iterator<Item = &'a str> + Clone,
        owner: &str,
        instead: &'static str,
    ) -> Self {
        let expected = expected_of(known.clone(), owner);
        let got = shown(got);
        Self::UnknownName { key, meant: names::did_you_mean(&got, known), got, expected, instead }
    }

    pub(crate) fn unknown_verb(got: &str, known: &[&str]) -> Self {
        let got = shown(got);
        let first = got.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        let meant = match known.iter().find(|verb| verb.eq_ignore_ascii_case(first)) {
            Some(verb) => format!(" (after `{verb}` come blocks in braces, as in `{{Key value}}`)"),
            None => names::did_you_mean(&got, known.iter().copied()),
        };
        Self::UnknownVerb { meant, got, expected: known.join(", ") }
    }

    pub(crate) fn unknown_key(verb: &'static str, got: &str, known: &[&str]) -> Self {
        let got = shown(got);
        Self::UnknownKey { verb, meant: meant_key(&got, known), got, expected: known.join(", ") }
    }

    /// Reports a key of DRIVE that a robot of a class does not take. A key of other robots is no mistyped one.
    pub fn no_drive_key(class: &str, got: &str, known: &[&str]) -> Self {
        let got = shown(got);
        let is_of_others = Drive::KEYS.iter().any(|key| key.eq_ignore_ascii_case(&got));
        let meant = if is_of_others { String::new() } else { meant_key(&got, known) };
        Self::NoDriveKey { class: class.to_owned(), meant, got, expected: known.join(", ") }
    }
}

/// Lists the names of which one is expected, in words. `owner` is the thing that has them.
pub fn expected_of<'a>(known: impl Iterator<Item = &'a str>, owner: &str) -> String {
    let known: Vec<&str> = known.collect();
    if known.is_empty() { format!("{owner} has none") } else { format!("expected one of {}", known.join(", ")) }
}

/// Returns the known key nearest to a wrong one as a suffix of a message. A key that goes on after a sign, as in `Left=2`, is
/// shown as the block that it should be.
fn meant_key(got: &str, known: &[&str]) -> String {
    let Some((key, value)) = got.split_once(['=', ':']) else { return names::did_you_mean(got, known.iter().copied()) };
    let key = names::nearest(key, known.iter().copied());
    key.map_or(String::new(), |key| format!(" (did you mean `{{{key} {value}}}`?)"))
}

/// Returns a client's text for use in a message: its first 60 characters.
pub fn shown(text: &str) -> String {
    text.chars().take(MAX_SHOWN).collect()
}
