//! One round of a league: who plays, and who has how many points. Everything follows from the world and the lines of its sessions, so
//! a replay comes to the same points.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use gamebots_proto::command::Init;
use gamebots_proto::{Problem, shown};
use goals::{Judge, RobotSight, Sight, distance};
use names::listed;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use scene::goal::{Find, Goal};
use scene::{Entrant, League, MapDef, ObjectId, PawnId, Pose, Score, ScoredGoal, Sensed, Standing, Standings, Team};
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
    /// Goals: the victims of the map, then those of the league.
    goals: Vec<ScoredGoal>,
    /// Teams, and the numbers of the goals that they have reached.
    reached: BTreeSet<(usize, usize)>,
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
    /// The judge of each goal; none if the robot lacks what the goal needs.
    judges: Vec<Option<Judge>>,
    /// Numbers of the goals at which it is, each with the simulated time of its arrival, s.
    since: BTreeMap<usize, f64>,
    touched: BTreeSet<usize>,
    /// The last scan of each laser that a goal names, by the number of the goal, m.
    scans: BTreeMap<usize, Vec<f64>>,
}

impl Round {
    pub(super) fn new(league: &League, map: &MapDef) -> Self {
        let team = |team: &Team| Standing { team: team.name.clone(), ..Standing::default() };
        Self {
            began: None,
            is_over: false,
            next_look: 0.0,
            players: BTreeMap::new(),
            goals: goals_of(league, map),
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
    pub(super) fn enter(&mut self, pawn: PawnId, place: Admission, init: &Init, world: &World) {
        self.began.get_or_insert(world.time());
        let Some(class) = world.robot(pawn).cloned().map(Arc::new) else { return };
        let map = &world.def().map;
        let victims = self.league.victims.map_or(0, |_| map.victims.len());
        let judge = |(number, goal): (usize, &ScoredGoal)| match &goal.goal {
            Goal::Find(find) if number < victims => Some(Judge::of_victim(number, find.radius, 1, map)),
            goal => Judge::new(goal, 1, LOOK_INTERVAL, &class, map).ok(),
        };
        let mut judges: Vec<Option<Judge>> = self.goals.iter().enumerate().map(judge).collect();
        // In a league nothing is random.
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for (judge, goal) in judges.iter_mut().zip(&self.goals) {
            let seen = RobotSight::of(world, pawn, has_joints(&goal.goal));
            let sight = Sight { robots: seen.into_iter().collect(), object: object_of(&goal.goal, world) };
            judge.iter_mut().for_each(|judge| judge.begin(&sight, &mut rng));
        }
        let (since, touched, scans) = Default::default();
        self.players.insert(pawn, Player { place, judges, since, touched, scans });
        let robots = &mut self.teams[place.team].robots;
        if robots.len() < MAX_ENTRANTS {
            robots.push(Entrant { robot: pawn.0, class: init.class().to_owned(), name: init.name.clone() });
        }
    }

    /// Sees what a sensor measured: goals about areas need scans.
    pub(super) fn see(&mut self, sensed: &Sensed, world: &World) {
        let Self { players, goals, .. } = self;
        let Some(player) = players.get_mut(&sensed.robot) else { return };
        let sensor = world.robot(sensed.robot).and_then(|robot| robot.sensors.get(sensed.sensor));
        let Some((sensor, ranges)) = sensor.zip(sensed.reading.ranges()) else { return };
        for (number, goal) in goals.iter().enumerate() {
            if goal.goal.scanner().is_some_and(|scanner| scanner.eq_ignore_ascii_case(&sensor.name)) {
                player.scans.insert(number, ranges.to_vec());
            }
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
            self.finish(time - began);
        }
        // When all have finished, nothing is left to stop for.
        let is_played = self.teams.iter().any(|team| team.finished.is_none());
        self.is_over = is_played && time >= began + self.league.time_limit - SAME_TIME;
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
        let Self { players, goals, reached, teams, .. } = self;
        let places: Vec<(PawnId, [f64; 2])> =
            players.keys().filter_map(|&it| Some((it, point_of(world, it)?))).collect();
        // The object of each goal that has one, and the robot that is nearest to it: that has brought it.
        let objects: Vec<Option<(Pose, Option<PawnId>)>> = goals
            .iter()
            .map(|goal| object_of(&goal.goal, world).map(|object| (object, nearest(&places, &object))))
            .collect();
        let has_joints = goals.iter().any(|goal| has_joints(&goal.goal));
        for (&robot, Player { place, judges, since, scans, .. }) in players {
            let Some(seen) = RobotSight::of(world, robot, has_joints) else { continue };
            let mut sight = Sight { robots: vec![seen], object: None };
            for (number, ((goal, judge), object)) in goals.iter().zip(judges).zip(&objects).enumerate() {
                let Some(judge) = judge.as_mut().filter(|_| !reached.contains(&(place.team, number))) else { continue };
                if goal.goal.scanner().is_some()
                    && let Some(seen) = sight.robots.first_mut()
                {
                    seen.scan = scans.get(&number).cloned().unwrap_or_default();
                }
                sight.object = object.map(|(pose, _)| pose);
                let is_its = object.is_none_or(|(_, nearest)| nearest == Some(robot));
                if !judge.judge(world, &sight).is_success || !is_its {
                    since.remove(&number);
                    continue;
                }
                let stayed = time - *since.entry(number).or_insert(time);
                if stayed >= goal.hold - SAME_TIME {
                    reached.insert((place.team, number));
                    scores.extend(count(&mut teams[place.team], world, robot, reason(goal), goal.points));
                }
            }
        }
    }

    /// Keeps the time since the first robot's arrival, s, for teams that have reached all goals by now.
    fn finish(&mut self, since: f64) {
        for (number, team) in self.teams.iter_mut().enumerate().filter(|(_, team)| team.finished.is_none()) {
            let reached = self.reached.range((number, 0)..(number + 1, 0)).count();
            team.finished = (!self.goals.is_empty() && reached == self.goals.len()).then_some(since);
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

/// Lists the goals of a league on a map: its victims, if they count, and the league's own.
fn goals_of(league: &League, map: &MapDef) -> Vec<ScoredGoal> {
    let victims = league.victims.iter().flat_map(|rule| {
        map.victims.iter().map(|victim| ScoredGoal {
            name: victim.name.clone(),
            points: rule.points,
            hold: rule.hold,
            goal: Goal::Find(Find { victim: victim.name.clone(), radius: rule.radius }),
        })
    });
    victims.chain(league.goals.iter().cloned()).collect()
}

/// Returns the reason for the points of a goal.
fn reason(goal: &ScoredGoal) -> String {
    let done = if let Goal::Find(_) = goal.goal { "found" } else { "reached" };
    format!("{done} {}", goal.name)
}

fn has_joints(goal: &Goal) -> bool {
    matches!(goal, Goal::Fetch(_))
}

/// Returns the pose of the object that a goal is about, if it is about one.
fn object_of(goal: &Goal, world: &World) -> Option<Pose> {
    let name = goal.object()?;
    let objects = &world.def().map.objects;
    let number = objects.iter().position(|object| object.solid.name.eq_ignore_ascii_case(name))?;
    world.object(ObjectId(number as u64))
}

fn point_of(world: &World, robot: PawnId) -> Option<[f64; 2]> {
    world.position(robot).map(|[x, y, _]| [x, y])
}

/// Returns the robot that is nearest to an object.
fn nearest(robots: &[(PawnId, [f64; 2])], object: &Pose) -> Option<PawnId> {
    let at = object.translation.vector.xy().into();
    let nearest = robots.iter().min_by(|(_, a), (_, b)| distance(*a, at).total_cmp(&distance(*b, at)));
    nearest.map(|(robot, _)| *robot)
}

/// Adds points to a team.
fn count(team: &mut Standing, world: &World, robot: PawnId, reason: String, points: i32) -> Option<Score> {
    team.points += i64::from(points);
    let (total, position) = (team.points, world.position(robot)?);
    let score = Score { time: world.time(), team: team.team.clone(), robot: robot.0, reason, points, total, position };
    team.scores.push(score.clone());
    Some(score)
}
