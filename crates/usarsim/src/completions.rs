//! `usarsim completions SHELL`, and the man pages of packages. Both are generated from the definitions of the arguments.

use std::path::PathBuf;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::{Failure, exit, print};

/// Options of `completions`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim completions bash > ~/.local/share/bash-completion/completions/usarsim\n  \
    usarsim completions fish > ~/.config/fish/completions/usarsim.fish\n  \
    usarsim completions zsh > _usarsim               # into a folder of $fpath"
)]
pub(crate) struct Arguments {
    /// The shell.
    shell: Shell,
}

/// Options of `man`.
#[derive(clap::Args)]
pub(crate) struct ManArguments {
    /// The folder.
    folder: PathBuf,
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "usarsim", &mut script);
    print(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}

pub(crate) fn man(arguments: &ManArguments) -> Result<(), Failure> {
    let ManArguments { folder } = arguments;
    let written = std::fs::create_dir_all(folder);
    let written = written.and_then(|()| clap_mangen::generate_to(crate::Arguments::command(), folder));
    written.map_err(|error| Failure::new(exit::FAILURE, format_args!("{}: {error}", folder.display())))
}
