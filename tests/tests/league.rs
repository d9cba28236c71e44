//! Leagues: who may enter, what brings points, and that a log replays to them.

use std::path::Path;

use gamebots_proto::Problem;
use gamebots_server::WorldControl;
use scene::goal::{Explore, Find, Follow, Goal, Push, Reach, Zone};
use scene::{League, NamedPose, ScoredGoal, Standings, Team, VictimRule, WorldDef};
use sessions::{News, Request, Sessions};
use sim_core::{Options, World};
use system_tests::{Server, wait_until};

fn start(name: &str, x: f64, y: f64) -> NamedPose {
    NamedPose { name: name.to_owned(), position: [x, y, 0.0], rotation: [0.0; 3] }
}

fn team(name: &str, starts: &[NamedPose]) -> Team {
    Team { name: name.to_owned(), starts: starts.to_vec(), classes: vec!["P3AT".to_owned(), "KUKA_YouBot".to_owned()] }
}

/// The map `rescue`, where the corridor's walls are at y = ±0.65 and the victim `office` sits at (-0.8, -1.7).
fn scene(league: League) -> WorldDef {
    let mut def = scene_loader::load("rescue", &[]).expect("a map");
    def.league = Some(league);
    def.check().expect("a good scene");
    def
}

fn rules(teams: Vec<Team>) -> League {
    let zone = |name: &str, x: f64, hold: f64| ScoredGoal {
        name: name.to_owned(),
        points: 7,
        hold,
        goal: Goal::Zone(Zone { position: [x, 0.0, -0.5], size: [1.0, 1.2, 2.0] }),
    };
    League {
        name: "test".to_owned(),
        time_limit: 10.0,
        teams,
        victims: Some(VictimRule { points: 20, radius: 1.5, hold: 0.5, touch: -5 }),
        goals: vec![zone("near", -2.0, 0.0), zone("far", 0.0, 1.0)],
    }
}

/// Sessions of a world, and what became of their lines.
struct Round {
    sessions: Sessions,
    problems: Vec<String>,
    ends: Vec<f64>,
}

impl Round {
    fn new(league: League) -> Self {
        let mut sessions = Sessions::new(World::new(scene(league), Options::default()));
        (0..4).for_each(|id| sessions.open(id, None, false, &mut |_, _| {}));
        Self { sessions, problems: Vec::new(), ends: Vec::new() }
    }

    fn send(&mut self, session: u64, line: &str) {
        let Self { sessions, problems, .. } = self;
        sessions.take(session, &Request::read(Ok(line.to_owned())), &mut |_, news| {
            if let News::Wrong { problems: new, .. } = news {
                problems.extend(new.iter().map(Problem::to_string));
            }
        });
    }

    fn run(&mut self, seconds: f64) {
        let Self { sessions, ends, .. } = self;
        for _ in 0..(seconds / sessions.world().time_step()).round() as usize {
            sessions.step(&mut |_, news| {
                if let News::TimeUp(standings) = news {
                    ends.push(standings.time);
                }
            });
        }
    }

    fn standings(&self) -> Standings {
        self.sessions.standings().expect("a league")
    }

    /// Returns team, reason and points of every score.
    fn scores(&self) -> Vec<(String, String, i32)> {
        let teams = self.standings().teams;
        let scores = teams.into_iter().flat_map(|team| team.scores);
        scores.map(|score| (score.team, score.reason, score.points)).collect()
    }
}

fn scored(team: &str, reason: &str, points: i32) -> (String, String, i32) {
    (team.to_owned(), reason.to_owned(), points)
}

#[test]
fn robots_enter_for_a_team_at_its_start_poses() {
    let teams = || {
        vec![team("red", &[start("R1", -6.6, -2.2), start("R2", -6.6, 2.2)]), team("blue", &[start("B1", -6.6, 0.0)])]
    };
    let rows: [(&[&str], &str, &str); 8] = [
        (&[], "INIT {ClassName P3AT} {Team red}", "-6.6 -2.2"),
        (&[], "INIT {ClassName P3AT} {Team RED} {Start r2}", "-6.6 2.2"),
        (&[], "INIT {ClassName P3AT} {Start B1}", "-6.6 0"),
        (&[], "INIT {ClassName P3AT} {Team red} {Location 7,0,0}", "-6.6 -2.2"),
        (&["INIT {ClassName P3AT} {Team red}"], "INIT {ClassName P3AT} {Team red} {Start R1}", "-6.6 2.2"),
        (
            &["INIT {ClassName P3AT} {Team blue}"],
            "INIT {ClassName P3AT} {Team blue}",
            "team blue has all its 1 robots in the world",
        ),
        (&[], "INIT {ClassName P3AT} {Team green}", "no team `green`: expected {Team ..} with one of red, blue"),
        (&[], "INIT {ClassName Kenaf} {Team red}", "team red has no Kenaf: expected one of P3AT, KUKA_YouBot"),
    ];
    for (before, line, expected) in rows {
        let mut round = Round::new(rules(teams()));
        before.iter().for_each(|line| round.send(0, line));
        let robots = round.sessions.world().robots().count();
        round.send(1, line);
        let newest = round.sessions.newest(1);
        let place = newest.and_then(|pawn| round.sessions.world().position(pawn));
        let got = match place {
            Some([x, y, _]) => format!("{} {}", (x * 10.0).round() / 10.0, (y * 10.0).round() / 10.0),
            None => round.problems.pop().unwrap_or_default(),
        };
        assert!(got.contains(expected), "{line}: {got}");
        assert_eq!(round.sessions.world().robots().count(), robots + usize::from(place.is_some()), "{line}");
    }
}

#[test]
fn a_place_is_free_again_when_its_robot_has_left() {
    let mut round = Round::new(rules(vec![team("red", &[start("R1", -6.6, 0.0)])]));
    for session in 0..3 {
        round.send(session, "INIT {ClassName P3AT}");
        assert!(round.sessions.newest(session).is_some(), "{:?}", round.problems);
        round.sessions.close(session, &mut |_, _| {});
    }
    assert_eq!(round.standings().teams[0].robots.len(), 3);
}

#[test]
fn a_zone_counts_once_for_each_team_after_the_time_of_its_stay() {
    let teams =
        vec![team("red", &[start("R1", -2.0, 0.3), start("R2", 0.0, 0.3)]), team("blue", &[start("B1", -2.3, -0.3)])];
    let mut round = Round::new(rules(teams));
    for (session, line) in [(0, "{Team red}"), (1, "{Team red}"), (2, "{Team blue}")] {
        round.send(session, &format!("INIT {{ClassName P3AT}} {line}"));
    }
    round.run(0.9);
    let near = [scored("red", "reached near", 7), scored("blue", "reached near", 7)];
    assert_eq!(round.scores(), near);
    round.run(0.4);
    let [red, blue] = near;
    assert_eq!(round.scores(), [red, scored("red", "reached far", 7), blue]);
    assert_eq!(
        round.standings().ranking().iter().map(|(place, team)| (*place, team.points)).collect::<Vec<_>>(),
        [(1, 14), (2, 7)]
    );
}

/// A red robot drives along the corridor and pushes a crate; a blue one, behind it, stands still.
#[test]
fn a_league_scores_goals_of_every_kind_by_the_judge_of_tasks() {
    let goal = |name: &str, goal: Goal| ScoredGoal { name: name.to_owned(), points: 3, hold: 0.0, goal };
    let reach = |x: f64| Goal::Reach(Reach { point: Some([x, 0.0]), distance: None, tolerance: 0.3 });
    let push = |x: f64| {
        let target = [[x, x], [0.0, 0.0]];
        Goal::Push(Push { object: Some("crate".to_owned()), target, tolerance: 0.2 })
    };
    let follow = |points: &[[f64; 2]]| {
        Goal::Follow(Follow { points: points.to_vec(), spacing: 0.5, most_beside: 0.3, mirror: false })
    };
    let explore = |scanner: &str| {
        let area = [[-6.0, -5.8], [-0.3, 0.3]];
        Goal::Explore(Explore { area, cell: 0.1, scanner: scanner.to_owned(), sight: 1.2, part: 0.9 })
    };
    let goals = [
        ("come", reach(-5.0), true),
        ("stay-away", reach(4.0), false),
        ("bring", push(-4.4), true),
        ("overshoot", push(1.0), false),
        ("lane", follow(&[[1.0, 0.0]]), true),
        ("turn", follow(&[[1.0, 0.0], [1.0, 2.0]]), false),
        ("look", explore("lms200"), true),
        ("no-such-laser", explore("Scanner9"), false),
        ("see", Goal::Find(Find { victim: "office".to_owned(), radius: 1.5 }), false),
    ];
    let teams = vec![team("red", &[start("R1", -6.4, 0.0)]), team("blue", &[start("B1", -7.6, 0.0)])];
    let mut league = League { goals: Vec::new(), victims: None, ..rules(teams) };
    league.goals = goals.iter().map(|(name, it, _)| goal(name, it.clone())).collect();
    let mut def = scene_loader::load("rescue", &[]).expect("a map");
    let mut object = scene_loader::objects().expect("objects")["WCCrate"].clone();
    (object.solid.name, object.solid.position) = ("crate".to_owned(), [-5.5, 0.0, -0.25]);
    def.map.objects.push(object);
    def.league = Some(league);
    def.check().expect("a good scene");
    let mut sessions = Sessions::new(World::new(def, Options::default()));
    let mut take = |session: u64, line: &str| {
        if !sessions.is_open(session) {
            sessions.open_silent(session);
        }
        let answer = sessions.take(session, &Request::read(Ok(line.to_owned())), &mut |_, _| {});
        assert_eq!(answer.problems, [], "{line}");
    };
    take(0, "INIT {ClassName P3AT} {Team red}");
    take(1, "INIT {ClassName P3AT} {Team blue}");
    take(0, "DRIVE {Left 5} {Right 5}");
    for _ in 0..1500 {
        sessions.step(&mut |_, _| {});
    }
    let standings = sessions.standings().expect("a league");
    let names = |team: usize| standings.teams[team].scores.iter().map(|score| score.reason.clone()).collect::<Vec<_>>();
    let mut scored = names(0);
    scored.sort();
    let mut expected: Vec<String> =
        goals.iter().filter(|(.., is_met)| *is_met).map(|(name, ..)| format!("reached {name}")).collect();
    expected.sort();
    assert_eq!(scored, expected);
    assert_eq!(names(1), [""; 0]);
}

#[test]
fn a_goal_that_a_league_cannot_have_is_refused_by_name() {
    let league = |goal: &str| {
        let head = "name = \"L\"\nmap = \"rescue\"\n[[team]]\nname = \"red\"\nstarts = [\"RobotStart1\"]\n";
        format!("{head}[[goal]]\nname = \"it\"\npoints = 1\n{goal}\n")
    };
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("league.toml");
    for (goal, expected) in [
        ("reach = { point = [1.0, 2.0], tolerance = 0.3 }", ""),
        ("reach = { distance = [1.0, 2.0], tolerance = 0.3 }", "in a league nothing is random"),
        ("reach = { point = [1.0, 2.0], distance = [1.0, 2.0], tolerance = 0.3 }", "either a `point` or a `distance`"),
        ("reach = { point = [1.0, nan], tolerance = 0.3 }", "reach.point: got NaN"),
        ("reach = { point = [1.0, 2.0], tolerance = 0.3 }\nzone = {}", "unknown field `zone`"),
        ("push = { target = [[1.0, 1.0], [2.0, 2.0]], tolerance = 0.2 }", "push: expected an `object` of the map"),
        ("follow = { points = [], most_beside = 0.3 }", "follow.points: got 0, expected 1 to 1000"),
        (
            "explore = { area = [[0.0, 90.0], [0.0, 90.0]], cell = 0.1, scanner = \"lms200\", sight = 5.0 }",
            "have 810000 cells: expected at most 100000",
        ),
        ("find = { victim = \"office\", radius = 0.0 }", "`find.radius` is 0"),
        ("find = { victim = \"nobody\", radius = 1.0 }", "the map rescue has no victim `nobody`: it has "),
        (
            "push = { object = \"crate\", target = [[1.0, 1.0], [2.0, 2.0]], tolerance = 0.2 }",
            "the map rescue has no object `crate`: it has ",
        ),
        ("", "expected one table of reach, follow, push, fetch, explore, find and zone"),
    ] {
        std::fs::write(&file, league(goal)).expect("a file");
        let error = scene_loader::league(&file, None).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(expected) && error.is_empty() == expected.is_empty(), "{goal}: {error}");
    }
    let mut def = scene_loader::load("rescue", &[]).expect("a map");
    let mut rules = rules(vec![team("red", &[start("R1", -6.4, 0.0)])]);
    let missing = Goal::Find(Find { victim: "nobody".to_owned(), radius: 1.0 });
    rules.goals = vec![ScoredGoal { name: "it".to_owned(), points: 1, hold: 0.0, goal: missing }];
    def.league = Some(rules);
    let error = def.check().expect_err("no such victim").to_string();
    assert!(error.contains("the map rescue has no victim `nobody`"), "{error}");
}

/// Leagues in logs before goals had zones.
#[test]
fn the_zones_of_an_older_log_are_goals() {
    let old = serde_json::json!({
        "name": "old", "time_limit": 60.0, "teams": [], "victims": null,
        "zones": [{ "name": "exit", "position": [1.0, 2.0, 3.0], "size": [1.0, 1.0, 1.0], "points": 5, "hold": 2.0 }],
    });
    let league: League = serde_json::from_value(old).expect("a league");
    let goal = Goal::Zone(Zone { position: [1.0, 2.0, 3.0], size: [1.0; 3] });
    assert_eq!(league.goals, [ScoredGoal { name: "exit".to_owned(), points: 5, hold: 2.0, goal }]);
    let again: League = serde_json::from_value(serde_json::to_value(&league).expect("JSON")).expect("a league");
    assert_eq!(again, league);
}

/// The victim `office` is 1.3 m from the middle of the corridor, behind its wall.
#[test]
fn a_victim_is_found_by_sight_and_not_through_a_wall() {
    for (x, y, expected) in [(-0.8, -0.3, false), (0.3, -2.2, true), (1.2, -2.2, false)] {
        let mut round = Round::new(rules(vec![team("red", &[start("R1", x, y)])]));
        round.send(0, "INIT {ClassName P3AT}");
        round.run(0.4);
        assert!(!round.scores().iter().any(|score| score.1 == "found office"), "{x} {y}: too early");
        round.run(0.6);
        assert_eq!(
            round.scores().contains(&scored("red", "found office", 20)),
            expected,
            "{x} {y}: {:?}",
            round.scores()
        );
    }
}

#[test]
fn touching_a_victim_costs_points_once() {
    let mut at = start("R1", 1.0, -1.7);
    at.rotation = [0.0, 0.0, std::f64::consts::PI];
    let mut round = Round::new(rules(vec![team("red", &[at])]));
    round.send(0, "INIT {ClassName P3AT}");
    round.run(0.2);
    assert!(round.scores().is_empty());
    round.send(0, "DRIVE {Left 3} {Right 3}");
    round.run(5.0);
    let touches = round.scores().into_iter().filter(|score| score.1.starts_with("touched")).collect::<Vec<_>>();
    assert_eq!(touches, [scored("red", "touched office", -5)]);
}

#[test]
fn the_time_begins_with_the_first_robot_and_nothing_counts_after_it() {
    let mut round = Round::new(rules(vec![team("red", &[start("R1", -4.0, 0.0)])]));
    round.run(2.0);
    assert_eq!(round.standings().began, None);
    round.send(0, "INIT {ClassName P3AT}");
    round.run(9.9);
    assert!(!round.standings().is_over);
    round.run(0.2);
    assert_eq!(round.ends.len(), 1);
    assert!((round.ends[0] - 12.0).abs() < 0.003, "{:?}", round.ends);
    let before = round.scores();
    round.send(0, "DRIVE {Left 5} {Right 5}");
    round.run(6.0);
    assert_eq!(round.scores(), before);
}

/// Four robots of two teams; a client that reads nothing, one that sends rubbish and asks for what it may not, and a referee's pause.
#[test]
fn a_round_replays_to_the_same_points() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let teams = vec![
        team("red", &[start("R1", -4.0, 0.3), start("R2", -6.6, -2.2)]),
        team("blue", &[start("B1", -4.0, -0.3), start("B2", -6.6, 2.2)]),
    ];
    let server = Server::start("rescue", &[], |config| {
        config.world.league = Some(League { time_limit: 20.0, ..rules(teams) });
        config.real_time_factor = 0.0;
        config.world_control = WorldControl::Nobody;
        config.log = Some(path("run.mcap"));
        config.result = Some(path("result.json"));
    });
    let mut clients: Vec<_> = ["red", "red", "blue", "blue"].iter().map(|team| (team, server.client())).collect();
    for (team, client) in &mut clients {
        client.send("REPORT {Errors true}");
        client.send(&format!("INIT {{ClassName P3AT}} {{Name {team}}} {{Team {team}}}"));
        client.send("DRIVE {Left 4} {Right 4}");
    }
    let mut hostile = server.client();
    hostile.send("REPORT {Errors true}");
    hostile.send("INIT {ClassName USARBotAPI.WorldController}");
    let refused = hostile.wait_for("a refusal", |line| line.contains("no world controller or avatar from here"));
    assert!(refused.contains("no page controls this world"), "{refused}");
    hostile.send("INIT {ClassName P3AT} {Team red}");
    hostile.wait_for("a refusal", |line| line.contains("team red has all its 2 robots in the world"));
    hostile.send("CONTROL {Type Create} {ClassName WCCrate} {Name x} {Location 0,0,0}");
    (0..2000).for_each(|number| hostile.send(&format!("{{{number}}} \u{7f}{{Team")));
    // The first client never reads.
    wait_until(|| {
        path("result.json").exists() && std::fs::read(path("result.json")).is_ok_and(|text| text.ends_with(b"}"))
    });
    drop((clients, hostile));
    server.stop().expect("a good end");
    let result: Standings =
        serde_json::from_slice(&std::fs::read(path("result.json")).expect("a file")).expect("standings");
    assert!(result.is_over);
    let points: Vec<i64> = result.teams.iter().map(|team| team.points).collect();
    assert_eq!(points, [14, 14], "{result:?}");
    check_replay(&path("run.mcap"), &result);
}

fn check_replay(log: &Path, result: &Standings) {
    let log = recorder::read(log).expect("a log");
    let last = log.entries.iter().rev().find_map(|entry| match &entry.record {
        recorder::Record::Standings(standings) => Some((**standings).clone()),
        _ => None,
    });
    assert_eq!(last.map(|it| it.teams), Some(result.teams.clone()));
    let replay = logbook::replay(&log).expect("a replay");
    assert!(replay.is_same(), "{replay:?}");
}

/// A log whose points were changed is not what was played.
#[test]
fn a_replay_notices_changed_points() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = Server::start("rescue", &[], |config| {
        config.world.league = Some(rules(vec![team("red", &[start("R1", -2.0, 0.0)])]));
        config.real_time_factor = 0.0;
        config.log = Some(path.clone());
    });
    let mut client = server.client();
    client.send("INIT {ClassName P3AT}");
    client.ground_truth();
    client.finish();
    server.stop().expect("a good end");
    let mut log = recorder::read(&path).expect("a log");
    assert!(logbook::replay(&log).expect("a replay").is_same());
    let changed = log.entries.iter_mut().find_map(|entry| match &mut entry.record {
        recorder::Record::Scored(score) => Some(&mut score.points),
        _ => None,
    });
    *changed.expect("a score") += 1;
    assert!(!logbook::replay(&log).expect("a replay").is_same());
}

#[test]
fn the_built_in_league_loads() {
    let file = scene_loader::league(Path::new("rescue"), None).expect("a league");
    assert_eq!((file.map.as_str(), file.league.teams.len()), ("rescue", 2));
    scene(file.league);
}
