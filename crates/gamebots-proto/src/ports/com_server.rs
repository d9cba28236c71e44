//! The old relay between robots, 5874 (ComServer.uc, ComLink.uc; protocol.md 7.2). Commands and answers end with `;`.

/// Longest command, bytes.
const MAX_COMMAND: usize = 512;

/// A command of a robot. The first word is read in any case.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ComCommand {
    /// `REGISTER name ip`: a robot and its address.
    Register {
        /// Name of the robot.
        name: String,
        /// Its address.
        ip: String,
    },
    /// `LISTEN name port`: a robot waits at a port.
    Listen {
        /// Name of the robot.
        name: String,
        /// Its port.
        port: u16,
    },
    /// `OPEN name port other port`: the server connects to both robots and joins them.
    Open {
        /// Name of the robot that asks.
        name: String,
        /// The port at which it waits.
        port: u16,
        /// Name of the other robot.
        other: String,
        /// The port at which that one waits.
        other_port: u16,
    },
    /// `GETSS name other`: the strength of the signal between two robots.
    Strength([String; 2]),
    /// A command with too few words, too many, or a port that is no number.
    Incorrect,
    /// Another command.
    Unknown,
}

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub enum ComAnswer<'a> {
    /// The command is done.
    Done,
    /// The strength of a signal, dBm.
    Strength(f64),
    /// A robot has this name, with another address.
    Taken(&'a str),
    /// No robot has this name.
    NotRegistered(&'a str),
    /// The robot waits at this port already.
    Listening(&'a str, u16),
    /// The robot does not wait at this port.
    NotListening(&'a str, u16),
    /// The radio does not reach the robot.
    OutOfReach(&'a str),
    /// A robot does not take the connection.
    NoConnection,
    /// The model of propagation says nothing.
    NoStrength,
    /// The command is about robots of another address.
    ThirdParty,
    /// The command has too few words or too many.
    Incorrect,
    /// There is no such command.
    Unknown,
}

impl ComCommand {
    /// Reads a command without its `;`.
    pub fn read(text: &str) -> Self {
        let words: Vec<&str> = text.split_whitespace().take(6).collect();
        let Some((verb, words)) = words.split_first() else { return Self::Unknown };
        let name = |word: &str| word.to_owned();
        let read = match (verb.to_ascii_uppercase().as_str(), words) {
            ("REGISTER", [robot, ip]) => Some(Self::Register { name: name(robot), ip: name(ip) }),
            ("LISTEN", [robot, port]) => port.parse().ok().map(|port| Self::Listen { name: name(robot), port }),
            ("OPEN", [robot, port, other, other_port]) => {
                let ports = port.parse().ok().zip(other_port.parse().ok());
                ports.map(|(port, other_port)| Self::Open { name: name(robot), port, other: name(other), other_port })
            }
            ("GETSS", [robot, other]) => Some(Self::Strength([name(robot), name(other)])),
            ("REGISTER" | "LISTEN" | "OPEN" | "GETSS", _) => None,
            _ => Some(Self::Unknown),
        };
        read.unwrap_or(Self::Incorrect)
    }
}

impl ComAnswer<'_> {
    /// Returns the text of the answer. It has no line end.
    pub fn text(&self) -> String {
        let reason = match self {
            Self::Done => return "OK;".to_owned(),
            Self::Strength(strength) => return format!("OK:{strength:.6};"),
            Self::Taken(name) => format!("Robot with name {name} already registered"),
            Self::NotRegistered(name) => format!("Robot {name} not registered"),
            Self::Listening(name, port) => format!("Robot with name {name} already listening at port {port}"),
            Self::NotListening(name, port) => format!("{name} not listening on port {port}"),
            Self::OutOfReach(name) => format!("Cannot connect to {name}"),
            Self::NoConnection => "Could not establish connection".to_owned(),
            Self::NoStrength => "Could not calculate signal strength".to_owned(),
            Self::ThirdParty => "Server does not accept third party requests".to_owned(),
            Self::Incorrect => "Incorrect Message".to_owned(),
            Self::Unknown => "Unknown Message".to_owned(),
        };
        format!("Fail: {reason};")
    }
}

/// Splits bytes into commands. Text that is not UTF-8 loses the other bytes, and too long a command its end.
#[derive(Debug, Default)]
pub struct ComFraming(Vec<u8>);

impl ComFraming {
    /// Takes the next bytes and returns the commands that they complete, without `;`.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        let mut commands = Vec::new();
        for &byte in bytes {
            match byte {
                b';' => commands.push(String::from_utf8_lossy(&std::mem::take(&mut self.0)).into_owned()),
                _ if self.0.len() < MAX_COMMAND => self.0.push(byte),
                _ => {}
            }
        }
        commands
    }
}

/// One direction of a joined connection: `SEND <length> <bytes>;` passes bytes on, `CLOSE;` ends both. Anything else is skipped up to its
/// `;`.
#[derive(Debug, Default)]
pub struct ComLink {
    state: LinkState,
}

#[derive(Debug)]
enum LinkState {
    /// The first five bytes of a message.
    Verb(Vec<u8>),
    /// The digits of a length, as far as they have come.
    Length(u64),
    /// The number of bytes to pass on.
    Bytes(u64),
    /// The `;` after them.
    End,
    /// The rest of a message; true for CLOSE.
    Rest(bool),
}

impl Default for LinkState {
    fn default() -> Self {
        Self::Verb(Vec::new())
    }
}

impl ComLink {
    /// Takes bytes of one robot. Returns those for the other one, and true if the connection ends after them.
    pub fn push(&mut self, bytes: &[u8]) -> (Vec<u8>, bool) {
        let mut passed = Vec::new();
        for &byte in bytes {
            match &mut self.state {
                LinkState::Verb(verb) if verb.is_empty() && byte.is_ascii_whitespace() => {}
                LinkState::Verb(verb) => {
                    verb.push(byte);
                    if verb.len() == 5 {
                        self.state = match &verb[..] {
                            b"SEND " => LinkState::Length(0),
                            verb => LinkState::Rest(verb == b"CLOSE"),
                        };
                    }
                }
                LinkState::Length(length) => match byte {
                    b'0'..=b'9' => *length = length.saturating_mul(10).saturating_add(u64::from(byte - b'0')),
                    b' ' if *length == 0 => self.state = LinkState::End,
                    b' ' => self.state = LinkState::Bytes(*length),
                    b';' => self.state = LinkState::default(),
                    _ => self.state = LinkState::Rest(false),
                },
                LinkState::Bytes(left) => {
                    passed.push(byte);
                    *left -= 1;
                    if *left == 0 {
                        self.state = LinkState::End;
                    }
                }
                LinkState::End => self.state = LinkState::default(),
                LinkState::Rest(closes) if byte == b';' => {
                    if *closes {
                        return (passed, true);
                    }
                    self.state = LinkState::default();
                }
                LinkState::Rest(_) => {}
            }
        }
        (passed, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read_by_their_words() {
        let name = |text: &str| text.to_owned();
        for (text, expected) in [
            ("REGISTER R1 10.0.0.1", ComCommand::Register { name: name("R1"), ip: name("10.0.0.1") }),
            ("\r\nlisten  R1 5000 ", ComCommand::Listen { name: name("R1"), port: 5000 }),
            ("OPEN A 1 B 2", ComCommand::Open { name: name("A"), port: 1, other: name("B"), other_port: 2 }),
            ("GETSS A B", ComCommand::Strength([name("A"), name("B")])),
            ("REGISTER R1", ComCommand::Incorrect),
            ("REGISTER R1 a b c d e f g", ComCommand::Incorrect),
            ("LISTEN R1 70000", ComCommand::Incorrect),
            ("HELLO", ComCommand::Unknown),
            ("", ComCommand::Unknown),
        ] {
            assert_eq!(ComCommand::read(text), expected, "{text}");
        }
    }

    #[test]
    fn commands_end_with_a_semicolon_however_they_are_cut() {
        let mut framing = ComFraming::default();
        assert_eq!(framing.push(b"REGISTER R1 "), [""; 0]);
        assert_eq!(framing.push(b"1;HELLO;LIS"), ["REGISTER R1 1", "HELLO"]);
        assert_eq!(framing.push(&[b'x'; 10_000]), [""; 0]);
        assert_eq!(framing.push(b";").first().map(String::len), Some(MAX_COMMAND));
    }

    #[test]
    fn a_link_passes_on_what_is_sent_however_it_is_cut() {
        for (text, passed, ends) in [
            ("SEND 5 hello;SEND 2 ;;;CLOSE;SEND 1 x;", "hello;;", true),
            ("SEND 0 ;SEND 3 abc;", "abc", false),
            ("\r\nSEND 1 a;\r\nSEND 1 b;", "ab", false),
            ("HELLO there;SEND 1 a;", "a", false),
            ("SEND x;SEND 1 a;", "a", false),
            ("SEND 99999999999999999999999 abc;", "abc;", false),
            ("CLOSE", "", false),
        ] {
            for cut in 0..text.len() {
                let (mut link, (first, second)) = (ComLink::default(), text.as_bytes().split_at(cut));
                let (mut got, mut has_ended) = link.push(first);
                if !has_ended {
                    let (rest, has_ended_now) = link.push(second);
                    got.extend(rest);
                    has_ended = has_ended_now;
                }
                assert_eq!((got, has_ended), (passed.as_bytes().to_vec(), ends), "{text} cut at {cut}");
            }
        }
    }
}
