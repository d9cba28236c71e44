//! Limits of a league.

use std::collections::BTreeSet;

use super::limits::{
    LEAGUE_TIME, MAX_GOALS, MAX_LEAGUE_CELLS, MAX_LEAGUE_POINTS, MAX_LEAGUE_SIGHT, MAX_ROBOTS, MAX_STARTS, MAX_TEAMS,
    POINTS, SIGHT,
};
use super::{SceneProblem, count, first, goal, name, named_pose, shown, wire_name};
use crate::goal::{Find, Goal, Reach};
use crate::{Classes, League, MapDef, NamedPose, ScoredGoal, Team, VictimRule};

pub(super) fn check_league(def: &League, map: &MapDef, robots: &Classes) -> Result<(), SceneProblem> {
    first("the league", league(def))?;
    for it in &def.teams {
        let starts = it.starts.iter().flat_map(named_pose);
        let unknown = it.classes.iter().filter(|class| !robots.contains_key(class));
        let unknown = unknown.map(|class| format!("no class `{}`: expected one of `usarsim robots`", shown(class)));
        first(&format!("the league, team {}", shown(&it.name)), team(it).into_iter().chain(starts).chain(unknown))?;
    }
    first("the league, victims", def.victims.iter().flat_map(victim_rule))?;
    def.goals.iter().try_for_each(|it| {
        let wrong = scored_goal(it).into_iter().chain(missing_on_map(&it.goal, map));
        first(&format!("the league, goal {}", shown(&it.name)), wrong)
    })
}

/// Lists the problems of a league; its teams, rules and goals have their own checks.
pub fn league(def: &League) -> Vec<String> {
    let mut wrong = name("name", &def.name);
    wrong.extend(LEAGUE_TIME.problem("time_limit", def.time_limit));
    if def.teams.is_empty() {
        wrong.push("no [[team]]: expected at least one".to_owned());
    }
    wrong.extend(count("teams", def.teams.len(), MAX_TEAMS));
    wrong.extend(count("goals", def.goals.len(), MAX_GOALS));
    let is_twice = |number: usize, name: &str| def.team(name) != Some(number);
    let twice = def.teams.iter().enumerate().find(|(number, team)| is_twice(*number, &team.name));
    wrong.extend(
        twice.map(|(_, team)| format!("two teams are called `{}`: expected different names", shown(&team.name))),
    );
    let names: BTreeSet<_> = def.goals.iter().map(|goal| &goal.name).collect();
    if names.len() < def.goals.len() {
        wrong.push("two goals or zones have the same name: expected different names".to_owned());
    }
    let (mut cells, mut points) = (0.0, 0);
    for it in &def.goals {
        match &it.goal {
            Goal::Explore(explore) => cells += explore.cell_count(),
            Goal::Follow(follow) => points += follow.points.len(),
            Goal::Reach(_) | Goal::Push(_) | Goal::Fetch(_) | Goal::Find(_) | Goal::Zone(_) => {}
        }
    }
    if cells > MAX_LEAGUE_CELLS {
        wrong.push(format!("the areas to explore have {cells} cells: expected at most {MAX_LEAGUE_CELLS}"));
    }
    wrong.extend(count("points of paths", points, MAX_LEAGUE_POINTS));
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

/// Lists the problems of a goal that brings points.
pub fn scored_goal(def: &ScoredGoal) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(goal(&def.goal));
    wrong.extend(LEAGUE_TIME.problem("hold", def.hold).filter(|_| def.hold != 0.0));
    wrong.extend(POINTS.problem("points", f64::from(def.points)));
    match &def.goal {
        Goal::Reach(Reach { point: None, .. }) => {
            wrong.push("reach: expected a `point`: in a league nothing is random".to_owned())
        }
        Goal::Push(push) if push.object.is_none() => wrong.push("push: expected an `object` of the map".to_owned()),
        Goal::Fetch(fetch) if fetch.object.is_none() => wrong.push("fetch: expected an `object` of the map".to_owned()),
        Goal::Explore(explore) if explore.sight > MAX_LEAGUE_SIGHT * explore.cell => {
            wrong.push(format!("explore.sight: got {}, expected at most {MAX_LEAGUE_SIGHT} cells", explore.sight));
        }
        Goal::Reach(_)
        | Goal::Follow(_)
        | Goal::Push(_)
        | Goal::Fetch(_)
        | Goal::Explore(_)
        | Goal::Find(_)
        | Goal::Zone(_) => {}
    }
    wrong
}

/// Describes what a goal names and the map does not have; `None` if the map has all.
pub fn missing_on_map(goal: &Goal, map: &MapDef) -> Option<String> {
    let (what, name, known): (_, _, Vec<&str>) = match (goal, goal.object()) {
        (_, Some(name)) => ("object", name, map.objects.iter().map(|object| object.solid.name.as_str()).collect()),
        (Goal::Find(Find { victim, .. }), None) => {
            ("victim", victim.as_str(), map.victims.iter().map(|victim| victim.name.as_str()).collect())
        }
        (
            Goal::Reach(_) | Goal::Follow(_) | Goal::Push(_) | Goal::Fetch(_) | Goal::Explore(_) | Goal::Zone(_),
            None,
        ) => return None,
    };
    if known.iter().any(|it| it.eq_ignore_ascii_case(name)) {
        return None;
    }
    Some(format!("the map {} has no {what} `{}`: it has {}", map.name, shown(name), names::listed(known)))
}
