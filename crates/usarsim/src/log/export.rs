//! `usarsim log export`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use recorder::{Table, export};

use crate::output::keep_inputs;
use crate::{Failure, exit};

/// Options of `log export`.
#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("format").required(true))]
#[command(
    after_help = "Examples:\n  usarsim log export run.mcap --csv > states.csv\n  usarsim log export run.mcap --parquet --out states.parquet\n  \
    usarsim log export run.mcap --tum --robot Ann > ann.tum\n  usarsim log export run.mcap --ros2 --out run.ros2.mcap\n\n\
    Tables have a row for each robot and 0.02 s: time, robot, pose, velocity and wheels in SI units, world frame (x forward, \
    y right, z down)."
)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// A table as CSV.
    #[arg(long, group = "format")]
    csv: bool,
    /// A table as Parquet; needs --out.
    #[arg(long, group = "format", requires = "out")]
    parquet: bool,
    /// The poses of one robot as TUM trajectory, as evo reads it: time x y z qx qy qz qw.
    #[arg(long, group = "format")]
    tum: bool,
    /// Messages of ROS 2 in an MCAP file; needs --out.
    #[arg(long, group = "format", requires = "out")]
    ros2: bool,
    /// Only this robot, by number or name.
    #[arg(long, value_name = "ROBOT", conflicts_with = "ros2")]
    robot: Option<String>,
    /// The output file, by default stdout. An existing file is replaced.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { file, csv, parquet, robot, out, ros2, .. } = arguments;
    let out = out.as_deref();
    out.map_or(Ok(()), |out| keep_inputs(out, &[file]))?;
    let log = super::read(file)?;
    let failed = |error| Failure::new(exit::FAILURE, error);
    if let Some(out) = out.filter(|_| *ros2) {
        return export::ros2(&log, out).map_err(failed);
    }
    let robot = robot.as_ref().map(|wanted| super::robot(&log, file, wanted)).transpose()?;
    let table = Table::of(&log, robot);
    if let Some(out) = out.filter(|_| *parquet) {
        return export::parquet(&table, out).map_err(failed);
    }
    if *csv {
        return write(table.to_csv(), out);
    }
    let robots = super::robots(&log);
    if robot.is_none() && robots.len() > 1 {
        let robots: Vec<String> = robots.keys().map(u64::to_string).collect();
        let text = format!("a trajectory needs one robot: choose it with --robot, one of {}", robots.join(", "));
        return Err(Failure::new(exit::USAGE, text));
    }
    write(table.to_tum(), out)
}

/// Writes lines to a file, or to a stdout whose reader may go away.
fn write(mut lines: impl Iterator<Item = String>, out: Option<&Path>) -> Result<(), Failure> {
    let Some(path) = out else {
        let mut stdout = BufWriter::new(std::io::stdout().lock());
        let _ = lines.try_for_each(|line| writeln!(stdout, "{line}")).and_then(|()| stdout.flush());
        return Ok(());
    };
    let mut write = || {
        let mut file = BufWriter::new(File::create(path)?);
        lines.try_for_each(|line| writeln!(file, "{line}"))?;
        file.flush()
    };
    write().map_err(|error| Failure::new(exit::FAILURE, format_args!("{}: {error}", path.display())))
}
