//! `usarsim log`: reads, exports, plots, replays and repairs logs.

mod cat;
mod export;
mod info;
pub(crate) mod plot;
mod recover;
mod replay;

use std::collections::BTreeMap;
use std::path::Path;

use recorder::{Log, Record};

use crate::{Failure, exit};

/// Subcommands of `log`.
#[derive(clap::Subcommand)]
#[command(
    after_help = "Examples:\n  usarsim log info run.mcap\n  usarsim log cat run.mcap --type GroundTruth --from 10 --to 20\n  \
    usarsim log plot run.mcap --out path.png\n  usarsim log export run.mcap --csv > states.csv\n  \
    usarsim log replay run.mcap\n  usarsim log replay run.mcap --serve --rtf 2\n\n\
    Exit codes: 0 done, 1 a replay that differs or a file that cannot be written, 2 usage, 65 not a log, 69 address in use."
)]
pub(crate) enum Command {
    /// Print duration, robots, map, seed and counts.
    Info(info::Arguments),
    /// Print the lines of the wire with their times: `<` came from a client, `>` went to one.
    Cat(cat::Arguments),
    /// Write the states of the robots as a table, or the log as messages of ROS 2.
    Export(export::Arguments),
    /// Draw the path over the map, or fields against time.
    Plot(plot::Arguments),
    /// Run the recorded lines again in a fresh world and compare every state and the digest bit by bit, or play the recorded
    /// messages to clients.
    Replay(replay::Arguments),
    /// Recover a log that was cut off: copy everything before the cut.
    Recover(recover::Arguments),
}

pub(crate) fn run(command: Command) -> Result<(), Failure> {
    match command {
        Command::Info(arguments) => info::run(&arguments),
        Command::Cat(arguments) => cat::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Plot(arguments) => plot::run(&arguments),
        Command::Replay(arguments) => replay::run(arguments),
        Command::Recover(arguments) => recover::run(&arguments),
    }
}

pub(crate) fn read(file: &Path) -> Result<Log, Failure> {
    let log = recorder::read(file).map_err(|error| Failure::new(exit::BAD_DATA, error))?;
    report_damage(file, log.damage.as_deref());
    Ok(log)
}

/// Reports that a file could be read only in part.
pub(crate) fn report_damage(file: &Path, damage: Option<&str>) {
    if let Some(damage) = damage {
        crate::complain(format_args!("{}: {damage}; everything before it is used", file.display()));
    }
}

/// Class and name of the robots that were in the world, by number.
pub(crate) fn robots(log: &Log) -> BTreeMap<u64, (&str, &str)> {
    let states = log.entries.iter().filter_map(|entry| match &entry.record {
        Record::State(state) => Some((state.robot, (state.class.as_str(), state.name.as_str()))),
        _ => None,
    });
    states.collect()
}

/// Finds a robot by its number or name.
pub(crate) fn robot(log: &Log, file: &Path, wanted: &str) -> Result<u64, Failure> {
    let known = robots(log);
    let is = |(robot, (_, name)): &(&u64, &(&str, &str))| robot.to_string() == wanted || *name == wanted;
    known.iter().find(is).map(|(robot, _)| *robot).ok_or_else(|| {
        let names =
            known.iter().map(|(robot, (class, name))| format!("{robot} ({})", format!("{class} {name}").trim_end()));
        let names = if known.is_empty() { "none".to_owned() } else { names.collect::<Vec<_>>().join(", ") };
        Failure::new(exit::USAGE, format_args!("{}: no robot `{wanted}`: it has {names}", file.display()))
    })
}
