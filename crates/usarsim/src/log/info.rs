//! `usarsim log info`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use recorder::Record;
use serde_json::json;

use crate::{Failure, print};

/// Options of `log info`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(Arguments { file, json }: &Arguments) -> Result<(), Failure> {
    let log = super::read(file)?;
    let mut counts = BTreeMap::new();
    let robots: BTreeMap<u64, String> = super::robots(&log)
        .into_iter()
        .map(|(robot, (class, name))| (robot, format!("{class} {name}").trim().to_owned()))
        .collect();
    for entry in &log.entries {
        let kind = match &entry.record {
            Record::In(_) => ["line in", "lines in"],
            Record::Out(_) => ["line out", "lines out"],
            Record::Sensed(_) => ["reading", "readings"],
            // A log has only one map.
            Record::Map(_) => continue,
            Record::Closed(_) => ["connection closed", "connections closed"],
            Record::Left(_) => ["robot that left", "robots that left"],
            Record::State(_) => ["state", "states"],
            Record::Object(_) => ["state of an object", "states of objects"],
            Record::ObjectSpawned(_) => ["object spawned", "objects spawned"],
            Record::Picture(..) => ["picture", "pictures"],
            Record::ObjectRemoved(_) => ["object removed", "objects removed"],
            Record::Scored(_) => ["change of points", "changes of points"],
            Record::Standings(_) => ["standing", "standings"],
            Record::Warning(_) => ["warning", "warnings"],
        };
        *counts.entry(kind).or_insert(0u64) += 1;
    }
    let seconds = log.entries.last().map_or(0.0, |entry| entry.time);
    let (complete, text) = (!log.end.is_empty(), |key: &str| log.run.get(key).cloned().unwrap_or_default());
    let dropped = log.end.get("dropped").cloned().unwrap_or_default();
    if *json {
        let counts: BTreeMap<_, _> = counts.iter().map(|([_, many], count)| (many, count)).collect();
        let run: BTreeMap<_, _> =
            log.run.iter().filter(|(key, _)| !["scene", "classes"].contains(&key.as_str())).collect();
        print(json!({
            "file": file.display().to_string(), "seconds": seconds, "complete": complete, "robots": robots,
            "counts": counts, "run": run, "end": log.end, "damage": log.damage,
        }));
        return Ok(());
    }
    print(format_args!("{}: {seconds:.3} s, {}", file.display(), if complete { "complete" } else { "cut off" }));
    print(format_args!("map {}, seed {}, steps of {} s", text("map"), text("seed"), text("time_step")));
    robots.iter().for_each(|(id, name)| print(format_args!("robot {id}: {name}")));
    for ([one, many], &count) in &counts {
        print(format_args!("{count} {}", if count == 1 { one } else { many }));
    }
    if complete && dropped != "0" {
        print(format_args!("{dropped} records dropped: the disk was too slow"));
    }
    Ok(())
}
