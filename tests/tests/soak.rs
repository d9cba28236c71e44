//! A world in which robots come and leave for a long time. Its memory stays constant, and a seed always gives the same result. `make soak`
//! runs these tests at full length.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use gamebots_proto::Problem;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use scene::DriveModel;
use sim_core::{Options, PawnId, TIME_STEP, World};
use system_tests::{Server, Usage, alone, command, init, init_on_top, sessions, setting};

/// Number of robots that come and leave, unless `USARSIM_SOAK_LEAVINGS` is set.
const LEAVINGS: u64 = 2_000;
/// Most steps until a robot has fallen onto the one below it.
const MAX_FALL: u64 = 100;
/// Hours of simulated time, unless `USARSIM_SOAK_HOURS` is set.
const HOURS: f64 = 2.0 / 60.0;
/// Steps in a second.
const SECOND: u64 = (1.0 / TIME_STEP) as u64;

/// Builds a world with both kinds of Mecanum robots: `KUKA_YouBot` as one body, `YouBot` with its rollers.
fn world(map: &str, seed: u64) -> World {
    let mut def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    for (class, model) in [("KUKA_YouBot", DriveModel::Analytic), ("YouBot", DriveModel::Bodies)] {
        let robot = def.robots.get_mut(class).expect("a shipped robot");
        robot.set_drive_model(Some(model));
    }
    World::new(def, Options { seed, ..Options::default() })
}

/// Executes a line of a client with this robot. Returns the client's robot after it.
fn send(robot: Option<PawnId>, world: &mut World, line: &str) -> Option<PawnId> {
    let mut problems = Vec::new();
    let spawned = world.execute(robot, &command(line), &mut problems).spawned;
    problems.retain(|problem| !matches!(problem, Problem::Beside { .. }));
    assert!(problems.is_empty(), "{line}: {problems:?}");
    spawned.or(robot)
}

#[track_caller]
fn check_memory(what: &str, first: u64, last: u64) {
    println!("{what}: {:.1} MB resident at first, {:.1} MB at the end", first as f64 / 1e6, last as f64 / 1e6);
    assert!(last as f64 <= 1.05 * first as f64 + 2e6, "{what}: from {first} to {last} bytes");
}

#[test]
fn robots_that_leave_leave_nothing_behind() {
    let _alone = alone();
    let leavings = setting("USARSIM_SOAK_LEAVINGS", LEAVINGS);
    let (start, mut touching, mut first) = (Instant::now(), 0, 0);
    let mut world = world("rough", 0);
    for pair in 0..leavings / 2 {
        // The second robot stands on the first. In every other pair the lower one leaves first.
        let classes = match pair % 16 {
            0 => ["YouBot", "P3AT"],
            1..4 => ["KUKA_YouBot", "KUKA_YouBot"],
            4..6 => ["P3AT", "KUKA_YouBot"],
            6 => ["P2AT", "P2DX"],
            7 => ["CasterSkidRobot", "BasicSkidRobot"],
            _ => ["P3AT", "P3AT"],
        };
        let mut robots = classes.map(|class| init_on_top(&mut world, class, [0.0, 0.0], 0.0));
        for robot in robots {
            send(Some(robot), &mut world, "DRIVE {Left 1} {Right 1}");
        }
        // Only the lower robot can push the upper one.
        let upper = robots[1];
        let is_pushed = |world: &World| {
            let contacts = world.observe(upper).expect("the upper robot").contacts;
            contacts.iter().any(|contact| contact.force.norm() > 0.0)
        };
        touching += u64::from((0..MAX_FALL).any(|_| {
            world.step();
            is_pushed(&world)
        }));
        if pair % 2 == 1 {
            robots.reverse();
        }
        for robot in robots {
            world.remove(robot);
            world.step();
        }
        if pair == 500 {
            first = Usage::of("self").resident;
        }
    }
    assert_eq!(world.robots().count(), 0);
    println!("{leavings} robots in {:.1} s, {touching} left while they touched another", start.elapsed().as_secs_f64());
    assert!(touching * 100 >= leavings / 2 * 99, "{touching} of {} pairs touched", leavings / 2);
    check_memory("robots that come and leave", first, Usage::of("self").resident);
}

#[test]
fn robots_that_leave_in_the_step_in_which_others_come_leave_nothing_behind() {
    let _alone = alone();
    let mut world = world("rough", 0);
    let mut first = 0;
    for round in 0..20_000 {
        let class = ["P3AT", "KUKA_YouBot", "P2AT"][round % 3];
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Start PlayerStart_0}}"));
        world.step();
        world.remove(robot);
        if round == 1000 {
            first = Usage::of("self").resident;
        }
    }
    check_memory("robots that come where one left", first, Usage::of("self").resident);
}

/// A client that repeatedly comes, drives and leaves.
struct Visitor {
    robot: Option<PawnId>,
    /// Step of its next arrival or departure.
    next: u64,
}

/// Result of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Outcome {
    /// Digest of the world in every second.
    digest: u64,
    messages: u64,
    visits: u64,
    commands: u64,
    /// Sum of the number of robots over all seconds.
    robots: u64,
}

/// Runs a world with visitors that come, drive, collide and leave, and reports every second.
fn soak(map: &str, seed: u64, seconds: u64, mut report: impl FnMut(u64, &Outcome)) -> Outcome {
    let mut world = world(map, seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut outcome = Outcome { digest: 0, messages: 0, visits: 0, commands: 0, robots: 0 };
    let mut visitors: Vec<Visitor> = (0..4).map(|index| Visitor { robot: None, next: index * SECOND }).collect();
    for step in 0..seconds * SECOND {
        // Commands come ten times a second.
        if step % (SECOND / 10) == 0 {
            for (index, visitor) in visitors.iter_mut().enumerate() {
                visit(index, visitor, step, &mut world, &mut random, &mut outcome);
            }
        }
        outcome.messages += world.step().len() as u64;
        if step % SECOND == SECOND - 1 {
            outcome.digest = outcome.digest.rotate_left(1) ^ world.digest();
            outcome.robots += world.robots().count() as u64;
            report(step / SECOND + 1, &outcome);
        }
    }
    outcome
}

fn visit(
    index: usize,
    visitor: &mut Visitor,
    step: u64,
    world: &mut World,
    random: &mut ChaCha8Rng,
    outcome: &mut Outcome,
) {
    let is_due = step >= visitor.next;
    match visitor.robot {
        None if is_due => {
            // One P3AT costs as much as five youBots.
            let class = if index == 0 { "P3AT" } else { "KUKA_YouBot" };
            let place = sessions::place(random);
            visitor.robot = send(None, world, &format!("INIT {{ClassName USARBot.{class}}} {place}"));
            visitor.next = step + random.random_range(5..90) * SECOND;
            outcome.visits += 1;
        }
        Some(_) if is_due => {
            visitor.robot.take().into_iter().for_each(|robot| world.remove(robot));
            visitor.next = step + random.random_range(1..30) * SECOND;
        }
        robot @ Some(_) if random.random_bool(0.1) => {
            let mut speed = || random.random_range(-8.0..8.0);
            let line = if index == 0 {
                format!("DRIVE {{Left {:.2}}} {{Right {:.2}}}", speed(), speed())
            } else {
                let speeds = [speed(), speed(), speed(), speed()];
                let wheels = ["Front-Left", "Front-Right", "Back-Left", "Back-Right"];
                let blocks = wheels.iter().zip(speeds).map(|(wheel, speed)| format!(" {{{wheel} {speed:.2}}}"));
                format!("DRIVE{}", blocks.collect::<String>())
            };
            send(robot, world, &line);
            send(robot, world, ["GETCONF {Type Robot}", "GETGEO {Type GroundTruth}"][random.random_range(0..2)]);
            outcome.commands += 2;
        }
        _ => {}
    }
}

#[test]
fn robots_that_come_collide_and_leave_for_hours_take_no_memory_and_repeat_themselves() {
    check_hours("arena");
}

#[test]
fn robots_that_push_objects_and_leave_for_hours_take_no_memory_and_repeat_themselves() {
    check_hours("hall");
}

#[track_caller]
fn check_hours(map: &str) {
    let _alone = alone();
    let seconds = (3600.0 * setting("USARSIM_SOAK_HOURS", HOURS)).round() as u64;
    let start = Instant::now();
    let mut resident = Vec::new();
    let report = |second: u64, outcome: &Outcome| {
        if second.is_multiple_of(3600) {
            let (hour, digest, minutes) = (second / 3600, outcome.digest, start.elapsed().as_secs_f64() / 60.0);
            println!("hour {hour}: digest {digest:016x}, {} visits, {minutes:.1} minutes", outcome.visits);
        }
        if second.is_multiple_of(seconds.div_ceil(10)) || second == seconds {
            resident.push(Usage::of("self").resident);
        }
    };
    let (one, other) = std::thread::scope(|scope| {
        let other = scope.spawn(|| soak(map, 1, seconds, |_, _| {}));
        (soak(map, 1, seconds, report), other.join().expect("the other run"))
    });
    println!(
        "{one:?} in {:.1} s, {:.2} robots at a time",
        start.elapsed().as_secs_f64(),
        one.robots as f64 / seconds as f64
    );
    assert_eq!(one, other);
    assert!(one.visits >= seconds / 30, "{one:?}");
    check_memory("robots that collide", resident[0], resident[resident.len() - 1]);
}

#[test]
fn questions_whose_answers_are_never_read_wait_outside() {
    let _alone = alone();
    let server = Server::start("rough", &[], |_| {});
    let mut bystander = server.bystander();
    let before = Usage::of("self").resident;
    for line in ["GETGEO {Type Sonar}\r\n", "A\r\n", "GETPATHNODES\r\n"] {
        let mut silent = TcpStream::connect(server.address).expect("a connection");
        silent.set_write_timeout(Some(Duration::from_secs(2))).expect("a timeout");
        silent
            .write_all(b"REPORT {Errors true}\r\nINIT {ClassName USARBot.P2AT} {Location 0,0,0}\r\n")
            .expect("INIT is taken");
        let (lines, mut taken) = (line.repeat(1000), 0);
        while taken < 40_000_000
            && let Ok(count) = silent.write(lines.as_bytes())
        {
            taken += count;
        }
        let grown = Usage::of("self").resident.saturating_sub(before) / 1_000_000;
        println!("{}: {taken} bytes taken, {grown} MB more", line.trim_end());
        assert!(grown < 100, "{line}: {grown} MB");
        bystander.check_undisturbed();
    }
}
