//! `usarsim log cat`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use recorder::Record;
use serde_json::json;

use crate::{Failure, print};

/// Options of `log cat`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Only lines with this verb or `{Type ..}`, as in DRIVE or GroundTruth.
    #[arg(long = "type", value_name = "WORD")]
    kind: Option<String>,
    /// Only this robot, by number or name: its lines, and those of its connection before it was there.
    #[arg(long, value_name = "ROBOT")]
    robot: Option<String>,
    /// Only this connection.
    #[arg(long, value_name = "NUMBER")]
    connection: Option<u64>,
    /// From this simulated time, s.
    #[arg(long, default_value_t = 0.0)]
    from: f64,
    /// To this simulated time, s.
    #[arg(long, default_value_t = f64::INFINITY)]
    to: f64,
    /// Print a JSON object for each line, with the line as it was sent: otherwise control characters are escaped.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(Arguments { file, kind, robot, connection, from, to, json }: &Arguments) -> Result<(), Failure> {
    let log = super::read(file)?;
    let robot = robot.as_ref().map(|wanted| super::robot(&log, file, wanted)).transpose()?;
    let lines = || {
        log.entries.iter().filter_map(|entry| match &entry.record {
            Record::In(line) => Some((entry.time, ('<', line))),
            Record::Out(line) => Some((entry.time, ('>', line))),
            _ => None,
        })
    };
    let connections: BTreeSet<u64> =
        lines().filter(|(_, (_, line))| line.robot == robot).map(|(_, (_, line))| line.connection).collect();
    for (time, (arrow, line)) in lines().filter(|(time, _)| (*from..=*to).contains(time)) {
        let of_robot =
            robot.is_none() || line.robot == robot || line.robot.is_none() && connections.contains(&line.connection);
        let of_connection = connection.is_none_or(|connection| connection == line.connection);
        if !of_robot || !of_connection || kind.as_ref().is_some_and(|kind| !is(&line.line, kind)) {
            continue;
        }
        if *json {
            let direction = if arrow == '<' { "in" } else { "out" };
            print(json!({
                "time": time, "connection": line.connection, "robot": line.robot, "direction": direction,
                "line": line.line,
            }));
        } else {
            print(format_args!("{time:.4} {} {arrow} {}", line.connection, line.line));
        }
    }
    Ok(())
}

/// True if a line has a word as its verb or type.
fn is(text: &str, wanted: &str) -> bool {
    let line = gamebots_proto::Line::parse(text);
    let names = [Some(line.verb.as_str()), line.get("Type")];
    names.into_iter().flatten().any(|name| name.eq_ignore_ascii_case(wanted))
}
