//! Options of commands that say what robots carry.

use std::path::PathBuf;

use scene_loader::{Equipment, FileProblem};

use crate::terminal::printable;
use crate::{Failure, exit};

/// Options for the equipment of robots.
#[derive(clap::Args)]
pub(crate) struct Choice {
    /// Items that robots carry: `shipped`, as their files say; `robocup2014`, as at that competition; or a TOML file with the
    /// [[CLASS.sensor]] and [[CLASS.mount]] tables of classes.
    #[arg(long, env = "USARSIM_EQUIPMENT", value_name = "NAME|FILE", conflicts_with = "ini", hide_short_help = true)]
    equipment: Option<String>,
    /// Take the robots' items and the sensors' settings from a USARSim ini file, as DefaultUSAR.ini or UT2004's USARBot.ini. May be given
    /// several times, in the order in which Unreal reads them.
    #[arg(long, value_name = "FILE.ini", hide_short_help = true)]
    ini: Vec<PathBuf>,
}

impl Choice {
    /// Loads the equipment.
    pub(crate) fn load(&self) -> Result<Equipment, Failure> {
        let loaded = match &self.equipment {
            Some(name) => Equipment::load(name),
            None if self.ini.is_empty() => Ok(Equipment::default()),
            None => Equipment::of_inis(&self.ini),
        };
        loaded.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))
    }
}

/// Prints what has no effect on stderr. Its reader may be gone.
pub(crate) fn warn(problems: &[FileProblem]) {
    use std::io::Write;
    for problem in problems {
        let _ = writeln!(std::io::stderr(), "{}", printable(&format!("warning: {problem}")));
    }
}
