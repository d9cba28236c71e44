//! `usarsim log replay`.

use std::path::{Path, PathBuf};

use gamebots_server::{Playback, ServeError, play};
use logbook::Replay;
use recorder::Record;
use serde_json::json;

use crate::serve::tokens;
use crate::signal::stop_signal;
use crate::values::real_time_factor;
use crate::{Failure, exit, print};

/// Options of `log replay`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The logs; of a folder every .mcap file below it.
    #[arg(value_name = "FILE.mcap|FOLDER", required = true)]
    files: Vec<PathBuf>,
    /// Print JSON, a line for each log.
    #[arg(long)]
    json: bool,
    /// Play what one client was sent to every client that connects, until Ctrl-C or SIGTERM.
    #[arg(long)]
    serve: bool,
    /// Play what this connection was sent; unless given, the first that had a robot.
    #[arg(long, value_name = "NUMBER", requires = "serve")]
    connection: Option<u64>,
    /// Address to listen on.
    #[arg(long, default_value = "127.0.0.1", requires = "serve")]
    host: String,
    /// Port to listen on; 0 takes a free one.
    #[arg(long, default_value_t = 3000, requires = "serve")]
    port: u16,
    /// Recorded seconds per second; 0 is as fast as possible.
    #[arg(long, default_value_t = 1.0, value_parser = real_time_factor, requires = "serve")]
    rtf: f64,
    /// Play only to clients whose first line is `LOGIN {Token ..}` with the token of a viewer, from a tokens.toml.
    #[arg(long, env = "USARSIM_TOKEN_FILE", value_name = "FILE.toml")]
    token_file: Option<PathBuf>,
}

pub(super) fn run(arguments: Arguments) -> Result<(), Failure> {
    if arguments.serve {
        return serve(arguments);
    }
    let mut files = Vec::new();
    for path in &arguments.files {
        collect(path, &mut files)?;
    }
    let [mut different, mut unreadable] = [0, 0];
    for file in &files {
        match again(file) {
            Ok(replay) => {
                different += u32::from(!replay.is_same());
                report(file, &replay, arguments.json);
            }
            // One bad log among many does not hide the results of the others.
            Err(failure) if files.len() > 1 => {
                crate::complain(&failure.message);
                unreadable += 1;
            }
            Err(failure) => return Err(failure),
        }
    }
    match (different, unreadable) {
        (0, 0) => Ok(()),
        (0, _) => Err(Failure::new(exit::BAD_DATA, format_args!("{unreadable} of {} logs not replayed", files.len()))),
        _ => Err(Failure::new(exit::FAILURE, format_args!("{different} of {} logs differ", files.len()))),
    }
}

/// Collects a file, or every log in a folder, recursively, in the order of names.
fn collect(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    if !path.is_dir() {
        files.push(path.to_owned());
        return Ok(());
    }
    let failed = |error| Failure::new(exit::BAD_DATA, format_args!("{}: {error}", path.display()));
    let entries: Result<Vec<_>, _> = std::fs::read_dir(path).map_err(failed)?.collect();
    let mut below: Vec<PathBuf> = entries.map_err(failed)?.into_iter().map(|entry| entry.path()).collect();
    below.sort();
    for path in below {
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|ending| ending == "mcap") {
            files.push(path);
        }
    }
    Ok(())
}

fn again(file: &Path) -> Result<Replay, Failure> {
    let log = super::read(file)?;
    let bad = |error| Failure::new(exit::BAD_DATA, format_args!("{}: {error}", file.display()));
    logbook::replay(&log).map_err(bad)
}

fn report(file: &Path, replay: &Replay, as_json: bool) {
    let file = file.display().to_string();
    let Replay { seconds, states, first_difference, .. } = replay;
    if as_json {
        let mut row = replay.to_json();
        row["file"] = file.into();
        print(row);
    } else if replay.is_same() {
        let cut_off = || "no digest, the log was cut off".to_owned();
        let digest = replay.recorded.map_or_else(cut_off, |digest| format!("digest {digest:016x}"));
        print(format_args!(
            "{file}: {seconds:.3} s replayed with the same bits: {states} states and readings, {digest}"
        ));
    } else {
        let first = first_difference.map_or("at the end".to_owned(), |time| format!("first at {time:.3} s"));
        print(format_args!("{file}: the replay differs, {first}"));
    }
}

fn serve(arguments: Arguments) -> Result<(), Failure> {
    let Arguments { files, host, port, rtf, connection, json, token_file, .. } = arguments;
    let tokens = token_file.as_deref().map(tokens).transpose()?;
    let [file] = &files[..] else {
        return Err(Failure::new(exit::USAGE, format_args!("--serve plays one log, got {}", files.len())));
    };
    let log = super::read(file)?;
    let sent = || {
        log.entries.iter().filter_map(|entry| match &entry.record {
            Record::Out(line) => Some((entry.time, line)),
            _ => None,
        })
    };
    let first = || sent().find(|(_, line)| line.robot.is_some()).or_else(|| sent().next());
    let Some(connection) = connection.or_else(|| first().map(|(_, line)| line.connection)) else {
        return Err(Failure::new(exit::BAD_DATA, format_args!("{}: no line was sent to anyone", file.display())));
    };
    let of_connection = sent().filter(|(_, line)| line.connection == connection);
    let lines: Vec<(f64, String)> = of_connection.map(|(time, line)| (time, line.line.clone())).collect();
    if lines.is_empty() {
        let text = format!("{}: nothing was sent to connection {connection}", file.display());
        return Err(Failure::new(exit::USAGE, text));
    }
    let (name, count) = (file.display().to_string(), lines.len());
    let seconds = lines.last().map_or(0.0, |line| line.0) - lines[0].0;
    let ready = |address: std::net::SocketAddr| {
        if json {
            let (host, port) = (address.ip().to_string(), address.port());
            print(json!({"event": "ready", "host": host, "port": port, "lines": count, "seconds": seconds}));
        } else {
            print(format_args!("usarsim plays {name} on {address}: {count} lines of {seconds:.1} s"));
        }
    };
    let playback = Playback { host, port, real_time_factor: rtf, lines, tokens };
    play(playback, ready, stop_signal()).map_err(|error| match error {
        ServeError::Listen { .. } => Failure::new(exit::UNAVAILABLE, error),
        _ => Failure::new(exit::FAILURE, error),
    })
}
