//! `usarsim check FILE...`.

use std::path::{Path, PathBuf};

use gamebots_server::{Tokens, TokensError};
use names::count;
use scene_loader::LoadError;
use serde_json::json;

use crate::{Failure, exit, print};

/// Options of `check`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim check assets/robots/*/robot.toml maps/*/map.toml\n  \
    usarsim check my-robot.urdf --json")]
pub(crate) struct Arguments {
    /// robot.toml, map.toml, scenario.toml, materials.toml, league.toml, tokens.toml, equipment .toml, .urdf or USARSim .ini files, or folders with a
    /// robot.toml, map.toml or scenario.toml.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print the mistakes as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut problems = Vec::new();
    let mut unreadable = Vec::new();
    for file in &arguments.files {
        if let Some(tokens) = tokens(file) {
            unreadable.extend(tokens.err().map(|error| format!("{}: {error}", file.display())));
            continue;
        }
        match scene_loader::check(file) {
            Ok(assumptions) if !arguments.json => {
                assumptions.iter().for_each(|it| print(format_args!("{}: note: {it}", file.display())));
            }
            Ok(_) => {}
            Err(LoadError::Bad(found)) => problems.extend(found),
            Err(error) => unreadable.push(error.to_string()),
        }
    }
    if arguments.json {
        let found = problems.iter().map(|problem| {
            json!({"file": problem.file, "line": problem.line, "column": problem.column, "message": problem.message})
        });
        let all = found.chain(unreadable.iter().map(|message| json!({"message": message})));
        print(serde_json::Value::from_iter(all));
    } else {
        problems.iter().for_each(print);
        unreadable.iter().for_each(print);
    }
    let mistakes = problems.len() + unreadable.len();
    if mistakes == 0 {
        if !arguments.json {
            print(format_args!("{} good", count(arguments.files.len(), "file")));
        }
        return Ok(());
    }
    let files = count(arguments.files.len(), "file");
    Err(Failure::new(exit::BAD_DATA, format_args!("{} in {files}", count(mistakes, "mistake"))))
}

/// Reads a file of tokens. `None` for another file: only those have such a table.
fn tokens(file: &Path) -> Option<Result<Tokens, TokensError>> {
    let text = scene_loader::text(file).ok()?;
    text.lines().any(|line| line.trim() == "[[token]]").then(|| text.parse())
}
