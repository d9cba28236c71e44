//! Limits of goals.

use super::limits::{
    CELL, GOAL_REACH, MAP_REACH, MAP_SIZE, MAX_CELLS, MAX_PATH_POINTS, PATH_WIDTH, SHARE, SIGHT, TOLERANCE,
};
use super::{Range, name};
use crate::goal::{Explore, Fetch, Find, Follow, Goal, Push, Reach, Zone};

/// Lists the problems of a goal that need no world.
pub fn goal(def: &Goal) -> Vec<String> {
    let mut wrong = Vec::new();
    match def {
        Goal::Reach(Reach { point, distance, tolerance }) => {
            wrong.extend(point.iter().flatten().filter_map(|&it| within("reach.point", [it; 2], GOAL_REACH)));
            wrong.extend(distance.and_then(|it| within("reach.distance", it, FAR)));
            wrong.extend(within("reach.tolerance", [*tolerance; 2], TOLERANCE));
            if point.is_some() == distance.is_some() {
                wrong.push("reach: expected either a `point` or a `distance`".to_owned());
            }
        }
        Goal::Follow(Follow { points, spacing, most_beside, .. }) => {
            wrong.extend(within("follow.spacing", [*spacing; 2], PATH_WIDTH));
            wrong.extend(within("follow.most_beside", [*most_beside; 2], PATH_WIDTH));
            if !(1..=MAX_PATH_POINTS).contains(&points.len()) {
                wrong.push(format!("follow.points: got {}, expected 1 to {MAX_PATH_POINTS}", points.len()));
            }
            wrong.extend(points.iter().flatten().find_map(|&it| within("follow.points", [it; 2], GOAL_REACH)));
            let apart = |[a, b]: [f64; 2], [c, d]: [f64; 2]| (c - a) * (c - a) + (d - b) * (d - b);
            let before = std::iter::once(&[0.0; 2]).chain(points);
            wrong.extend(before.zip(points).find(|(before, point)| apart(**before, **point) < 1e-6).map(
                |(_, point)| {
                    format!("follow.points: got {point:?} twice, expected points that differ, the first not 0, 0")
                },
            ));
        }
        Goal::Push(Push { object, target, tolerance }) => {
            at_point("push", object.as_ref(), *target, *tolerance, &mut wrong)
        }
        Goal::Fetch(Fetch { object, target, tolerance, .. }) => {
            at_point("fetch", object.as_ref(), *target, *tolerance, &mut wrong);
        }
        Goal::Explore(explore) => {
            let Explore { area, cell, sight, part, .. } = explore;
            wrong.extend(area.iter().find_map(|&range| within("explore.area", range, GOAL_REACH)));
            wrong.extend(within("explore.cell", [*cell; 2], CELL));
            wrong.extend(within("explore.sight", [*sight; 2], Range { least: *cell, ..FAR }));
            wrong.extend(within("explore.part", [*part; 2], SHARE));
            if wrong.is_empty() {
                let cells = explore.cell_count();
                if cells > MAX_CELLS {
                    wrong.push(format!("explore.cell: got {cells} cells, expected at most {MAX_CELLS}"));
                }
            }
        }
        Goal::Find(Find { victim, radius }) => {
            wrong.extend(name("find.victim", victim));
            wrong.extend(SIGHT.problem("find.radius", *radius));
        }
        Goal::Zone(zone) => wrong.extend(self::zone(zone)),
    }
    wrong
}

/// Lists the problems of a zone.
fn zone(def: &Zone) -> Vec<String> {
    let mut wrong: Vec<String> = MAP_REACH.problem_in("position", &def.position).into_iter().collect();
    wrong.extend(MAP_SIZE.problem_in("size", &def.size));
    wrong
}

/// Lists the problems of a goal for an object at a point.
fn at_point(key: &str, object: Option<&String>, target: [[f64; 2]; 2], tolerance: f64, wrong: &mut Vec<String>) {
    wrong.extend(object.iter().flat_map(|it| name(&format!("{key}.object"), it)));
    wrong.extend(target.into_iter().find_map(|range| within(&format!("{key}.target"), range, GOAL_REACH)));
    wrong.extend(within(&format!("{key}.tolerance"), [tolerance; 2], TOLERANCE));
}

/// Describes a range of numbers that is not ordered or not within another one; `None` if it is good.
pub fn within(key: &str, [low, high]: [f64; 2], Range { least, most, .. }: Range) -> Option<String> {
    let is_good = low >= least && high <= most && low <= high;
    (!is_good).then(|| format!("{key}: got {low} to {high}, expected a range within {least} to {most}"))
}

/// Distances of goals.
const FAR: Range = Range { least: 0.0, ..GOAL_REACH };
