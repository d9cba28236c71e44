//! One round of a league: who plays, and who has how many points. Everything follows from the world and the lines of its sessions, so
//! a replay comes to the same points.

use std::collections::{BTreeMap, BTreeSet};

use gamebots_proto::command::Init;
use gamebots_proto::{Problem, shown};
use names::listed;
use scene::{Entrant, League, PawnId, Score, Standing, Standings, Team};
use sim_core::World;

/// Simulated time between two looks for victims and zones, s.
const LOOK_INTERVAL: f64 = 0.1;
/// Simulated time below which two times are the same, s.
const SAME_TIME: f64 = 1e-9;
/// Most robots of a team that the standings list.
const MAX_ENTRANTS: usize = 256;

/// A round that is played.
#[derive(Clone)]
pub(super) struct Round {
    league: League,
    /// Simulated time when the first robot arrived, s.
    began: Option<f64>,
    is_over: bool,
    /// Simulated time of the next look, s.
    next_look: f64,
    players: BTreeMap<PawnId, Player>,
    /// Goals that teams have reached.
    reached: BTreeSet<(usize, Goal)>,
    /// The state of each team, in the order of the league.
    teams: Vec<Standing>,
}

/// A place in a team.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Admission {
    team: usize,
    /// Index of the start pose.
    start: usize,
}

/// A robot that plays.
#[derive(Clone)]
struct Player {
    place: Admission,
    /// Goals at which it is, each with the simulated time of its arrival, s.
    since: BTreeMap<Goal, f64>,
    touched: BTreeSet<usize>,
}

/// A victim of the map or a zone of the league, by its index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Goal {
    Victim(usize),
    Zone(usize),
}

impl Round {
    pub(super) fn new(league: &League) -> Self {
        let team = |team: &Team| Standing { team: team.name.clone(), ..Standing::default() };
        Self {
            began: None,
            is_over: false,
            next_look: 0.0,
            players: BTreeMap::new(),
            reached: BTreeSet::new(),
            teams: league.teams.iter().map(team).collect(),
            league: league.clone(),
        }
    }

    /// Gives a robot a place in its team, and puts the team's start pose into its INIT.
    ///
    /// # Errors
    /// If it names no team, or if the team may not have this robot.
    pub(super) fn admit(&mut self, init: &mut Init, world: &World) -> Result<Admission, Problem> {
        self.players.retain(|pawn, _| world.robot(*pawn).is_some());
        let refused = |why: String| Problem::NotAdmitted { why };
        let team = self.team(init).map_err(refused)?;
        let Team { name, starts, classes } = &self.league.teams[team];
        if !classes.is_empty() && !classes.iter().any(|class| class.eq_ignore_ascii_case(init.class())) {
            let expected = listed(classes.iter().map(String::as_str));
            return Err(refused(format!("team {name} has no {}: expected one of {expected}", shown(init.class()))));
        }
        let is_free = |start: &usize| {
            let place = Admission { team, start: *start };
            self.players.values().all(|player| player.place != place)
        };
        let wanted = starts.iter().position(|start| start.name.eq_ignore_ascii_case(&init.start));
        let Some(start) = wanted.filter(is_free).or_else(|| (0..starts.len()).find(is_free)) else {
            return Err(refused(format!("team {name} has all its {} robots in the world", starts.len())));
        };
        let pose = &starts[start];
        init.start.clear();
        (init.location, init.rotation) = (pose.position, pose.rotation);
        Ok(Admission { team, start })
    }

    /// Returns the team that an INIT names, by itself or by its start pose. A single team need not be named.
    fn team(&self, init: &Init) -> Result<usize, String> {
        let names = listed(self.league.teams.iter().map(|team| team.name.as_str()));
        let expected = || format!("expected {{Team ..}} with one of {names}");
        if !init.team.is_empty() {
            let team = self.league.team(&init.team);
            return team.ok_or_else(|| format!("no team `{}`: {}", shown(&init.team), expected()));
        }
        let has_start = |team: &Team| team.starts.iter().any(|start| start.name.eq_ignore_ascii_case(&init.start));
        let with_start = || (0..self.league.teams.len()).filter(|&team| has_start(&self.league.teams[team]));
        match (self.league.teams.len(), with_start().count()) {
            (1, _) => Ok(0),
            (_, 1) => with_start().next().ok_or_else(expected),
            _ => Err(expected()),
        }
    }

    /// Enters a robot that came into the world.
    pub(super) fn enter(&mut self, pawn: PawnId, place: Admission, init: &Init, time: f64) {
        self.began.get_or_insert(time);
        self.players.insert(pawn, Player { place, since: BTreeMap::new(), touched: BTreeSet::new() });
        let robots = &mut self.teams[place.team].robots;
        if robots.len() < MAX_ENTRANTS {
            robots.push(Entrant { robot: pawn.0, class: init.class().to_owned(), name: init.name.clone() });
        }
    }

    /// Gives points for what robots did in the last step, and returns them. Returns true as well if the time is up now.
    pub(super) fn step(&mut self, world: &mut World) -> (Vec<Score>, bool) {
        let (time, mut scores) = (world.time(), Vec::new());
        let Some(began) = self.began.filter(|_| !self.is_over) else { return (scores, false) };
        if self.league.victims.is_some_and(|rule| rule.touch != 0) {
            self.touch(world, &mut scores);
        }
        if time >= self.next_look - SAME_TIME {
            self.next_look = time + LOOK_INTERVAL;
            self.look(world, &mut scores);
        }
        self.is_over = time >= began + self.league.time_limit - SAME_TIME;
        (scores, self.is_over)
    }

    fn touch(&mut self, world: &World, scores: &mut Vec<Score>) {
        let Some(rule) = self.league.victims else { return };
        for (&robot, Player { place, touched, .. }) in &mut self.players {
            for victim in world.touched(robot) {
                if touched.insert(victim) {
                    let reason = format!("touched {}", world.def().map.victims[victim].name);
                    scores.extend(count(&mut self.teams[place.team], world, robot, reason, rule.touch));
                }
            }
        }
    }

    fn look(&mut self, world: &mut World, scores: &mut Vec<Score>) {
        let time = world.time();
        let victims = if self.league.victims.is_some() { world.def().map.victims.len() } else { 0 };
        let goals: Vec<Goal> =
            (0..victims).map(Goal::Victim).chain((0..self.league.zones.len()).map(Goal::Zone)).collect();
        let Self { league, players, reached, teams, .. } = self;
        for (&robot, Player { place, since, .. }) in players {
            for &goal in &goals {
                if reached.contains(&(place.team, goal)) {
                    continue;
                }
                if !is_at(world, league, robot, goal) {
                    since.remove(&goal);
                    continue;
                }
                let stayed = time - *since.entry(goal).or_insert(time);
                let (points, hold, reason) = worth(league, world, goal);
                if stayed >= hold - SAME_TIME {
                    reached.insert((place.team, goal));
                    scores.extend(count(&mut teams[place.team], world, robot, reason, points));
                }
            }
        }
    }

    /// Returns every team's points.
    pub(super) fn standings(&self, world: &World) -> Standings {
        Standings {
            league: self.league.name.clone(),
            map: world.def().map.name.clone(),
            time_limit: self.league.time_limit,
            began: self.began,
            time: world.time(),
            is_over: self.is_over,
            teams: self.teams.clone(),
        }
    }
}

/// True if a robot is at a goal.
fn is_at(world: &mut World, league: &League, robot: PawnId, goal: Goal) -> bool {
    let Some(position) = world.position(robot) else { return false };
    match goal {
        Goal::Zone(zone) => league.zones[zone].contains(position),
        Goal::Victim(victim) => {
            let pelvis = world.def().map.victims[victim].position;
            let way = [0, 1, 2].map(|axis| position[axis] - pelvis[axis]);
            let distance = way.iter().map(|it| it * it).sum::<f64>().sqrt();
            league.victims.is_some_and(|rule| distance <= rule.radius) && world.sees(robot, victim)
        }
    }
}

/// Returns the points of a goal, the time that a robot has to stay there, s, and the reason for the points.
fn worth(league: &League, world: &World, goal: Goal) -> (i32, f64, String) {
    match goal {
        Goal::Zone(zone) => {
            let zone = &league.zones[zone];
            (zone.points, zone.hold, format!("reached {}", zone.name))
        }
        Goal::Victim(victim) => {
            let (points, hold) = league.victims.map_or((0, 0.0), |rule| (rule.points, rule.hold));
            (points, hold, format!("found {}", world.def().map.victims[victim].name))
        }
    }
}

/// Adds points to a team.
fn count(team: &mut Standing, world: &World, robot: PawnId, reason: String, points: i32) -> Option<Score> {
    team.points += i64::from(points);
    let (total, position) = (team.points, world.position(robot)?);
    let score = Score { time: world.time(), team: team.team.clone(), robot: robot.0, reason, points, total, position };
    team.scores.push(score.clone());
    Some(score)
}
