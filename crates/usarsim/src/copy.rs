//! `usarsim copy`: the files of a robot or a map that is built in, to begin one's own with.

use std::path::{Path, PathBuf};

use crate::show::What;
use crate::{Failure, exit, print};

/// Options of `copy`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim copy map arena my-arena && usarsim serve --map my-arena\n  \
    usarsim copy robot P3AT MyPioneer && usarsim serve --robot MyPioneer/robot.toml\n\nThe class of a robot is the name of its \
    folder: INIT {ClassName USARBot.MyPioneer}.")]
pub(crate) struct Arguments {
    /// What to copy.
    what: What,
    /// Its name (see `usarsim maps`, `usarsim robots`).
    name: String,
    /// A folder that is not there yet.
    folder: PathBuf,
}

pub(crate) fn run(Arguments { what, name, folder }: &Arguments) -> Result<(), Failure> {
    let files = match what {
        What::Robot => scene_loader::robot_files(name),
        What::Map => scene_loader::map_files(name),
    };
    let files = files.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
    let failed = |path: &Path, error| Failure::new(exit::FAILURE, format_args!("{}: {error}", path.display()));
    // Nothing of anybody's is overwritten: not even an empty folder that another program has made for itself.
    std::fs::create_dir(folder).map_err(|error| failed(folder, error))?;
    for (file, content) in files {
        let path = folder.join(file);
        std::fs::write(&path, content).map_err(|error| failed(&path, error))?;
        print(path.display());
    }
    Ok(())
}
