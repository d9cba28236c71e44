//! The program `usarsim` as a library: arguments, dispatch, and the only place that produces exit codes. The Python package runs the
//! same program.

mod bench;
mod calibrate;
mod check;
mod completions;
mod connect;
mod copy;
mod equipment;
mod experiment;
mod import;
mod import_map;
mod league;
mod list;
mod log;
mod output;
mod progress;
mod relay;
mod serve;
mod show;
mod signal;
mod snapshot;
mod sweep;
mod teleop;
mod terminal;
mod validate;
mod values;

use std::ffi::OsString;

use clap::{Parser, Subcommand};

use terminal::printable;

/// Exit codes, after sysexits.h.
mod exit {
    pub(crate) const FAILURE: u8 = 1;
    pub(crate) const USAGE: u8 = 2;
    pub(crate) const BAD_DATA: u8 = 65;
    pub(crate) const UNAVAILABLE: u8 = 69;
    pub(crate) const DEFECT: u8 = 70;
    pub(crate) const BAD_CONFIGURATION: u8 = 78;
}

/// A robot simulator that replaces the USARSim server: controllers written for USARSim connect to port 3000 and drive.
#[derive(Parser)]
#[command(
    name = "usarsim",
    version,
    after_help = "Examples:\n  usarsim serve\n  usarsim serve --map arena --log run.mcap\n  \
    usarsim check maps/rough/map.toml\n\nExit codes: 0 done, 1 failure, 2 usage, 65 bad file, 69 no connection or address in use, \
    70 a defect of this program, 78 bad map or robot"
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Print debug messages on stderr; `-vv` prints trace messages too.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Print only errors on stderr.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Run a simulation server until Ctrl-C or SIGTERM.
    Serve(Box<serve::Arguments>),
    /// Drive a robot with the keyboard.
    Teleop(teleop::Arguments),
    /// Send lines to a server and print its answers, with history and completion.
    Connect(connect::Arguments),
    /// Let controllers that know no token reach a server that asks for one.
    Relay(relay::Arguments),
    /// List the maps.
    Maps(list::Arguments),
    /// List the scenarios: robots on maps with goals.
    Scenarios(list::Arguments),
    /// List the robot classes with their sensors and actuators.
    Robots(list::Arguments),
    /// Draw a map, with or without a robot, to a PNG file.
    Snapshot(snapshot::Arguments),
    /// Print every number of a robot or a map, including overrides.
    Show(show::Arguments),
    /// Copy the files of a built-in robot or map, as a start for your own.
    Copy(copy::Arguments),
    /// Make a robot from a ROS description package.
    Import(import::Arguments),
    /// Make a map from a glTF, OBJ, STL or COLLADA mesh, or from a world of Gazebo (SDF).
    ImportMap(import_map::Arguments),
    /// Check robot.toml, map.toml, scenario.toml, materials.toml, league.toml, tokens.toml, equipment, URDF and ini files and report every mistake with its line.
    Check(check::Arguments),
    /// Run the physical checks of a robot on wheels.
    Validate(validate::Arguments),
    /// Measure the speed and the accuracy of the simulation.
    Bench(bench::Arguments),
    /// Run the experiments of the thesis "A KUKA youBot simulation in USARSim", or your own.
    #[command(subcommand)]
    Experiment(experiment::Command),
    /// Find the numbers of a robot's wheels from a log of its motion.
    Calibrate(calibrate::Arguments),
    /// Run an experiment of many runs in batches, here or spread over machines.
    Sweep(sweep::Arguments),
    /// Show the points, the map and the paths of a league that was played.
    #[command(subcommand)]
    League(league::Command),
    /// Inspect, export, plot, replay and repair logs.
    #[command(subcommand)]
    Log(log::Command),
    /// Print the completion script of a shell. --help says where to put it.
    Completions(completions::Arguments),
    /// Write the man pages into a folder.
    #[command(hide = true)]
    Man(completions::ManArguments),
    /// Be the process of a server's node of ROS 2, by pipes.
    #[cfg(feature = "ros2")]
    #[command(hide = true)]
    Ros2Node,
}

/// Runs the program and returns its exit code. The first argument is the program's name. Help and wrong arguments end the process.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = Arguments::parse_from(arguments);
    // Dropping the guard writes the remaining lines.
    let _logging = start_logging(&arguments);
    report_panics();
    match std::panic::catch_unwind(|| dispatch(arguments)) {
        Ok(Ok(())) => 0,
        Ok(Err(Failure { code, message })) => {
            complain(message);
            code
        }
        // The panic hook has logged the place.
        Err(_) => exit::DEFECT,
    }
}

fn dispatch(arguments: Arguments) -> Result<(), Failure> {
    match arguments.command {
        Command::Serve(arguments) => serve::run(*arguments),
        Command::Teleop(arguments) => teleop::run(&arguments),
        Command::Connect(arguments) => connect::run(&arguments),
        Command::Relay(arguments) => relay::run(&arguments),
        Command::Maps(arguments) => list::maps(&arguments),
        Command::Scenarios(arguments) => list::scenarios(&arguments),
        Command::Robots(arguments) => list::robots(&arguments),
        Command::Snapshot(arguments) => snapshot::run(&arguments),
        Command::Show(arguments) => show::run(&arguments),
        Command::Copy(arguments) => copy::run(&arguments),
        Command::ImportMap(arguments) => import_map::run(&arguments),
        Command::Import(arguments) => import::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Validate(arguments) => validate::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Experiment(command) => experiment::run(&command, arguments.quiet),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Sweep(command) => sweep::run(&command, arguments.quiet),
        Command::League(command) => league::run(&command),
        Command::Log(command) => log::run(command),
        Command::Completions(arguments) => completions::run(&arguments),
        Command::Man(arguments) => completions::man(&arguments),
        #[cfg(feature = "ros2")]
        Command::Ros2Node => ros2::run_node().map_err(|error| Failure::new(exit::FAILURE, error)),
    }
}

/// Logs a panic in one line with its place. `RUST_BACKTRACE=1` adds the stack.
fn report_panics() {
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        let message = panic.payload_as_str().unwrap_or("without a message");
        let calls = std::backtrace::Backtrace::capture();
        let calls = match calls.status() {
            std::backtrace::BacktraceStatus::Captured => format!("\n{calls}"),
            _ => String::new(),
        };
        tracing::error!("a defect of this program: panicked at {place}: {message}{calls}");
    }));
}

/// A reason for the program to end with an exit code other than 0.
struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    fn new(code: u8, message: impl std::fmt::Display) -> Self {
        Self { code, message: message.to_string() }
    }
}

/// Most log lines that wait for the reader of stderr. The queue takes 32 bytes for each from the start.
const MAX_WAITING_LINES: usize = 8192;

/// Starts a thread that writes log lines, so a stopped reader of stderr does not stop the server. If the queue is full, lines are dropped.
fn start_logging(arguments: &Arguments) -> tracing_appender::non_blocking::WorkerGuard {
    use std::io::IsTerminal;
    use tracing_subscriber::filter::{LevelFilter, Targets};
    use tracing_subscriber::prelude::*;
    let level = match (arguments.quiet, arguments.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::INFO,
        (false, 1) => LevelFilter::DEBUG,
        (false, _) => LevelFilter::TRACE,
    };
    let colour = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let queue = tracing_appender::non_blocking::NonBlockingBuilder::default().buffered_lines_limit(MAX_WAITING_LINES);
    let (writer, guard) = queue.finish(std::io::stderr());
    // Foxglove's server says where it listens, which is behind our own port.
    let targets = Targets::new().with_default(level).with_target("foxglove", level.min(LevelFilter::WARN));
    // DDS writes a line for every lost fragment, and complains when it leaves.
    let targets = targets.with_target("rustdds", LevelFilter::OFF);
    let lines = tracing_subscriber::fmt::layer().with_writer(writer).with_ansi(colour).with_target(false);
    tracing_subscriber::registry().with(lines.with_filter(targets)).init();
    guard
}

/// Reports an error on stderr, without waiting for a reader that is gone or has stopped.
fn complain(message: impl std::fmt::Display) {
    use std::io::Write;
    let text = format!("usarsim: {}\n", printable(&message.to_string()));
    let (written, done) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let _ = std::io::stderr().write_all(text.as_bytes());
        let _ = written.send(());
    });
    let _ = done.recv_timeout(std::time::Duration::from_secs(1));
}

/// Prints to stdout with control characters escaped. A reader that is gone is not an error.
fn print(text: impl std::fmt::Display) {
    use std::io::Write;
    let mut stdout = std::io::stdout().lock();
    let _ = writeln!(stdout, "{}", printable(&text.to_string())).and_then(|()| stdout.flush());
}
