//! Bytes to lines to commands, and the same from a server to a client.

use gamebots_proto::{Command, Dialect, Framing, Line, MAX_BLOCKS, Message, Problem};

use crate::assert_finite;

/// Most bytes of what is said about one mistake.
const MAX_TEXT: usize = 2000;

/// Bytes as a client may send them, and as a server may send them to `usarsim connect`.
///
/// What is read from them is written and read again as the same; every number is finite; what is said about mistakes has a
/// bound; how the bytes are cut does not matter.
pub fn wire(bytes: &[u8]) {
    let lines = framed(&[bytes]);
    let (first, second) = bytes.split_at(bytes.len() / 2);
    assert_eq!(framed(&[first, second]), lines, "the lines depend on how the bytes are cut");
    for line in lines {
        match line {
            Ok(text) => {
                command(&text);
                message(&text);
            }
            Err(problem) => assert_short(&problem),
        }
    }
}

fn framed(segments: &[&[u8]]) -> Vec<Result<String, Problem>> {
    let mut framing = Framing::default();
    let mut lines: Vec<_> = segments.iter().flat_map(|segment| framing.push(segment)).collect();
    lines.extend(framing.finish());
    lines
}

fn command(text: &str) {
    let mut problems = Vec::new();
    let Some(command) = Command::read(&Line::parse(text), &mut problems) else {
        return problems.iter().for_each(assert_short);
    };
    assert!(problems.len() <= MAX_BLOCKS + 10, "{} problems", problems.len());
    problems.iter().for_each(assert_short);
    assert_finite("a command", &command);
    if let Command::Set(set) = &command {
        assert_finite("the parameters of SET", &set.numbers());
    }
    let written = command.write().to_string();
    let mut left = Vec::new();
    let again = Command::read(&Line::parse(&written), &mut left);
    assert_eq!(again.as_ref(), Some(&command), "{text:?} was written as {written:?}");
    // A command keeps some texts as they were sent, with what is wrong with them.
    assert!(left.len() <= problems.len(), "{text:?} was written as {written:?}: {left:?}, before {problems:?}");
}

/// Numbers from a server need not be finite; these are not written.
fn message(text: &str) {
    if let Some(message) = Message::read(text) {
        let written = message.write(Dialect::Udk);
        let again = Message::read(&written);
        assert!(again.is_some(), "{text:?} was written as {written:?}");
        assert_finite("what is written", &again);
    }
}

fn assert_short(problem: &Problem) {
    let said = problem.to_string();
    assert!(said.len() <= MAX_TEXT, "{} bytes about a mistake: {said}", said.len());
}
