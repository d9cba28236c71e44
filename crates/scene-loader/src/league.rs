//! `league.toml`: the rules of a league, its map, and the settings of the server for it.

use std::path::{Path, PathBuf};

use scene::goal::{Goal, Zone};
use scene::{League, MapDef, NamedPose, ScoredGoal, Team, VictimRule, check};
use serde::Deserialize;

use crate::LoadError;
use crate::document::{Document, Table, Vector};
use crate::problem::Problems;
use crate::source::Source;
use crate::{catalogue, map as map_file, shipped};

const KEYS: &str = "name, map, time_limit, control, communication, victims, start, team, zone, goal";
/// File of a map's league, in its folder.
const LEAGUE: &str = "league.toml";
/// Map of a league that names none.
const DEFAULT_MAP: &str = "rescue";
/// Duration of a round, s, as in RoboCup.
const DEFAULT_TIME: f64 = 1200.0;

/// A league with its map and its settings of the server.
#[derive(Debug, Clone, PartialEq)]
pub struct LeagueFile {
    /// The rules.
    pub league: League,
    /// The map: a name or a path.
    pub map: String,
    /// Pages that may pause and reset the world.
    pub control: Controllers,
    /// Model of the radio between robots.
    pub communication: Communication,
}

/// Pages that may control the world of a league, unless tokens decide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Controllers {
    /// All pages.
    Everyone,
    /// Pages on the server's own machine.
    #[default]
    Local,
    /// No page.
    Nobody,
}

/// Model of the radio between robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Communication {
    /// Every link holds.
    #[default]
    Everywhere,
    /// Links weaken with the distance.
    Distance,
    /// Walls weaken them, too.
    Walls,
}

fn one() -> i32 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Victims {
    #[serde(default = "one")]
    points: i32,
    #[serde(default = "Victims::radius")]
    radius: f64,
    #[serde(default)]
    hold: f64,
    #[serde(default)]
    touch: i32,
}

impl Victims {
    /// Returns the distance from which RoboCup's robots report a victim, m.
    fn radius() -> f64 {
        1.5
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TeamTable {
    name: String,
    starts: Vec<String>,
    #[serde(default)]
    classes: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ZoneTable {
    name: String,
    position: Vector,
    size: Vector,
    #[serde(default = "one")]
    points: i32,
    #[serde(default)]
    hold: f64,
}

/// A goal with one table of its kind: `reach = { point = [1, 2], tolerance = 0.3 }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GoalTable {
    name: String,
    #[serde(default = "one")]
    points: i32,
    #[serde(default)]
    hold: f64,
    #[serde(flatten)]
    goal: Option<Goal>,
}

/// Loads a league from a file, or the league of a built-in map by the map's name. `map` replaces the file's map.
///
/// # Errors
/// Reports an unreadable file, all problems of the file, or a map that cannot be loaded.
pub fn league(path: &Path, map: Option<&str>) -> Result<LeagueFile, LoadError> {
    let mut problems = Problems::default();
    let built_in = shipped::league_of_map(&path.to_string_lossy()).filter(|_| !path.exists());
    let (source, name, folder) = match built_in {
        Some(source) => (source, LEAGUE.to_owned(), None),
        None => {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            (Source::of_file(path), name, path.parent())
        }
    };
    let league = read(&source.display(&name), &source.text(&name)?, folder, map, &mut problems)?;
    match league {
        Some(league) => problems.into_result(league),
        None => Err(LoadError::Bad(problems.into_list())),
    }
}

fn read(
    file: &str,
    text: &str,
    folder: Option<&Path>,
    map: Option<&str>,
    problems: &mut Problems,
) -> Result<Option<LeagueFile>, LoadError> {
    let Some((mut document, mut root)) = Document::parse(file, text, problems) else { return Ok(None) };
    let name: Option<String> = document.required(&mut root, "name", "a name for the league");
    let own_map: Option<String> = document.optional(&mut root, "map");
    let map = map.map(str::to_owned).or_else(|| own_map.map(|map| beside(folder, map)));
    let map = map.unwrap_or_else(|| DEFAULT_MAP.to_owned());
    let time_limit = document.optional(&mut root, "time_limit").unwrap_or(DEFAULT_TIME);
    let control = document.optional(&mut root, "control").unwrap_or_default();
    let communication = document.optional(&mut root, "communication").unwrap_or_default();
    let victims = read_victims(&mut document, &mut root);
    let mut starts = map_file::read_poses(&mut document, &mut root, "start");
    let map_def = catalogue::map(&map, &[])?;
    starts.extend(map_def.starts.iter().cloned());
    let teams = read_teams(&mut document, &mut root, &starts);
    let goals = read_goals(&mut document, &mut root, &map_def);
    document.finish(root, KEYS);
    let Some(name) = name else { return Ok(None) };
    let league = League { name, time_limit, teams, victims, goals };
    document.as_a_whole(|| check::league(&league));
    Ok(Some(LeagueFile { league, map, control, communication }))
}

/// Returns a map's path from the folder of the league, if it is a path; names stay as they are.
pub(crate) fn beside(folder: Option<&Path>, map: String) -> String {
    let path: Option<PathBuf> = folder.map(|folder| folder.join(&map)).filter(|path| path.exists());
    path.map_or(map, |path| path.display().to_string())
}

fn read_teams<'a>(document: &mut Document<'a>, root: &mut Table<'a>, known: &[NamedPose]) -> Vec<Team> {
    let tables = document.list(root, "team");
    let team = |(span, TeamTable { name, starts, classes })| {
        let names = || known.iter().map(|pose| pose.name.as_str());
        let poses = starts.iter().filter_map(|start| known.get(document.one_of(&span, "starts", start, names())?));
        let team = Team { name, starts: poses.cloned().collect(), classes };
        document.wrong(&span, check::team(&team));
        team
    };
    tables.into_iter().map(team).collect()
}

/// Reads the rule for victims, if there is one.
pub(crate) fn read_victims<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<VictimRule> {
    let (span, table) = document.section(root, "victims").ok().flatten()?;
    let Victims { points, radius, hold, touch } = table;
    let rule = VictimRule { points, radius, hold, touch };
    document.wrong(&span, check::victim_rule(&rule));
    Some(rule)
}

/// Reads zones, and then the goals on a map.
pub(crate) fn read_goals<'a>(document: &mut Document<'a>, root: &mut Table<'a>, map: &MapDef) -> Vec<ScoredGoal> {
    let mut goals = read_zones(document, root);
    goals.extend(read_others(document, root, map));
    goals
}

fn read_zones<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Vec<ScoredGoal> {
    let tables = document.list(root, "zone");
    let zone = |(span, ZoneTable { name, position, size, points, hold })| {
        let zone = ScoredGoal { name, points, hold, goal: Goal::Zone(Zone { position, size }) };
        document.wrong(&span, check::scored_goal(&zone));
        zone
    };
    tables.into_iter().map(zone).collect()
}

fn read_others<'a>(document: &mut Document<'a>, root: &mut Table<'a>, map: &MapDef) -> Vec<ScoredGoal> {
    let tables = document.list(root, "goal");
    let goal = |(span, GoalTable { name, points, hold, goal })| {
        let Some(goal) = goal else {
            let expected = "expected one table of reach, follow, push, fetch, explore, find and zone".to_owned();
            document.wrong(&span, vec![expected]);
            return None;
        };
        let goal = ScoredGoal { name, points, hold, goal };
        let missing = check::missing_on_map(&goal.goal, map);
        document.wrong(&span, check::scored_goal(&goal).into_iter().chain(missing));
        Some(goal)
    };
    tables.into_iter().filter_map(goal).collect()
}
