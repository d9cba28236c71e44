//! `usarsim serve`.

mod opened;
#[cfg(feature = "ros2")]
mod ros2;

use std::io::Write;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gamebots_proto::Dialect;
use gamebots_server::{
    AvailableMap, AvailableScenario, Config, IfTaken, ImageKind, Listener, Open, Propagation, Ready, ServeError,
    Service, Tokens, WorldControl,
};
use scene::{DriveModel, WorldDef};
use scene_loader::{Changes, Communication, Controllers, LeagueFile, ListedScenario, LoadError, Override};
use sim_core::{Options, SavedWorld};
use thread_pool::ThreadPool;

use crate::signal::stop_signal;
use crate::terminal::printable;
use crate::values::{drive_model, real_time_factor, time_step};
use crate::{Failure, equipment, exit, print};

/// Map of a server that is told none.
const DEFAULT_MAP: &str = "hall";
/// Default port of the page.
const DEFAULT_HTTP_PORT: u16 = 8080;
/// Ports of USARSim beside the controllers'.
const TRUTH_PORT: u16 = 3989;
const POSITIONS_PORT: u16 = 7435;
const IMAGES_PORT: u16 = 5003;
const WIRELESS_PORT: u16 = 50000;
const COM_SERVER_PORT: u16 = 5874;

/// Values of options, by name.
const CONTROLS: [(&str, WorldControl); 3] =
    [("everyone", WorldControl::Everyone), ("local", WorldControl::Local), ("nobody", WorldControl::Nobody)];
const MODELS: [(&str, Propagation); 3] =
    [("everywhere", Propagation::Everywhere), ("distance", Propagation::Distance), ("walls", Propagation::Walls)];
const IMAGE_KINDS: [(&str, ImageKind); 6] = [
    ("raw", ImageKind::Raw),
    ("super", ImageKind::Super),
    ("good", ImageKind::Good),
    ("normal", ImageKind::Normal),
    ("fair", ImageKind::Fair),
    ("bad", ImageKind::Bad),
];

/// Controllers in the older dialect.
const UT2004: Service = Service::Controllers { dialect: Some(Dialect::Ut2004) };

/// Options of `serve`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim serve                          # a hall, 127.0.0.1:3000, real time\n  \
    usarsim serve --map slope-4.5 --rtf 10\n  usarsim serve --map my/map.toml --robot my/robot.toml\n  \
    usarsim serve --scenario stairs          # something to do, with a goal and a time\n  \
    usarsim serve --host 0.0.0.0             # other machines can watch and drive\n\n\
    These are the common options; --help lists all.",
    after_long_help = "Examples:\n  usarsim serve                          # a hall, 127.0.0.1:3000, real time\n  \
    usarsim serve --map slope-4.5 --rtf 10\n  usarsim serve --map my/map.toml --robot my/robot.toml --port 0 --json\n  \
    usarsim serve --robot turtlebot3_burger.urdf\n  \
    usarsim serve --equipment robocup2014    # a P3AT with eight sonars\n  \
    usarsim serve --ini DefaultUSAR.ini --ini my/UDKUSAR.ini\n  \
    usarsim serve --scenario stairs          # something to do, with a goal and a time\n  \
    usarsim serve --scenarios my/scenarios   # more of that on the page\n  \
    usarsim serve --league rescue --log run.mcap --result result.json\n  \
    usarsim serve --from usarsim-hall.json   # go on with a world that the page saved\n  \
    usarsim serve --host 0.0.0.0             # other machines can watch and drive\n  \
    usarsim serve --host 0.0.0.0 --control local  # only this machine can pause and reset\n  \
    usarsim serve --host 0.0.0.0 --token-file tokens.toml  # only those with a token can watch and drive\n\n\
    The server runs until Ctrl-C or SIGTERM and then ends with exit code 0."
)]
pub(crate) struct Arguments {
    /// A map by name (see `usarsim maps`), or the path of a map.toml or of its folder.
    /// Defaults to `hall`, or to the map of the league.
    #[arg(long, env = "USARSIM_MAP", value_name = "NAME|FILE", help_heading = "World")]
    map: Option<String>,
    /// Play a league: teams, their start poses, a time limit, and points for victims and zones, from a league.toml; `rescue` is built in.
    /// The page shows the points; the world stops when the time is up.
    #[arg(long, env = "USARSIM_LEAGUE", value_name = "NAME|FILE", help_heading = "World")]
    league: Option<PathBuf>,
    /// Play a scenario: a map with robots, a goal and a time, by its name (see `usarsim scenarios`), or from a scenario.toml or its folder.
    #[arg(
        long,
        env = "USARSIM_SCENARIO",
        value_name = "NAME|FILE",
        conflicts_with_all = ["map", "league"],
        help_heading = "World"
    )]
    scenario: Option<String>,
    /// Offer the scenarios of a folder on the page, beside those that are built in: its folders with a scenario.toml.
    #[arg(long, env = "USARSIM_SCENARIOS", value_name = "FOLDER", help_heading = "World", hide_short_help = true)]
    scenarios: Option<PathBuf>,
    /// Write the result of the league to a JSON file when the time is up, at a reset and at the end. An existing file is kept: the result
    /// is then result-2.json, result-3.json ..
    #[arg(
        long,
        env = "USARSIM_RESULT",
        value_name = "FILE.json",
        requires = "league",
        help_heading = "World",
        hide_short_help = true
    )]
    result: Option<PathBuf>,
    /// Go on with a world that the page saved (`Save the world`), from its file. Its map, robots, seed, time step and units count. An
    /// INIT with the class and name of a robot in it takes that robot over.
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["map", "league", "scenario", "robot", "set", "equipment", "ini", "drive_model", "dt", "seed", "wheel_speeds"], help_heading = "World")]
    from: Option<PathBuf>,
    /// Seed of all randomness: the same seed and commands give the same run.
    #[arg(long, env = "USARSIM_SEED", default_value_t = 0, help_heading = "World", hide_short_help = true)]
    seed: u64,
    /// A further robot class from a robot.toml or its folder, whose class is the name of the folder, or from a URDF, whose class is the name of
    /// the file. May be given several times.
    #[arg(long, env = "USARSIM_ROBOT", value_name = "FILE", help_heading = "Robots")]
    robot: Vec<PathBuf>,
    /// Replace a number: robot.PATH, CLASS.PATH, map.PATH or material.PATH=VALUE, as in robot.wheels.gain=2.5. May be given
    /// several times; `usarsim show` prints the result.
    #[arg(long, value_name = "PATH=VALUE", help_heading = "Robots", hide_short_help = true)]
    set: Vec<Override>,
    #[command(flatten, next_help_heading = "Robots")]
    equipment: equipment::Choice,
    /// Drive model of the robots that support it: articulated, bodies, analytic or kinematic; by default the
    /// one in their robot.toml.
    #[arg(long, env = "USARSIM_DRIVE_MODEL", value_name = "MODEL", value_parser = drive_model, help_heading = "Robots", hide_short_help = true)]
    drive_model: Option<DriveModel>,
    /// When a connection closes, remove only its newest robot, as USARSim does.
    #[arg(long, env = "USARSIM_KEEP_ROBOTS", help_heading = "Robots", hide_short_help = true)]
    keep_robots: bool,
    /// Report mistakes in clients' lines to them as `NFO {Error ..}`. USARSim does not.
    #[arg(long, env = "USARSIM_REPORT_ERRORS", help_heading = "Robots", hide_short_help = true)]
    report_errors: bool,
    /// Unit of wheel speeds on the wire: radians or revolutions a second.
    #[arg(long, env = "USARSIM_WHEEL_SPEEDS", default_value = "rad", help_heading = "Robots", hide_short_help = true)]
    wheel_speeds: WheelSpeeds,
    /// Port of the page with the 3-D view; 0 takes a free one. By default 8080, or a free one if that is taken.
    #[arg(long, env = "USARSIM_HTTP", value_name = "PORT", help_heading = "Page")]
    http: Option<u16>,
    /// Serve no page, even where --http or USARSIM_HTTP asks for one.
    #[arg(long, help_heading = "Page", hide_short_help = true)]
    no_http: bool,
    /// Address to listen on, for controllers and for the page. 0.0.0.0 accepts connections from other machines.
    #[arg(long, env = "USARSIM_HOST", default_value = "127.0.0.1", help_heading = "Ports")]
    host: String,
    /// Port to listen on; 0 takes a free one.
    #[arg(long, env = "USARSIM_PORT", default_value_t = 3000, help_heading = "Ports")]
    port: u16,
    /// Dialect of the server's lines: udk, ut2004 (grouped sonars, GEO in one brace, an answer to every SET, which older controllers
    /// expect), or auto: ut2004 for the robots that only UT2004 had (P2DX, P2AT).
    #[arg(long, env = "USARSIM_DIALECT", default_value = "auto", value_name = "DIALECT", value_parser = dialect, help_heading = "Ports", hide_short_help = true)]
    dialect: DialectChoice,
    /// Serve controllers on this port, too, in UT2004's dialect whatever their robots; 0 takes a free one.
    #[arg(long, env = "USARSIM_UT2004_PORT", value_name = "PORT", help_heading = "Ports", hide_short_help = true)]
    ut2004_port: Option<u16>,
    /// Stream the channels of a log live to Foxglove or Lichtblick on this port (theirs is 8765); 0 takes a free one.
    #[arg(long, env = "USARSIM_FOXGLOVE", value_name = "PORT", help_heading = "Ports", hide_short_help = true)]
    foxglove: Option<u16>,
    /// Port of the poses of robots, objects and victims, for referees and score boards; `off` for none. By default 3989, and none with
    /// --port 0. If another program has it, the server starts without.
    #[arg(long, env = "USARSIM_TRUTH", value_name = "PORT|off", value_parser = port_or_off, help_heading = "Ports", hide_short_help = true)]
    truth: Option<PortOrOff>,
    /// Port of robots and the walls between them, for wireless simulators (WSS); `off` for none. By default 7435, as --truth.
    #[arg(long, env = "USARSIM_POSITIONS", value_name = "PORT|off", value_parser = port_or_off, help_heading = "Ports", hide_short_help = true)]
    positions: Option<PortOrOff>,
    /// Port of the image server: what the first four cameras see, in one picture; `off` for none. By default 5003, as --truth.
    #[arg(long, env = "USARSIM_IMAGES", value_name = "PORT|off", value_parser = port_or_off, help_heading = "Ports", hide_short_help = true)]
    images: Option<PortOrOff>,
    /// Kind of the image server's pictures: raw pixels, or JPEG of quality 100 (super), 75 (good), 50 (normal), 25 (fair) or 10 (bad).
    #[arg(long, env = "USARSIM_IMAGE_KIND", value_name = "KIND", default_value = "raw", value_parser = choice(&IMAGE_KINDS), help_heading = "Ports", hide_short_help = true)]
    image_kind: ImageKind,
    /// Send the first picture of a connection unasked (the image server's LegacyMode): some clients, as UvA's, wait for it and ask afterwards.
    #[arg(long, env = "USARSIM_IMAGE_LEGACY", help_heading = "Ports", hide_short_help = true)]
    image_legacy: bool,
    /// Port of the radio between robots, as of the program WSS; `off` for none. By default 50000, as --truth.
    #[arg(long, env = "USARSIM_WIRELESS", value_name = "PORT|off", value_parser = port_or_off, help_heading = "Ports", hide_short_help = true)]
    wireless: Option<PortOrOff>,
    /// Port of the old relay between robots, ComServer; `off` for none. By default 5874, as --truth.
    #[arg(long, env = "USARSIM_COM_SERVER", value_name = "PORT|off", value_parser = port_or_off, help_heading = "Ports", hide_short_help = true)]
    com_server: Option<PortOrOff>,
    /// Reach of the radio: everywhere, weaker with distance, or weaker with distance and walls. By default everywhere, or as the league
    /// says.
    #[arg(long, env = "USARSIM_PROPAGATION", value_name = "MODEL", value_parser = choice(&MODELS), help_heading = "Ports", hide_short_help = true)]
    propagation: Option<Propagation>,
    /// Most connections. Above it the server accepts no new ones until some close, as in USARSim.
    #[arg(long, env = "USARSIM_MAX_CONNECTIONS", default_value_t = 64, help_heading = "Ports", hide_short_help = true)]
    max_connections: usize,
    #[cfg(feature = "ros2")]
    #[command(flatten, next_help_heading = "ROS 2")]
    ros2: ros2::Ros2Choice,
    /// Real-time factor: simulated seconds per second; 0 is as fast as possible.
    #[arg(long, env = "USARSIM_RTF", default_value_t = 1.0, value_parser = real_time_factor, help_heading = "Time")]
    rtf: f64,
    /// Length of a time step, s. A longer step is faster; with `bodies` it is less accurate.
    #[arg(long, env = "USARSIM_DT", value_name = "SECONDS", default_value_t = sim_core::TIME_STEP, value_parser = time_step, help_heading = "Time", hide_short_help = true)]
    dt: f64,
    /// Threads for the simulation; by default the number of cores. The results are bitwise identical for any number.
    #[arg(long, env = "USARSIM_THREADS", value_parser = clap::value_parser!(u32).range(1..=256), help_heading = "Time", hide_short_help = true)]
    threads: Option<u32>,
    /// Write every line and every pose to an MCAP file. An existing file is kept: the log is then run-2.mcap, run-3.mcap ..
    #[arg(long, env = "USARSIM_LOG", value_name = "FILE.mcap", help_heading = "Log")]
    log: Option<PathBuf>,
    /// `ros2` also writes ROS 2 messages to a second file: run.ros2.mcap beside run.mcap.
    #[arg(
        long,
        env = "USARSIM_LOG_FORMAT",
        value_name = "FORMAT",
        default_value = "native",
        requires = "log",
        help_heading = "Log",
        hide_short_help = true
    )]
    log_format: LogFormat,
    /// Record what robots' cameras see in logs, and stream it to Foxglove: 320 x 240 pixels, ten times a second each.
    #[arg(long, env = "USARSIM_PICTURES", help_heading = "Log", hide_short_help = true)]
    pictures: bool,
    /// Print the ready line as JSON.
    #[arg(long, help_heading = "Log", hide_short_help = true)]
    json: bool,
    /// Panic at this simulated time, to test the report of a defect.
    #[arg(long, hide = true, value_name = "SECONDS")]
    panic_at: Option<f64>,
    /// Let only those watch, drive and control the world who have a token: from a tokens.toml with roles for each (viewer, driver, referee). The
    /// first line to every port is then `LOGIN {Token ..}`, and the page asks for one.
    #[arg(long, env = "USARSIM_TOKEN_FILE", value_name = "FILE.toml", help_heading = "Access")]
    token_file: Option<PathBuf>,
    /// Pages that may pause, step, reset, record, and change the speed or the map: everyone's, only those on this machine
    /// (also through `ssh -L`), or nobody. Everybody can watch and drive their own robots.
    /// Defaults to everyone's, or to what the league says.
    #[arg(long, env = "USARSIM_CONTROL", value_name = "WHO", value_parser = choice(&CONTROLS), help_heading = "Access", hide_short_help = true)]
    control: Option<WorldControl>,
}

/// Creates a parser of values by name.
fn choice<T: Copy + Send + Sync + 'static>(values: &'static [(&'static str, T)]) -> impl TypedValueParser<Value = T> {
    let names = PossibleValuesParser::new(values.iter().map(|(name, _)| *name));
    names.try_map(|name| values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or(name))
}

/// A port, or `None` for no service.
#[derive(Clone, Copy)]
struct PortOrOff(Option<u16>);

#[derive(Clone, Copy, ValueEnum)]
enum WheelSpeeds {
    Rad,
    Rev,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LogFormat {
    Native,
    Ros2,
}

/// A dialect, or `None` if the robot decides.
#[derive(Clone, Copy)]
struct DialectChoice(Option<Dialect>);

fn dialect(text: &str) -> Result<DialectChoice, String> {
    if text == "auto" {
        return Ok(DialectChoice(None));
    }
    text.parse()
        .map(|dialect| DialectChoice(Some(dialect)))
        .map_err(|_: String| "expected auto, udk or ut2004".to_owned())
}

fn port_or_off(text: &str) -> Result<PortOrOff, String> {
    if text == "off" {
        return Ok(PortOrOff(None));
    }
    text.parse().map(|port| PortOrOff(Some(port))).map_err(|_| "expected a port from 0 to 65535, or off".to_owned())
}

pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::new(exit::BAD_CONFIGURATION, error);
    let robots: Vec<&std::path::Path> = arguments.robot.iter().map(PathBuf::as_path).collect();
    let league = arguments.league.as_ref().map(|path| scene_loader::league(path, arguments.map.as_deref()));
    let league = league.transpose().map_err(|error| wrong(&error))?;
    let map = arguments.map.as_deref().or(league.as_ref().map(|league| league.map.as_str())).unwrap_or(DEFAULT_MAP);
    let (mut world, saved) = match &arguments.from {
        Some(path) => {
            gamebots_server::read_saved(path).map(|(scene, state)| (scene, Some(state))).map_err(|it| wrong(&it))?
        }
        None => {
            let equipment = arguments.equipment.load()?;
            let changes = Changes { overrides: &arguments.set, equipment: &equipment };
            let loaded = match &arguments.scenario {
                None => scene_loader::load_equipped(map, &robots, changes),
                Some(name) => scene_loader::scenario(name)
                    .and_then(|setting| scene_loader::load_around(setting, &robots, changes)),
            };
            let world = loaded.map_err(|error| wrong(&error))?;
            equipment::warn(&equipment.warnings(world.robots.keys().map(String::as_str)));
            (world, None)
        }
    };
    if let Some(league) = &league {
        world.league = Some(league.league.clone());
        world.check().map_err(|problem| wrong(&problem))?;
    }
    let tokens = arguments.token_file.as_deref().map(tokens).transpose()?;
    if let Some((tokens, league)) = tokens.as_ref().zip(world.league.as_ref())
        && let Some(unknown) = tokens.teams().find(|team| league.team(team).is_none())
    {
        let teams = league.teams.iter().map(|team| team.name.as_str()).collect::<Vec<_>>().join(", ");
        return Err(wrong(&format!("--token-file: no team `{unknown}` in the league: expected one of {teams}")));
    }
    let drive_model = arguments.drive_model;
    if drive_model.is_some() {
        world.robots.change(move |robot| robot.set_drive_model(drive_model));
    }
    // Shipped classes, which are read later, have no notes.
    for (_, robot) in world.robots.read() {
        for assumption in &robot.assumptions {
            let text = format!("{}: note: {assumption}", robot.class);
            // The reader of stderr may be gone.
            let _ = writeln!(std::io::stderr(), "{}", printable(&text));
        }
    }
    let speed_unit = match arguments.wheel_speeds {
        WheelSpeeds::Rad => 1.0,
        WheelSpeeds::Rev => std::f64::consts::TAU,
    };
    let options =
        Options { seed: arguments.seed, speed_unit, time_step: arguments.dt, keep_robots: arguments.keep_robots };
    let page = |port, if_taken| Listener { service: Service::Page, port, if_taken };
    let page =
        arguments.http.map_or_else(|| page(DEFAULT_HTTP_PORT, IfTaken::Another), |port| page(port, IfTaken::Fail));
    // Several servers on free ports do not compete for these.
    let usual = |port| PortOrOff(Some(port).filter(|_| arguments.port != 0));
    let beside = |choice: Option<PortOrOff>, service, port| {
        let PortOrOff(port) = choice.unwrap_or_else(|| usual(port));
        port.map(|port| Listener { service, port, if_taken: IfTaken::LeaveOut })
    };
    let DialectChoice(dialect) = arguments.dialect;
    let mut listeners = vec![Listener::new(Service::Controllers { dialect }, arguments.port)];
    listeners.extend(arguments.ut2004_port.map(|port| Listener::new(UT2004, port)));
    listeners.extend(Some(page).filter(|_| !arguments.no_http));
    listeners.extend(arguments.foxglove.map(|port| Listener::new(Service::Foxglove, port)));
    listeners.extend(beside(arguments.truth, Service::Truth, TRUTH_PORT));
    listeners.extend(beside(arguments.positions, Service::Positions, POSITIONS_PORT));
    listeners.extend(beside(arguments.images, Service::Images, IMAGES_PORT));
    listeners.extend(beside(arguments.wireless, Service::Wireless, WIRELESS_PORT));
    listeners.extend(beside(arguments.com_server, Service::ComServer, COM_SERVER_PORT));
    let threads = arguments.threads.map_or_else(ThreadPool::of_machine, |threads| ThreadPool::new(threads as usize));
    #[cfg(feature = "ros2")]
    let ros2 = arguments.ros2.options(tokens.is_some(), &world)?.map(|options| ::ros2::Options {
        read_robot: Some(::ros2::ReadRobot(Arc::new(move |text| opened::robot_of_text(text, drive_model)))),
        ..options
    });
    let config = Config {
        #[cfg(feature = "ros2")]
        ros2,
        panic_at: arguments.panic_at,
        maps: other_maps(&arguments.set, &world).into(),
        scenarios: scenarios(arguments.scenarios.as_deref(), arguments.scenario.as_deref())?.into(),
        open: Some(Open(Arc::new(move |files, work, chosen| opened::open(files, work, chosen, drive_model)))),
        options: saved.as_ref().map_or(options, SavedWorld::options),
        saved,
        host: arguments.host,
        listeners,
        real_time_factor: arguments.rtf,
        max_connections: arguments.max_connections,
        report_errors: arguments.report_errors,
        log: arguments.log,
        ros2_log: arguments.log_format == LogFormat::Ros2,
        pictures: arguments.pictures,
        result: arguments.result,
        world_control: world_control(arguments.control, league.as_ref()),
        tokens,
        propagation: propagation(arguments.propagation, league.as_ref()),
        image_kind: arguments.image_kind,
        image_legacy: arguments.image_legacy,
        threads: threads.map_err(|error| Failure::new(exit::FAILURE, error))?,
        ..Config::new(world)
    };
    let map = config.world.map.name.clone();
    let classes: Vec<String> = config.world.robots.keys().cloned().collect();
    let json = arguments.json;
    let ready = move |ready: Ready| print(ready_line(&ready, &map, &classes, json));
    gamebots_server::run(config, ready, stop_signal()).map_err(|error| match error {
        ServeError::Listen { .. } => Failure::new(exit::UNAVAILABLE, error),
        ServeError::WorldPanicked { .. } => Failure::new(exit::DEFECT, error),
        ServeError::Saved(_) => Failure::new(exit::BAD_CONFIGURATION, error),
        _ => Failure::new(exit::FAILURE, error),
    })
}

/// Reads a file of tokens. Warns of those that could be guessed.
pub(crate) fn tokens(path: &Path) -> Result<Tokens, Failure> {
    let wrong = |message: String| Failure::new(exit::BAD_CONFIGURATION, message);
    let text = scene_loader::text(path).map_err(|error| wrong(error.to_string()))?;
    let tokens: Tokens = text.parse().map_err(|error| wrong(format!("{}: {error}", path.display())))?;
    for number in tokens.guessable() {
        tracing::warn!(
            "{}: token {number} could be guessed: expected a random one, as `openssl rand -hex 16` makes",
            path.display()
        );
    }
    Ok(tokens)
}

/// Returns the pages that control the world: as chosen, or as the league says.
fn world_control(choice: Option<WorldControl>, league: Option<&LeagueFile>) -> WorldControl {
    let of_league = |league: &LeagueFile| match league.control {
        Controllers::Everyone => WorldControl::Everyone,
        Controllers::Local => WorldControl::Local,
        Controllers::Nobody => WorldControl::Nobody,
    };
    choice.or(league.map(of_league)).unwrap_or(WorldControl::Everyone)
}

/// Returns the model of the radio: as chosen, or as the league says.
fn propagation(choice: Option<Propagation>, league: Option<&LeagueFile>) -> Propagation {
    let of_league = |league: &LeagueFile| match league.communication {
        Communication::Everywhere => Propagation::Everywhere,
        Communication::Distance => Propagation::Distance,
        Communication::Walls => Propagation::Walls,
    };
    choice.or(league.map(of_league)).unwrap_or_default()
}

/// Returns the scenarios that the page offers: those that are built in, those of a folder, and the one that is played.
fn scenarios(folder: Option<&Path>, played: Option<&str>) -> Result<Vec<AvailableScenario>, Failure> {
    let wrong = |error: LoadError| Failure::new(exit::BAD_CONFIGURATION, error);
    let mut names = scene_loader::scenario_names();
    for path in folder.map(scene_loader::scenarios_in).transpose().map_err(wrong)?.into_iter().flatten() {
        let path = path.display().to_string();
        scene_loader::scenario(&path).map_err(wrong)?;
        names.push(path);
    }
    names.extend(played.map(str::to_owned));
    let available = |ListedScenario { found, card, demo, picture }| {
        let read = Arc::new(move || scene_loader::scenario(&found).map_err(|error| error.to_string()));
        AvailableScenario { card, picture, read, demo }
    };
    let listed = scene_loader::listed_scenarios(&names).map_err(wrong)?;
    Ok(listed.into_iter().map(available).collect())
}

/// Returns the maps that the page offers: the first one, then the built-in ones with the same overrides. A scenario has a map of its own.
fn other_maps(overrides: &[Override], world: &WorldDef) -> Vec<AvailableMap> {
    let first = Some(&world.map).filter(|_| world.scenario.is_none());
    let names = scene_loader::map_names().into_iter().filter(|name| first.is_none_or(|first| *name != first.name));
    let available = |name: String| {
        if !overrides.is_empty() {
            // An override may apply to the first map alone, so maps that it does not fit are left out.
            return scene_loader::map(&name, overrides).ok().map(AvailableMap::from);
        }
        let (description, of) = (scene_loader::map_description(&name)?, name.clone());
        let read = Arc::new(move || scene_loader::map(&of, &[]).map_err(|error| error.to_string()));
        Some(AvailableMap { name, description, read, is_added: false })
    };
    first.cloned().map(AvailableMap::from).into_iter().chain(names.filter_map(available)).collect()
}

fn ready_line(ready: &Ready, map: &str, classes: &[String], json: bool) -> String {
    let (page, port) = (ready.of(Service::Page), |service| ready.of(service).map(|address| address.port()));
    let foxglove = port(Service::Foxglove);
    let ut2004 = ready.of(UT2004).filter(|other| Some(*other) != ready.controllers()).map(|address| address.port());
    let Some(address) = ready.controllers() else { return String::new() };
    if json {
        serde_json::json!({
            "event": "ready", "host": address.ip().to_string(), "port": address.port(), "ut2004_port": ut2004, "http": port(Service::Page),
            "foxglove": foxglove, "truth": port(Service::Truth), "positions": port(Service::Positions),
            "images": port(Service::Images), "wireless": port(Service::Wireless), "com_server": port(Service::ComServer), "map": map, "robots": classes,
        })
        .to_string()
    } else {
        let ip = if address.ip().is_unspecified() { own_address() } else { address.ip() };
        let see = page.map(|page| SocketAddr::new(ip, page.port()));
        let see = see.map(|page| format!("\nsee it at http://{page}")).unwrap_or_default();
        let foxglove = foxglove.map(|port| format!("\nFoxglove: open ws://{ip}:{port}")).unwrap_or_default();
        format!("usarsim ready on {address}, map {map}, {} classes of robots{see}{foxglove}", classes.len())
    }
}

/// Returns an address by which other machines reach this one. Connecting a UDP socket only chooses a route and sends nothing.
fn own_address() -> IpAddr {
    let local = Ipv4Addr::LOCALHOST.into();
    let socket = UdpSocket::bind("0.0.0.0:0");
    let routed = socket.and_then(|it| it.connect("192.0.2.1:9").and_then(|()| it.local_addr()));
    routed.map_or(local, |address| address.ip())
}
