//! `usarsim connect`.

use std::borrow::Cow;
use std::io::{BufRead, IsTerminal};
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::time::Duration;

use gamebots_client::Client;
use gamebots_proto::message::PERIODIC_VERBS;
use gamebots_proto::{Block, Command, Line};
use rustyline::completion::{Completer, Pair};
use rustyline::error::ReadlineError;
use rustyline::history::DefaultHistory;
use rustyline::{Context, Editor, ExternalPrinter, Helper};

use crate::{Failure, exit, print};

/// Options of `connect`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim connect 127.0.0.1:3000\n  \
    echo GETSTARTPOSES | usarsim connect 127.0.0.1:3000\n\n\
    In a terminal Tab completes verbs and keys, the arrows recall lines, and lines on a timer (STA, SEN) are hidden until\n\
    they are asked for: :watch shows all of them, :watch GroundTruth those with that word, :unwatch none. :quit or Ctrl-D ends.\n\
    Without a terminal every line is printed, until half a second after the last answer when the input ends.")]
pub(crate) struct Arguments {
    /// The server.
    #[arg(value_name = "HOST:PORT", default_value = "127.0.0.1:3000")]
    address: String,
}

/// How often both sides are looked at.
const POLL: Duration = Duration::from_millis(20);
/// Without a terminal, how long an answer is waited for after the last line of the input.
const LAST_ANSWER: Duration = Duration::from_millis(500);

/// The keys that each verb takes, for completion.
const KEYS: &[(&str, &[&str])] = &[
    ("INIT", &["ClassName", "Name", "Start", "Location", "Rotation"]),
    (
        "DRIVE",
        &[
            "Left",
            "Right",
            "Front-Left",
            "Front-Right",
            "Back-Left",
            "Back-Right",
            "LinearVelocity",
            "LateralVelocity",
            "RotationalVelocity",
            "AltitudeVelocity",
            "Speed",
            "FrontSteer",
            "RearSteer",
            "WheelNumber",
            "WheelSpeed",
            "Normalized",
            "Light",
        ],
    ),
    ("MULTIDRIVE", &[]),
    ("ACT", &["Name", "Link", "Value", "Gripper"]),
    ("MISPKG", &["Name", "Link", "Value", "Order", "Gripper"]),
    ("SET", &["Type", "Name", "Opcode", "Params"]),
    ("GETCONF", &["Type", "Name"]),
    ("GETGEO", &["Type", "Name"]),
    ("GETSTARTPOSES", &[]),
    ("GETPATHNODES", &[]),
    ("GETCLOSESTPATHNODE", &["Location"]),
    ("REPORT", &["Errors"]),
];

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let client = connect(&arguments.address)?;
    if std::io::stdin().is_terminal() { talk(client) } else { pass_through(client) }
}

/// Connects, or says what to do. A person wants to hear of mistakes, which the protocol has no word for.
pub(crate) fn connect(address: &str) -> Result<Client, Failure> {
    let failed = |error: std::io::Error| {
        let hint = "is a server running there? `usarsim serve` starts one";
        Failure::new(exit::UNAVAILABLE, format_args!("{address}: {error}; {hint}"))
    };
    let mut client = Client::connect(address).map_err(failed)?;
    client.send("REPORT {Errors true}").map_err(failed)?;
    Ok(client)
}

/// Every line of the input to the server, every line of the server to the output.
fn pass_through(mut client: Client) -> Result<(), Failure> {
    let lost = |error: std::io::Error| Failure::new(exit::UNAVAILABLE, format_args!("the connection is lost: {error}"));
    let (sender, lines) = mpsc::channel();
    std::thread::spawn(move || {
        std::io::stdin().lock().lines().map_while(Result::ok).try_for_each(|line| sender.send(line))
    });
    let mut wait = None;
    loop {
        match lines.try_recv() {
            Ok(line) => client.send(&line).map_err(lost)?,
            Err(TryRecvError::Disconnected) if wait.is_none() => wait = Some(std::time::Instant::now() + LAST_ANSWER),
            Err(_) => {}
        }
        match client.next_line(POLL) {
            Ok(Some(line)) => print(line),
            Ok(None) => {}
            // The server has ended the connection.
            Err(_) => return Ok(()),
        }
        if wait.is_some_and(|end| std::time::Instant::now() > end) {
            return Ok(());
        }
    }
}

/// What the person has typed.
enum Typed {
    Line(String),
    /// Lines on a timer with this word are shown; `None` hides all.
    Watch(Option<String>),
}

/// With a person at a terminal.
fn talk(client: Client) -> Result<(), Failure> {
    let failed = |error: ReadlineError| Failure::new(exit::FAILURE, error);
    let mut editor: Editor<Words, DefaultHistory> = Editor::new().map_err(failed)?;
    editor.set_helper(Some(Words));
    let history = history_file();
    if let Some(file) = &history {
        // There is none the first time.
        let _ = editor.load_history(file);
    }
    let printer = editor.create_external_printer().map_err(failed)?;
    let (sender, typed) = mpsc::channel();
    let colour = std::env::var_os("NO_COLOR").is_none();
    std::thread::spawn(move || show(client, &typed, printer, colour));
    loop {
        match editor.readline("> ") {
            Ok(line) if line.trim().is_empty() => {}
            Ok(line) => {
                // A history that cannot be kept is no reason to stop.
                let _ = editor.add_history_entry(&line);
                if !obey(line.trim(), &sender) {
                    break;
                }
            }
            Err(ReadlineError::Interrupted | ReadlineError::Eof) => break,
            Err(error) => return Err(failed(error)),
        }
    }
    if let Some(file) = &history {
        let _ = file.parent().map(std::fs::create_dir_all);
        let _ = editor.save_history(file);
    }
    Ok(())
}

/// Does what a line says; false at the end.
fn obey(line: &str, sender: &Sender<Typed>) -> bool {
    let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
    let typed = match word {
        ":quit" | ":q" => return false,
        ":watch" => Typed::Watch(Some(rest.trim().to_owned())),
        ":unwatch" => Typed::Watch(None),
        word if word.starts_with(':') => {
            print(
                ":watch [WORD]  show lines on a timer, those with a word\n:unwatch       hide them\n:quit          end",
            );
            return true;
        }
        _ => Typed::Line(line.to_owned()),
    };
    if sender.send(typed).is_err() {
        print("the connection is gone; start the server and connect again");
        return false;
    }
    true
}

/// Sends what is typed and prints what comes, until the connection or the person is gone.
fn show(mut client: Client, typed: &Receiver<Typed>, mut printer: impl ExternalPrinter, colour: bool) {
    let mut watched: Option<String> = None;
    loop {
        loop {
            match typed.try_recv() {
                Ok(Typed::Line(line)) if client.send(&line).is_err() => break,
                Ok(Typed::Line(_)) => {}
                Ok(Typed::Watch(word)) => watched = word,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return,
            }
        }
        let line = match client.next_line(POLL) {
            Ok(Some(line)) => line,
            Ok(None) => continue,
            Err(error) => {
                let _ = printer.print(format!("the server has ended the connection ({error}); :quit\n"));
                return;
            }
        };
        let is_periodic = line.split(' ').next().is_some_and(|verb| PERIODIC_VERBS.contains(&verb));
        let is_wanted =
            watched.as_ref().is_some_and(|word| line.to_ascii_lowercase().contains(&word.to_ascii_lowercase()));
        if (!is_periodic || is_wanted) && printer.print(format!("{}\n", pretty(&line, colour))).is_err() {
            return;
        }
    }
}

/// A line with its verb, keys and values told apart.
fn pretty(line: &str, colour: bool) -> Cow<'_, str> {
    if !colour {
        return line.into();
    }
    let parsed = Line::parse(line);
    let mut text = format!("\x1b[1;36m{}\x1b[0m", parsed.verb);
    for Block { key, value } in &parsed.blocks {
        text.push_str(&format!(" \x1b[2m{{\x1b[0m\x1b[33m{key}\x1b[0m {value}\x1b[2m}}\x1b[0m"));
    }
    text.into()
}

/// Where lines are remembered.
fn history_file() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let state = state.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/state")))?;
    Some(state.join("usarsim/history"))
}

/// Completes verbs and keys.
struct Words;

impl Helper for Words {}
impl rustyline::highlight::Highlighter for Words {}
impl rustyline::validate::Validator for Words {}

impl rustyline::hint::Hinter for Words {
    type Hint = String;
}

impl Completer for Words {
    type Candidate = Pair;

    fn complete(&self, line: &str, position: usize, _: &Context) -> Result<(usize, Vec<Pair>), ReadlineError> {
        let (start, words) = candidates(&line[..position]);
        let pair = |word: String| Pair { display: word.trim_end().to_owned(), replacement: word };
        Ok((start, words.into_iter().map(pair).collect()))
    }
}

/// Where the word at the end of a text begins, and what it may become.
fn candidates(text: &str) -> (usize, Vec<String>) {
    let fitting = |word: &str, all: &[&str], end: &str| {
        let lower = word.to_ascii_lowercase();
        let fits = |candidate: &&&str| candidate.to_ascii_lowercase().starts_with(&lower);
        all.iter().filter(fits).map(|candidate| format!("{candidate}{end}")).collect()
    };
    let Some((verb, rest)) = text.split_once(' ') else {
        return (0, fitting(text, Command::VERBS, " "));
    };
    let keys = KEYS.iter().find(|(known, _)| known.eq_ignore_ascii_case(verb)).map_or(&[][..], |(_, keys)| keys);
    let block = rest.rfind('{').map_or(rest, |open| &rest[open + 1..]);
    if block.contains('}') || block.trim_end() != block || !rest.contains('{') {
        // Between two blocks the next one begins.
        return (text.len(), keys.iter().map(|key| format!("{{{key} ")).collect());
    }
    if block.contains(' ') {
        return (text.len(), Vec::new());
    }
    (text.len() - block.len(), fitting(block, keys, " "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, start: usize, expected: &[&str]) {
        assert_eq!(candidates(text), (start, expected.iter().map(|&word| word.to_owned()).collect()), "{text}");
    }

    #[test]
    fn verbs_and_keys_are_completed() {
        check("dr", 0, &["DRIVE "]);
        check("GETC", 0, &["GETCONF ", "GETCLOSESTPATHNODE "]);
        check("INIT {Cl", 6, &["ClassName "]);
        check("init {ClassName USARBot.P3AT} {st", 31, &["Start "]);
        check("INIT {ClassName USAR", 20, &[]);
        check("GETCONF ", 8, &["{Type ", "{Name "]);
        check("FLY {", 5, &[]);
    }

    #[test]
    fn every_verb_has_its_keys() {
        let known: Vec<&str> = KEYS.iter().map(|(verb, _)| *verb).collect();
        assert_eq!(known, Command::VERBS);
    }

    #[test]
    fn colours_keep_the_text() {
        let line = "SEN {Time 1.0000} {Type GroundTruth} {Name GndTruth}";
        let mut shown = pretty(line, true).into_owned();
        for code in ["\x1b[1;36m", "\x1b[0m", "\x1b[2m", "\x1b[33m"] {
            shown = shown.replace(code, "");
        }
        assert_eq!((shown.as_str(), pretty(line, false).as_ref()), (line, line));
    }
}
