//! `usarsim log recover`.

use std::path::PathBuf;

use recorder::{RecoverError, Recovered};
use serde_json::json;

use crate::{Failure, exit, print};

/// Options of `log recover`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// The log; it is not changed.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// The output file, by default the log's name with .recovered.mcap. Must not exist.
    #[arg(long, value_name = "FILE.mcap")]
    out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(Arguments { file, out, json }: &Arguments) -> Result<(), Failure> {
    let out = out.clone().unwrap_or_else(|| file.with_extension("recovered.mcap"));
    if out.exists() {
        let text = format!("{} exists: give another with --out", out.display());
        return Err(Failure::new(exit::USAGE, text));
    }
    let Recovered { messages, seconds, damage } = recorder::recover(file, &out).map_err(|error| match error {
        RecoverError::Read(error) => Failure::new(exit::BAD_DATA, error),
        RecoverError::Write(error) => Failure::new(exit::FAILURE, error),
    })?;
    super::report_damage(file, damage.as_deref());
    let out = out.display();
    if *json {
        print(json!({"file": out.to_string(), "messages": messages, "seconds": seconds, "damage": damage}));
    } else {
        print(format_args!("{out}: {messages} messages up to {seconds:.3} s"));
    }
    Ok(())
}
