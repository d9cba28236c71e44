//! `usarsim copy`: copies the files of a built-in robot or map, as a start for one's own.

use std::path::PathBuf;

use crate::output::{new_folder, write};
use crate::show::What;
use crate::{Failure, exit, print};

/// Options of `copy`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim copy map arena my-arena && usarsim serve --map my-arena\n  \
    usarsim copy robot P3AT MyPioneer && usarsim serve --robot MyPioneer/robot.toml\n\nA robot's class is the name of its \
    folder: INIT {ClassName USARBot.MyPioneer}.")]
pub(crate) struct Arguments {
    /// Kind of definition.
    what: What,
    /// Its name (see `usarsim maps`, `usarsim robots`).
    name: String,
    /// New folder for the files. It must not exist.
    folder: PathBuf,
}

pub(crate) fn run(Arguments { what, name, folder }: &Arguments) -> Result<(), Failure> {
    let files = match what {
        What::Robot => scene_loader::robot_files(name),
        What::Map => scene_loader::map_files(name),
    };
    let files = files.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
    new_folder(folder)?;
    for (file, content) in files {
        let path = folder.join(file);
        write(&path, content)?;
        print(path.display());
    }
    Ok(())
}
