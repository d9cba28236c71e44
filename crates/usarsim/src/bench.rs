//! `usarsim bench`: measures the speed and, in the same run, the accuracy of the world.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use experiments::{Course, Crowd, Moment, Motion};
use scene::{DriveModel, MapDef, RobotDef, WorldDef};
use scene_loader::Override;
use serde_json::json;
use sim_core::{Options, SolverEffort, World};
use thread_pool::ThreadPool;

use crate::output::{definition_files, keep_inputs};
use crate::values::{time_step, within};
use crate::{Failure, exit, print};

/// Options of `bench`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim bench\n  usarsim bench --drive-model analytic --json\n  \
    usarsim bench --robots 50 --drive-model analytic --threads 2\n  usarsim bench --robot P3AT\n  \
    usarsim bench --crowd --robot P3AT,YouBot --robots 40\n\nA Mecanum robot drives forward, to the right and on the spot at 1 rad/s, and is \
    compared with the exact kinematics of wheels with finite rollers for the angle that the wheels turned; any other forward, on the \
    spot and on a curve, and is compared with the twist at which the friction of its wheels balances.\n\nWith --crowd robots stand on a grid of 0.75 m and drive to its middle at 5 rad/s, where they push, climb and heap up.")]
pub(crate) struct Arguments {
    /// A robot class with wheels, or the path of its robot.toml. A crowd takes several, which take turns.
    #[arg(long, default_value = "YouBotArm", value_name = "NAME|FILE", value_delimiter = ',')]
    robot: Vec<String>,
    /// Drive model: articulated, bodies, analytic or kinematic; by default the one in its robot.toml.
    #[arg(long, value_name = "MODEL", value_parser = crate::values::drive_model)]
    drive_model: Option<DriveModel>,
    /// Number of robots that drive side by side.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    robots: u32,
    /// Drive all robots to one place.
    #[arg(long, conflicts_with = "trace")]
    crowd: bool,
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

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { robots, seconds, map, set, .. } = arguments;
    if let Some(trace) = &arguments.trace {
        let robots = arguments.robot.iter().map(|robot| definition_files(robot));
        keep_inputs(trace, &robots.chain([definition_files(map)]).collect::<Vec<_>>().concat())?;
    }
    let broken = |error| Failure::new(exit::BAD_CONFIGURATION, error);
    let mut definitions = Vec::new();
    for robot in &arguments.robot {
        let mut robot = scene_loader::robot(robot, set).map_err(broken)?;
        robot.set_drive_model(arguments.drive_model);
        definitions.push(robot);
    }
    let map = scene_loader::map(map, set).map_err(broken)?;
    scene_loader::check_used(set).map_err(broken)?;
    if arguments.crowd {
        return run_crowd(arguments, definitions, map);
    }
    let Ok([robot]) = <[RobotDef; 1]>::try_from(definitions) else {
        return Err(Failure::new(exit::USAGE, "several robots: expected --crowd, or one class"));
    };
    let (class, model) = (robot.class.clone(), robot.drive_model);
    let dt = arguments.dt.unwrap_or_else(|| default_step(&robot));
    let map_name = map.name.clone();
    let motions_of_robot = Motion::of_robot(&robot);
    let def = WorldDef { map, robots: [(class.clone(), robot)].into(), ..WorldDef::default() };
    let threads = ThreadPool::new(arguments.threads as usize).map_err(|error| Failure::new(exit::FAILURE, error))?;
    let options = Options { time_step: dt, ..Options::default() };
    let (mut simulated, mut wall, mut worst, mut digest) = (0.0, 0.0, 0.0f64, 0u64);
    let mut effort = SolverEffort::default();
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
        effort += course.solver_effort();
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
            "solver": effort,
            "unsettled_steps": effort.unsettled,
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

/// Returns the default time step for a robot, s. It is short enough to be accurate.
fn default_step(robot: &RobotDef) -> f64 {
    if robot.drive_model == DriveModel::Bodies { 0.004 } else { 0.016 }
}

/// Measures a crowd that drives to one place.
fn run_crowd(arguments: &Arguments, definitions: Vec<RobotDef>, map: MapDef) -> Result<(), Failure> {
    let &Arguments { robots, seconds, dt, json, .. } = arguments;
    let dt = dt.unwrap_or_else(|| definitions.iter().map(default_step).fold(f64::INFINITY, f64::min));
    let classes: Vec<String> = definitions.iter().map(|robot| robot.class.clone()).collect();
    let map_name = map.name.clone();
    let def = WorldDef {
        map,
        robots: definitions.into_iter().map(|robot| (robot.class.clone(), robot)).collect(),
        ..WorldDef::default()
    };
    let threads = ThreadPool::new(arguments.threads as usize).map_err(|error| Failure::new(exit::FAILURE, error))?;
    let options = Options { time_step: dt, ..Options::default() };
    let world = World::new(def, options).on_threads(Arc::new(threads.clone()));
    let crowd = Crowd::start(world, &classes, robots);
    let mut crowd = crowd.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
    let steps = (seconds / dt).round().max(1.0) as u64;
    let (mut wall, mut worst) = (0.0, 0.0_f64);
    threads.run_in_a_hurry(|| {
        for _ in 0..steps {
            let start = Instant::now();
            crowd.step();
            let step = start.elapsed().as_secs_f64();
            (wall, worst) = (wall + step, worst.max(step));
        }
    });
    let (factor, each) = (seconds / wall, 1e6 * wall / (steps as f64 * f64::from(robots)));
    let (effort, names) = (crowd.world().solver_effort(), classes.join(","));
    if json {
        print(json!({
            "real_time_factor": factor,
            "microseconds_per_robot_and_step": each,
            "worst_step_milliseconds": 1e3 * worst,
            "dt": dt,
            "robots": robots,
            "robots_left": crowd.world().robots().count(),
            "threads": threads.threads(),
            "steps": steps,
            "solver": effort,
            "unsettled_steps": effort.unsettled,
            "digest": format!("{:016x}", crowd.world().digest()),
            "map": map_name,
            "robot": names,
        }));
    } else {
        print(format_args!(
            "{robots} {names} drive to one place, steps of {} ms: {factor:.2} times real time, {each:.1} us a robot and step, \
             the longest step {:.1} ms; {} systems, {:.1} Newton steps each, {} not settled",
            1e3 * dt,
            1e3 * worst,
            effort.systems,
            effort.newton_steps as f64 / effort.systems.max(1) as f64,
            effort.unsettled
        ));
    }
    Ok(())
}
