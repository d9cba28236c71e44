//! Rights of connections: the roles that they have, and what that admits.

use std::net::IpAddr;
use std::time::Duration;

use gamebots_proto::ports::read_login;
use gamebots_proto::{Command, Problem};
use sessions::Request;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::access::tokens::{Role, Token, Tokens};

/// Longest LOGIN line, bytes.
const MAX_LOGIN: usize = 512;
/// Longest time for a LOGIN line.
pub(crate) const LOGIN_TIME: Duration = Duration::from_secs(10);

/// Viewers that may control the world: pause, step, speed, reset, record, save, remove, map. Every other viewer can still watch, and drive
/// its own robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WorldControl {
    /// Every page, and Foxglove.
    Everyone,
    /// Pages that are open on the server's own machine, also through a tunnel that ends there. Foxglove is excluded, because
    /// its clients cannot be told apart.
    Local,
    /// Nobody.
    Nobody,
}

impl WorldControl {
    /// Returns the reason to refuse a page's requests, if any. `peer` is the page's address, `own` the server's in that
    /// connection.
    pub(crate) fn refusal(self, peer: IpAddr, own: IpAddr) -> Option<&'static str> {
        let (peer, own) = (peer.to_canonical(), own.to_canonical());
        match self {
            Self::Everyone => None,
            Self::Local if peer.is_loopback() || peer == own => None,
            Self::Local => Some("only pages that are open on the server's own machine control this world"),
            Self::Nobody => Some("no page controls this world"),
        }
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
            Request { text: String::new(), command: None, problems, pawn: None }
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
    fn a_page_is_local_by_loopback_or_by_the_same_address_at_both_ends() {
        for (peer, own, local) in [
            ("127.0.0.1", "127.0.0.1", true),
            ("127.0.0.2", "127.0.0.1", true),
            ("::1", "::1", true),
            ("::ffff:127.0.0.1", "::ffff:127.0.0.1", true),
            ("192.168.1.7", "192.168.1.7", true),
            ("::ffff:192.168.1.7", "192.168.1.7", true),
            ("192.168.1.8", "192.168.1.7", false),
            ("fe80::2", "fe80::1", false),
        ] {
            let [peer, own] = [peer, own].map(|it| it.parse().unwrap_or_else(|_| panic!("{it}")));
            let controls = [WorldControl::Everyone, WorldControl::Local, WorldControl::Nobody];
            let may = controls.map(|control| control.refusal(peer, own).is_none());
            assert_eq!(may, [true, local, false], "{peer} at {own}");
        }
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
