//! Framing: splits bytes into lines.
//!
//! CR, LF, CR LF and LF CR all end a line, runs of them collapse and empty lines vanish. A line longer than the limit is discarded up to
//! its end and the connection lives on. Where empty lines count, CR LF is one end.

use crate::Problem;

/// Longest line that a server takes, in bytes without its terminator. USARSim had no limit; a stranger needs one.
pub const MAX_LINE_BYTES: usize = 64 * 1024;

/// Longest line that a client takes, in bytes without its terminator. The longest answer of a server, that of GetSTA, has 256 KiB.
pub const MAX_ANSWER_BYTES: usize = 1024 * 1024;

/// Splits a stream of bytes into lines; holds the part of a line that has not ended yet.
#[derive(Debug)]
pub struct Framing {
    partial: Vec<u8>,
    /// Longest line that is kept, in bytes without its end.
    limit: usize,
    /// Bytes of an over-long line discarded so far.
    discarded: usize,
    /// True if empty lines count.
    keeps_empty: bool,
    /// True if the last byte was a CR.
    is_after_cr: bool,
}

impl Default for Framing {
    /// Creates a framing of a server, with lines of up to [`MAX_LINE_BYTES`].
    fn default() -> Self {
        Self { partial: Vec::new(), limit: MAX_LINE_BYTES, discarded: 0, keeps_empty: false, is_after_cr: false }
    }
}

impl Framing {
    /// Creates a framing of a client, with lines of up to [`MAX_ANSWER_BYTES`].
    pub fn of_answers() -> Self {
        Self { limit: MAX_ANSWER_BYTES, ..Self::default() }
    }

    /// Creates a framing in which empty lines count.
    pub fn with_empty_lines() -> Self {
        Self { keeps_empty: true, ..Self::default() }
    }

    /// Takes the next bytes of the stream and returns the lines that they complete, in order.
    ///
    /// An over-long line gives one [`Problem::LineTooLong`] when its end arrives.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Result<String, Problem>> {
        let mut lines = Vec::new();
        for part in bytes.split_inclusive(|&byte| is_end(byte)) {
            match part.split_last() {
                Some((&last, text)) if is_end(last) => {
                    self.keep(text);
                    let is_second_end = last == b'\n' && self.is_after_cr && text.is_empty();
                    let line = self.finish();
                    let empty = || (self.keeps_empty && !is_second_end).then(|| Ok(String::new()));
                    lines.extend(line.or_else(empty));
                    self.is_after_cr = last == b'\r';
                }
                _ => {
                    self.keep(part);
                    self.is_after_cr = false;
                }
            }
        }
        lines
    }

    /// Ends the stream: the last fragment counts as a line.
    pub fn finish(&mut self) -> Option<Result<String, Problem>> {
        let bytes = std::mem::take(&mut self.partial);
        let discarded = std::mem::take(&mut self.discarded);
        if discarded > 0 {
            return Some(Err(Problem::LineTooLong { got: discarded, limit: self.limit }));
        }
        (!bytes.is_empty()).then(|| Ok(decode(bytes)))
    }

    /// True if the waiting fragment could be a whole line: its last block is closed.
    pub fn ends_with_block(&self) -> bool {
        self.discarded == 0 && self.partial.trim_ascii_end().ends_with(b"}")
    }

    fn keep(&mut self, text: &[u8]) {
        if self.discarded > 0 || self.partial.len() + text.len() > self.limit {
            self.discarded += self.partial.len() + text.len();
            self.partial = Vec::new();
        } else {
            self.partial.extend_from_slice(text);
        }
    }
}

fn is_end(byte: u8) -> bool {
    byte == b'\r' || byte == b'\n'
}

/// Decodes a line. USARSim's text is 8-bit: text that is not UTF-8 is read as Latin-1, so that no byte is lost.
fn decode(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().iter().map(|&byte| char::from(byte)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(chunks: &[&str], expected: &[&str]) {
        let mut framing = Framing::default();
        let mut got: Vec<String> = Vec::new();
        for chunk in chunks {
            got.extend(framing.push(chunk.as_bytes()).into_iter().map(|line| line.unwrap()));
        }
        got.extend(framing.finish().map(|line| line.unwrap()));
        assert_eq!(got, expected, "chunks {chunks:?}");
    }

    #[test]
    fn lines_end_as_clients_end_them() {
        check(&["A\r\nB\r\n"], &["A", "B"]);
        check(&["A\nB\n"], &["A", "B"]);
        check(&["A\rB\r"], &["A", "B"]);
        check(&["A\n\rB\n\r"], &["A", "B"]);
        check(&["A\r\n\nB\r\n\n"], &["A", "B"]);
        check(&["\r\n\r\n\n\r"], &[]);
        check(&["GETSTART", "POSES\r", "\nB"], &["GETSTARTPOSES", "B"]);
        check(&["no end"], &["no end"]);
    }

    #[test]
    fn empty_lines_count_where_they_are_questions() {
        let rows: [(&[&str], &[&str]); 5] = [
            (&["\r\n"], &[""]),
            (&["\r", "\n"], &[""]),
            (&["\n\n\r\n"], &["", "", ""]),
            (&["A\r\n\r\nB\n"], &["A", "", "B"]),
            (&["A\r", "B\r\n"], &["A", "B"]),
        ];
        for (chunks, expected) in rows {
            let mut framing = Framing::with_empty_lines();
            let lines: Vec<_> = chunks.iter().flat_map(|chunk| framing.push(chunk.as_bytes())).collect();
            assert_eq!(lines.into_iter().map(Result::unwrap).collect::<Vec<_>>(), expected, "{chunks:?}");
        }
    }

    #[test]
    fn an_over_long_line_is_dropped_whole_and_the_next_one_is_read() {
        let mut framing = Framing::default();
        assert!(framing.push(&vec![b'x'; 1 << 20]).is_empty());
        assert!(framing.partial.capacity() <= MAX_LINE_BYTES);
        let lines = framing.push(b"tail\r\nGETSTARTPOSES\r\n");
        assert_eq!(
            lines,
            [Err(Problem::LineTooLong { got: (1 << 20) + 4, limit: MAX_LINE_BYTES }), Ok("GETSTARTPOSES".to_owned())]
        );
    }

    #[test]
    fn a_line_of_just_the_limit_is_kept() {
        let mut bytes = vec![b'x'; MAX_LINE_BYTES];
        bytes.push(b'\n');
        assert_eq!(Framing::default().push(&bytes)[0].as_ref().map(String::len), Ok(MAX_LINE_BYTES));
    }

    #[test]
    fn a_client_takes_the_longest_answer() {
        let mut bytes = vec![b'x'; MAX_ANSWER_BYTES];
        bytes.extend(b"\ny");
        assert_eq!(Framing::of_answers().push(&bytes)[0].as_ref().map(String::len), Ok(MAX_ANSWER_BYTES));
        bytes.extend(vec![b'y'; MAX_ANSWER_BYTES]);
        bytes.push(b'\n');
        let too_long = Problem::LineTooLong { got: MAX_ANSWER_BYTES + 1, limit: MAX_ANSWER_BYTES };
        assert_eq!(Framing::of_answers().push(&bytes)[1], Err(too_long));
    }

    #[test]
    fn bytes_that_are_not_utf8_are_read_as_latin_1() {
        assert_eq!(Framing::default().push(b"caf\xe9\n"), [Ok("café".to_owned())]);
    }

    proptest! {
        #[test]
        fn arbitrary_bytes_never_panic_and_chunks_do_not_matter(
            bytes in proptest::collection::vec(any::<u8>(), 0..400), cut in 0usize..400,
        ) {
            let cut = cut.min(bytes.len());
            let mut whole = Framing::default();
            let mut parts = Framing::default();
            let expected = whole.push(&bytes);
            let mut got = parts.push(&bytes[..cut]);
            got.extend(parts.push(&bytes[cut..]));
            prop_assert_eq!(got, expected);
            prop_assert_eq!(parts.finish(), whole.finish());
        }
    }
}
