//! `usarsim log`: what is in a log, its lines, and the same run again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use recorder::{Log, Record};
use serde_json::json;

use crate::{Failure, exit, print};

/// Subcommands of `log`.
#[derive(clap::Subcommand)]
#[command(
    after_help = "Examples:\n  usarsim log info run.mcap\n  usarsim log cat run.mcap --type GroundTruth --from 10 --to 20\n  \
    usarsim log replay run.mcap\n\nExit codes: 0 done, 1 a replay that came out different, 65 no log."
)]
pub(crate) enum Command {
    /// Duration, robots, map, seed, counts.
    Info(File),
    /// The lines of the wire with their times: `<` came from a client, `>` went to one.
    Cat(CatArguments),
    /// Feed the recorded lines to a fresh world and compare every state and the digest, bit by bit.
    Replay(File),
}

/// A log.
#[derive(clap::Args)]
pub(crate) struct File {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Options of `log cat`.
#[derive(clap::Args)]
pub(crate) struct CatArguments {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Only lines with this verb or `{Type ..}`, as in DRIVE or GroundTruth.
    #[arg(long = "type", value_name = "WORD")]
    kind: Option<String>,
    /// Only this connection.
    #[arg(long, value_name = "NUMBER")]
    connection: Option<u64>,
    /// From this simulated time, s.
    #[arg(long, default_value_t = 0.0)]
    from: f64,
    /// To this simulated time, s.
    #[arg(long, default_value_t = f64::INFINITY)]
    to: f64,
}

pub(crate) fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Info(File { file, json }) => info(file, &read(file)?, *json),
        Command::Cat(arguments) => cat(arguments, &read(&arguments.file)?),
        Command::Replay(File { file, json }) => replay(file, &read(file)?, *json),
    }
}

fn read(file: &Path) -> Result<Log, Failure> {
    recorder::read(file).map_err(|error| Failure::new(exit::BAD_DATA, error))
}

fn info(file: &Path, log: &Log, as_json: bool) -> Result<(), Failure> {
    let (mut counts, mut robots) = (BTreeMap::new(), BTreeMap::new());
    for entry in &log.entries {
        let kind = match &entry.record {
            Record::In(_) => "lines in",
            Record::Out(_) => "lines out",
            Record::Closed(_) => "connections closed",
            Record::State(state) => {
                robots.insert(state.robot, format!("{} {}", state.class, state.name).trim().to_owned());
                "states"
            }
            Record::Object(_) => "states of objects",
            Record::Warning(_) => "warnings",
        };
        *counts.entry(kind).or_insert(0u64) += 1;
    }
    let seconds = log.entries.last().map_or(0.0, |entry| entry.time);
    let (complete, text) = (!log.end.is_empty(), |key: &str| log.run.get(key).cloned().unwrap_or_default());
    let dropped = log.end.get("dropped").cloned().unwrap_or_default();
    if as_json {
        let run: BTreeMap<_, _> = log.run.iter().filter(|(key, _)| *key != "scene").collect();
        print(json!({
            "file": file.display().to_string(), "seconds": seconds, "complete": complete, "robots": robots,
            "counts": counts, "run": run, "end": log.end,
        }));
        return Ok(());
    }
    print(format_args!("{}: {seconds:.3} s, {}", file.display(), if complete { "complete" } else { "cut off" }));
    print(format_args!("map {}, seed {}, steps of {} s", text("map"), text("seed"), text("time_step")));
    robots.iter().for_each(|(id, name)| print(format_args!("robot {id}: {name}")));
    counts.iter().for_each(|(kind, count)| print(format_args!("{count} {kind}")));
    if complete && dropped != "0" {
        print(format_args!("{dropped} records dropped: the disk was too slow"));
    }
    Ok(())
}

fn cat(arguments: &CatArguments, log: &Log) -> Result<(), Failure> {
    let CatArguments { kind, connection, from, to, .. } = arguments;
    let fits = |text: &str, wanted: &str| {
        let line = gamebots_proto::Line::parse(text);
        let names = [Some(line.verb.as_str()), line.get("Type")];
        names.into_iter().flatten().any(|name| name.eq_ignore_ascii_case(wanted))
    };
    for entry in log.entries.iter().filter(|entry| (*from..=*to).contains(&entry.time)) {
        let (arrow, line) = match &entry.record {
            Record::In(line) => ('<', line),
            Record::Out(line) => ('>', line),
            _ => continue,
        };
        if connection.is_some_and(|connection| connection != line.connection) {
            continue;
        }
        if kind.as_ref().is_none_or(|kind| fits(&line.line, kind)) {
            print(format_args!("{:.4} {} {arrow} {}", entry.time, line.connection, line.line));
        }
    }
    Ok(())
}

fn replay(file: &Path, log: &Log, as_json: bool) -> Result<(), Failure> {
    let replay = recorder::replay(log).map_err(|error| Failure::new(exit::BAD_DATA, error))?;
    let recorded = replay.recorded.map(|digest| format!("{digest:016x}"));
    if as_json {
        print(json!({
            "file": file.display().to_string(), "same": replay.is_same(), "seconds": replay.seconds,
            "digest": format!("{:016x}", replay.digest), "recorded": recorded, "states": replay.states,
            "first_difference": replay.first_difference,
        }));
    }
    if !replay.is_same() {
        let first = replay.first_difference.map_or("at the end".to_owned(), |time| format!("first at {time:.3} s"));
        return Err(Failure::new(
            exit::FAILURE,
            format_args!("{}: the replay came out different, {first}", file.display()),
        ));
    }
    if !as_json {
        let digest = recorded.map_or("no digest, the log was cut off".to_owned(), |digest| format!("digest {digest}"));
        print(format_args!("{:.3} s again with the same bits: {} states, {digest}", replay.seconds, replay.states));
    }
    Ok(())
}
