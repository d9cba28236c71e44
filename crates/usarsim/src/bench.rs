//! `usarsim bench`: how fast the world is, and how exact in the same run.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use experiments::{Course, Moment, Motion};
use scene::{DriveModel, WorldDef};
use scene_loader::Override;
use serde_json::json;
use sim_core::{Options, World};
use thread_pool::ThreadPool;

use crate::output::{definition_files, keep_inputs};
use crate::{Failure, exit, print, within};

/// Options of `bench`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim bench\n  usarsim bench --drive-model analytic --json\n  \
    usarsim bench --robots 50 --drive-model analytic --threads 2\n  usarsim bench --robot P3AT\n\nA Mecanum robot drives forward, to the right and on the spot at 1 rad/s, and is \
    compared with the exact kinematics of wheels with finite rollers for the angle that the wheels turned; any other forward, on the \
    spot and on a curve, and is compared with the twist at which the friction of its wheels balances.")]
pub(crate) struct Arguments {
    /// A robot class with wheels, or the path of its robot.toml.
    #[arg(long, default_value = "YouBotArm", value_name = "NAME|FILE")]
    robot: String,
    /// Drive model: articulated, bodies, analytic, kinematic or kinematic-textbook; by default the one in its robot.toml.
    #[arg(long, value_name = "MODEL")]
    drive_model: Option<DriveModel>,
    /// Number of robots that drive side by side.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    robots: u32,
    /// Simulated seconds of each motion.
    #[arg(long, default_value_t = 10.0, value_parser = seconds)]
    seconds: f64,
    /// Length of a time step, s; by default 0.004 with `bodies`, 0.016 with the other models. `serve` takes 0.002.
    #[arg(long, value_parser = time_step)]
    dt: Option<f64>,
    /// Threads for the simulation.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: u32,
    /// A map by name or file, as for `serve`.
    #[arg(long, default_value = "rough", value_name = "NAME|FILE")]
    map: String,
    /// Replace a number: robot.PATH, CLASS.PATH, map.PATH or material.PATH=VALUE. May be given several times.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Override>,
    /// Write the path of the first robot as a table: motion, time (s), wheel phase (rad), height over the lowest (m).
    #[arg(long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    within(text, 0.1, 1000.0)
}

pub(crate) fn time_step(text: &str) -> Result<f64, String> {
    within(text, 1e-4, 0.02)
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { robot, robots, seconds, map, set, .. } = arguments;
    if let Some(trace) = &arguments.trace {
        keep_inputs(trace, &[definition_files(robot), definition_files(map)].concat())?;
    }
    let broken = |error| Failure::new(exit::BAD_CONFIGURATION, error);
    let mut robot = scene_loader::robot(robot, set).map_err(broken)?;
    robot.set_drive_model(arguments.drive_model);
    let (class, model) = (robot.class.clone(), robot.drive_model);
    let dt = arguments.dt.unwrap_or(if model == DriveModel::Bodies { 0.004 } else { 0.016 });
    let map = scene_loader::map(map, set).map_err(broken)?;
    scene_loader::check_used(set).map_err(broken)?;
    let map_name = map.name.clone();
    let motions_of_robot = Motion::of_robot(&robot);
    let def = WorldDef { map, robots: BTreeMap::from([(class.clone(), robot)]) };
    let threads = ThreadPool::new(arguments.threads as usize).map_err(|error| Failure::new(exit::FAILURE, error))?;
    let options = Options { time_step: dt, ..Options::default() };
    let (mut simulated, mut wall, mut worst, mut digest, mut unsettled) = (0.0, 0.0, 0.0f64, 0u64, 0);
    let (mut motions, mut trace) = (serde_json::Map::new(), "motion,time,phase,height\n".to_owned());
    for &motion in motions_of_robot {
        let world = World::new(def.clone(), options).on_threads(Arc::new(threads.clone()));
        let course = threads.run(|| Course::start(world, &class, *robots, motion, 1.0));
        let mut course = course.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
        let start = Instant::now();
        threads.run_in_a_hurry(|| course.run(*seconds));
        wall += start.elapsed().as_secs_f64();
        simulated += seconds;
        digest = digest.rotate_left(1) ^ course.digest();
        unsettled += course.unsettled_steps();
        if arguments.trace.is_some() {
            for Moment { time, phase, height } in course.moments() {
                trace += &format!("{},{time:.4},{phase:.6},{height:.8}\n", motion.name());
            }
        }
        let travel = course.travel().ok_or_else(|| Failure::new(exit::FAILURE, "the robots are gone"))?;
        worst = worst.max((travel.ratio - 1.0).abs());
        motions.insert(motion.name().to_owned(), json!({"ratio": travel.ratio, "ripple_mm": 1e3 * travel.ripple}));
        if !arguments.json {
            let (name, ratio) = (motion.name(), travel.ratio);
            print(format_args!("{name:<10} {ratio:.4} of the exact travel, ripple {:.3} mm", 1e3 * travel.ripple));
        }
    }
    if let Some(file) = &arguments.trace {
        let refused = |error| Failure::new(exit::FAILURE, format_args!("{}: {error}", file.display()));
        std::fs::write(file, trace).map_err(refused)?;
    }
    let (factor, step) = (simulated / wall, 1e6 * wall * dt / simulated);
    if arguments.json {
        print(json!({
            "real_time_factor": factor,
            "worst_error_percent": 100.0 * worst,
            "microseconds_per_step": step,
            "dt": dt,
            "robots": robots,
            "threads": threads.threads(),
            "unsettled_steps": unsettled,
            "digest": format!("{digest:016x}"),
            "map": map_name,
            "robot": class,
            "drive_model": model.name(),
            "motions": motions,
        }));
    } else {
        let cores =
            if threads.threads() == 1 { "one core".to_owned() } else { format!("{} threads", threads.threads()) };
        print(format_args!(
            "{robots} {class}, {}, steps of {} ms: {factor:.1} times real time on {cores}, {step:.1} us a step, worst error {:.2} %",
            model.name(),
            1e3 * dt,
            100.0 * worst
        ));
    }
    Ok(())
}
