//! `usarsim connect`.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::{BufRead, ErrorKind, IsTerminal};
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use gamebots_client::Client;
use gamebots_proto::message::{Message, Nfo, is_periodic_line};
use gamebots_proto::{Block, Command, Line, ports};
use rustyline::completion::{Completer, Pair};
use rustyline::error::ReadlineError;
use rustyline::history::DefaultHistory;
use rustyline::{Context, Editor, ExternalPrinter, Helper};

use crate::terminal::printable;
use crate::{Failure, exit, print};

/// Options of `connect`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim connect 127.0.0.1:3000\n  \
    echo GETSTARTPOSES | usarsim connect 127.0.0.1:3000\n\n\
    In a terminal Tab completes verbs, keys, classes, starts and sensors, the arrows recall lines, and help lists all of them. \
    Lines on a timer (STA, SEN) are hidden until they are asked for: :watch shows all of them, :watch GroundTruth those with \
    that word, :unwatch none. :quit or Ctrl-D ends.\n\n\
    Without a terminal every line is printed. The program ends half a second after the end of the input.")]
pub(crate) struct Arguments {
    /// The server.
    #[arg(value_name = "HOST:PORT", default_value = "127.0.0.1:3000")]
    address: String,
    #[command(flatten)]
    token: OwnToken,
}

/// A token to log in with.
#[derive(clap::Args)]
pub(crate) struct OwnToken {
    /// Token for a server with --token-file. Other users of this machine can read a command line, so the variable is better.
    #[arg(long, env = "USARSIM_TOKEN", hide_env_values = true)]
    token: Option<String>,
}

impl OwnToken {
    /// Returns the line to log in with, without its end; none without a token.
    pub(crate) fn login(&self) -> Option<String> {
        self.token.as_deref().map(ports::login)
    }
}

/// Interval at which both sides are polled.
const POLL: Duration = Duration::from_millis(20);
/// Time to wait for an answer after the last line of the input, without a terminal.
const LAST_ANSWER: Duration = Duration::from_millis(500);

/// Returns each verb with the keys that it takes.
fn verbs() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    Command::VERBS.iter().copied().zip(Command::KEYS.iter().copied())
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let client = connect(&arguments.address, &arguments.token)?;
    if std::io::stdin().is_terminal() { talk(client) } else { pass_through(client) }
}

/// Connects, with a hint in the error. Asks the server to report mistakes, as a person wants to see them; USARSim ignores that line.
pub(crate) fn connect(address: &str, token: &OwnToken) -> Result<Client, Failure> {
    let failed = |error: std::io::Error| {
        let hint = "is a server running there? `usarsim serve` starts one";
        Failure::new(exit::UNAVAILABLE, format_args!("{address}: {error}; {hint}"))
    };
    let mut client = Client::connect(address).map_err(failed)?;
    token.login().map_or(Ok(()), |line| client.send(&line)).map_err(failed)?;
    client.send("REPORT {Errors true}").map_err(failed)?;
    Ok(client)
}

/// Copies every line of the input to the server, and every line of the server to the output.
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
            Err(error) if error.kind() == ErrorKind::InvalidData => tracing::warn!(%error, "a line is left out"),
            // The server closed the connection.
            Err(_) => return Ok(()),
        }
        if wait.is_some_and(|end| std::time::Instant::now() > end) {
            return Ok(());
        }
    }
}

/// Input of the person.
enum Typed {
    Line(String),
    /// Shows lines on a timer with this word; `None` hides all.
    Watch(Option<String>),
}

/// Talks with a person at a terminal.
fn talk(mut client: Client) -> Result<(), Failure> {
    let failed = |error: ReadlineError| Failure::new(exit::FAILURE, error);
    let known = Known::default();
    for question in QUESTIONS {
        client.send(question).map_err(|error| Failure::new(exit::UNAVAILABLE, error))?;
    }
    let mut editor: Editor<Words, DefaultHistory> = Editor::new().map_err(failed)?;
    editor.set_helper(Some(Words(known.clone())));
    let history = history_file();
    if let Some(file) = &history {
        // The first time there is no history.
        let _ = editor.load_history(file);
    }
    let printer = editor.create_external_printer().map_err(failed)?;
    let (sender, typed) = mpsc::channel();
    let colour = std::env::var_os("NO_COLOR").is_none();
    let learned = known.clone();
    std::thread::spawn(move || show(client, &typed, printer, &learned, colour));
    print("connected; help lists verbs, classes and starts, Tab completes them");
    loop {
        match editor.readline("> ") {
            Ok(line) if line.trim().is_empty() => {}
            Ok(line) => {
                // Failing to keep the history is no reason to stop.
                let _ = editor.add_history_entry(&line);
                if !obey(line.trim(), &sender, &known) {
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

/// Executes a typed line. Returns false at the end of the session.
fn obey(line: &str, sender: &Sender<Typed>, known: &Known) -> bool {
    let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
    let typed = match word {
        ":quit" | ":q" => return false,
        ":watch" => Typed::Watch(Some(rest.trim().to_owned())),
        ":unwatch" => Typed::Watch(None),
        word if word.starts_with(':') || ["help", "?"].iter().any(|it| word.eq_ignore_ascii_case(it)) => {
            print(help(&known.names()));
            return true;
        }
        _ => Typed::Line(line.to_owned()),
    };
    if sender.send(typed).is_err() {
        print("the connection is lost; start the server and connect again");
        return false;
    }
    true
}

/// Returns the help text: verbs, keys, names and commands.
fn help(names: &Names) -> String {
    let verb = |(verb, keys): (&str, &[&str])| match keys.len() {
        0 => format!("  {verb}\n"),
        _ => format!("  {verb:<19}{}\n", keys.iter().map(|key| format!("{{{key}}}")).collect::<Vec<_>>().join(" ")),
    };
    let listed = |names: &BTreeSet<String>| match names.len() {
        0 => "the server has not said".to_owned(),
        _ => names.iter().map(String::as_str).collect::<Vec<_>>().join(", "),
    };
    format!(
        "verbs and their keys:\n{}classes: {}\nstarts: {}\n\n  INIT {{ClassName USARBot.P3AT}} {{Start PlayerStart_0}}\n  \
         DRIVE {{Left 1}} {{Right 1}}\n\n:watch [WORD]  show lines on a timer, those with a word\n:unwatch       hide them\n\
         :quit          end",
        verbs().map(verb).collect::<String>(),
        listed(&names.classes),
        listed(&names.starts)
    )
}

/// Sends typed lines and prints received ones, until the connection or the session ends.
fn show(mut client: Client, typed: &Receiver<Typed>, mut printer: impl ExternalPrinter, known: &Known, colour: bool) {
    let mut watched: Option<String> = None;
    let mut unasked = 0;
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
            // Names in the line are offered as completions later, so it is made printable first.
            Ok(Some(line)) => printable(&line).into_owned(),
            Ok(None) => continue,
            Err(error) if error.kind() == ErrorKind::InvalidData => error.to_string(),
            Err(error) => {
                let _ = printer.print(format!("the server has ended the connection ({error}); :quit\n"));
                return;
            }
        };
        // The answers to the first questions are not shown, as the person did not ask them.
        if known.names().learn(&line) && unasked < QUESTIONS.len() {
            unasked += 1;
            continue;
        }
        let is_periodic = is_periodic_line(&line);
        let is_wanted =
            watched.as_ref().is_some_and(|word| line.to_ascii_lowercase().contains(&word.to_ascii_lowercase()));
        if (!is_periodic || is_wanted) && printer.print(format!("{}\n", pretty(&line, colour))).is_err() {
            return;
        }
    }
}

/// Questions for the names to complete. USARSim ignores the first.
const QUESTIONS: [&str; 2] = ["GETCLASSES", "GETSTARTPOSES"];

/// Names learned from the server so far.
#[derive(Clone, Default)]
struct Known(Arc<Mutex<Names>>);

impl Known {
    fn names(&self) -> MutexGuard<'_, Names> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[derive(Default)]
struct Names {
    /// Classes as INIT takes them.
    classes: BTreeSet<String>,
    starts: BTreeSet<String>,
    /// Types of the sensors and actuators; then their names.
    types: BTreeSet<String>,
    items: BTreeSet<String>,
}

impl Names {
    /// Learns the names in a line. Returns true if it answers one of the questions.
    fn learn(&mut self, line: &str) -> bool {
        let answer = line.starts_with("NFO ").then(|| Message::read(line)).flatten();
        match answer {
            Some(Message::Nfo(Nfo::Classes(classes))) => {
                self.classes = classes.into_iter().map(|class| format!("USARBot.{class}")).collect();
                return true;
            }
            Some(Message::Nfo(Nfo::StartPoses(poses))) => {
                self.starts = poses.into_iter().map(|pose| pose.name).collect();
                return true;
            }
            _ => {}
        }
        let line = Line::parse(line);
        if ["SEN", "CONF", "GEO", "ASTA"].contains(&line.verb.as_str()) {
            self.types.extend(line.get("Type").map(str::to_owned));
            self.items.extend(line.blocks.iter().filter(|it| it.key == "Name").map(|it| it.value.clone()));
        }
        false
    }

    /// Returns the known values of a key.
    fn values(&self, verb: &str, key: &str) -> Vec<&str> {
        fn of(names: &BTreeSet<String>) -> Vec<&str> {
            names.iter().map(String::as_str).collect()
        }
        match (verb, key) {
            ("INIT", "ClassName") => of(&self.classes),
            ("INIT", "Start") => of(&self.starts),
            ("GETCONF" | "GETGEO", "Type") => self.types.iter().map(String::as_str).chain(["Robot"]).collect(),
            ("SET", "Type") => of(&self.types),
            ("SET" | "GETCONF" | "GETGEO" | "ACT" | "MISPKG", "Name") => of(&self.items),
            ("REPORT", "Errors") | ("DRIVE", "Normalized" | "Light" | "Flip") => vec!["true", "false"],
            _ => Vec::new(),
        }
    }
}

/// Colours the verb, keys and values of a line.
fn pretty(line: &str, colour: bool) -> Cow<'_, str> {
    if !colour {
        return line.into();
    }
    if line.starts_with("NFO {Error ") {
        return format!("\x1b[1;31m{line}\x1b[0m").into();
    }
    let parsed = Line::parse(line);
    let mut text = format!("\x1b[1;36m{}\x1b[0m", parsed.verb);
    for Block { key, value } in &parsed.blocks {
        text.push_str(&format!(" \x1b[2m{{\x1b[0m\x1b[33m{key}\x1b[0m {value}\x1b[2m}}\x1b[0m"));
    }
    text.into()
}

/// Returns the path of the history file.
fn history_file() -> Option<PathBuf> {
    let state = std::env::var_os("XDG_STATE_HOME").map(PathBuf::from).filter(|path| path.is_absolute());
    let state = state.or_else(|| Some(PathBuf::from(std::env::var_os("HOME")?).join(".local/state")))?;
    Some(state.join("usarsim/history"))
}

/// Completes verbs, keys and names.
struct Words(Known);

impl Helper for Words {}
impl rustyline::highlight::Highlighter for Words {}
impl rustyline::validate::Validator for Words {}

impl rustyline::hint::Hinter for Words {
    type Hint = String;
}

impl Completer for Words {
    type Candidate = Pair;

    fn complete(&self, line: &str, position: usize, _: &Context) -> Result<(usize, Vec<Pair>), ReadlineError> {
        let (start, words) = candidates(&line[..position], &self.0.names());
        let pair = |word: String| Pair { display: word.trim_end().to_owned(), replacement: word };
        Ok((start, words.into_iter().map(pair).collect()))
    }
}

/// Returns the start of the last word of a text, and its completions.
fn candidates(text: &str, names: &Names) -> (usize, Vec<String>) {
    let fitting = |word: &str, all: &[&str], end: &str| {
        let lower = word.to_ascii_lowercase();
        // A class is also completed without its package.
        let fits = |candidate: &&&str| {
            let candidate = candidate.to_ascii_lowercase();
            candidate.starts_with(&lower) || candidate.strip_prefix("usarbot.").is_some_and(|it| it.starts_with(&lower))
        };
        all.iter().filter(fits).map(|candidate| format!("{candidate}{end}")).collect()
    };
    let Some((verb, rest)) = text.split_once(' ') else {
        return (0, fitting(text, Command::VERBS, " "));
    };
    let Some((verb, keys)) = verbs().find(|(known, _)| known.eq_ignore_ascii_case(verb)) else {
        return (text.len(), Vec::new());
    };
    let block = rest.rfind('{').map_or(rest, |open| &rest[open + 1..]);
    if block.contains('}') || !rest.contains('{') {
        // Between two blocks, a new one starts.
        return (text.len(), keys.iter().map(|key| format!("{{{key} ")).collect());
    }
    let Some((key, value)) = block.split_once(' ') else {
        return (text.len() - block.len(), fitting(block, keys, " "));
    };
    let key = keys.iter().find(|known| known.eq_ignore_ascii_case(key)).unwrap_or(&"");
    (text.len() - value.len(), fitting(value, &names.values(verb, key), "} "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, start: usize, expected: &[&str]) {
        let mut names = Names::default();
        for line in [
            "NFO {Classes 3} {Names KUKA_YouBot,P2AT,P3AT}",
            "NFO {StartPoses 2} {PlayerStart_0 0.0000,0.0000,0.0000 0.0000,0.0000,0.0000 Roof 1.0000,0.0000,0.0000 0.0000,0.0000,0.0000}",
            "SEN {Time 1.0000} {Type GroundTruth} {Name GndTruth} {Location 0,0,0} {Orientation 0,0,0}",
        ] {
            names.learn(line);
        }
        assert_eq!(candidates(text, &names), (start, expected.iter().map(|&word| word.to_owned()).collect()), "{text}");
    }

    #[test]
    fn verbs_keys_and_names_are_completed() {
        check("dr", 0, &["DRIVE "]);
        check("GETCO", 0, &["GETCONF "]);
        check("INIT {Cl", 6, &["ClassName "]);
        check("init {ClassName USARBot.P3AT} {st", 31, &["Start "]);
        check("init {ClassName USARBot.P", 16, &["USARBot.P2AT} ", "USARBot.P3AT} "]);
        check("INIT {ClassName ku", 16, &["USARBot.KUKA_YouBot} "]);
        check("INIT {ClassName USARBot.P3AT} {Start r", 37, &["Roof} "]);
        check("GETCONF {Type ", 14, &["GroundTruth} ", "Robot} "]);
        check("GETGEO {Type GroundTruth} {name g", 32, &["GndTruth} "]);
        check("DRIVE {Left ", 12, &[]);
        check("GETCONF ", 8, &["{Type ", "{Name "]);
        check("FLY {", 5, &[]);
    }

    #[test]
    fn colours_keep_the_text() {
        let line = "SEN {Time 1.0000} {Type GroundTruth} {Name GndTruth}";
        let mut shown = pretty(line, true).into_owned();
        for code in ["\x1b[1;36m", "\x1b[0m", "\x1b[2m", "\x1b[33m"] {
            shown = shown.replace(code, "");
        }
        assert_eq!((shown.as_str(), pretty(line, false).as_ref()), (line, line));
        assert_eq!(pretty("NFO {Error x}", true), "\x1b[1;31mNFO {Error x}\x1b[0m");
    }

    #[test]
    fn help_names_verbs_classes_and_starts() {
        let mut names = Names::default();
        assert!(help(&names).contains("classes: the server has not said"));
        assert!(names.learn("NFO {Classes 1} {Names P3AT}"));
        let help = help(&names);
        for part in
            ["  INIT               {ClassName} {Name}", "  GETSTARTPOSES\n", "classes: USARBot.P3AT\n", ":watch"]
        {
            assert!(help.contains(part), "{help}");
        }
    }
}
