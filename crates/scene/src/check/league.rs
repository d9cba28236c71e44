//! Limits of a league.

use std::collections::BTreeSet;

use super::limits::{LEAGUE_TIME, MAP_REACH, MAP_SIZE, MAX_ROBOTS, MAX_STARTS, MAX_TEAMS, MAX_ZONES, POINTS, SIGHT};
use super::{SceneProblem, count, first, name, named_pose, shown, wire_name};
use crate::{Classes, League, NamedPose, Team, VictimRule, Zone};

pub(super) fn check_league(def: &League, robots: &Classes) -> Result<(), SceneProblem> {
    first("the league", league(def))?;
    for it in &def.teams {
        let starts = it.starts.iter().flat_map(named_pose);
        let unknown = it.classes.iter().filter(|class| !robots.contains_key(class));
        let unknown = unknown.map(|class| format!("no class `{}`: expected one of `usarsim robots`", shown(class)));
        first(&format!("the league, team {}", shown(&it.name)), team(it).into_iter().chain(starts).chain(unknown))?;
    }
    first("the league, victims", def.victims.iter().flat_map(victim_rule))?;
    def.zones.iter().try_for_each(|it| first(&format!("the league, zone {}", shown(&it.name)), zone(it)))
}

/// Lists the problems of a league; its teams, rules and zones have their own checks.
pub fn league(def: &League) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(LEAGUE_TIME.problem("time_limit", def.time_limit));
    if def.teams.is_empty() {
        wrong.push("no [[team]]: expected at least one".to_owned());
    }
    wrong.extend(count("teams", def.teams.len(), MAX_TEAMS));
    wrong.extend(count("zones", def.zones.len(), MAX_ZONES));
    let is_twice = |number: usize, name: &str| def.team(name) != Some(number);
    let twice = def.teams.iter().enumerate().find(|(number, team)| is_twice(*number, &team.name));
    wrong.extend(
        twice.map(|(_, team)| format!("two teams are called `{}`: expected different names", shown(&team.name))),
    );
    let names: BTreeSet<_> = def.zones.iter().map(|zone| &zone.name).collect();
    if names.len() < def.zones.len() {
        wrong.push("two zones have the same name: expected different names".to_owned());
    }
    wrong
}

/// Lists the problems of a team; its poses have their own checks.
pub fn team(def: &Team) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    if def.starts.is_empty() {
        wrong.push("`starts` is empty: expected a start pose for each robot".to_owned());
    }
    wrong.extend(count("start poses", def.starts.len(), MAX_STARTS));
    wrong.extend(count("classes", def.classes.len(), MAX_ROBOTS));
    let is_same = |a: &NamedPose, b: &NamedPose| a.name.eq_ignore_ascii_case(&b.name);
    let twice = (1..def.starts.len()).find(|&it| def.starts[..it].iter().any(|other| is_same(other, &def.starts[it])));
    wrong.extend(twice.map(|it| format!("`starts` has {} twice", shown(&def.starts[it].name))));
    wrong
}

/// Lists the problems of a rule for victims.
pub fn victim_rule(def: &VictimRule) -> Vec<String> {
    let mut wrong: Vec<String> = SIGHT.problem("radius", def.radius).into_iter().collect();
    wrong.extend(LEAGUE_TIME.problem("hold", def.hold).filter(|_| def.hold != 0.0));
    wrong.extend(POINTS.problem("points", f64::from(def.points)));
    wrong.extend(POINTS.problem("touch", f64::from(def.touch)));
    wrong
}

/// Lists the problems of a zone.
pub fn zone(def: &Zone) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(MAP_SIZE.problem_in("size", &def.size));
    wrong.extend(LEAGUE_TIME.problem("hold", def.hold).filter(|_| def.hold != 0.0));
    wrong.extend(POINTS.problem("points", f64::from(def.points)));
    wrong
}
