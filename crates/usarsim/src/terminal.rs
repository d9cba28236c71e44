//! Untrusted text, made safe for a terminal.

use std::borrow::Cow;

/// Escapes the control characters in a text, except newline and tab. A line of a server, a client or a log must not move the cursor, change
/// colours or fill the clipboard.
///
/// DEL and the controls from U+0080 on become `\u009b`, which JSON reads back: JSON itself escapes only those below U+0020. So the output
/// of `--json` stays JSON.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    let is_harmful = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(is_harmful) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '\r' => safe.push_str("\\r"),
            _ if !is_harmful(c) => safe.push(c),
            '\0'..='\x1f' => safe.push_str(&format!("\\x{:02x}", c as u32)),
            _ => safe.push_str(&format!("\\u{:04x}", c as u32)),
        }
    }
    safe.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_escaped_and_all_others_kept() {
        for (text, expected) in [
            ("SEN {Time 1.0}\tµ é 机\n", "SEN {Time 1.0}\tµ é 机\n"),
            ("\x1b]52;c;aGk=\x07", "\\x1b]52;c;aGk=\\x07"),
            ("a\x1b[2Jb\rc\0", "a\\x1b[2Jb\\rc\\x00"),
            ("\u{9b}2J\u{7f}\u{85}", "\\u009b2J\\u007f\\u0085"),
        ] {
            assert_eq!(printable(text), expected);
        }
    }

    #[test]
    fn escaped_json_reads_as_the_same_text() {
        let text = (0..0x100).filter_map(char::from_u32).collect::<String>();
        let json = serde_json::to_string(&text).expect("a text");
        let safe = printable(&json).into_owned();
        assert!(!safe.contains(char::is_control), "{safe:?}");
        assert_eq!(serde_json::from_str::<String>(&safe).expect("a text"), text);
    }
}
