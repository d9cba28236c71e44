//! `scenario.toml`: something to do on a map. Its goals are written as those of a league.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scene::{League, NamedPose, Scenario, ScenarioCard, ScenarioRobot, Setting, Team, Viewpoint, check};
use serde::Deserialize;

use crate::LoadError;
use crate::document::{Document, Vector};
use crate::league::{beside, read_goals, read_victims};
use crate::materials::Materials;
use crate::problem::Problems;
use crate::shipped::{SCENARIOS, built_in_materials, folders, unknown};
use crate::source::Source;
use crate::{catalogue, map as map_file};

const KEYS: &str = "title, text, keys, map, time_limit, stars, rank, camera, robot, victims, zone, goal, half_space, box, ramp, cylinder, ball, \
                    mesh, height_field";
/// File of a scenario, in its folder.
const SCENARIO: &str = "scenario.toml";
/// Lines of a run that reaches the goals, with their times, in its folder.
const DEMO: &str = "demo.txt";
/// Picture of a scenario, in its folder.
const PICTURE: &str = "picture.jpg";
/// Largest picture, bytes.
const MAX_PICTURE: u64 = 1 << 20;
/// Most scenarios of a folder.
const MAX_SCENARIOS: usize = 256;
/// Place in lists of a scenario that says none.
const LAST: u32 = 100;
/// The only team.
const TEAM: &str = "players";

/// A scenario as a list shows it, without its map, and the files beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedScenario {
    /// Its name, or the path of its file or folder, as it was asked for.
    pub found: String,
    /// The card.
    pub card: ScenarioCard,
    /// Lines of a run that reaches the goals, with their times.
    pub demo: Option<String>,
    /// Picture as JPEG.
    pub picture: Option<Vec<u8>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RobotTable {
    class: String,
    #[serde(default)]
    name: Option<String>,
    position: Vector,
    #[serde(default)]
    rotation: Vector,
}

/// Returns the names of the embedded scenarios.
pub fn scenario_names() -> Vec<String> {
    let is_scenario = |name: &String| SCENARIOS.get_file(format!("{name}/{SCENARIO}")).is_some();
    folders(&SCENARIOS).into_iter().filter(is_scenario).collect()
}

/// Lists the scenarios of a folder: its folders with a `scenario.toml`, by their names.
///
/// # Errors
/// When it cannot be read, has none, or has too many.
pub fn scenarios_in(folder: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let unreadable = |reason: String| LoadError::Unreadable { file: folder.display().to_string(), reason };
    let entries = std::fs::read_dir(folder).map_err(|error| unreadable(error.to_string()))?;
    let found = entries.flatten().map(|entry| entry.path()).filter(|path| path.join(SCENARIO).is_file());
    let mut found: Vec<PathBuf> = found.take(MAX_SCENARIOS + 1).collect();
    found.sort();
    match found.len() {
        0 => Err(unreadable(format!("expected folders with a {SCENARIO}"))),
        count if count > MAX_SCENARIOS => Err(unreadable(format!("expected at most {MAX_SCENARIOS} scenarios"))),
        _ => Ok(found),
    }
}

/// Loads a scenario by its name, or by the path of its file or folder: its map with its own solids, and its goals as a league of one team.
///
/// # Errors
/// Reports an unknown name, an unreadable file, all problems of the file, or a map that cannot be loaded.
pub fn scenario(name: &str) -> Result<Setting, LoadError> {
    let (source, file, name) = find(name)?;
    let mut problems = Problems::default();
    let text = source.text(&file)?;
    let read = read(&source, &file, &name, &text, &built_in_materials(&[])?, &mut problems)?;
    match read {
        Some(scenario) => problems.into_result(scenario),
        None => Err(LoadError::Bad(problems.into_list())),
    }
}

/// Reads what a list shows of scenarios, and sorts them by their rank and then by their names. The last one of several with a name counts.
///
/// # Errors
/// Reports an unknown name, an unreadable file, or a file without what a list shows.
pub fn listed_scenarios(names: &[String]) -> Result<Vec<ListedScenario>, LoadError> {
    let mut by_name = BTreeMap::new();
    for name in names {
        let listed = listed_scenario(name)?;
        by_name.insert(listed.card.name.clone(), listed);
    }
    let mut listed: Vec<ListedScenario> = by_name.into_values().collect();
    listed.sort_by(|a, b| (a.card.rank, &a.card.name).cmp(&(b.card.rank, &b.card.name)));
    Ok(listed)
}

/// Reads what a list shows of a scenario. Only [`scenario`] checks all of it.
fn listed_scenario(asked: &str) -> Result<ListedScenario, LoadError> {
    #[derive(Deserialize)]
    struct Robot {
        class: String,
    }
    #[derive(Deserialize)]
    struct Head {
        title: String,
        text: String,
        keys: String,
        map: String,
        time_limit: f64,
        stars: [f64; 2],
        rank: Option<u32>,
        robot: Vec<Robot>,
    }
    let (source, file, name) = find(asked)?;
    let unreadable = |reason: String| LoadError::Unreadable { file: source.display(&file), reason };
    let Head { title, text, keys, map, time_limit, stars, rank, robot } =
        toml::from_str(&source.text(&file)?).map_err(|error| unreadable(error.message().to_owned()))?;
    let robots = robot.into_iter().map(|robot| robot.class).collect();
    let map = Path::new(&map).file_name().map_or(map.clone(), |name| name.to_string_lossy().into_owned());
    let demo = source.has(DEMO).then(|| source.text(DEMO)).transpose()?;
    let picture = source.has(PICTURE).then(|| source.bytes(PICTURE, MAX_PICTURE)).transpose()?;
    let rank = rank.unwrap_or(LAST);
    let card = ScenarioCard { name, title, text, keys, map, robots, time_limit, stars, rank };
    Ok(ListedScenario { found: asked.to_owned(), card, demo, picture })
}

/// Returns the folder, the file and the name of a scenario.
fn find(name: &str) -> Result<(Source, String, String), LoadError> {
    if let Some(dir) = SCENARIOS.get_dir(name) {
        return Ok((Source::BuiltIn(dir), SCENARIO.to_owned(), name.to_owned()));
    }
    let path = &catalogue::in_folder(Path::new(name), SCENARIO);
    if !path.is_file() {
        return Err(unknown("scenario", name, &scenario_names()));
    }
    let file = catalogue::file_name(path, "a scenario.toml")?;
    Ok((Source::of_file(path), file, catalogue::name_of(path, "scenario")))
}

fn read(
    source: &Source,
    file: &str,
    name: &str,
    text: &str,
    materials: &Materials,
    problems: &mut Problems,
) -> Result<Option<Setting>, LoadError> {
    let shown = source.display(file);
    let Some((mut document, mut root)) = Document::parse(&shown, text, problems) else { return Ok(None) };
    let title: Option<String> = document.required(&mut root, "title", "a title");
    let what: Option<String> = document.required(&mut root, "text", "one line about what is to be done");
    let keys: Option<String> = document.required(&mut root, "keys", "the keys that matter, in one line");
    let map: Option<String> = document.required(&mut root, "map", "the name of a map");
    let time_limit: Option<f64> = document.required(&mut root, "time_limit", "the time to its end in seconds");
    let stars: Option<[f64; 2]> = document.required(&mut root, "stars", "times for three stars and two in seconds");
    let _: Option<u32> = document.optional(&mut root, "rank");
    let camera: Option<Viewpoint> = document.section(&mut root, "camera").ok().flatten().map(|(_, camera)| camera);
    let Some(map) = map else { return Ok(None) };
    let mut map = catalogue::map(&beside(source.path(), map), &[])?;
    map_file::read_solids(source, &mut document, &mut root, materials, &mut map);
    let (mut robots, mut starts) = (Vec::new(), Vec::new());
    for (span, table) in document.list(&mut root, "robot") {
        let RobotTable { class, name, position, rotation } = table;
        let name = name.unwrap_or_else(|| class.clone());
        let start = NamedPose { name: name.clone(), position, rotation };
        document.wrong(&span, check::named_pose(&start));
        robots.push(ScenarioRobot { class, name });
        starts.push(start);
    }
    let victims = read_victims(&mut document, &mut root);
    let goals = read_goals(&mut document, &mut root, &map);
    if goals.is_empty() && victims.is_none() {
        document.problem(&(0..0), "no goal: expected [victims], a [[zone]] or a [[goal]]");
    }
    document.finish(root, KEYS);
    document.as_a_whole(|| check::map(&map));
    let (Some(title), Some(text), Some(keys)) = (title, what, keys) else { return Ok(None) };
    let (Some(time_limit), Some(stars)) = (time_limit, stars) else { return Ok(None) };
    let mut classes: Vec<String> = robots.iter().map(|robot| robot.class.clone()).collect();
    classes.sort();
    classes.dedup();
    let team = Team { name: TEAM.to_owned(), starts, classes };
    let scenario = Scenario { name: name.to_owned(), title, text, keys, robots, stars, camera };
    document.as_a_whole(|| check::scenario(&scenario, time_limit).into_iter().chain(check::team(&team)).collect());
    let league = League { name: scenario.title.clone(), time_limit, teams: vec![team], victims, goals };
    document.as_a_whole(|| check::league(&league));
    Ok(Some(Setting { map, league: Some(league), scenario: Some(scenario) }))
}
