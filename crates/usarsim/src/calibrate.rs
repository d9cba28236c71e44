//! `usarsim calibrate`: the numbers of a robot's wheels from a log of its motion.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use experiments::calibrate::{Calibration, Number, Record, calibrate, write_robot};
use recorder::{Table, bag};
use scene::RobotDef;

use crate::output::keep_inputs;
use crate::values::within;
use crate::{Failure, exit, log, print};

/// Longest table, bytes: some hours of a robot.
const MAX_TABLE: u64 = 512 << 20;

/// Options of `calibrate`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim calibrate run.mcap my-robot/robot.toml\n  usarsim calibrate drive.csv my-robot/robot.toml --out calibrated.toml\n  \
    usarsim calibrate run.mcap P3AT --robot 2 --json\n  \
    usarsim calibrate drive.csv my-robot/robot.toml --coasting coasting.csv\n  \
    usarsim calibrate bag.mcap my-robot/robot.toml --poses /vrpn/robot/pose --wheels fl,fr,rl,rr\n\nA log is one of `usarsim serve --log`, a bag of ROS 2 (MCAP), or a table with the columns time (s), x, y (m), yaw (rad), and \
    wheel_angle_1 (rad) or wheel_speed_1 (rad/s) for each driven wheel, in the robot's order. What to drive, and what a log cannot tell: \
    docs/howto-calibrate.md. A bag of ROS 2 has the wheels in sensor_msgs/JointState."
)]
pub(crate) struct Arguments {
    /// Log of the robot: .mcap, or a table as CSV.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// The robot: a robot.toml, or the name of a class.
    #[arg(value_name = "ROBOT.toml|CLASS")]
    robot: String,
    /// Log of runs that end without power, for rolling resistance and the friction of the rollers' bearings.
    #[arg(long, value_name = "LOG")]
    coasting: Option<PathBuf>,
    /// Friction between tyres and floor: the stiffness of tyres that is found is in proportion to it.
    #[arg(long, value_name = "COEFFICIENT", default_value_t = 0.6, value_parser = friction)]
    friction: f64,
    /// Only this robot of the log, by number, or in an .mcap by name.
    #[arg(long = "robot", value_name = "ROBOT")]
    only: Option<String>,
    /// Topic of sensor_msgs/JointState in a bag of ROS 2; by default the only one.
    #[arg(long, value_name = "TOPIC")]
    joints: Option<String>,
    /// Topic of the poses in a bag: geometry_msgs/PoseStamped or nav_msgs/Odometry; by default the only one.
    #[arg(long, value_name = "TOPIC")]
    poses: Option<String>,
    /// Names of the wheels' joints in a bag, in the robot's order; by default those of the robot.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    wheels: Vec<String>,
    /// File for robot.toml with the numbers that were found.
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn friction(text: &str) -> Result<f64, String> {
    within(text, 0.01, 10.0)
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { log, robot, only, out, json, .. } = arguments;
    let bad = |error: &dyn std::fmt::Display| Failure::new(exit::BAD_CONFIGURATION, error);
    let def = scene_loader::robot(robot, &[]).map_err(|error| bad(&error))?;
    let read = |log: &Path| if is_bag(log)? { of_bag(arguments, log, &def) } else { record(log, only.as_deref()) };
    let (record, coasting) = (read(log)?, arguments.coasting.as_deref().map(read).transpose()?);
    let found = calibrate(&record, &def, coasting.as_ref(), arguments.friction)
        .map_err(|error| bad(&format_args!("{}: {error}", log.display())))?;
    let mut changed = Vec::new();
    if let Some(out) = out {
        let file = Path::new(robot);
        let logs = std::iter::once(log).chain(&arguments.coasting).map(PathBuf::as_path);
        keep_inputs(out, &logs.chain([file]).collect::<Vec<_>>())?;
        if !file.is_file() {
            return Err(Failure::new(
                exit::USAGE,
                format_args!("--out of the class `{robot}`: expected its robot.toml; `usarsim copy robot` writes one"),
            ));
        }
        let text = scene_loader::text(file).map_err(|error| bad(&error))?;
        let (text, lines) = write_robot(&text, &def, &found).map_err(|error| bad(&format_args!("{robot}: {error}")))?;
        std::fs::write(out, text)
            .map_err(|error| Failure::new(exit::FAILURE, format_args!("{}: {error}", out.display())))?;
        changed = lines;
    }
    if *json {
        print(serde_json::to_string_pretty(&found).unwrap_or_default());
        return Ok(());
    }
    show(&found, arguments.friction);
    if let Some(out) = out {
        print(format_args!("{}: {}", out.display(), changed.join("; ")));
    }
    Ok(())
}

fn record(file: &Path, only: Option<&str>) -> Result<Record, Failure> {
    let bad = |error: &dyn std::fmt::Display| {
        Failure::new(exit::BAD_CONFIGURATION, format_args!("{}: {error}", file.display()))
    };
    if is_mcap(file) {
        let read = log::read(file)?;
        let robot = only.map(|wanted| log::robot(&read, file, wanted)).transpose()?;
        return Record::read(&Table::of(&read, robot).to_csv().collect::<Vec<_>>().join("\n"), None)
            .map_err(|error| bad(&error));
    }
    let mut text = String::new();
    let opened = File::open(file).map_err(|error| bad(&error))?;
    opened.take(MAX_TABLE + 1).read_to_string(&mut text).map_err(|error| bad(&error))?;
    if text.len() as u64 > MAX_TABLE {
        return Err(bad(&format_args!("more than {} MB: expected a shorter table", MAX_TABLE >> 20)));
    }
    Record::read(&text, only).map_err(|error| bad(&error))
}

fn is_mcap(file: &Path) -> bool {
    file.extension().is_some_and(|it| it.eq_ignore_ascii_case("mcap"))
}

fn is_bag(file: &Path) -> Result<bool, Failure> {
    Ok(is_mcap(file) && bag::is_bag(file).map_err(|error| Failure::new(exit::BAD_DATA, error))?)
}

/// Reads a bag of ROS 2.
fn of_bag(arguments: &Arguments, file: &Path, robot: &RobotDef) -> Result<Record, Failure> {
    let Arguments { joints, poses, wheels, .. } = arguments;
    let bag =
        bag::read(file, joints.as_deref(), poses.as_deref()).map_err(|error| Failure::new(exit::BAD_DATA, error))?;
    log::report_damage(file, bag.damage.as_deref());
    let own = robot.driven().map(|wheel| ros2_topics::name(wheel.name));
    let wanted = if wheels.is_empty() { own.collect() } else { wheels.clone() };
    let mut places = Vec::new();
    for name in &wanted {
        let place = bag.names.iter().position(|it| it == name).ok_or_else(|| {
            let (topic, names) = (&bag.topics[0], bag.names.join(", "));
            let message = format!(
                "no joint `{name}` on {topic}: it has {names}; name the wheels' with --wheels, in the robot's order"
            );
            Failure::new(exit::BAD_DATA, format_args!("{}: {message}", file.display()))
        })?;
        places.push(place);
    }
    let wheels = bag.joints.iter().filter_map(|(time, angles)| {
        Some((*time, places.iter().map(|&place| angles.get(place).copied()).collect::<Option<Vec<f64>>>()?))
    });
    Record::join(bag.poses, wheels.collect())
        .map_err(|error| Failure::new(exit::BAD_DATA, format_args!("{}: {error}", file.display())))
}

fn show(found: &Calibration, friction: f64) {
    let Calibration { numbers, curves, missing, windows, residuals: [way, turn], is_mirrored, patch } = found;
    print(format_args!(
        "{windows} windows of 1 s; the numbers leave {:.1} mm and {:.2} mrad of a window",
        way * 1e3,
        turn * 1e3
    ));
    if *is_mirrored {
        print("poses with y to the left and yaw counterclockwise");
    }
    for Number { name, unit, value, interval: [low, high], in_file } in numbers {
        let file = in_file.map_or(String::new(), |it| format!("; in the file {it:.5}"));
        print(format_args!("{name}: {value:.5} {unit}  95 % from {low:.5} to {high:.5}{file}"));
    }
    if let Some([length, width]) = patch {
        print(format_args!(
            "that stiffness is for a patch of half length {length:.4} m and half width {width:.4} m, and a friction of {} (--friction)",
            friction
        ));
    }
    for curve in curves {
        print(format_args!(
            "effective track at a curvature of {:.2}: {:.4} m +- {:.4} ({} windows)",
            curve.curvature, curve.track, curve.error, curve.windows
        ));
    }
    missing.iter().for_each(|it| print(format_args!("not found: {it}")));
}
