//! Leagues: teams that score on a map within a time.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::NamedPose;
use crate::goal::Goal;
use crate::stored;

/// Definition of a league: the rules of one round.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "stored::League")]
pub struct League {
    /// Name, for people.
    pub name: String,
    /// Simulated time from the first robot's arrival to the end, s.
    pub time_limit: f64,
    /// Teams, in the order of the file.
    pub teams: Vec<Team>,
    /// Rule for the map's victims; without it they do not count.
    pub victims: Option<VictimRule>,
    /// Goals beside the victims.
    pub goals: Vec<ScoredGoal>,
}

/// A team.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Team {
    /// Name without white space or braces, as in `INIT {Team red}`.
    pub name: String,
    /// Start poses. The team has at most as many robots at a time.
    pub starts: Vec<NamedPose>,
    /// Classes that its robots may have; any if empty.
    pub classes: Vec<String>,
}

/// Points for victims. A robot finds a victim that it sees from nearby for a while.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct VictimRule {
    /// Points for each victim that a team finds.
    pub points: i32,
    /// Greatest distance between robot frame and pelvis, m.
    pub radius: f64,
    /// Time for which the robot has to see it without a break, s.
    pub hold: f64,
    /// Points for each victim that a robot touches, usually negative; once for each robot and victim.
    pub touch: i32,
}

/// A goal that brings points to each team, once, when one of its robots reaches it and stays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScoredGoal {
    /// Name without white space or braces.
    pub name: String,
    /// Points.
    pub points: i32,
    /// Time for which the robot has to stay, s.
    pub hold: f64,
    /// The goal.
    pub goal: Goal,
}

impl League {
    /// Finds a team by its name, in any case.
    pub fn team(&self, name: &str) -> Option<usize> {
        self.teams.iter().position(|team| team.name.eq_ignore_ascii_case(name))
    }
}

/// A change of a team's points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Simulated time, s.
    pub time: f64,
    /// Name of the team.
    pub team: String,
    /// Number of the robot.
    pub robot: u64,
    /// The reason, as in `found victim-1`, `reached exit` or `touched victim-1`.
    pub reason: String,
    /// Points gained or lost.
    pub points: i32,
    /// The team's points afterwards.
    pub total: i64,
    /// Position of the robot, m.
    pub position: [f64; 3],
}

/// The state of a league: every team's points.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Standings {
    /// Name of the league.
    pub league: String,
    /// Name of the map.
    pub map: String,
    /// Simulated time from the first robot's arrival to the end, s.
    pub time_limit: f64,
    /// Simulated time when the first robot arrived, s.
    pub began: Option<f64>,
    /// Simulated time of this state, s.
    pub time: f64,
    /// True if the time is up.
    pub is_over: bool,
    /// Teams, in the order of the definition.
    pub teams: Vec<Standing>,
}

/// The state of a team.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Standing {
    /// Its name.
    pub team: String,
    /// Its points.
    pub points: i64,
    /// Robots that entered for it.
    pub robots: Vec<Entrant>,
    /// Changes of its points, in order.
    pub scores: Vec<Score>,
    /// Simulated time from the first robot's arrival to the last goal, when it has reached all, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finished: Option<f64>,
}

/// A robot that entered for a team.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entrant {
    /// Its number.
    pub robot: u64,
    /// Its class.
    pub class: String,
    /// Its name from INIT.
    pub name: String,
}

impl Score {
    /// True if the points are for a victim that was found.
    pub fn is_found_victim(&self) -> bool {
        self.reason.starts_with("found ")
    }

    /// Returns the name of the goal or victim that it is for; penalties have none.
    pub fn goal(&self) -> Option<&str> {
        ["found ", "reached "].into_iter().find_map(|done| self.reason.strip_prefix(done))
    }

    /// Returns the bytes of memory that its texts take.
    pub fn held(&self) -> usize {
        size_of::<Self>() + self.team.len() + self.reason.len()
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { team, reason, points, total, .. } = self;
        write!(f, "{team} {reason}: {points:+}, now {total}")
    }
}

impl Standings {
    /// Returns the time that is left, s.
    pub fn time_left(&self) -> f64 {
        self.began.map_or(self.time_limit, |began| (began + self.time_limit - self.time).max(0.0))
    }

    /// Returns the teams with their places, from 1. Teams with equal points share a place.
    pub fn ranking(&self) -> Vec<(usize, &Standing)> {
        let mut teams: Vec<&Standing> = self.teams.iter().collect();
        teams.sort_by_key(|team| std::cmp::Reverse(team.points));
        let place = |team: &Standing| 1 + self.teams.iter().filter(|other| other.points > team.points).count();
        teams.into_iter().map(|team| (place(team), team)).collect()
    }
}
