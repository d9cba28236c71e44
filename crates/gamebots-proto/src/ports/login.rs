//! `LOGIN {Token t}`: the first line to every port of a server with tokens. USARSim has no such line.

use crate::Line;

/// Writes a login, without its end.
pub fn login(token: &str) -> String {
    Line::new("LOGIN").with("Token", token).to_string()
}

/// Returns the token of a login; empty if it has none. `None` for another line.
pub fn read_login(text: &str) -> Option<String> {
    let line = Line::parse(text);
    line.verb.eq_ignore_ascii_case("LOGIN").then(|| line.get("Token").unwrap_or_default().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_login_is_read_in_any_case_and_nothing_else_is_one() {
        for (text, token) in [
            ("LOGIN {Token abc}", Some("abc")),
            ("login{token  abc }", Some("abc")),
            ("LOGIN", Some("")),
            ("LOGIN {Token abc", Some("")),
            ("INIT {Token abc}", None),
            ("GET /?LOGIN HTTP/1.1", None),
            ("", None),
        ] {
            assert_eq!(read_login(text).as_deref(), token, "{text}");
        }
        assert_eq!(read_login(&login("a-b_c")).as_deref(), Some("a-b_c"));
    }
}
