//! XML as the field reads it. Readers of ROS and Gazebo (TinyXML-2) take files that XML's specification refuses, and files of other
//! encodings than UTF-8. [`lenient`] turns such a text into one that the strict library takes. Lines stay where they are.

use std::borrow::Cow;
use std::collections::BTreeSet;

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use roxmltree::{Document, ParsingOptions};

/// Maximum number of namespace declarations: the XML library copies them to every element that declares one more.
const MAX_NAMESPACES: usize = 100;
/// Bytes in which a declaration is looked for.
const HEAD: usize = 200;

/// A text that is no XML.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub(crate) struct NotXml {
    /// Place of the mistake, bytes.
    pub(crate) offset: usize,
    message: String,
}

/// Decodes a file by its byte order mark or its declaration. Bytes that are no UTF-8, where nothing else is said, are those of Windows.
pub(crate) fn decode(bytes: &[u8]) -> String {
    if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
        return lenient(&encoding.decode_without_bom_handling(&bytes[mark..]).0).into_owned();
    }
    let head = &bytes[..bytes.len().min(HEAD)];
    let encoding = match head {
        [b'<', 0, ..] => UTF_16LE,
        [0, b'<', ..] => UTF_16BE,
        _ => {
            let head = String::from_utf8_lossy(head);
            let declared =
                head.split_once("?>").and_then(|(head, _)| head.split_once("encoding")).map(|(_, rest)| rest);
            let label = declared.and_then(|rest| rest.split(['"', '\'']).nth(1));
            let declared = label.and_then(|label| Encoding::for_label(label.as_bytes())).unwrap_or(UTF_8);
            // A text whose declaration can be read has one byte a letter, whatever it says.
            if [UTF_16LE, UTF_16BE].contains(&declared) { UTF_8 } else { declared }
        }
    };
    let (text, has_errors) = encoding.decode_without_bom_handling(bytes);
    let text = if has_errors && encoding == UTF_8 { WINDOWS_1252.decode_without_bom_handling(bytes).0 } else { text };
    lenient(&text).into_owned()
}

/// Parses a text, with at most so many elements, attributes and texts.
pub(crate) fn parse(text: &str, most: u32) -> Result<Document<'_>, NotXml> {
    let namespaces = text.matches("xmlns").count();
    if namespaces > MAX_NAMESPACES {
        let message = format!("{namespaces} namespaces: expected at most {MAX_NAMESPACES}");
        return Err(NotXml { offset: 0, message });
    }
    let options = ParsingOptions { nodes_limit: most, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        let place = error.pos();
        let line_start: usize = text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
        let line = text.get(line_start..).and_then(|rest| rest.lines().next()).unwrap_or_default();
        let column = line.char_indices().nth(place.col as usize - 1).map_or(line.len(), |(at, _)| at);
        NotXml { offset: line_start + column, message: format!("not XML: {error}") }
    })
}

/// Returns a text that the strict library takes, if the field's readers take the given one:
///
/// * comments with `--` in them
/// * prefixes that nobody declares, and names with several colons: a colon becomes `_`, but that of `xacro`, which has to be expanded
/// * a declaration after white space, and document types, which are left out
/// * an attribute that is there twice: the first counts
/// * `&` and `<` that begin nothing
/// * characters that XML does not have
/// * attributes without quotes, or without a space between them
/// * texts and further elements behind the root
pub(crate) fn lenient(text: &str) -> Cow<'_, str> {
    let declared = declared_prefixes(text);
    let mut made = Lenient { text, made: String::with_capacity(text.len() + 16), declared, depth: 0, is_over: false };
    made.document();
    if made.made == text { Cow::Borrowed(text) } else { Cow::Owned(made.made) }
}

/// Lists the prefixes that a text declares anywhere.
fn declared_prefixes(text: &str) -> BTreeSet<&str> {
    let after = text.split("xmlns:").skip(1);
    let name = |rest: &'_ str| rest.find(|c: char| !is_name(c)).unwrap_or(rest.len());
    let mut prefixes: BTreeSet<&str> = after.map(|rest| &rest[..name(rest)]).collect();
    // Those of XML itself, and one whose use has a message of its own.
    prefixes.extend(["xml", "xmlns", "xacro"]);
    prefixes
}

fn is_name(c: char) -> bool {
    c.is_alphanumeric() || "_:.-".contains(c) || !c.is_ascii()
}

/// A text under construction.
struct Lenient<'a> {
    text: &'a str,
    made: String,
    declared: BTreeSet<&'a str>,
    /// Number of open elements.
    depth: usize,
    /// True after the root's end.
    is_over: bool,
}

impl<'a> Lenient<'a> {
    fn document(&mut self) {
        let mut rest = self.text;
        while let Some(at) = rest.find('<') {
            let (before, markup) = rest.split_at(at);
            self.characters(before);
            rest = self.markup(markup);
        }
        self.characters(rest);
    }

    /// Leaves out a piece; its lines stay.
    fn leave_out(&mut self, piece: &str) {
        self.made.extend(piece.chars().filter(|c| *c == '\n'));
    }

    /// Adds text between elements.
    fn characters(&mut self, text: &str) {
        if self.depth == 0 {
            self.leave_out(text);
        } else {
            self.content(text);
        }
    }

    /// Adds text, or the value of an attribute.
    fn content(&mut self, text: &str) {
        for (at, c) in text.char_indices() {
            self.made.push(match c {
                '&' if !is_reference(&text[at..]) => '+',
                '<' => '(',
                '\t' | '\n' | '\r' => c,
                c if c.is_control() && (c as u32) < 0x20 || matches!(c, '\u{fffe}' | '\u{ffff}') => ' ',
                c => c,
            });
        }
    }

    /// Adds one piece of markup. Returns the text behind it.
    fn markup(&mut self, text: &'a str) -> &'a str {
        if let Some(comment) = text.strip_prefix("<!--") {
            let (inside, rest) = comment.split_once("-->").unwrap_or((comment, ""));
            self.made.push_str("<!--");
            let is_good = !inside.contains("--") && !inside.ends_with('-');
            let calm = if is_good { Cow::Borrowed(inside) } else { Cow::Owned(inside.replace('-', "~")) };
            self.made.extend(calm.chars().map(|c| if c.is_control() && !c.is_whitespace() { ' ' } else { c }));
            self.made.push_str("-->");
            return rest;
        }
        if text.starts_with("<![CDATA[") {
            let end = text.find("]]>").map_or(text.len(), |at| at + 3);
            if self.depth > 0 {
                self.made.push_str(&text[..end]);
            }
            return &text[end..];
        }
        if text.starts_with("<!") {
            let end = end_of_type(text);
            self.leave_out(&text[..end]);
            return &text[end..];
        }
        if text.starts_with("<?") {
            let end = text.find("?>").map_or(text.len(), |at| at + 2);
            self.leave_out(&text[..end]);
            return &text[end..];
        }
        let begins = text[1..].strip_prefix('/').unwrap_or(&text[1..]).chars().next();
        if !begins.is_some_and(|c| c.is_alphabetic() || c == '_' || c == ':' || !c.is_ascii()) {
            // Nothing begins here.
            self.characters("<");
            return &text[1..];
        }
        self.tag(text)
    }

    /// Adds the tag of an element. Returns the text behind it.
    fn tag(&mut self, text: &'a str) -> &'a str {
        let start = self.made.len();
        let is_end = text.starts_with("</");
        let (open, mut rest) = text.split_at(if is_end { 2 } else { 1 });
        self.made.push_str(open);
        rest = self.name(rest);
        let mut seen = BTreeSet::new();
        let is_empty = loop {
            let trimmed = rest.trim_start();
            let space = &rest[..rest.len() - trimmed.len()];
            self.made.push_str(space);
            rest = trimmed;
            if let Some(behind) = rest.strip_prefix("/>") {
                self.made.push_str("/>");
                rest = behind;
                break true;
            }
            if let Some(behind) = rest.strip_prefix('>') {
                self.made.push('>');
                rest = behind;
                break false;
            }
            let Some(value) = attribute(rest) else {
                // The strict library says what is wrong here.
                let end = rest.find('>').map_or(rest.len(), |at| at + 1);
                self.made.push_str(&rest[..end]);
                rest = &rest[end..];
                break false;
            };
            let (key, value, quote, behind) = value;
            if seen.insert(key) {
                if space.is_empty() {
                    self.made.push(' ');
                }
                self.name(key);
                self.made.push('=');
                self.made.push(quote);
                self.content(value);
                self.made.push(quote);
            } else {
                self.leave_out(value);
            }
            rest = behind;
        };
        let is_behind = self.is_over && self.depth == 0;
        match (is_end, is_empty) {
            (true, _) => self.depth = self.depth.saturating_sub(1),
            (false, true) => {}
            (false, false) => self.depth += 1,
        }
        if is_behind {
            // A second root: it is left out as a whole, as depth stays zero.
            let piece = self.made.split_off(start);
            self.leave_out(&piece);
            self.depth = 0;
        }
        self.is_over |= self.depth == 0;
        rest
    }

    /// Adds a name. Returns the text behind it.
    fn name(&mut self, text: &'a str) -> &'a str {
        let end = text.find(|c| !is_name(c)).unwrap_or(text.len());
        let (name, rest) = text.split_at(end);
        match name.split_once(':') {
            Some((prefix, local)) if self.declared.contains(prefix) && !local.is_empty() => {
                self.made.push_str(prefix);
                self.made.push(':');
                self.made.push_str(&local.replace(':', "_"));
            }
            _ => self.made.push_str(&name.replace(':', "_")),
        }
        rest
    }
}

/// Splits an attribute at the begin of a text: name, value, quote, and the text behind it.
fn attribute(text: &str) -> Option<(&str, &str, char, &str)> {
    let end = text.find(|c| !is_name(c)).filter(|end| *end > 0)?;
    let (key, rest) = text.split_at(end);
    let rest = rest.trim_start().strip_prefix('=')?.trim_start();
    match rest.chars().next()? {
        quote @ ('"' | '\'') => {
            let (value, behind) = rest[1..].split_once(quote)?;
            Some((key, value, quote, behind))
        }
        _ => {
            // A bare word ends at a space or with the tag.
            let end = rest.find(|c: char| c.is_whitespace() || c == '>')?;
            let (value, behind) = rest.split_at(end);
            let value = if behind.starts_with('>') { value.strip_suffix('/').unwrap_or(value) } else { value };
            Some((key, value, '"', &rest[value.len()..]))
                .filter(|_| !value.is_empty() && !value.contains(['"', '\'', '<']))
        }
    }
}

/// True if a text begins with a reference that XML knows without a document type.
fn is_reference(text: &str) -> bool {
    /// Longest name or number.
    const LONGEST: usize = 8;
    let Some(end) = text.bytes().skip(1).take(LONGEST + 1).position(|c| c == b';') else { return false };
    let name = &text[1..=end];
    let number = name.strip_prefix('#').map(|number| match number.strip_prefix('x') {
        Some(digits) => u32::from_str_radix(digits, 16),
        None => number.parse(),
    });
    let is_character = |code: u32| char::from_u32(code).is_some_and(|c| !c.is_control() || "\t\n\r".contains(c));
    ["amp", "lt", "gt", "quot", "apos"].contains(&name) || number.is_some_and(|code| code.is_ok_and(is_character))
}

/// Returns the end of a document type at the begin of a text. It may have a list of declarations in brackets.
fn end_of_type(text: &str) -> usize {
    let mut depth = 0_i32;
    for (at, c) in text.char_indices() {
        match c {
            '[' => depth += 1,
            ']' => depth -= 1,
            '>' if depth <= 0 => return at + 1,
            _ => {}
        }
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn what_the_field_reads_is_read() {
        for (text, expected) in [
            ("<a><!-- one -- two --></a>", "<a><!-- one ~~ two --></a>"),
            ("<a><!-- end ---></a>", "<a><!-- end ~--></a>"),
            ("\n <?xml version=\"1.0\"?>\n<a/>", "\n\n<a/>"),
            ("<a gz:b=\"1\"/>", "<a gz_b=\"1\"/>"),
            ("<a><gz:b/></a>", "<a><gz_b/></a>"),
            ("<a xmlns:gz=\"u\" gz:b=\"1\"/>", "<a xmlns:gz=\"u\" gz:b=\"1\"/>"),
            ("<a><ignition::b>1</ignition::b></a>", "<a><ignition__b>1</ignition__b></a>"),
            ("<a b=\"1\" b='2'/>", "<a b=\"1\" />"),
            ("<a b=\"1\"c='2'/>", "<a b=\"1\" c='2'/>"),
            ("<a b = \"1\"/>", "<a b=\"1\"/>"),
            ("<a b=one c=2/>", "<a b=\"one\" c=\"2\"/>"),
            ("<a b=x/y>z</a>", "<a b=\"x/y\">z</a>"),
            ("<a b=\"x < y & z &amp; &#65; &no;\"/>", "<a b=\"x ( y + z &amp; &#65; +no;\"/>"),
            ("<a>1 < 2 & 3</a>", "<a>1 ( 2 + 3</a>"),
            ("<!DOCTYPE a [<!ENTITY e \"x\">]><a/>", "<a/>"),
            ("<a>\u{1}\u{c}</a>", "<a>  </a>"),
            ("<a/>stray\n<b>c</b>", "<a/>\n"),
            ("stray <a/>", "<a/>"),
            ("<a><![CDATA[ < & -- ]]></a>", "<a><![CDATA[ < & -- ]]></a>"),
        ] {
            let made = lenient(text);
            assert_eq!(made, expected, "{text}");
            parse(&made, 100).unwrap_or_else(|error| panic!("{text}: {error}"));
        }
    }

    #[test]
    fn mistakes_stay_mistakes_at_their_places() {
        for (text, offset) in [("<a>\n<b>\n</a>", 8), ("<a b=/>", 5), ("<a", 0), ("", 0), ("<a>é<b></c></a>", 8)] {
            let made = lenient(text);
            let error = parse(&made, 100).expect_err("it is no XML");
            assert_eq!(error.offset, offset, "{text}: {error}");
        }
        let error = parse("<a><xacro:b/></a>", 100).expect_err("nobody declares it");
        assert!(error.to_string().contains("xacro"), "{error}");
    }

    #[test]
    fn files_are_decoded_by_what_they_say() {
        let text = "<?xml version=\"1.0\" encoding=\"utf-16\"?><a b=\"Höhe\"/>";
        let wide = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        let latin = b"<?xml version='1.0' encoding='iso-8859-1'?><a b=\"H\xf6he\"/>".to_vec();
        let windows = b"<a b=\"H\xf6he\"/>".to_vec();
        let marked = [&[0xff, 0xfe][..], &wide(u16::to_le_bytes)].concat();
        let wrong = text.as_bytes().to_vec();
        for bytes in [wide(u16::to_le_bytes), wide(u16::to_be_bytes), marked, latin, windows, wrong] {
            assert_eq!(decode(&bytes), "<a b=\"Höhe\"/>", "{bytes:?}");
        }
    }

    proptest! {
        #[test]
        fn nothing_panics_and_good_texts_stay(text in "[<>a-c/=\"'&;:! \\-\\[\\]?\n#x1ö]{0,60}") {
            let made = lenient(&text);
            let lines = |text: &str| text.matches('\n').count();
            prop_assert!(lines(&made) <= lines(&text));
            let again = lenient(&made).into_owned();
            prop_assert_eq!(again, made);
            let _ = parse(&lenient(&text), 100);
        }
    }
}
