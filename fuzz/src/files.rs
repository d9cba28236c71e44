//! Files that somebody gives: robots, maps, materials, URDF, meshes.
//!
//! They are written to a folder and read as the program does. Whatever is accepted has to make a world that can be driven in.

use std::path::{Path, PathBuf};

use gamebots_proto::{Command, Problem};
use scene::WorldDef;
use scene_loader::{Changes, Content, Equipment, Import, LeagueFile, LoadError, MapImport, Packages, SdfFile};
use sessions::{News, Request, Sessions};
use sim_core::{Options, World};
use tempfile::TempDir;

use crate::assert_finite;

const STEPS: usize = 50;

/// A robot whose body is a URDF, with wheels of its own; and one whose wheels are joints of the URDF.
const ROBOT_OF_URDF: &str = include_str!("files/robot.toml");
const ROBOT_OF_JOINTS: &str = include_str!("../../assets/robots/KUKA_YouBot/robot.toml");
const URDF_WITH_JOINTS: &str = include_str!("../../assets/robots/KUKA_YouBot/robot.urdf");
/// Meshes that the robot of joints names.
const LOOKS_WITH_JOINTS: [(&str, &[u8]); 3] = [
    ("base.glb", include_bytes!("../../assets/robots/KUKA_YouBot/base.glb")),
    ("hub.glb", include_bytes!("../../assets/robots/KUKA_YouBot/hub.glb")),
    ("hokuyo.glb", include_bytes!("../../assets/robots/KUKA_YouBot/hokuyo.glb")),
];
/// A body whose shape is a mesh.
const URDF_OF_STL: &str = include_str!("files/stl.urdf");
const URDF_OF_OBJ: &str = include_str!("files/obj.urdf");
/// A floor with a mesh upon it.
const MAP_OF_STL: &str = include_str!("files/stl.toml");
const MAP_OF_OBJ: &str = include_str!("files/obj.toml");
/// A small mesh for files that name one.
const MESH: &str = include_str!("files/part.obj");

/// A robot.toml. The URDF that it may name is there.
pub fn robot(bytes: &[u8]) {
    let folder = Folder::new(&[("robot.urdf", URDF_WITH_JOINTS.as_bytes())]);
    drive_robot(&folder.with("robot.toml", bytes));
}

/// A map.toml. A mesh that it may name is there.
pub fn map(bytes: &[u8]) {
    let folder = Folder::new(&[("part.obj", MESH.as_bytes())]);
    drive_on_map(&folder.with("map.toml", bytes));
}

/// A league.toml. Of a good one a round of a few steps is played, in which each team sends a robot.
pub fn league(bytes: &[u8]) {
    let folder = Folder::new(&[]);
    let read = scene_loader::league(&folder.with("league.toml", bytes), None);
    // A map that is unknown is refused by its name.
    if let Err(LoadError::Bad(_)) = &read {
        assert_lines(&read);
    }
    let Ok(LeagueFile { league, map, .. }) = read else { return };
    let mut definition = scene_loader::load(&map, &[]).expect("the map of what is called good");
    definition.league = Some(league.clone());
    // The server starts after this check only.
    if definition.check().is_err() {
        return;
    }
    let mut round = Sessions::new(World::new(definition, Options::default()));
    for (session, team) in (0..).zip(&league.teams) {
        round.open(session, None, false, &mut |_, _| {});
        let line = format!("INIT {{ClassName P3AT}} {{Team {}}}", team.name);
        round.take(session, &Request::read(Ok(line)), &mut |_, _| {});
    }
    for _ in 0..STEPS {
        round.step(&mut |_, news| {
            if let News::Scored(score) = news {
                assert!(league.team(&score.team).is_some() && score.time.is_finite(), "{score:?}");
            }
        });
    }
    let standings = round.standings().expect("a league");
    assert_eq!(standings.teams.len(), league.teams.len());
    for team in standings.teams {
        let points: i64 = team.scores.iter().map(|score| i64::from(score.points)).sum();
        assert_eq!(points, team.points, "{}", team.team);
    }
}

/// A materials.toml, which is only checked: a world takes those that are built in.
pub fn material(bytes: &[u8]) {
    assert_lines(&scene_loader::check(&Folder::new(&[]).with("materials.toml", bytes)));
}

/// An ini of USARSim, as the equipment of three robots: one on wheels, one that flies, and an arm.
pub fn ini(bytes: &[u8]) {
    let read = Equipment::of_inis(&[Folder::new(&[]).with("x.ini", bytes)]);
    assert_lines(&read);
    let Ok(equipment) = read else { return };
    let classes = scene_loader::robot_names();
    let warnings = equipment.warnings(classes.iter().map(String::as_str));
    assert!(warnings.iter().all(|warning| warning.line > 0 && warning.column > 0), "{warnings:?}");
    let map = scene_loader::map("arena", &[]).expect("a map");
    for class in ["P3AT", "AirRobot", "KR60"] {
        let loaded = scene_loader::robot_equipped(class, Changes { overrides: &[], equipment: &equipment });
        assert_lines(&loaded);
        if let Ok(robot) = loaded {
            let robots = [(class.to_owned(), robot)].into();
            let world = WorldDef { map: map.clone(), robots, ..WorldDef::default() };
            // Loading a world ends with this check.
            if world.check().is_ok() {
                drive(world, class);
            }
        }
    }
}

/// A world of Gazebo, from which a map and a robot are made.
pub fn sdf(bytes: &[u8]) {
    let folder = Folder::new(&[("part.obj", MESH.as_bytes())]);
    let file = folder.with("x.sdf", bytes);
    robot_of_sdf(&file);
    let import = MapImport { floor: true, ..MapImport::new(&file) };
    let made = scene_loader::import_map(&import);
    assert_lines(&made);
    let Ok(made) = made else { return };
    for (name, bytes) in &made.meshes {
        folder.with(name, bytes);
    }
    let start = "[[start]]\nname = \"PlayerStart_0\"\nposition = [0.0, 0.0, 0.0]\n";
    drive_on_map(&folder.with("map.toml", (made.text + start).as_bytes()));
}

/// Imports the robots of a file of SDF. The URDF that one becomes is good, but for what its numbers say.
fn robot_of_sdf(file: &Path) {
    let work = Folder::new(&[]);
    let of = SdfFile { file, models: &[], within: None, work: &work.path("") };
    let Ok(robots) = scene_loader::sdf_robots(&of) else { return };
    for name in robots.iter().take(3) {
        let robot = scene_loader::sdf_robot(&of, Some(name)).expect("it is listed");
        assert!(!scene_loader::is_sdf(&robot.text) && scene_loader::urdf_name(&robot.text).is_some(), "{}", robot.text);
        let mut packages = Packages::around(file, &[], &[]).expect("its folder");
        packages.allow(&work.path(""));
        import(file, &robot.text, &robot.wheels, &packages);
    }
}

/// A URDF, checked by itself, as the body of two robots, and imported. A mesh that it may name is there.
pub fn urdf(bytes: &[u8]) {
    let folder = Folder::new(&[
        ("robot.toml", ROBOT_OF_URDF.as_bytes()),
        ("jointed.toml", ROBOT_OF_JOINTS.as_bytes()),
        ("part.obj", MESH.as_bytes()),
    ]);
    for (name, bytes) in LOOKS_WITH_JOINTS {
        folder.with(name, bytes);
    }
    assert_lines(&scene_loader::check(&folder.with("robot.urdf", bytes)));
    drive_robot(&folder.path("robot.toml"));
    drive_robot(&folder.path("jointed.toml"));
    let file = &folder.path("robot.urdf");
    let Ok(text) = scene_loader::xml_text(file) else { return };
    import(file, &text, &[], &Packages::around(file, &[], &[]).expect("its folder"));
}

/// Imports a URDF. What the import makes is a robot.
fn import(file: &Path, text: &str, wheels: &[String], packages: &Packages) {
    let import = Import { file, text, class: "Robot", packages, wheels, drive: None };
    let Ok(imported) = scene_loader::import(&import) else { return };
    let folder = Folder::new(&[]);
    std::fs::create_dir(folder.path("meshes")).expect("a folder");
    for (name, content) in imported.files {
        match content {
            Content::Text(text) => folder.with(&name, text.as_bytes()),
            Content::CopyOf(path) => folder.with(&name, &std::fs::read(path).expect("a mesh")),
        };
    }
    let robot = folder.path("robot.toml");
    scene_loader::check(&robot).expect("what was imported is good");
    drive_robot(&robot);
}

/// An STL file as a part of a map and as the body of a robot.
pub fn stl(bytes: &[u8]) {
    mesh("part.stl", bytes, MAP_OF_STL, URDF_OF_STL);
}

/// An OBJ file as a part of a map and as the body of a robot.
pub fn obj(bytes: &[u8]) {
    mesh("part.obj", bytes, MAP_OF_OBJ, URDF_OF_OBJ);
}

/// A COLLADA file as what is seen of a robot.
pub fn dae(bytes: &[u8]) {
    visual("part.dae", bytes);
}

/// A glTF file as what is seen of a robot.
pub fn glb(bytes: &[u8]) {
    visual("part.glb", bytes);
}

fn visual(name: &str, bytes: &[u8]) {
    let robot = format!("{ROBOT_OF_URDF}\n[[visual]]\nmesh = \"{name}\"\n");
    let folder = Folder::new(&[(name, bytes), ("robot.urdf", URDF_WITH_JOINTS.as_bytes())]);
    drive_robot(&folder.with("robot.toml", robot.as_bytes()));
}

fn mesh(name: &str, bytes: &[u8], map: &str, urdf: &str) {
    let folder = Folder::new(&[
        (name, bytes),
        ("map.toml", map.as_bytes()),
        ("robot.urdf", urdf.as_bytes()),
        ("robot.toml", ROBOT_OF_URDF.as_bytes()),
    ]);
    drive_on_map(&folder.path("map.toml"));
    drive_robot(&folder.path("robot.toml"));
}

/// A folder of its own, which goes when it is dropped.
struct Folder(TempDir);

impl Folder {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder for files"));
        for (name, bytes) in files {
            folder.with(name, bytes);
        }
        folder
    }

    fn with(&self, name: &str, bytes: &[u8]) -> PathBuf {
        std::fs::write(self.path(name), bytes).expect("a file is written");
        self.path(name)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

/// Loads a robot that passes its check, and drives it on the map with the most obstacles.
fn drive_robot(file: &Path) {
    let checked = scene_loader::check(file);
    assert_lines(&checked);
    if checked.is_ok() {
        let class = scene_loader::robot(&file.display().to_string(), &[]).expect("what is called good").class;
        drive(scene_loader::load("arena", &[file]).expect("what is called good"), &class);
    }
}

fn drive_on_map(file: &Path) {
    let checked = scene_loader::check(file);
    assert_lines(&checked);
    if checked.is_ok() {
        drive(scene_loader::load(&file.display().to_string(), &[]).expect("what is called good"), "P3AT");
    }
}

fn drive(definition: WorldDef, class: &str) {
    let start = definition.map.starts[0].name.clone();
    let mut world = World::new(definition, Options::default());
    let (mut robot, mut problems) = (None, Vec::new());
    for line in [
        format!("INIT {{ClassName {class}}} {{Start {start}}}"),
        "DRIVE {Left 2} {Right 3} {Front-Left 2} {Front-Right 3} {Back-Left 1} {Back-Right 2}".to_owned(),
        "GETCONF {Type Robot}".to_owned(),
        "GETGEO {Type Robot}".to_owned(),
    ] {
        let command = Command::parse(&line, &mut problems).expect("a command");
        let executed = world.execute(robot, &command, &mut problems);
        robot = executed.spawned.or(robot);
        assert_finite("an answer", &executed.answers);
    }
    let Some(robot) = robot else {
        // Something may lie on the start.
        return assert!(matches!(problems.first(), Some(Problem::NoRoom { .. })), "{problems:?}");
    };
    assert_finite("the start", &world.observe(robot));
    for step in 0..STEPS {
        assert_finite("a message", &world.step());
        assert_eq!(world.take_lost(), [], "step {step}");
        assert_finite(&format!("step {step}"), &world.observe(robot));
        assert_finite("the objects", &world.objects().map(|object| object.pose).collect::<Vec<_>>());
    }
}

/// Every mistake has a place.
fn assert_lines<T>(checked: &Result<T, LoadError>) {
    match checked {
        Err(LoadError::Bad(problems)) => {
            assert!(!problems.is_empty(), "refused without a reason");
            assert!(problems.iter().all(|problem| problem.line > 0 && problem.column > 0), "{problems:?}");
        }
        // A file without a shape has no line to name.
        Err(LoadError::Import(why)) => assert!(why.contains(": "), "{why}"),
        Err(LoadError::Unreadable { .. }) | Ok(_) => {}
        Err(other) => panic!("{other}"),
    }
}
