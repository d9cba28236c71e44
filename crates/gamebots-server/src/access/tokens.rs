//! Tokens of clients, and the roles that each gives: watch, drive, control the world.
//!
//! Without tokens everybody has every right. With tokens nobody has any without one: the first line to a port is `LOGIN {Token ..}`, and the
//! page sends its token with every request.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::Deserialize;
use subtle::ConstantTimeEq;

/// Lengths of a token, characters. 16 random ones cannot be guessed.
const LENGTHS: std::ops::RangeInclusive<usize> = 16..=128;
/// Fewest different characters of a random token. 16 hexadecimal digits have fewer in one of a thousand tokens.
const FEWEST_CHARACTERS: usize = 7;
/// Most tokens.
const MAX_TOKENS: usize = 1000;

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
    pub(crate) const ALL: [Self; 3] = [Self::Viewer, Self::Driver, Self::Referee];

    pub(crate) fn name(self) -> &'static str {
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

/// A token, its roles, and the only team that it may drive for.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Token {
    token: String,
    pub(crate) roles: Vec<Role>,
    pub(crate) team: Option<String>,
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
    pub(crate) fn find(&self, text: &str) -> Option<&Token> {
        let is_it = |token: &&Token| bool::from(token.token.as_bytes().ct_eq(text.as_bytes()));
        self.0.iter().filter(is_it).fold(None, |_, token| Some(token))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let tokens: Tokens = format!("[[token]]\ntoken = \"{secret}\"\nroles = [\"viewer\"]").parse().unwrap();
        assert_eq!(format!("{tokens:?}"), "Tokens(1)");
    }
}
