//! Rights of clients: who may watch, drive, and control the world.
//!
//! Without tokens everybody has every right. With tokens nobody has any without one: the first line to a port is `LOGIN {Token ..}`, and the
//! page sends its token with every request.

use std::collections::BTreeSet;
use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;
use std::sync::Arc;
use std::time::Duration;

use gamebots_proto::ports::read_login;
use gamebots_proto::{Command, Problem};
use serde::Deserialize;
use sessions::Request;
use subtle::ConstantTimeEq;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::WorldControl;

/// Lengths of a token, characters. 16 random ones cannot be guessed.
const LENGTHS: std::ops::RangeInclusive<usize> = 16..=128;
/// Fewest different characters of a random token. 16 hexadecimal digits have fewer in one of a thousand tokens.
const FEWEST_CHARACTERS: usize = 7;
/// Most tokens.
const MAX_TOKENS: usize = 1000;
/// Longest LOGIN line, bytes.
const MAX_LOGIN: usize = 512;
/// Longest time for a LOGIN line.
pub(crate) const LOGIN_TIME: Duration = Duration::from_secs(10);

/// A kind of right. None includes another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Role {
    /// Sees the world: the page, truth, positions, pictures, Foxglove.
    Viewer,
    /// Drives robots, uses their radio, and sees what their cameras see.
    Driver,
    /// Controls the world: pauses it, removes robots, starts logs, and has world controllers and avatars.
    Referee,
}

impl Role {
    const ALL: [Self; 3] = [Self::Viewer, Self::Driver, Self::Referee];

    fn name(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Driver => "driver",
            Self::Referee => "referee",
        }
    }
}

/// The tokens that a server knows, with what they allow.
#[derive(Clone)]
pub struct Tokens(Arc<[Token]>);

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Token {
    token: String,
    roles: Vec<Role>,
    team: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    token: Vec<Token>,
}

/// A mistake in a file of tokens.
#[derive(Debug, thiserror::Error)]
pub enum TokensError {
    /// The text is no TOML, or has other keys.
    #[error(
        "line {line}: {message}: expected [[token]] with token = \"..\", roles = [\"viewer\", \"driver\", \"referee\"] and perhaps team = \"..\""
    )]
    Syntax {
        /// Line of the file, from 1.
        line: usize,
        /// The mistake, without the text of the file.
        message: String,
    },
    /// There are no tokens, or too many.
    #[error("{got} tokens: expected 1 to {MAX_TOKENS}")]
    Count {
        /// Number of tokens.
        got: usize,
    },
    /// A token that is too short, too long, or cannot be sent.
    #[error(
        "token {number}: `token` has {got} characters: expected {} to {} letters, digits and - _ . ~, as `openssl rand -hex 16` makes",
        LENGTHS.start(),
        LENGTHS.end()
    )]
    Token {
        /// Its place in the file, from 1.
        number: usize,
        /// Its length.
        got: usize,
    },
    /// A token that stands there twice.
    #[error("token {number} equals token {other}: expected another for each")]
    Twice {
        /// Its place in the file, from 1.
        number: usize,
        /// The earlier place.
        other: usize,
    },
    /// A token without roles.
    #[error("token {number}: `roles` is empty: expected some of \"viewer\", \"driver\", \"referee\"")]
    NoRoles {
        /// Its place in the file, from 1.
        number: usize,
    },
    /// A team's token that does not drive, or a team without a name.
    #[error("token {number}: `team` is `{team}`: expected a name without braces, and \"driver\" in `roles`")]
    Team {
        /// Its place in the file, from 1.
        number: usize,
        /// Name of the team.
        team: String,
    },
}

impl FromStr for Tokens {
    type Err = TokensError;

    fn from_str(text: &str) -> Result<Self, TokensError> {
        let File { token: tokens } = toml::from_str(text).map_err(|error| syntax(text, &error))?;
        if !(1..=MAX_TOKENS).contains(&tokens.len()) {
            return Err(TokensError::Count { got: tokens.len() });
        }
        for (index, Token { token, roles, team }) in tokens.iter().enumerate() {
            let number = index + 1;
            // These need no quotes in a line, a header or an address.
            let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.~".contains(&byte);
            if !LENGTHS.contains(&token.len()) || !token.bytes().all(is_plain) {
                return Err(TokensError::Token { number, got: token.chars().count() });
            }
            if let Some(other) = tokens.iter().take(index).position(|other| other.token == *token) {
                return Err(TokensError::Twice { number, other: other + 1 });
            }
            if roles.is_empty() {
                return Err(TokensError::NoRoles { number });
            }
            let is_bad = |team: &&String| {
                team.trim().is_empty() || team.contains(['{', '}', '\r', '\n']) || !roles.contains(&Role::Driver)
            };
            if let Some(team) = team.as_ref().filter(is_bad) {
                return Err(TokensError::Team { number, team: team.clone() });
            }
        }
        Ok(Self(tokens.into()))
    }
}

/// Describes a mistake of syntax. The parser's own text quotes the file, which may be a token.
fn syntax(text: &str, error: &toml::de::Error) -> TokensError {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
    let message = match error.message().split_once("string \"") {
        Some((before, rest)) => format!("{before}string{}", rest.rsplit_once('"').map_or("", |(_, after)| after)),
        None => error.message().to_owned(),
    };
    TokensError::Syntax { line: before.matches('\n').count() + 1, message }
}

impl fmt::Debug for Tokens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Tokens({})", self.0.len())
    }
}

impl Tokens {
    /// Returns the teams that tokens are of.
    pub fn teams(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter_map(|token| token.team.as_deref())
    }

    /// Returns the places in the file, from 1, of tokens that could be guessed: words without a digit, or few characters again and again.
    pub fn guessable(&self) -> impl Iterator<Item = usize> {
        let is_guessable = |Token { token, .. }: &Token| {
            let characters: BTreeSet<u8> = token.bytes().collect();
            characters.len() < FEWEST_CHARACTERS || !token.bytes().any(|byte| byte.is_ascii_digit())
        };
        self.0.iter().enumerate().filter(move |(_, token)| is_guessable(token)).map(|(index, _)| index + 1)
    }

    /// Finds a token. Every known one is compared, each in a time that does not depend on the characters that are right.
    fn find(&self, text: &str) -> Option<&Token> {
        let is_it = |token: &&Token| bool::from(token.token.as_bytes().ct_eq(text.as_bytes()));
        self.0.iter().filter(is_it).fold(None, |_, token| Some(token))
    }
}

/// Rights of a connection.
#[derive(Debug, Clone)]
pub(crate) struct Rights {
    roles: Vec<Role>,
    /// The only team that it may drive for.
    team: Option<String>,
}

/// The reason why a connection gets no rights.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Refusal {
    #[error("there is no token")]
    NoToken,
    #[error("the token is unknown")]
    Unknown,
    #[error("the token has not the role {0}")]
    Role(String),
}

/// Access control of a server: its tokens, if it has any.
#[derive(Debug, Clone)]
pub(crate) struct Access(Option<Tokens>);

impl Access {
    pub(crate) fn new(tokens: Option<Tokens>) -> Self {
        Self(tokens)
    }

    /// True if nobody needs a token.
    pub(crate) fn is_open(&self) -> bool {
        self.0.is_none()
    }

    /// Returns the rights that a token gives.
    ///
    /// # Errors
    /// If it gives none of `wanted`.
    pub(crate) fn rights(&self, token: Option<&str>, wanted: &[Role]) -> Result<Rights, Refusal> {
        let Some(tokens) = &self.0 else { return Ok(Rights::all()) };
        let Token { roles, team, .. } = tokens.find(token.ok_or(Refusal::NoToken)?).ok_or(Refusal::Unknown)?;
        if !wanted.iter().any(|role| roles.contains(role)) {
            return Err(Refusal::Role(wanted.iter().map(|role| role.name()).collect::<Vec<_>>().join(" or ")));
        }
        Ok(Rights { roles: roles.clone(), team: team.clone() })
    }

    /// Reads the LOGIN line of a connection, and not a byte after it.
    ///
    /// # Errors
    /// If the line does not come in time, or its token gives none of `wanted`.
    pub(crate) async fn log_in(&self, stream: &mut TcpStream, wanted: &[Role]) -> Result<Rights, Refusal> {
        let line = timeout(LOGIN_TIME, read_line(stream)).await.ok().flatten();
        self.rights(line.and_then(|line| read_login(&line)).as_deref(), wanted)
    }

    /// Returns the reason why a connection may not control the world, if any. With tokens its role counts instead of its address `peer`, and
    /// of the server's address `own` in that connection.
    pub(crate) fn refusal(
        &self,
        rights: &Rights,
        control: WorldControl,
        peer: IpAddr,
        own: IpAddr,
    ) -> Option<&'static str> {
        if self.is_open() || control == WorldControl::Nobody {
            return control.refusal(peer, own);
        }
        (!rights.have(Role::Referee)).then_some("only a token with the role referee controls this world")
    }
}

/// Reads a line byte by byte. `None` if it is too long or does not end.
async fn read_line(stream: &mut TcpStream) -> Option<String> {
    let mut line = Vec::new();
    while line.len() < MAX_LOGIN {
        match stream.read_u8().await.ok()? {
            b'\r' | b'\n' if line.is_empty() => {}
            b'\r' | b'\n' => return String::from_utf8(line).ok(),
            byte => line.push(byte),
        }
    }
    None
}

impl Rights {
    /// Returns every right, as everybody has without tokens.
    pub(crate) fn all() -> Self {
        Self { roles: Role::ALL.to_vec(), team: None }
    }

    pub(crate) fn have(&self, role: Role) -> bool {
        self.roles.contains(&role)
    }

    /// Checks a request of a controller: an INIT needs the right to it, and gets the connection's team. A refused one is replaced by the reason.
    pub(crate) fn admit(&self, request: Request, refusal: Option<&'static str>) -> Request {
        let Some(Command::Init(init)) = &request.command else { return request };
        let refused = |why: String| {
            let problems = vec![Problem::NotAdmitted { why }];
            Request { text: String::new(), command: None, problems }
        };
        if !init.is_of_robot() {
            return match refusal {
                Some(reason) => refused(format!("no world controller or avatar from here: {reason}")),
                None => request,
            };
        }
        if !self.have(Role::Driver) {
            return refused("the connection's token has not the role driver".to_owned());
        }
        match &self.team {
            Some(team) if init.team.is_empty() => {
                // Logs have the team, so that they replay without the token.
                let (verb, blocks) = request.text.split_at(request.text.find('{').unwrap_or(request.text.len()));
                Request::read(Ok(format!("{} {{Team {team}}} {blocks}", verb.trim_end())))
            }
            Some(team) if !init.team.eq_ignore_ascii_case(team) => {
                refused(format!("{{Team {}}}: expected {team}, the team of the connection's token", init.team))
            }
            _ => request,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RED: &str = "red-0123456789abcdef";
    const REFEREE: &str = "ref-0123456789abcdef";

    fn tokens() -> Access {
        let text = format!(
            "[[token]]\ntoken = \"{RED}\"\nroles = [\"driver\"]\nteam = \"red\"\n\
             [[token]]\ntoken = \"{REFEREE}\"\nroles = [\"viewer\", \"referee\"]\n"
        );
        Access::new(Some(text.parse().unwrap()))
    }

    #[test]
    fn a_file_of_tokens_is_checked() {
        let token = |rest: &str| format!("[[token]]\ntoken = \"0123456789abcdef\"\n{rest}\n");
        for (text, expected) in [
            (String::new(), "missing field `token`"),
            ("token = []".to_owned(), "0 tokens: expected 1 to 1000"),
            (token("roles = [\"king\"]"), "unknown variant `king`"),
            (token("roles = []"), "token 1: `roles` is empty"),
            (token("roles = [\"viewer\"]\nname = \"x\""), "unknown field `name`"),
            (token("roles = [\"viewer\"]\nteam = \"red\""), "`team` is `red`: expected"),
            (token("roles = [\"driver\"]\nteam = \"a}b\""), "`team` is `a}b`: expected"),
            (token("roles = [\"driver\"]\nteam = \" \""), "`team` is ` `: expected"),
            (token("roles = [\"driver\"]").repeat(2), "token 2 equals token 1"),
            ("[[token]]\ntoken = \"short\"\nroles = [\"viewer\"]".to_owned(), "token 1: `token` has 5 characters"),
            (format!("[[token]]\ntoken = \"{}\"\nroles = [\"viewer\"]", "é".repeat(20)), "has 20 characters"),
        ] {
            let error = text.parse::<Tokens>().err().map(|error| error.to_string()).unwrap_or_default();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn tokens_that_could_be_guessed_are_found() {
        for (token, expected) in [
            ("the-projector-in-the-hall", vec![1]),
            ("0000000000000000", vec![1]),
            ("abababababababa1", vec![1]),
            ("3f0c9a517be2d846", vec![]),
            ("red-0123456789abcdef", vec![]),
        ] {
            let tokens: Tokens = format!("[[token]]\ntoken = \"{token}\"\nroles = [\"viewer\"]").parse().unwrap();
            assert_eq!(tokens.guessable().collect::<Vec<_>>(), expected, "{token}");
        }
    }

    #[test]
    fn an_error_or_a_debug_text_shows_no_token() {
        let secret = "secret-0123456789";
        for text in [
            format!("[[token]]\ntoken = \"{secret}\"\nroles = [\"king\"]"),
            format!("[[token]]\nroles = [\"viewer\"]\ntoken = \"{secret}"),
            format!("[[token]]\ntoken = \"{secret}}}\"\nroles = [\"viewer\"]"),
            format!("[[token]]\ntoken = {secret}\nroles = [\"viewer\"]"),
            format!("token = \"{secret}\""),
            format!("\"{secret}\""),
        ] {
            let error = text.parse::<Tokens>().err().unwrap();
            assert!(!error.to_string().contains(secret), "{error}");
        }
        assert_eq!(format!("{:?}", tokens()), "Access(Some(Tokens(2)))");
    }

    #[test]
    fn tokens_give_their_roles_and_no_others() {
        let access = tokens();
        let wrong = RED.replace('f', "e");
        for (token, wanted, expected) in [
            (Some(RED), &[Role::Driver][..], None),
            (Some(RED), &[Role::Driver, Role::Referee], None),
            (Some(REFEREE), &[Role::Driver, Role::Referee], None),
            (Some(RED), &[Role::Viewer], Some("the token has not the role viewer")),
            (Some(REFEREE), &[Role::Driver], Some("the token has not the role driver")),
            (Some(&wrong), &[Role::Driver], Some("the token is unknown")),
            (Some(&RED[..19]), &[Role::Driver], Some("the token is unknown")),
            (Some(""), &[Role::Driver], Some("the token is unknown")),
            (None, &[Role::Driver], Some("there is no token")),
        ] {
            let refusal = access.rights(token, wanted).err().map(|refusal| refusal.to_string());
            assert_eq!(refusal.as_deref(), expected, "{token:?} {wanted:?}");
        }
        assert!(Access::new(None).rights(None, &[Role::Referee]).is_ok());
    }

    #[test]
    fn an_init_needs_its_right_and_gets_its_team() {
        let (access, anywhere) = (tokens(), &[Role::Driver, Role::Referee][..]);
        let no_referee =
            "no world controller or avatar from here: only a token with the role referee controls this world";
        for (token, line, expected) in [
            (RED, "INIT {ClassName P3AT}", Ok("INIT {Team red} {ClassName P3AT}")),
            (RED, "INIT{ClassName P3AT} {Name x", Ok("INIT {Team red} {ClassName P3AT} {Name x")),
            (RED, "init", Ok("init {Team red} ")),
            (RED, "INIT {ClassName P3AT} {Team RED}", Ok("INIT {ClassName P3AT} {Team RED}")),
            (
                RED,
                "INIT {ClassName P3AT} {Team blue}",
                Err("{Team blue}: expected red, the team of the connection's token"),
            ),
            (RED, "INIT {ClassName USARBotAPI.WorldController}", Err(no_referee)),
            (RED, "DRIVE {Left 1}", Ok("DRIVE {Left 1}")),
            (RED, "INIT {ClassName USARAvatar.USARAvatarNewMale}", Err(no_referee)),
            (REFEREE, "INIT {ClassName WorldController}", Ok("INIT {ClassName WorldController}")),
            (REFEREE, "INIT {ClassName P3AT}", Err("the connection's token has not the role driver")),
        ] {
            let rights = access.rights(Some(token), anywhere).unwrap();
            let here = IpAddr::from([127, 0, 0, 1]);
            let refusal = access.refusal(&rights, WorldControl::Everyone, here, here);
            let got = rights.admit(Request::read(Ok(line.to_owned())), refusal);
            match expected {
                Ok(text) => assert_eq!((got.text.as_str(), got.command.is_some()), (text, true), "{line}"),
                Err(why) => {
                    assert_eq!(got.problems, [Problem::NotAdmitted { why: why.to_owned() }], "{line}");
                    assert!(got.command.is_none() && got.text.is_empty(), "{line}");
                }
            }
        }
    }

    #[test]
    fn with_tokens_a_role_controls_the_world_and_not_an_address() {
        let access = tokens();
        let [here, there] = [[127, 0, 0, 1], [10, 0, 0, 7]].map(IpAddr::from);
        for (token, control, peer, may) in [
            (REFEREE, WorldControl::Local, there, true),
            (REFEREE, WorldControl::Nobody, here, false),
            (RED, WorldControl::Everyone, here, false),
        ] {
            let rights = access.rights(Some(token), &Role::ALL).unwrap();
            assert_eq!(access.refusal(&rights, control, peer, here).is_none(), may, "{token} {control:?} {peer}");
        }
    }
}
