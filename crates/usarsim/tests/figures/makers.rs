//! Makers of the figures. With `true` they also measure times.

use std::path::Path;
use std::process::Command;

use experiments::claim::Claims;
use experiments::plan::{Plan, Run};
use experiments::real::{self, Measured};
use experiments::run::{self, Outcome};
use experiments::{Course, Motion, Travel};
use gamebots_proto::Dialect;
use gamebots_proto::message::{self, Field, Message, Reading};
use kinematics::FiniteRollers;
use kinematics::thesis::{Sizes, base_velocity, printed};
use scene::{DriveModel, PawnId, RobotDef, Steering, WorldDef};
use sim_core::{Options, World};

use super::{UNTIMED, budget, repository};

/// Returns a table in Markdown, with the empty lines around it.
fn table(head: &str, rows: impl IntoIterator<Item = String>) -> String {
    let rule = "---|".repeat(head.matches('|').count() - 1);
    let rows: String = rows.into_iter().map(|row| row + "\n").collect();
    format!("\n\n{head}\n|{rule}\n{rows}\n")
}

/// Returns a number with at least three digits, or the placeholder.
fn time(timed: bool, number: &serde_json::Value) -> String {
    let number = number.as_f64().unwrap();
    match timed {
        false => UNTIMED.to_owned(),
        true if number < 10.0 => format!("{number:.2}"),
        true if number < 100.0 => format!("{number:.1}"),
        true => format!("{number:.0}"),
    }
}

/// Class of the youBot in the figures: the thesis's.
const THESIS: &str = "KUKA_YouBot";

/// Returns the report of `usarsim bench --json` with these arguments. If times are measured, it is the fastest of three.
fn bench(timed: bool, arguments: &[&str]) -> serde_json::Value {
    let run = || -> serde_json::Value {
        eprintln!("usarsim bench {}", arguments.join(" "));
        let mut program = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        let output = program.args(["bench", "--json"]).args(arguments).current_dir(repository()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let step = |report: &serde_json::Value| report["microseconds_per_step"].as_f64().unwrap();
    let runs = (0..if timed { 3 } else { 1 }).map(|_| run());
    runs.min_by(|a, b| step(a).total_cmp(&step(b))).unwrap()
}

/// Makes the table of published measurements of real robots.
pub(crate) fn real_robots() -> String {
    let mut rows = Vec::new();
    for (name, text) in real::files() {
        let measured = Measured::read(&name, text).unwrap();
        for row in real::run(&measured).unwrap() {
            let spread = row.spread.map_or(String::new(), |spread| format!(" ± {spread:.4}"));
            let (robot, real, ours) = (&measured.name, format!("{:.4}{spread}", row.real), row.ours);
            rows.push(format!("| {robot} | {} | {real} | {ours:.4} | {:+.1} % |", row.what, row.percent()));
        }
    }
    table("| robot | quantity | real | here | difference |", rows)
}

pub(crate) fn drive_models(timed: bool) -> String {
    let [plane, solid, mesh] = ["rough", "bench/floors/box.toml", "bench/floors/mesh.toml"];
    let rows = [
        ("bodies", "0.002", plane),
        ("bodies", "0.004", plane),
        ("bodies", "0.004", solid),
        ("bodies", "0.004", mesh),
        ("articulated", "0.002", plane),
        ("articulated", "0.004", plane),
        ("articulated", "0.016", plane),
        ("articulated", "0.016", solid),
        ("articulated", "0.016", mesh),
        ("analytic", "0.002", plane),
        ("analytic", "0.008", plane),
        ("analytic", "0.016", plane),
        ("analytic", "0.02", plane),
        ("analytic", "0.016", solid),
        ("analytic", "0.016", mesh),
        ("kinematic", "0.016", plane),
    ];
    let row = |(model, step, map): (&str, &str, &str)| {
        let report = bench(timed, &["--robot", THESIS, "--drive-model", model, "--dt", step, "--map", map]);
        let [factor, microseconds] = ["real_time_factor", "microseconds_per_step"].map(|key| time(timed, &report[key]));
        let error = report["worst_error_percent"].as_f64().unwrap();
        let motions = report["motions"].as_object().unwrap().values();
        let ripple = motions.map(|motion| motion["ripple_mm"].as_f64().unwrap()).fold(0.0, f64::max);
        format!("| {model} | {step} | `{map}` | {factor} | {microseconds} | {error:.2} % | {ripple:.3} mm |")
    };
    let head = "| M, model | S, time step, s | F, map | times real time | us a step | worst error | ripple |";
    table(head, rows.map(row))
}

pub(crate) fn robots(timed: bool) -> String {
    let microseconds = |model: &str, robots: &str| match timed {
        false => UNTIMED.to_owned(),
        true => {
            let arguments =
                ["--robot", THESIS, "--drive-model", model, "--dt", "0.002", "--robots", robots, "--seconds", "1"];
            time(true, &bench(true, &arguments)["microseconds_per_step"])
        }
    };
    let row = |model: &str| {
        format!("| {model} | {} |", ["1", "10", "20"].map(|robots| microseconds(model, robots)).join(" | "))
    };
    table("| M, model | N = 1 | 10 | 20 |", ["bodies", "articulated", "analytic", "kinematic"].map(row))
}

pub(crate) fn threads(timed: bool) -> String {
    let row = |threads: &str| {
        let robots =
            ["--robot", THESIS, "--drive-model", "analytic", "--dt", "0.008", "--robots", "50", "--seconds", "5"];
        let report = bench(timed, &[&robots[..], &["--threads", threads]].concat());
        let [factor, microseconds] = ["real_time_factor", "microseconds_per_step"].map(|key| time(timed, &report[key]));
        let error = report["worst_error_percent"].as_f64().unwrap();
        format!("| {threads} | {factor} | {microseconds} | {error:.2} % |")
    };
    table("| T, threads | times real time | us a step | worst error |", ["1", "2"].map(row))
}

pub(crate) fn cost(timed: bool, groups: &[&str]) -> String {
    let rows = budget::ROWS.iter().filter(|(group, ..)| groups.contains(group)).map(|(_, what, measure, bar)| {
        if timed {
            eprintln!("{what}");
        }
        let got = if timed { measure() } else { UNTIMED.to_owned() };
        format!("| {what} | {got} | {bar} |")
    });
    table("| measured | got | wanted |", rows)
}

/// Loads a world as shipped.
fn world(map: &str) -> WorldDef {
    scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Motions of the youBot, their units, and the signs of its wheels: front left, front right, back left, back right.
const MOTIONS: [(Motion, &str, &str, [f64; 4]); 3] = [
    (Motion::Forward, "forward", "m", [1.0, 1.0, 1.0, 1.0]),
    (Motion::Right, "to the right", "m", [1.0, -1.0, -1.0, 1.0]),
    (Motion::Clockwise, "turning", "rad", [1.0, -1.0, 1.0, -1.0]),
];

/// Drives a youBot for ten seconds with wheels commanded to 1 rad/s, in its own drive model or another. `away` is the start's distance from
/// the origin along x and along y, m.
fn youbot(map: &str, model: Option<DriveModel>, motion: Motion, away: f64) -> Travel {
    let mut def = world(map);
    def.map.starts[0].position = [away, away, 0.0];
    def.robots.get_mut("KUKA_YouBot").unwrap().set_drive_model(model);
    let mut course = Course::start(World::new(def, Options::default()), "KUKA_YouBot", 1, motion, 1.0).unwrap();
    course.run(10.0);
    course.travel().unwrap()
}

/// Returns the displacement per radian of the youBot's wheels, m or rad: by the textbook, by finite rollers in the mean over their phases,
/// and by the Jacobians of the thesis as printed.
fn by_kinematics(motion: Motion, signs: [f64; 4]) -> [f64; 3] {
    let rollers = base_motion::mecanum::finite_rollers(&world("rough").robots["KUKA_YouBot"]).unwrap();
    let FiniteRollers { base, axis_circle, .. } = rollers;
    let twist = base.forward(signs);
    let part = [1.0, rollers.mean_lateral_ratio(), rollers.mean_rotation_ratio()];
    let jacobians = printed(&Sizes {
        wheel_radius: base.wheel_radius,
        roller_radius: base.wheel_radius - axis_circle,
        half_track: base.half_track,
        half_wheelbase: base.half_wheelbase,
    });
    let [front_left, front_right, back_left, back_right] = signs;
    let velocity = base_velocity(&jacobians, [front_right, front_left, back_left, back_right]).unwrap();
    let axis = motion as usize;
    let textbook = [twist.forward, twist.right, twist.clockwise][axis];
    // In the thesis x is to the right, y ahead, and yaw counterclockwise.
    [textbook, textbook * part[axis], [velocity.y, velocity.x, -velocity.z][axis]]
}

/// Compares the motion of robots on plain wheels with the balance of friction.
pub(crate) fn sliding() -> String {
    let def = world("rough");
    // Further names of a class, and classes like another, have the same body.
    let has_own_body = |robot: &RobotDef| {
        let files = scene_loader::robot_files(&robot.class).unwrap();
        let (_, text) = files.into_iter().find(|(file, _)| file == "robot.toml").unwrap();
        let text = String::from_utf8_lossy(text);
        !text.contains(&format!("\"{}\"", robot.class)) && !text.lines().any(|line| line.starts_with("like = "))
    };
    let on_plain_wheels = def
        .robots
        .values()
        .filter(|robot| robot.steering != Steering::Omni && robot.driven().next().is_some() && has_own_body(robot));
    let rows = on_plain_wheels.map(|robot| {
        let motions = Motion::of_robot(robot);
        let ratio = |model: DriveModel, motion| {
            let mut own = robot.clone();
            own.set_drive_model(Some(model));
            let robots = [(robot.class.clone(), own)].into();
            let def = WorldDef { map: def.map.clone(), robots, ..WorldDef::default() };
            let mut course = Course::start(World::new(def, Options::default()), &robot.class, 1, motion, 1.0).unwrap();
            course.run(10.0);
            format!("{:.4}", course.travel().unwrap().ratio)
        };
        let cell = |model, motion| {
            if motions.contains(&motion) && robot.can_have(model) { ratio(model, motion) } else { "-".to_owned() }
        };
        let cells = [DriveModel::Articulated, DriveModel::Bodies].map(|model| {
            [Motion::Forward, Motion::Clockwise, Motion::Curve].map(|motion| cell(model, motion)).join(" | ")
        });
        format!("| `{}` | {} |", robot.class, cells.join(" | "))
    });
    table("| robot | straight on | on the spot | on a curve | `bodies`: straight on | on the spot | on a curve |", rows)
}

pub(crate) fn far() -> String {
    let rows = [DriveModel::Bodies, DriveModel::Articulated, DriveModel::Analytic].into_iter().flat_map(|model| {
        [0.0, 100.0, 1000.0].map(|away| {
            let ratio = |motion| format!("{:.5}", youbot("rough", Some(model), motion, away).ratio);
            format!("| {} | {away} m | {} |", model.name(), Motion::ALL.map(ratio).join(" | "))
        })
    });
    table("| model | x and y of the start | forward | right | turning |", rows)
}

pub(crate) fn motion() -> String {
    let mut rows = Vec::new();
    for map in ["rough", "smooth"] {
        for (motion, name, unit, signs) in MOTIONS {
            let Travel { moved, turned, ratio, .. } = youbot(map, None, motion, 0.0);
            let moved = moved[motion as usize];
            let (by_wheels, commanded) = (moved / ratio, 10.0 * by_kinematics(motion, signs)[1]);
            rows.push(format!(
                "| youBot on `{map}` | {name}, 1 rad/s | {moved:.3} {unit} | {turned:.2} rad | {by_wheels:.3} {unit} \
                 | {commanded:.3} {unit} |"
            ));
        }
    }
    rows.push(p3at());
    table("| robot | motion | measured | wheels turned | exact for this angle | exact for the speed commanded |", rows)
}

fn p3at() -> String {
    let mut world = World::new(world("rough"), Options::default());
    let mut robot = None;
    let state = |world: &World, robot: Option<PawnId>| {
        let (body, wheels) = world.state(robot.unwrap()).unwrap();
        (body.pose.translation.x, wheels.iter().map(|wheel| wheel.angle).sum::<f64>() / wheels.len() as f64)
    };
    execute(&mut world, &mut robot, "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
    run_for(&mut world, 0.5);
    execute(&mut world, &mut robot, "DRIVE {Left 3} {Right 3}");
    run_for(&mut world, 2.0);
    let from = state(&world, robot);
    run_for(&mut world, 10.0);
    let to = state(&world, robot);
    let (moved, turned) = (to.0 - from.0, to.1 - from.1);
    let radius = world.def().robots["P3AT"].wheel_geometry().radius;
    let (by_wheels, commanded) = (radius * turned, radius * 30.0);
    format!(
        "| P3AT on `rough` | forward, 3 rad/s | {moved:.3} m | {turned:.2} rad | {by_wheels:.3} m | {commanded:.3} m |"
    )
}

/// Executes a line for the newest robot and returns the answers.
fn execute(world: &mut World, robot: &mut Option<PawnId>, line: &str) -> Vec<Message> {
    let command = gamebots_proto::Command::parse(line, &mut Vec::new()).unwrap();
    let executed = world.execute(*robot, &command, &mut Vec::new());
    *robot = executed.spawned.or(*robot);
    executed.answers.into_iter().filter_map(|answer| world.message(answer)).collect()
}

/// Runs a world for a time and returns its messages.
fn run_for(world: &mut World, seconds: f64) -> Vec<Message> {
    let steps = (seconds / world.time_step()).round() as u64;
    let mut step = || world.step().into_iter().filter_map(|(_, report)| world.message(report)).collect::<Vec<_>>();
    (0..steps).flat_map(|_| step()).collect()
}

/// Shows a session: typed lines and their answers, and the last status and ground truth of the stream that follows.
pub(crate) fn session() -> String {
    let mut world = World::new(world("rough"), Options::default());
    let mut robot = None;
    let mut text = format!("\n\n```console\n$ nc 127.0.0.1 3000\n{}\n", world.greeting().write(Dialect::Udk));
    for (typed, seconds) in [
        ("INIT {ClassName USARBot.KUKA_YouBot} {Name R1} {Start PlayerStart_0}", 0.0),
        ("GETCONF {Type Robot}", 1.0),
        ("DRIVE {Front-Left 1}{Front-Right -1}{Back-Left -1}{Back-Right 1}", 5.0),
        ("DRIVE {LinearVelocity 0.2} {RotationalVelocity 0.5}", 0.0),
        ("DRIVE {Left 0} {Right 0}", 0.0),
    ] {
        text += &format!("> {typed}\n");
        for answer in execute(&mut world, &mut robot, typed) {
            text += &format!("{}\n", answer.write(Dialect::Udk));
        }
        let streamed = run_for(&mut world, seconds);
        let is_truth =
            |message: &&Message| matches!(message, Message::Sen(sen) if matches!(sen.reading, Reading::GroundTruth(_)));
        let status = streamed.iter().rfind(|message| matches!(message, Message::Sta(_)));
        for message in status.into_iter().chain(streamed.iter().rfind(is_truth)) {
            text += &format!("{}\n", message.write(Dialect::Udk));
        }
        text += if streamed.is_empty() { "" } else { "...\n" };
    }
    text + "```\n\n"
}

/// Lists every field of every message, from the tables that write them.
pub(crate) fn messages() -> String {
    let head = "| key | UDK | UT2004 | unit | meaning |\n|---|---|---|---|---|\n";
    let either = |[udk, ut2004]: [&str; 2], mark: &str| match () {
        () if udk == ut2004 => format!("{mark}{udk}{mark}"),
        () => format!("{mark}{udk}{mark}, UT2004 {mark}{ut2004}{mark}"),
    };
    let row = |field: &Field| {
        let [udk, ut2004] = field.format;
        let about = field.about.trim();
        let mut rows = format!("| {} | {udk} | {ut2004} | {} | {about} |\n", either(field.key, "`"), field.unit);
        for (key, value) in field.then {
            let [udk, ut2004] = value.map(|value| if value.is_empty() { "-".to_owned() } else { format!("`{value}`") });
            rows += &format!("| {} | {udk} | {ut2004} | | Always the same. |\n", either(*key, "`"));
        }
        rows
    };
    let rows = |fields: &[Field]| fields.iter().map(row).collect::<String>();
    let mut text = String::from("\n\n");
    for (line, time, table) in message::tables() {
        text += &format!("### `{line}`: {}\n\n{}\n\n", table.name, table.about.trim());
        let own: Vec<Field> = time.into_iter().chain(table.fields.iter().copied()).collect();
        if !own.is_empty() {
            text += &format!("{head}{}\n", rows(&own));
        }
        for each in table.each {
            text += &format!("Then, any number of times: {}\n\n{head}{}\n", each.about.trim(), rows(each.fields));
        }
    }
    text
}

/// Compares the three kinematics with the model whose rollers have no inertia.
pub(crate) fn kinematics() -> String {
    let rows = MOTIONS.map(|(motion, name, unit, signs)| {
        let Travel { moved, turned, .. } = youbot("rough", Some(DriveModel::Analytic), motion, 0.0);
        let measured = moved[motion as usize] / turned;
        let [textbook, exact, printed] = by_kinematics(motion, signs);
        let scaled = format!(", and {:.4} by the factor of (6.34)", printed * std::f64::consts::FRAC_1_SQRT_2);
        let scaled = if motion == Motion::Right { &scaled } else { "" };
        format!("| {name} | {textbook:.4} {unit} | {exact:.4} | {printed:.4}{scaled} | {measured:.4} |")
    });
    table("| motion | textbook | finite rollers, mean | thesis as printed | measured in `analytic` |", rows)
}

pub(crate) fn thesis_runs() -> String {
    thesis_plans().iter().map(|plan| plan.runs().len()).sum::<usize>().to_string()
}

pub(crate) fn thesis_needed() -> String {
    let Claims { claims } = toml::from_str(experiments::thesis::claims()).unwrap();
    let needed = |mut plan: Plan| {
        experiments::thesis::keep_needed(&mut plan, &claims);
        plan.runs().len()
    };
    thesis_plans().into_iter().map(needed).sum::<usize>().to_string()
}

fn thesis_plans() -> Vec<Plan> {
    let files = experiments::thesis::files().into_iter();
    files.map(|(file, text)| Plan::read(Path::new(&file), text).unwrap_or_else(|error| panic!("{error}"))).collect()
}

/// Checks the thesis's claims about forward motion that need only some runs of one experiment.
pub(crate) fn thesis() -> String {
    let mut plan = thesis_plans().into_iter().find(|plan| plan.name == "forward").unwrap();
    plan.keep_models(&[DriveModel::Bodies]);
    let runs = plan.runs();
    let has = |run: &Run, name: &str, values: &[&str]| {
        run.labels.iter().any(|(axis, value)| axis == name && values.contains(&value.as_str()))
    };
    let wanted = runs
        .iter()
        .filter(|run| has(run, "centre", &["body"]) && has(run, "ground", &["rough", "slope 1.5", "slope 4.5"]));
    let outcomes: Vec<Outcome> = wanted.map(|run| run::run(&plan, run, None).unwrap()).collect();
    let Claims { claims } = toml::from_str(experiments::thesis::claims()).unwrap();
    let rows = [
        "Forward on carpet, simulated",
        "Forward, 0 to 1.5 degrees, simulated",
        "Forward, 1.5 to 4.5 degrees, simulated",
        "Mechanism",
    ];
    let row = |start: &str| {
        let claim = claims.iter().find(|claim| claim.text.starts_with(start)).unwrap();
        let (number, found, unit) = (claim.number.unwrap(), claim.found(&outcomes, "bodies").unwrap(), &claim.unit);
        format!("| {} | {number} {unit} | {found:.2} {unit} |", claim.text)
    };
    table("| claim | the thesis | `bodies` |", rows.map(row))
}
