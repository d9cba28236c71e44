//! `usarsim snapshot`.

mod labels;

use std::path::{Path, PathBuf};

use gamebots_proto::command::Command;
use gamebots_proto::{Line, Problem};
use indicatif::ProgressBar;
use logbook::Demo;
use nalgebra::Vector3;
use picture::{Camera, FIELD_OF_VIEW, FROM_CORNER, Image, Looks, Stage};
use scene::{DriveModel, MapDef, Scenario, Viewpoint};
use scene_loader::{Changes, Equipment, LoadError, Override};
use sim_core::{Options, World};

use crate::output::{definition_files, keep_inputs};
use crate::values::within;
use crate::{Failure, exit, print};

/// Options of `snapshot`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim snapshot --map arena --out arena.png\n  \
    usarsim snapshot --robot KUKA_YouBot --out youbot.png --view front\n  \
    usarsim snapshot --map slope-4.5 --robot P3AT --start RobotStart2 --seconds 2 \\\n    \
    --drive \"{Left 2} {Right 2}\" --out slope.png --size 1600x900\n  \
    usarsim snapshot --robot Kenaf --without floor,background --out kenaf.png\n  \
    usarsim snapshot --map factory --labels --out factory.png\n  \
    usarsim snapshot --robot YouBot --drive \"{LateralVelocity 0.2}\" --film 4 --out aside.png --size 640x360\n  \
    usarsim snapshot --scenario stairs --seconds 5 --film 12 --out stairs.png --size 640x400")]
pub(crate) struct Arguments {
    /// A map by name, or the path of a map.toml or of its folder.
    #[arg(long, default_value = "hall", value_name = "NAME|FILE")]
    map: String,
    /// A robot class to spawn, or the path of its robot.toml, of its folder or of a URDF.
    #[arg(long, value_name = "CLASS|FILE")]
    robot: Option<String>,
    /// Start pose of the robot by its name on the map; by default the map's first.
    #[arg(long, value_name = "NAME")]
    start: Option<String>,
    /// A DRIVE line for the robot, with or without the verb.
    #[arg(long, value_name = "BLOCKS", requires = "robot")]
    drive: Option<String>,
    /// A scenario by name, or the path of its scenario.toml or of its folder: its demo, from its camera.
    #[arg(
        long,
        value_name = "NAME|FILE",
        conflicts_with_all = ["map", "robot", "set", "drive_model", "view", "distance"]
    )]
    scenario: Option<String>,
    /// Simulated seconds before the picture is taken.
    #[arg(long, default_value = "1", value_parser = seconds)]
    seconds: f64,
    /// Write an animated PNG of this many simulated seconds, from then on.
    #[arg(long, value_name = "SECONDS", value_parser = film_seconds)]
    film: Option<f64>,
    /// Replace a number, as for `serve`.
    #[arg(long, value_name = "PATH=VALUE")]
    set: Vec<Override>,
    /// Drive model, as for `serve`.
    #[arg(long, value_name = "MODEL", value_parser = crate::values::drive_model)]
    drive_model: Option<DriveModel>,
    /// Position of the camera.
    #[arg(long, default_value = "corner")]
    view: View,
    /// Distance from the camera to the middle of the robot or of the map, m; by default the robot, or the whole map, fills the picture.
    #[arg(long, value_name = "M", value_parser = distance)]
    distance: Option<f64>,
    /// Parts to leave out: what is behind the world is transparent without a background.
    #[arg(long, value_name = "PART,..", value_delimiter = ',')]
    without: Vec<Part>,
    /// Write the names of robots, objects and starts.
    #[arg(long)]
    labels: bool,
    /// Pixels, width x height.
    #[arg(long, default_value = "1280x720", value_name = "WxH", value_parser = size)]
    size: [usize; 2],
    /// The picture, a file name that ends in .png.
    #[arg(long, value_name = "FILE.png", value_parser = png)]
    out: PathBuf,
}

/// A part of a picture.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Part {
    /// Floors without an end.
    Floor,
    /// The grid on them.
    Grid,
    /// The sky.
    Background,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum View {
    /// From behind, to the left and above.
    Corner,
    /// From straight above, x upward.
    Top,
    /// From the right side, a little above.
    Side,
    /// From ahead, a little above.
    Front,
    /// From ahead, to the left and above.
    Portrait,
}

impl View {
    /// Returns the direction from the target to the camera, in the robot's axes.
    fn direction(self) -> Vector3<f64> {
        match self {
            Self::Corner => -FROM_CORNER,
            Self::Top => -Vector3::z(),
            Self::Side => Vector3::new(0.0, 1.0, -0.2),
            Self::Front => Vector3::new(1.0, 0.25, -0.3),
            Self::Portrait => Vector3::new(0.85, -0.6, -0.5),
        }
        .normalize()
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    within(text, 0.0, 3600.0)
}

fn film_seconds(text: &str) -> Result<f64, String> {
    within(text, 0.1, 60.0)
}

fn distance(text: &str) -> Result<f64, String> {
    within(text, 0.05, 1000.0)
}

fn png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    is_png.then_some(path).ok_or_else(|| "expected a name that ends in .png".to_owned())
}

fn size(text: &str) -> Result<[usize; 2], String> {
    let parsed = text.split_once('x').and_then(|(wide, high)| Some([wide.parse().ok()?, high.parse().ok()?]));
    parsed
        .filter(|size| size.iter().all(|edge| (16..=8192).contains(edge)))
        .ok_or("expected WxH of 16 to 8192".to_owned())
}

/// Frames per second of a film.
const FRAMES_PER_SECOND: u16 = 15;
/// Vertical field of view of the page, for which the cameras of scenarios are chosen, rad.
const PAGE_FIELD_OF_VIEW: f64 = 0.733;
/// Distances of the camera from a robot over that at which it fills the picture: a driving one needs more room.
const AROUND: f64 = 1.15;
const AROUND_IN_FILMS: f64 = 2.0;

/// A world that goes on by itself, or by the lines of a demo.
enum Moving {
    Alone(Box<World>),
    Demo(Box<Demo>),
}

impl Moving {
    fn world(&self) -> &World {
        match self {
            Self::Alone(world) => world,
            Self::Demo(demo) => demo.world(),
        }
    }

    /// Takes steps up to a simulated time, s. A demo ends before.
    fn run_to(&mut self, time: f64) -> Result<(), String> {
        while self.world().time() < time {
            match self {
                Self::Alone(world) => drop(world.step()),
                Self::Demo(demo) => match demo.step().map_err(|error| error.to_string())? {
                    true => {}
                    false => break,
                },
            }
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let lacks = |part: Part| arguments.without.contains(&part);
    if arguments.film.is_some() && lacks(Part::Background) {
        let why = "a film has a background: leave out `--film` or `--without background`";
        return Err(Failure::new(exit::USAGE, why));
    }
    let given = [Some(&arguments.map), arguments.robot.as_ref()];
    let inputs: Vec<PathBuf> = given.into_iter().flatten().flat_map(|given| definition_files(given)).collect();
    keep_inputs(&arguments.out, &inputs)?;
    let moving = match &arguments.scenario {
        Some(name) => demo(name),
        None => scene(arguments),
    };
    let mut moving = moving.map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
    let [width, height] = arguments.size;
    let stage = Stage::new(moving.world().def());
    let camera = match &moving.world().def().scenario {
        Some(scenario) => camera_of(scenario, &moving.world().def().map, arguments.size),
        None => camera(&stage, moving.world(), arguments),
    };
    if arguments.scenario.is_some() {
        moving.run_to(arguments.seconds).map_err(|error| Failure::new(exit::BAD_DATA, error))?;
    }
    let looks = Looks { floor: !lacks(Part::Floor), grid: !lacks(Part::Grid), backdrop: None };
    let draw_with = |world: &World, looks: &Looks| {
        let size = arguments.size;
        let mut image = picture::picture_with(&stage, world.def(), &world.snapshot(), &camera, size, looks);
        if arguments.labels {
            let labels = labels::labels(&stage, world, &camera, size);
            charts::write_labels(&mut image.pixels, size, &labels).map_err(|error| error.to_string())?;
        }
        Ok(image)
    };
    let draw = |world: &World| draw_with(world, &looks);
    let written = match arguments.film {
        Some(seconds) => film(&mut moving, seconds, draw)
            .and_then(|frames| picture::film(&frames, FRAMES_PER_SECOND).map_err(|error| error.to_string())),
        None if lacks(Part::Background) => {
            let before = |backdrop| draw_with(moving.world(), &Looks { backdrop: Some(backdrop), ..looks });
            before([0.0; 3])
                .and_then(|black| Image::cut_out(&black, &before([1.0; 3])?).map_err(|error| error.to_string()))
        }
        None => draw(moving.world()).and_then(|image| image.to_png().map_err(|error| error.to_string())),
    };
    let written = written.and_then(|png| std::fs::write(&arguments.out, png).map_err(|error| error.to_string()));
    written.map_err(|error| Failure::new(exit::FAILURE, format_args!("{}: {error}", arguments.out.display())))?;
    print(format_args!("{} ({width} x {height})", arguments.out.display()));
    Ok(())
}

/// Returns a map, with a robot that has driven for a time if one is wanted.
fn scene(arguments: &Arguments) -> Result<Moving, String> {
    let is_file = |robot: &str| {
        let is_built_in = |class: &String| class.eq_ignore_ascii_case(robot);
        Path::new(robot).exists() && !scene_loader::robot_names().iter().any(is_built_in)
    };
    let file = arguments.robot.as_deref().filter(|robot| is_file(robot));
    let files: Vec<&Path> = file.into_iter().map(Path::new).collect();
    let loaded = scene_loader::load_with(&arguments.map, &files, &arguments.set);
    let mut def = loaded.map_err(|error| error.to_string())?;
    let drive_model = arguments.drive_model;
    def.robots.change(move |robot| robot.set_drive_model(drive_model));
    let mut world = World::new(def, Options::default());
    if let Some(robot) = &arguments.robot {
        let class = scene_loader::robot(robot, &[]).map_err(|error| error.to_string())?.class;
        place(&mut world, &class, arguments)?;
    }
    Ok(Moving::Alone(Box::new(world)))
}

/// Returns the camera that the options ask for.
fn camera(stage: &Stage, world: &World, arguments: &Arguments) -> Camera {
    let snapshot = world.snapshot();
    let robot = snapshot.robots.first();
    let ahead = robot.map_or_else(Vector3::x, |robot| robot.body.pose.rotation * Vector3::x());
    let turn = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), ahead.y.atan2(ahead.x));
    let direction = turn * arguments.view.direction().normalize();
    let drawn = robot.map_or_else(
        || picture::corners_of_map(&world.def().map),
        |robot| stage.corners_of(world.def(), &snapshot, robot),
    );
    let fitted = Camera::fitting(&drawn, -direction, FIELD_OF_VIEW, arguments.size);
    let around = match (robot, arguments.film) {
        (None, _) => 1.0,
        (Some(_), None) => AROUND,
        (Some(_), Some(_)) => AROUND_IN_FILMS,
    };
    let distance = arguments.distance.unwrap_or(around * (fitted.eye - fitted.target).norm());
    Camera { eye: fitted.target + direction * distance, ..fitted }
}

/// Returns the camera of a scenario, or one for its whole map.
fn camera_of(scenario: &Scenario, map: &MapDef, size: [usize; 2]) -> Camera {
    scenario.camera.map_or_else(
        || Camera::of_map(map, size),
        |Viewpoint { from, at }| Camera {
            eye: from.into(),
            target: at.into(),
            down: Vector3::z(),
            field_of_view: PAGE_FIELD_OF_VIEW,
        },
    )
}

/// Returns the demo of a scenario.
fn demo(name: &str) -> Result<Moving, String> {
    let text = |error: LoadError| error.to_string();
    let setting = scene_loader::scenario(name).map_err(text)?;
    let listed = scene_loader::listed_scenarios(&[name.to_owned()]).map_err(text)?;
    let lines = listed.into_iter().next().and_then(|listed| listed.demo).unwrap_or_default();
    let changes = Changes { overrides: &[], equipment: &Equipment::default() };
    let def = scene_loader::load_around(setting, &[], changes).map_err(text)?;
    let demo = Demo::new(def, &lines, None).map_err(|error| format!("{name}: {error}"))?;
    Ok(Moving::Demo(Box::new(demo)))
}

/// Draws frames of the world from now on.
fn film(
    moving: &mut Moving,
    seconds: f64,
    draw: impl Fn(&World) -> Result<Image, String>,
) -> Result<Vec<Image>, String> {
    let count = (seconds * f64::from(FRAMES_PER_SECOND)).round().max(1.0) as u64;
    let progress = ProgressBar::new(count).with_message("frames");
    let begin = moving.world().time();
    let mut pictures = Vec::new();
    for number in 0..count {
        moving.run_to(begin + number as f64 / f64::from(FRAMES_PER_SECOND))?;
        pictures.push(draw(moving.world())?);
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(pictures)
}

/// Spawns the robot on the map, drives it, and runs the world for a time.
fn place(world: &mut World, class: &str, arguments: &Arguments) -> Result<(), String> {
    let mut problems: Vec<Problem> = Vec::new();
    let mut command = |text: String| Command::read(&Line::parse(&text), &mut problems);
    let starts: Vec<&str> = world.def().map.starts.iter().map(|start| start.name.as_str()).collect();
    let start = arguments.start.as_deref().or(starts.first().copied()).unwrap_or_default();
    if !starts.iter().any(|known| known.eq_ignore_ascii_case(start)) {
        let meant = names::did_you_mean(start, starts.iter().copied());
        return Err(format!("unknown start `{start}`{meant}: expected one of {}", names::listed(starts)));
    }
    let init = command(format!("INIT {{ClassName USARBot.{class}}} {{Start {start}}}"));
    let drive = arguments.drive.as_ref().and_then(|drive| command(experiments::plan::drive_line(drive)));
    if let Some(Command::Init(init)) = init
        && let Some(robot) = world.init(&init, &mut problems)
        && let Some(drive) = drive
    {
        world.execute(Some(robot), &drive, &mut problems);
    }
    if let Some(problem) = problems.first() {
        return Err(problem.to_string());
    }
    let steps = (arguments.seconds / world.time_step()).round() as u64;
    (0..steps).for_each(|_| drop(world.step()));
    Ok(())
}
