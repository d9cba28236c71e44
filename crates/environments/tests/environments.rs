//! Environments play the shipped tasks, with the same bits alone and among others.

use std::f32::consts::FRAC_PI_2;
use std::path::Path;

use environments::{Autoreset, BatchError, Environments, Outcomes, Task};
use thread_pool::ThreadPool;

/// Arrays of a step, for a number of environments.
#[derive(Clone, PartialEq, Debug)]
struct Arrays {
    observations: Vec<f32>,
    rewards: Vec<f64>,
    terminated: Vec<bool>,
    truncated: Vec<bool>,
    successes: Vec<bool>,
    last: Vec<f32>,
}

impl Arrays {
    fn of(environments: &Environments) -> Self {
        let (task, count) = (environments.task(), environments.count());
        let observations = vec![0.0; count * task.robots() * task.observations()];
        let flags = vec![false; count];
        Self {
            last: observations.clone(),
            observations,
            rewards: vec![0.0; count * task.robots()],
            terminated: flags.clone(),
            truncated: flags.clone(),
            successes: flags,
        }
    }

    fn outcomes(&mut self) -> Outcomes<'_> {
        Outcomes {
            observations: &mut self.observations,
            rewards: &mut self.rewards,
            terminated: &mut self.terminated,
            truncated: &mut self.truncated,
            successes: &mut self.successes,
            last_observations: &mut self.last,
        }
    }
}

fn environments(task: &str, count: usize, threads: usize) -> Environments {
    let task = Task::load(task).unwrap_or_else(|error| panic!("{error}"));
    Environments::new(task, count, ThreadPool::new(threads).expect("threads")).expect("environments")
}

/// Returns actions that differ by environment, action and time.
fn actions(environment: usize, width: usize, time: usize) -> Vec<f32> {
    (0..width).map(|action| ((environment * 7 + action * 3 + time) as f32 * 0.37).sin()).collect()
}

/// Plays environments with the seeds from `first` on. Returns the observations and rewards of all steps, and the digests at the end.
fn play(task: &str, first: usize, count: usize, threads: usize, steps: usize) -> Vec<(Vec<Arrays>, u64)> {
    let mut all = environments(task, count, threads);
    let (mut arrays, width) = (Arrays::of(&all), all.task().robots() * all.task().actions());
    let seeds: Vec<u64> = (first..first + count).map(|seed| seed as u64).collect();
    all.reset(Some(&seeds), None, &mut arrays.observations).expect("a reset");
    let mut history = vec![Vec::new(); count];
    for time in 0..steps {
        let given: Vec<f32> = (0..count).flat_map(|number| actions(first + number, width, time)).collect();
        all.step(&given, Autoreset::NextStep, arrays.outcomes()).expect("a step");
        for (number, history) in history.iter_mut().enumerate() {
            history.push(part(&arrays, number, count));
        }
    }
    let digest = |number| all.world(number).expect("a world").digest();
    history.into_iter().enumerate().map(|(number, history)| (history, digest(number))).collect()
}

/// Returns the part of one environment.
fn part(arrays: &Arrays, number: usize, count: usize) -> Arrays {
    let (observations, rewards) = (arrays.observations.len() / count, arrays.rewards.len() / count);
    Arrays {
        observations: arrays.observations[number * observations..][..observations].to_vec(),
        rewards: arrays.rewards[number * rewards..][..rewards].to_vec(),
        terminated: vec![arrays.terminated[number]],
        truncated: vec![arrays.truncated[number]],
        successes: vec![arrays.successes[number]],
        last: Vec::new(),
    }
}

#[test]
fn every_shipped_task_plays_alone_and_among_others_with_the_same_bits() {
    for task in Task::shipped() {
        let among = play(&task, 3, 9, 2, 12);
        for (number, (history, digest)) in among.iter().enumerate() {
            let alone = play(&task, 3 + number, 1, 1, 12);
            assert_eq!((history, digest), (&alone[0].0, &alone[0].1), "{task} {number}");
            let finite = history.iter().all(|it| it.observations.iter().all(|number| number.is_finite()));
            assert!(finite, "{task}: {history:?}");
        }
        assert!(among.windows(2).all(|pair| pair[0].1 != pair[1].1), "{task}: seeds make different worlds");
    }
}

/// A reach whose episodes last four intervals.
const SHORT: &str = r#"
description = "Short"
map = "rough"
robot = "YouBot"
drive_model = "analytic"
time_step = 0.02
control_interval = 0.04
seconds = 0.16
[action]
twist = [0.8, 0.8, 1.0]
[start]
[reach]
distance = [1.0, 1.0]
tolerance = 0.1
"#;

fn short(count: usize) -> Environments {
    let task = Task::read(Path::new("short.toml"), SHORT).expect("a task");
    Environments::new(task, count, ThreadPool::one()).expect("environments")
}

/// Goals of leagues are goals of tasks.
#[test]
fn a_zone_and_a_victim_are_goals_for_learning() {
    let reach = "[reach]\ndistance = [1.0, 1.0]\ntolerance = 0.1";
    let rescue = |text: String| text.replace("map = \"rough\"", "map = \"rescue\"");
    for (goal, start, width, is_success) in [
        ("[zone]\nposition = [0.0, 0.0, 0.0]\nsize = [1.0, 1.0, 2.0]", "[start]", 6, true),
        ("[zone]\nposition = [3.0, 0.0, 0.0]\nsize = [1.0, 1.0, 2.0]", "[start]", 6, false),
        ("[find]\nvictim = \"office\"\nradius = 1.5", "[start]\nposition = [[0.3, 0.3], [-2.2, -2.2]]", 7, true),
        ("[find]\nvictim = \"office\"\nradius = 1.5", "[start]\nposition = [[-0.8, -0.8], [-0.3, -0.3]]", 7, false),
    ] {
        let text = rescue(SHORT.replacen(reach, goal, 1).replacen("[start]", start, 1));
        let task = Task::read(Path::new("short.toml"), &text).expect("a task");
        assert_eq!(task.observations(), width, "{goal}");
        let mut all = Environments::new(task, 1, ThreadPool::one()).expect("environments");
        let mut arrays = Arrays::of(&all);
        all.reset(Some(&[5]), None, &mut arrays.observations).expect("a reset");
        all.step(&[0.0; 3], Autoreset::NextStep, arrays.outcomes()).expect("a step");
        assert_eq!(arrays.successes, [is_success], "{goal} {start}");
        assert!((arrays.rewards[0] > 0.9) == is_success, "{:?}", arrays.rewards);
    }
}

#[test]
fn an_episode_that_is_cut_off_begins_again_as_the_mode_says() {
    let still = vec![0.0; 3];
    let play = |mode| {
        let mut one = short(1);
        let mut arrays = Arrays::of(&one);
        one.reset(Some(&[5]), None, &mut arrays.observations).expect("a reset");
        let first = arrays.observations.clone();
        let step = |_| {
            one.step(&still, mode, arrays.outcomes()).expect("a step");
            (arrays.truncated[0], arrays.observations.clone(), arrays.rewards[0], arrays.last.clone())
        };
        (first, (0..6).map(step).collect::<Vec<_>>())
    };
    let (first, steps) = play(Autoreset::NextStep);
    assert_eq!(steps.iter().map(|it| it.0).collect::<Vec<_>>(), [false, false, false, true, false, false]);
    assert!(steps[4].2 == 0.0 && steps[3].2 < 0.0, "the step that begins an episode has no reward");
    assert!(steps[4].1 != steps[3].1 && steps[4].1 != first, "another episode");
    let (_, same) = play(Autoreset::SameStep);
    assert_eq!(same.iter().map(|it| it.0).collect::<Vec<_>>(), [false, false, false, true, false, false]);
    assert_eq!((&same[3].1, &same[3].3), (&steps[4].1, &steps[3].1), "the next episode, and the end of the last");
    let (_, none) = play(Autoreset::Disabled);
    assert_eq!((none[4].1.clone(), none[4].2), (none[3].1.clone(), 0.0), "nothing happens");
}

#[test]
fn a_reset_with_marks_leaves_the_others_alone() {
    let mut all = short(3);
    let mut arrays = Arrays::of(&all);
    all.reset(Some(&[1, 2, 3]), None, &mut arrays.observations).expect("a reset");
    all.step(&[0.5; 9], Autoreset::Disabled, arrays.outcomes()).expect("a step");
    let before = arrays.clone();
    all.reset(Some(&[9, 9, 9]), Some(&[false, true, false]), &mut arrays.observations).expect("a reset");
    let changed: Vec<bool> =
        (0..3).map(|it| part(&before, it, 3).observations != part(&arrays, it, 3).observations).collect();
    assert_eq!(changed, [false, true, false]);
    let age: Vec<f64> = (0..3).map(|it| all.world(it).expect("a world").time()).collect();
    assert_eq!(age, [0.04, 0.0, 0.04]);
}

#[test]
fn arrays_of_another_size_and_actions_that_are_no_numbers_are_refused() {
    let mut all = short(2);
    let mut arrays = Arrays::of(&all);
    all.reset(None, None, &mut arrays.observations).expect("a reset");
    let size = |array, got, expected| BatchError::Size { array, got, expected };
    for (actions, expected) in [
        (vec![0.0; 5], size("actions", 5, 6)),
        (vec![], size("actions", 0, 6)),
        (vec![0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0], BatchError::Action { environment: 1, got: f32::NAN }),
        (vec![f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 0.0], BatchError::Action { environment: 0, got: f32::INFINITY }),
    ] {
        let refused = all.step(&actions, Autoreset::NextStep, arrays.outcomes()).expect_err("refused");
        assert_eq!(refused.to_string(), expected.to_string());
    }
    assert_eq!(all.reset(Some(&[1]), None, &mut arrays.observations), Err(size("seeds", 1, 2)));
    assert_eq!(all.reset(None, Some(&[true]), &mut arrays.observations), Err(size("marks", 1, 2)));
    assert_eq!(all.reset(None, None, &mut [0.0; 9]), Err(size("observations", 9, 10)));
    assert_eq!(all.world(0).expect("a world").time(), 0.0, "nothing happened");
    let task = || Task::load("YouBotReach").expect("a task");
    assert!(Environments::new(task(), 0, ThreadPool::one()).is_err());
    assert!(Environments::new(task(), usize::MAX, ThreadPool::one()).is_err());
}

#[test]
fn an_episode_without_room_for_a_robot_is_an_error() {
    let folder = tempfile::tempdir().expect("a folder");
    let wall = |name: &str, position: &str, size: &str| {
        format!("[[box]]\nname = \"{name}\"\nmaterial = \"plywood\"\nposition = {position}\nsize = {size}\n")
    };
    // A closet of 0.9 m, with room for one youBot.
    let map = [
        "description = \"A closet\"\n[[half_space]]\nname = \"floor\"\nmaterial = \"concrete\"\n".to_owned(),
        wall("front", "[0.5, 0.0, -0.6]", "[0.1, 1.1, 1.2]"),
        wall("back", "[-0.5, 0.0, -0.6]", "[0.1, 1.1, 1.2]"),
        wall("left", "[0.0, -0.5, -0.6]", "[1.1, 0.1, 1.2]"),
        wall("right", "[0.0, 0.5, -0.6]", "[1.1, 0.1, 1.2]"),
        "[[start]]\nname = \"Middle\"\nposition = [0.0, 0.0, 0.0]\n".to_owned(),
    ];
    std::fs::write(folder.path().join("closet.toml"), map.concat()).expect("a map");
    let play = |robots: usize| {
        let text = SHORT.replace("\"rough\"", "\"closet.toml\"");
        let text = text.replace("seconds = 0.16", &format!("seconds = 0.16\nrobots = {robots}"));
        let task = Task::read(&folder.path().join("short.toml"), &text).expect("a task");
        let mut all = Environments::new(task, 2, ThreadPool::one()).expect("environments");
        let mut arrays = Arrays::of(&all);
        let reset = all.reset(None, None, &mut arrays.observations);
        (reset, all.step(&vec![0.0; 6 * robots], Autoreset::NextStep, arrays.outcomes()))
    };
    assert_eq!(play(1), (Ok(()), Ok(())));
    let (reset, step) = play(3);
    let text = reset.expect_err("no room").to_string();
    assert!(text.starts_with("environment 0: no episode begins: "), "{text}");
    assert_eq!(step, Err(BatchError::NotBegun(0)));
}

/// Plays a task with a controller until an episode ends. Returns the sum of the rewards, and true for a success.
fn solve(task: &str, seed: u64, mut act: impl FnMut(&[f32]) -> Vec<f32>) -> (f64, bool) {
    let mut one = environments(task, 1, 1);
    let mut arrays = Arrays::of(&one);
    one.reset(Some(&[seed]), None, &mut arrays.observations).expect("a reset");
    let mut sum = 0.0;
    loop {
        let actions = act(&arrays.observations);
        one.step(&actions, Autoreset::Disabled, arrays.outcomes()).expect("a step");
        sum += arrays.rewards[0];
        if arrays.terminated[0] || arrays.truncated[0] {
            return (sum, arrays.successes[0]);
        }
    }
}

/// Returns velocities toward a point, as parts of the limits.
fn toward([forward, right]: [f32; 2]) -> Vec<f32> {
    let scale = (1.0 / forward.hypot(right).max(1e-6)).min(4.0);
    vec![forward * scale, right * scale, 0.0]
}

#[test]
fn a_simple_controller_reaches_the_point() {
    for seed in 0..5 {
        let (reward, success) = solve("YouBotReach", seed, |seen| toward([seen[0], seen[1]]));
        // It comes 0.4 to 2.9 m nearer and arrives.
        assert!(success && (0.9..4.0).contains(&reward), "{seed}: {reward}");
        let (reward, success) = solve("YouBotReach", seed, |_| vec![0.0; 3]);
        assert!(!success && (-2.1..-1.9).contains(&reward), "{seed}: {reward}, 10 s of standing");
    }
}

#[test]
fn a_simple_controller_follows_the_path() {
    for seed in 0..3 {
        let (reward, success) = solve("YouBotFollow", seed, |seen| toward([seen[0], seen[1]]));
        assert!(success && (6.0..9.0).contains(&reward), "{seed}: {reward}");
        let (reward, success) = solve("YouBotFollow", seed, |seen| toward([-seen[0], -seen[1]]));
        assert!(!success && reward < 0.0, "{seed}: {reward}, the wrong way");
    }
}

#[test]
fn a_simple_controller_pushes_the_crate() {
    let successes = (0..6).filter(|&seed| {
        let act = |seen: &[f32]| {
            let (object, target) = ([seen[0], seen[1]], [seen[2], seen[3]]);
            let way = [target[0] - object[0], target[1] - object[1]];
            let length = way[0].hypot(way[1]).max(1e-6);
            let behind = [object[0] - 0.5 * way[0] / length, object[1] - 0.5 * way[1] / length];
            // Behind the crate as seen from the point, it pushes.
            let is_behind = behind[0].hypot(behind[1]) < 0.25;
            toward(if is_behind { object } else { behind })
        };
        solve("YouBotPush", seed, act).1
    });
    assert!(successes.count() >= 3);
}

/// Heights and lengths of the youBot's arm, m: shoulder over the floor, upper arm, forearm, hand; and the shoulder ahead of the middle.
const SHOULDER: f32 = 0.241;
const ARM: [f32; 3] = [0.155, 0.135, 0.209];
const SHOULDER_AHEAD: f32 = 0.2;
/// Distance of the block ahead of the robot when the arm grips it, m.
const AHEAD: f32 = 0.4;

/// Returns the angles of the arm for a hand that points down at a height over the floor, m.
fn arm_at(height: f32) -> [f32; 5] {
    let [upper, lower, hand] = ARM;
    let (ahead, up) = (AHEAD - SHOULDER_AHEAD, height + hand - SHOULDER);
    let distance = ahead.hypot(up);
    let lift = ((distance * distance + upper * upper - lower * lower) / (2.0 * distance * upper)).acos();
    let shoulder = FRAC_PI_2 - up.atan2(ahead) - lift;
    let forearm = (ahead - upper * shoulder.sin()).atan2(up - upper * shoulder.cos());
    [0.0, shoulder, forearm - shoulder, std::f32::consts::PI - forearm, 0.0]
}

#[test]
fn a_script_fetches_the_block() {
    for seed in 0..10 {
        let (mut targets, mut height, mut phase, mut wait) = ([0.0_f32; 5], 0.2_f32, 0, 30);
        let (reward, success) = solve("YouBotFetch", seed, |seen| {
            let (off, mut wanted) = ([seen[0] - AHEAD, seen[1]], arm_at(height));
            // The hand points down, so it turns against the robot. All four sides of the block fit.
            let heading = f32::atan2(seen[19], seen[18]);
            wanted[4] = (heading / FRAC_PI_2).round() * FRAC_PI_2 - heading;
            let far = wanted.iter().zip(&seen[11..16]).map(|(wanted, angle)| (wanted - angle).abs());
            let is_there = far.fold(0.0, f32::max) < 0.03;
            match phase {
                // Down in steps, while the base keeps the block under the hand.
                0 if is_there && off[0].hypot(off[1]) < 0.004 && height > 0.041 => {
                    height = f32::max(0.04, height - 0.02)
                }
                0 if is_there && off[0].hypot(off[1]) < 0.004 => phase = 1,
                1 if wait > 0 => wait -= 1,
                1 => (phase, height) = (2, 0.15),
                2 if is_there => phase = 3,
                3 => {
                    let apart = (0..3).map(|axis| (seen[axis] - seen[3 + axis]).powi(2)).sum::<f32>().sqrt();
                    assert!(apart < 0.01, "{seed}: the hand sees the block {apart} m from its fingers");
                }
                _ => {}
            }
            let base = match phase {
                0 => off.map(|off| (4.0 * off).clamp(-0.5, 0.5)),
                3 => {
                    let way = [seen[6] - seen[0], seen[7] - seen[1]];
                    way.map(|part| part / way[0].hypot(way[1]).max(0.5))
                }
                _ => [0.0, 0.0],
            };
            let joints = [0, 1, 2, 3, 4].map(|joint| ((wanted[joint] - targets[joint]) / 0.06).clamp(-1.0, 1.0));
            targets.iter_mut().zip(joints).for_each(|(target, speed)| *target += 0.06 * speed);
            let gripper = if phase == 0 { 1.0 } else { -1.0 };
            [&base[..], &[0.0], &joints, &[gripper]].concat()
        });
        assert!(success && reward > 1.0, "{seed}: {reward}");
    }
}

#[test]
fn a_robot_that_drives_sees_more_than_one_that_stands() {
    let stands = solve("P3ATExplore", 1, |_| vec![0.0, 0.0]).0;
    // It turns away from what is near.
    let drives = solve("P3ATExplore", 1, |seen| {
        let ahead = seen[15..21].iter().copied().fold(1.0, f32::min);
        if ahead > 0.05 { vec![1.0, 1.0] } else { vec![1.0, -1.0] }
    });
    println!("standing it sees {stands:.1} m² more after the start, driving {:.1}", drives.0);
    assert!(drives.0 > stands + 20.0, "{stands} {drives:?}");
}

#[test]
fn a_task_with_a_mistake_is_refused_with_its_place() {
    for (from, to, expected) in [
        ("map = \"rough\"", "map = \"ruff\"", "unknown map `ruff`"),
        ("robot = \"YouBot\"", "robot = \"YouBo\"", "unknown robot `YouBo`"),
        ("robot = \"YouBot\"", "robot = \"P3AT\"", "drive_model: P3AT cannot have it"),
        ("drive_model = \"analytic\"", "drive_model = \"magic\"", "drive_model: "),
        ("drive_model = \"analytic\"", "drive_model = \"analytic\"\nset = [\"robot.nothing=1\"]", "robot.nothing=1"),
        ("time_step = 0.02", "time_step = 0.5", "time_step: got 0.5, expected 0.0001 to 0.02"),
        ("time_step = 0.02", "time_step = nan", "time_step: got NaN, expected 0.0001 to 0.02"),
        ("control_interval = 0.04", "control_interval = 0.05", "control_interval: got 2.5 time steps"),
        ("control_interval = 0.04", "control_interval = 2.0", "control_interval: got 2, expected 0.02 to 1"),
        ("seconds = 0.16", "seconds = 1e9", "seconds: got 1000000000, expected 0.04 to 3600"),
        ("seconds = 0.16", "seconds = 0.16\nrobots = 0", "robots: got 0, expected 1 to 16"),
        ("seconds = 0.16", "seconds = 0.16\nspeed = 1", "unknown field `speed`"),
        ("[start]", "[start]\nname = \"Nowhere\"", "unknown start `Nowhere`"),
        ("[start]", "[start]\nyaw = [1.0, -1.0]", "start.yaw: got 1 to -1"),
        ("[start]", "[start]\nposition = [[0.0, inf], [0.0, 0.0]]", "start.position: got 0 to inf"),
        ("twist = [0.8, 0.8, 1.0]", "twist = [0.8, 0.8, -1.0]", "action: got -1, expected 0 to 1000"),
        ("twist = [0.8, 0.8, 1.0]", "joints = { Elbow = 1.0 }", "unknown joint `Elbow`"),
        ("twist = [0.8, 0.8, 1.0]", "gripper = \"Hand\"", "YouBot has no gripper `Hand`"),
        ("distance = [1.0, 1.0]", "distance = [-1.0, 1.0]", "reach.distance: got -1 to 1"),
        (
            "[reach]",
            "[push]\ntarget = [[0.0, 1.0], [0.0, 1.0]]\ntolerance = 0.1\n[reach]",
            "expected one table of [reach], [follow], [push], [fetch], [explore], [find] and [zone]",
        ),
        ("[reach]\ndistance = [1.0, 1.0]", "[push]\ntarget = [[0.0, 1.0], [0.0, 1.0]]", "expected an [object]"),
        (
            "[reach]\ndistance = [1.0, 1.0]\ntolerance = 0.1",
            "[explore]\narea = [[0.0, 1.0], [0.0, 1.0]]\ncell = 0.1\nsight = 5.0\nscanner = \"Eye\"",
            "YouBot has no sensor `Eye`",
        ),
        (
            "[reach]\ndistance = [1.0, 1.0]\ntolerance = 0.1",
            "[explore]\narea = [[-900.0, 900.0], [-900.0, 900.0]]\ncell = 0.01\nsight = 5.0\nscanner = \"Hokuyo\"",
            "cells, expected at most 1000000",
        ),
        (
            "[reach]\ndistance = [1.0, 1.0]\ntolerance = 0.1",
            "[find]\nvictim = \"nobody\"\nradius = 1.0",
            "find.victim: the map rough has no `nobody`",
        ),
        ("distance = [1.0, 1.0]", "point = [1.0, 1.0]\ndistance = [1.0, 1.0]", "either a `point` or a `distance`"),
        (
            "[reach]\ndistance = [1.0, 1.0]\ntolerance = 0.1",
            "[follow]\npoints = [[0.0, 0.0]]\nspacing = 0.1\nmost_beside = 0.1",
            "expected points that differ",
        ),
    ] {
        assert!(SHORT.contains(from), "{from}");
        let text = SHORT.replacen(from, to, 1);
        let refused = Task::read(Path::new("short.toml"), &text).err().map(|error| error.to_string());
        let text = refused.unwrap_or_default();
        assert!(text.starts_with("short.toml: ") && text.contains(expected), "{to}: {text}");
    }
    let unknown = Task::load("YouBotReech").err().map(|error| error.to_string()).unwrap_or_default();
    assert!(unknown.contains("did you mean `YouBotReach`"), "{unknown}");
}
