//! Limits of a scenario.

use super::limits::{LEAGUE_TIME, MAP_REACH, MAX_STARTS};
use super::{SceneProblem, count, first, name, shown, wire_name};
use crate::{Classes, League, Scenario};

pub(super) fn check_scenario(def: &Scenario, league: Option<&League>, robots: &Classes) -> Result<(), SceneProblem> {
    let place = format!("the scenario {}", shown(&def.name));
    let Some(league) = league else { return first(&place, ["it has no league: expected its goals".to_owned()]) };
    let unknown = def.robots.iter().filter(|robot| !robots.contains_key(&robot.class));
    let unknown = unknown.map(|it| format!("no class `{}`: expected one of `usarsim robots`", shown(&it.class)));
    first(&place, scenario(def, league.time_limit).into_iter().chain(unknown))
}

/// Lists the problems of a scenario whose time ends after so long, s.
pub fn scenario(def: &Scenario, time_limit: f64) -> Vec<String> {
    let mut wrong: Vec<String> = [("name", &def.name), ("title", &def.title), ("text", &def.text), ("keys", &def.keys)]
        .into_iter()
        .flat_map(|(key, text)| name(key, text))
        .collect();
    if def.robots.is_empty() {
        wrong.push("no [[robot]]: expected at least one".to_owned());
    }
    wrong.extend(count("robots", def.robots.len(), MAX_STARTS));
    wrong.extend(def.robots.iter().flat_map(|robot| wire_name("class", &robot.class)));
    wrong.extend(LEAGUE_TIME.problem_in("stars", &def.stars));
    let [three, two] = def.stars;
    if !(three <= two && two <= time_limit) {
        wrong.push(format!(
            "`stars` is [{three}, {two}]: expected a first time that is less, both within {time_limit} s"
        ));
    }
    for (key, point) in def.camera.iter().flat_map(|it| [("camera.from", it.from), ("camera.at", it.at)]) {
        wrong.extend(MAP_REACH.problem_in(key, &point));
    }
    if def.camera.is_some_and(|camera| camera.from == camera.at) {
        wrong.push("camera: `from` is `at`: expected two places".to_owned());
    }
    wrong
}
