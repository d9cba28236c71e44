//! Untrusted text, made safe for a terminal.

use std::borrow::Cow;

/// Characters that a terminal does not show but follows: format characters of Unicode (category Cf), which turn the text round or hide
/// parts of it, and its two line separators.
const FORMATS: [std::ops::RangeInclusive<char>; 19] = [
    '\u{ad}'..='\u{ad}',
    '\u{600}'..='\u{605}',
    '\u{61c}'..='\u{61c}',
    '\u{6dd}'..='\u{6dd}',
    '\u{70f}'..='\u{70f}',
    '\u{890}'..='\u{891}',
    '\u{8e2}'..='\u{8e2}',
    '\u{180e}'..='\u{180e}',
    '\u{200b}'..='\u{200f}',
    '\u{2028}'..='\u{202e}',
    '\u{2060}'..='\u{206f}',
    '\u{feff}'..='\u{feff}',
    '\u{fff9}'..='\u{fffb}',
    '\u{110bd}'..='\u{110bd}',
    '\u{110cd}'..='\u{110cd}',
    '\u{13430}'..='\u{1343f}',
    '\u{1bca0}'..='\u{1bca3}',
    '\u{1d173}'..='\u{1d17a}',
    '\u{e0000}'..='\u{e007f}',
];

fn is_harmful(c: char) -> bool {
    c.is_control() && !matches!(c, '\n' | '\t') || FORMATS.iter().any(|range| range.contains(&c))
}

/// Escapes the control and format characters in a text, except newline and tab. A line of a server, a client or a log must not move the
/// cursor, change colours, turn the text round or fill the clipboard.
///
/// DEL and the characters from U+0080 on become `\u009b`, which JSON reads back: JSON itself escapes only those below U+0020. So the output
/// of `--json` stays JSON.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_harmful) {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            '\r' => safe.push_str("\\r"),
            _ if !is_harmful(c) => safe.push(c),
            '\0'..='\x1f' => safe.push_str(&format!("\\x{:02x}", c as u32)),
            // JSON writes characters beyond U+FFFF as two.
            _ => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| safe.push_str(&format!("\\u{unit:04x}"))),
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
            ("a\u{202e}b\u{2066}c\u{2069}", "a\\u202eb\\u2066c\\u2069"),
            ("\u{200b}\u{feff}\u{2028}\u{ad}", "\\u200b\\ufeff\\u2028\\u00ad"),
            ("\u{e0041}", "\\udb40\\udc41"),
            ("שלום עليكم é 机 🤖", "שלום עليكم é 机 🤖"),
        ] {
            assert_eq!(printable(text), expected);
        }
    }

    #[test]
    fn escaped_json_reads_as_the_same_text() {
        let formats = FORMATS.into_iter().flatten();
        let text = (0..0x100).filter_map(char::from_u32).chain(formats).collect::<String>();
        let json = serde_json::to_string(&text).expect("a text");
        let safe = printable(&json).into_owned();
        assert!(!safe.contains(is_harmful), "{safe:?}");
        assert_eq!(serde_json::from_str::<String>(&safe).expect("a text"), text);
    }
}
