//! Unreal's ini files: sections, entries, and values in parentheses. It knows no name of USARSim.

use std::fmt;

/// Deepest nesting of parentheses in a value. An item of USARSim has two levels.
const MOST_DEEP: usize = 8;

/// A section, `[Package.Class]`, and its entries. A file may have several of the same name.
pub(super) struct Section<'a> {
    pub(super) name: &'a str,
    pub(super) entries: Vec<Entry<'a>>,
}

/// An entry, `Key=Value`.
pub(super) struct Entry<'a> {
    /// Byte offset of the line's first character in the text.
    pub(super) at: usize,
    /// Character before the key that changes a list: `+`, `.`, `-` or `!`.
    pub(super) prefix: Option<char>,
    pub(super) key: &'a str,
    /// Value without comments.
    pub(super) value: &'a str,
    /// Byte offset of the value in the text.
    pub(super) value_at: usize,
}

/// A value: a word, with its quotes removed, or fields in parentheses.
#[derive(Debug, PartialEq)]
pub(super) enum Value<'a> {
    Word(&'a str),
    Fields(Vec<Field<'a>>),
}

/// A field of a value in parentheses, `Name=Value`. Elements of a list have an empty name.
#[derive(Debug, PartialEq)]
pub(super) struct Field<'a> {
    /// Byte offset in the text.
    pub(super) at: usize,
    pub(super) name: &'a str,
    pub(super) value: Value<'a>,
}

/// A mistake in the syntax.
#[derive(Debug, PartialEq)]
pub(super) struct Mistake {
    /// Byte offset in the text.
    pub(super) at: usize,
    pub(super) message: &'static str,
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.message)
    }
}

/// Decodes UTF-8, or UTF-16 with a byte order mark. Other bytes are characters of Latin 1, as old Windows programs wrote them. `None` if
/// it is no text.
pub(super) fn decode(bytes: &[u8]) -> Option<String> {
    let units =
        |of: fn([u8; 2]) -> u16| bytes.as_chunks::<2>().0.iter().skip(1).map(|&pair| of(pair)).collect::<Vec<u16>>();
    let text = match bytes {
        [0xff, 0xfe, ..] => String::from_utf16_lossy(&units(u16::from_le_bytes)),
        [0xfe, 0xff, ..] => String::from_utf16_lossy(&units(u16::from_be_bytes)),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => str::from_utf8(bytes).map_or_else(|_| bytes.iter().copied().map(char::from).collect(), str::to_owned),
    };
    (!text.contains('\0')).then_some(text)
}

/// Splits a text into sections. Lines that are neither a section, an entry nor a comment are mistakes.
pub(super) fn sections(text: &str) -> (Vec<Section<'_>>, Vec<Mistake>) {
    let (mut sections, mut mistakes): (Vec<Section>, _) = (Vec::new(), Vec::new());
    let mut end = 0;
    for line in text.split_inclusive(['\n', '\r']) {
        let start = end;
        end += line.len();
        let trimmed = line.trim();
        let at = start + (line.len() - line.trim_start().len());
        if trimmed.is_empty() || [";", "//", "#"].iter().any(|begin| trimmed.starts_with(begin)) {
            continue;
        }
        if let Some(rest) = trimmed.strip_prefix('[') {
            match rest.split_once(']') {
                Some((name, _)) => sections.push(Section { name: name.trim(), entries: Vec::new() }),
                None => mistakes.push(Mistake { at, message: "expected `]` at the end of the section's name" }),
            }
            continue;
        }
        let Some((key, value)) = trimmed.split_once('=') else {
            mistakes.push(Mistake { at, message: "expected a [section], a key=value or a comment" });
            continue;
        };
        let value_at = at + key.len() + 1 + (value.len() - value.trim_start().len());
        let (prefix, key) = match key.chars().next() {
            Some(prefix @ ('+' | '.' | '-' | '!')) => (Some(prefix), &key[1..]),
            _ => (None, key),
        };
        // An element of a list may have its number: `Sensors[0]`.
        let key = key.split('[').next().unwrap_or_default().trim();
        let entry = Entry { at, prefix, key, value: without_comment(value.trim_start()).trim_end(), value_at };
        // Entries before the first section belong to nothing.
        if let Some(section) = sections.last_mut() {
            section.entries.push(entry);
        }
    }
    (sections, mistakes)
}

/// Returns a value up to a comment, `;` or `//`, outside of quotes.
fn without_comment(value: &str) -> &str {
    let mut quoted = false;
    let is_end = |(place, character): (usize, char)| {
        quoted ^= character == '"';
        (!quoted && (character == ';' || value[place..].starts_with("//"))).then_some(place)
    };
    let end = value.char_indices().find_map(is_end);
    &value[..end.unwrap_or(value.len())]
}

/// Reads the fields of a value in parentheses. Text behind them is ignored, as Unreal ignores it. `at` is the offset of the value.
pub(super) fn fields(value: &str, at: usize) -> Result<Vec<Field<'_>>, Mistake> {
    let mut reader = Reader { text: value, place: 0, at };
    reader.skip_blanks();
    reader.fields(0)
}

/// A position in a value.
struct Reader<'a> {
    text: &'a str,
    place: usize,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        self.text.get(self.place..).unwrap_or_default()
    }

    fn skip_blanks(&mut self) {
        self.place += self.rest().len() - self.rest().trim_start().len();
    }

    /// Skips a character if it comes next.
    fn takes(&mut self, character: char) -> bool {
        let is_next = self.rest().starts_with(character);
        self.place += if is_next { character.len_utf8() } else { 0 };
        is_next
    }

    fn mistake(&self, message: &'static str) -> Mistake {
        Mistake { at: self.at + self.place, message }
    }

    fn fields(&mut self, depth: usize) -> Result<Vec<Field<'a>>, Mistake> {
        if depth > MOST_DEEP {
            return Err(self.mistake("expected at most 8 parentheses inside each other"));
        }
        if !self.takes('(') {
            return Err(self.mistake("expected `(`"));
        }
        let mut fields = Vec::new();
        loop {
            self.skip_blanks();
            if self.takes(')') {
                return Ok(fields);
            }
            if self.takes(',') {
                continue;
            }
            if self.rest().is_empty() {
                return Err(self.mistake("expected `)`"));
            }
            let at = self.at + self.place;
            let name = self.until(&['=', ',', '(', ')']).trim();
            if self.takes('=') {
                self.skip_blanks();
                fields.push(Field { at, name, value: self.value(depth)? });
            } else if name.is_empty() {
                fields.push(Field { at, name, value: self.value(depth)? });
            } else {
                fields.push(Field { at, name: "", value: Value::Word(unquoted(name)) });
            }
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value<'a>, Mistake> {
        if self.rest().starts_with('(') {
            return self.fields(depth + 1).map(Value::Fields);
        }
        Ok(Value::Word(unquoted(self.until(&[',', ')']).trim())))
    }

    /// Returns the text up to one of these characters outside of double quotes, or to the end.
    fn until(&mut self, ends: &[char]) -> &'a str {
        let mut quoted = false;
        let rest = self.rest();
        let is_end = |&(_, character): &(usize, char)| {
            quoted ^= character == '"';
            !quoted && ends.contains(&character)
        };
        let end = rest.char_indices().find(is_end).map_or(rest.len(), |(end, _)| end);
        self.place += end;
        &rest[..end]
    }
}

fn unquoted(word: &str) -> &str {
    word.strip_prefix('"').map_or(word, |word| word.strip_suffix('"').unwrap_or(word))
}

/// Reads a number as C does: `.1`, `1.`, `+1` and `0.5f` are numbers. `None` for anything else, and for what is not finite.
pub(super) fn number(word: &str) -> Option<f64> {
    let word = word.trim();
    let ends_in_digit = |text: &&str| text.ends_with(|last: char| last.is_ascii_digit() || last == '.');
    let word = word.strip_suffix(['f', 'F']).filter(ends_in_digit).unwrap_or(word);
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Reads a truth value.
pub(super) fn boolean(word: &str) -> Option<bool> {
    let is_one_of = |known: [&str; 4]| known.iter().any(|known| known.eq_ignore_ascii_case(word.trim()));
    if is_one_of(["true", "1", "yes", "on"]) {
        Some(true)
    } else {
        is_one_of(["false", "0", "no", "off"]).then_some(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists the entries of a text as `section key=value`.
    fn entries(text: &str) -> Vec<String> {
        let (sections, _) = sections(text);
        let all = sections.iter().flat_map(|section| section.entries.iter().map(move |entry| (section.name, entry)));
        let shown = |(name, it): (&str, &Entry)| {
            assert!(text[it.value_at..].starts_with(it.value), "{}", it.value);
            format!("{name} {}{}={}", it.prefix.map(String::from).unwrap_or_default(), it.key, it.value)
        };
        all.map(shown).collect()
    }

    #[test]
    fn lines_are_sections_entries_and_comments() {
        let cases: [(&str, &[&str]); 12] = [
            ("[A.B]\nKey=1\r\nOther = 2 \r\n", &["A.B Key=1", "A.B Other=2"]),
            ("[ A ] ; note\r\rKey=x", &["A Key=x"]),
            ("Lost=1\n[A]\n", &[]),
            ("[A]\n; Key=1\n//Key=2\n  # Key=3\n", &[]),
            ("[A]\nKey=0.349;\nKey=1 // one\nKey=2;x=3", &["A Key=0.349", "A Key=1", "A Key=2"]),
            ("[A]\nKey=\"a;b//c\";d", &["A Key=\"a;b//c\""]),
            ("[A]\nList=(X=1,Y=\";\") ; z", &["A List=(X=1,Y=\";\")"]),
            ("[A]\n+K=1\n.K=2\n-K=3\n!K=\n", &["A +K=1", "A .K=2", "A -K=3", "A !K="]),
            ("[A]\nSensors[0]=(X=1)\nSensors[12] =(X=2)", &["A Sensors=(X=1)", "A Sensors=(X=2)"]),
            ("[A]\n[B]\nK=\n[A]\nK=1", &["B K=", "A K=1"]),
            ("[A]\nK==1", &["A K==1"]),
            ("[A]\n=1", &["A =1"]),
        ];
        for (text, expected) in cases {
            assert_eq!(entries(text), expected, "{text:?}");
        }
    }

    #[test]
    fn other_lines_are_mistakes_with_their_place() {
        let (sections, mistakes) = sections("[A]\n  word\n[B\nK=1\n");
        let places: Vec<usize> = mistakes.iter().map(|it| it.at).collect();
        assert_eq!(places, [6, 11]);
        assert_eq!(sections.len(), 1);
    }

    #[test]
    fn values_in_parentheses_have_fields() {
        use Value::{Fields, Word};
        let field = |at, name, value| Field { at, name, value };
        let cases = [
            ("()", Ok(vec![])),
            ("( X = 1 , Y=\"a, b)\" )", Ok(vec![field(2, "X", Word("1")), field(10, "Y", Word("a, b)"))])),
            ("(C=class'P.C',D=)", Ok(vec![field(1, "C", Word("class'P.C'")), field(14, "D", Word(""))])),
            (
                "(P=(X=1.5,y=-.2)) tail",
                Ok(vec![field(1, "P", Fields(vec![field(4, "X", Word("1.5")), field(10, "y", Word("-.2"))]))]),
            ),
            ("(\"a\",(b))", Ok(vec![field(1, "", Word("a")), field(5, "", Fields(vec![field(6, "", Word("b"))]))])),
            ("X=1", Err(Mistake { at: 0, message: "expected `(`" })),
            ("(X=1", Err(Mistake { at: 4, message: "expected `)`" })),
            ("(X=(Y=1)", Err(Mistake { at: 8, message: "expected `)`" })),
        ];
        for (text, expected) in cases {
            assert_eq!(fields(text, 0), expected, "{text}");
        }
        assert!(fields(&"(X=".repeat(1000), 0).is_err());
        assert!(fields(&format!("{}{}", "(X=".repeat(8), ")".repeat(8)), 0).is_ok());
    }

    #[test]
    fn numbers_are_those_of_c_and_finite() {
        for (word, expected) in [
            (".1", Some(0.1)),
            ("-.2", Some(-0.2)),
            ("+1.", Some(1.0)),
            ("0.5f", Some(0.5)),
            ("1.f", Some(1.0)),
            ("1e-3", Some(0.001)),
            (" 7 ", Some(7.0)),
            ("inf", None),
            ("NaN", None),
            ("1e999", None),
            ("", None),
            ("0,5", None),
            ("f", None),
            ("0x10", None),
        ] {
            assert_eq!(number(word), expected, "{word}");
        }
        assert_eq!(
            ["True", "FALSE", "1", "no", "2", ""].map(boolean),
            [Some(true), Some(false), Some(true), Some(false), None, None]
        );
    }

    #[test]
    fn every_encoding_of_windows_is_text() {
        let utf16 = |of: fn(u16) -> [u8; 2]| "\u{feff}[A]\nK=ü".encode_utf16().flat_map(of).collect::<Vec<u8>>();
        let cases: [&[u8]; 4] =
            ["[A]\nK=ü".as_bytes(), "\u{feff}[A]\nK=ü".as_bytes(), &utf16(u16::to_le_bytes), &utf16(u16::to_be_bytes)];
        for bytes in cases {
            assert_eq!(decode(bytes).as_deref(), Some("[A]\nK=ü"), "{bytes:?}");
        }
        assert_eq!(decode(b"K=\xfc").as_deref(), Some("K=ü"));
        assert_eq!(decode(b"K=\0"), None);
        assert_eq!(decode(b"\xff\xfeK"), Some(String::new()));
    }
}
