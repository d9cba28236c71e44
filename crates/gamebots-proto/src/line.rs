//! A verb and its blocks, in the order sent: `DRIVE {Left 1.0} {Right 1.0}`.

use std::fmt;

use crate::shown;

/// Most blocks of one line that are read.
pub const MAX_BLOCKS: usize = 4096;

/// One `{key value}`. The value keeps its inner spaces; either part may be empty.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Block {
    /// Text before the first white space.
    pub key: String,
    /// Everything after it.
    pub value: String,
}

/// A line split into its verb and its blocks. Never a map: `ACT` depends on order and repeats.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Line {
    /// The text before the first `{`, as sent.
    pub verb: String,
    /// The blocks in the order sent, at most [`MAX_BLOCKS`].
    pub blocks: Vec<Block>,
    /// True when the line had more blocks than were read.
    pub truncated: bool,
    /// Beginning of the first text outside of the blocks that has a letter or a digit.
    pub stray: Option<String>,
    /// Beginning of the last block, without its `{`, if its brace is not closed. It is not among the blocks.
    pub unclosed: Option<String>,
}

impl Line {
    /// Creates a line without blocks.
    pub fn new(verb: &str) -> Self {
        Self { verb: verb.to_owned(), ..Self::default() }
    }

    /// Adds a block at the end.
    pub fn with(mut self, key: &str, value: impl fmt::Display) -> Self {
        self.blocks.push(Block { key: key.to_owned(), value: value.to_string() });
        self
    }

    /// Splits a text as USARSim's ParsedMessage.uc does: no nesting, no quoting, an unclosed last block is
    /// dropped, text between blocks is ignored. Three things are more lenient: tabs count as spaces, a stray
    /// `}` is skipped, and a block without a value does not hide those after it.
    pub fn parse(text: &str) -> Self {
        let text = text.trim();
        let (verb, mut rest) = text.split_at(text.find('{').unwrap_or(text.len()));
        let mut line = Self::new(verb.trim());
        // Each byte is searched once for either brace: a stray `}` lies before the next `{`.
        while let Some((between, after)) = rest.split_once('{') {
            line.note_stray(between);
            let Some((block, after)) = after.split_once('}') else {
                line.unclosed = Some(shown(after));
                return line;
            };
            if line.blocks.len() == MAX_BLOCKS {
                line.truncated = true;
                return line;
            }
            line.blocks.push(Block::parse(block));
            rest = after;
        }
        line.note_stray(rest);
        line
    }

    /// Notes text outside of the blocks, unless it is only punctuation, as clients put between blocks.
    fn note_stray(&mut self, text: &str) {
        if self.stray.is_none() && text.contains(char::is_alphanumeric) {
            self.stray = Some(shown(text.trim()));
        }
    }

    /// Returns the value of the first block with this key, in any case.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.blocks.iter().find(|block| block.key.eq_ignore_ascii_case(key)).map(|block| block.value.as_str())
    }
}

impl Block {
    fn parse(text: &str) -> Self {
        let text = text.trim();
        let (key, value) = text.split_at(text.find(char::is_whitespace).unwrap_or(text.len()));
        Self { key: key.to_owned(), value: value.trim().to_owned() }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.verb)?;
        for Block { key, value } in &self.blocks {
            let space = if value.is_empty() { "" } else { " " };
            write!(f, " {{{key}{space}{value}}}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, verb: &str, blocks: &[(&str, &str)]) {
        let line = Line::parse(text);
        let got: Vec<(&str, &str)> = line.blocks.iter().map(|b| (b.key.as_str(), b.value.as_str())).collect();
        assert_eq!((line.verb.as_str(), got.as_slice()), (verb, blocks), "{text}");
    }

    #[test]
    fn lines_split_as_in_the_protocol() {
        check("GETSTARTPOSES", "GETSTARTPOSES", &[]);
        check("\t GETSTARTPOSES  ", "GETSTARTPOSES", &[]);
        check("DRIVE{Left 1}{Right 1}", "DRIVE", &[("Left", "1"), ("Right", "1")]);
        check("DRIVE {Left   1  } , junk {  Right   1}", "DRIVE", &[("Left", "1"), ("Right", "1")]);
        check("INIT {Location 1, 2, 3}", "INIT", &[("Location", "1, 2, 3")]);
        check(
            "DRIVE {Left 1} {Light} {} {Right 1}",
            "DRIVE",
            &[("Left", "1"), ("Light", ""), ("", ""), ("Right", "1")],
        );
        check("DRIVE {Left 1} {Right 1", "DRIVE", &[("Left", "1")]);
        check("DRIVE {Left 1}} {Right 1}", "DRIVE", &[("Left", "1"), ("Right", "1")]);
        check("DRIVE } {Left 1}", "DRIVE }", &[("Left", "1")]);
        check("A {A {B 1} 2}", "A", &[("A", "{B 1")]);
        check("DRIVE {Left\t1}", "DRIVE", &[("Left", "1")]);
        check("", "", &[]);
    }

    #[test]
    fn text_that_is_in_no_block_is_noted() {
        for (text, stray, unclosed) in [
            ("DRIVE {Left 1} {Right 1", None, Some("Right 1")),
            ("DRIVE {Left 2", None, Some("Left 2")),
            ("DRIVE {", None, Some("")),
            ("DRIVE {Left 1} Right 2 {Light true} x", Some("Right 2"), None),
            ("DRIVE {Left 1} Right 2", Some("Right 2"), None),
            ("SET {Opcode Release}DRIVE {Left 1}", Some("DRIVE"), None),
            ("DRIVE {Left 1}} , ; {Right 1} .", None, None),
            ("GETSTARTPOSES", None, None),
        ] {
            let line = Line::parse(text);
            assert_eq!((line.stray.as_deref(), line.unclosed.as_deref()), (stray, unclosed), "{text}");
        }
    }

    #[test]
    fn the_first_of_two_equal_keys_wins_whatever_its_case() {
        let line = Line::parse("DRIVE {LEFT 1} {left 0}");
        assert_eq!(line.get("Left"), Some("1"));
        assert_eq!(line.get("Right"), None);
    }

    #[test]
    fn blocks_beyond_the_limit_are_not_read() {
        let line = Line::parse(&"{a b}".repeat(MAX_BLOCKS + 1));
        assert!(line.truncated);
        assert_eq!(line.blocks.len(), MAX_BLOCKS);
    }
}
