//! Avatars: where they walk, what stops them, and what they say.

use gamebots_proto::Dialect;
use gamebots_proto::message::Message;
use sim_core::{Options, PawnId, World};
use system_tests::{Server, apply, init, problems, run};

const TALL: &str = "USARAvatar.USARAvatarTallMaleA";
const NEW: &str = "USARAvatar.USARAvatarNewMale";

/// A world with an avatar.
struct Walk {
    world: World,
    avatar: PawnId,
}

impl Walk {
    fn new(map: &str, class: &str, place: &str) -> Self {
        let mut world = World::new(scene_loader::load(map, &[]).expect("a map"), Options::default());
        let avatar = init(&mut world, &format!("INIT {{ClassName {class}}} {{Name Ann}} {{Location {place}}}"));
        Self { world, avatar }
    }

    /// Sends an order that has no problem.
    fn must(&mut self, text: &str) {
        assert_eq!(problems(&mut self.world, self.avatar, text), [""; 0], "{text}");
    }

    /// Returns x, y and the angle to the axis x, rounded to 5 cm and 0.1 rad.
    fn at(&self) -> [f64; 3] {
        let avatar = self.world.objects().find(|object| object.def.solid.name == "Ann").expect("an avatar");
        let (position, rotation) = scene::position_and_rotation(&avatar.pose);
        let rounded = |number: f64, unit: f64| (number / unit).round() * unit + 0.0;
        [rounded(position[0], 0.05), rounded(position[1], 0.05), rounded(rotation[2], 0.1)]
    }

    /// Checks where the avatar is after a time, s.
    fn check(&mut self, seconds: f64, expected: [f64; 3]) {
        run(&mut self.world, seconds);
        let got = self.at();
        let is_near = got.iter().zip(expected).all(|(got, expected)| (got - expected).abs() < 0.11);
        assert!(is_near, "{got:?}, expected {expected:?}");
    }
}

#[test]
fn an_avatar_walks_runs_and_goes_backwards() {
    let mut walk = Walk::new("rough", TALL, "0,0,0");
    walk.must("MOVE {Type Walk_Forward} {Action New} {Location 3, 0}");
    walk.check(2.0, [1.44, 0.0, 0.0]);
    walk.must("MOVE {Type Run} {Action Append} {Location 3,3}");
    walk.must("MOVE {Type Walk_Backward} {Action Append} {Location 3,2}");
    walk.check(2.2, [3.0, 0.0, 0.0]);
    walk.check(1.0, [3.0, 3.0, 1.57]);
    walk.check(2.0, [3.0, 2.0, 1.57]);
    // As fast as the run before it.
    walk.must("MOVE {Type Run} {Action New} {Location 9,2}");
    walk.check(1.0, [5.9, 2.0, 0.0]);
    walk.must("MOVE {Action Pause}");
    walk.check(1.0, [5.9, 2.0, 0.0]);
    walk.must("MOVE {Action Resume}");
    walk.check(2.0, [9.0, 2.0, 0.0]);
    walk.must("MOVE {Type Walk_Forward} {Action New} {Location 9,-5}");
    walk.must("MOVE {Type Walk_Forward} {Action New} {Location 8,2}");
    walk.check(3.0, [8.0, 2.0, 3.1]);
}

#[test]
fn an_avatar_goes_around_corners_to_a_path_node() {
    let mut walk = Walk::new("rescue", NEW, "-6.6,0,0");
    walk.must("GOTO {Name office}");
    walk.check(30.0, [0.6, -3.6, -0.1]);
    let said = problems(&mut walk.world, walk.avatar, "GOTO {Name Moon}");
    assert!(said[0].starts_with("GOTO: there is no path node `Moon`: expected one of Hall, Corridor"), "{said:?}");
    walk.must("MOVE {Type Walk_Forward} {Action New} {Pathnode Corridor}");
}

#[test]
fn an_avatar_stops_before_walls_and_robots_and_goes_on() {
    let mut walk = Walk::new("rough", TALL, "0,0,0");
    let robot = init(&mut walk.world, "INIT {ClassName USARBot.P3AT} {Location 2,0,-0.2}");
    run(&mut walk.world, 0.5);
    walk.must("MOVE {Type Walk_Forward} {Action New} {Location 5,0}");
    run(&mut walk.world, 6.0);
    let [x, ..] = walk.at();
    assert!((1.0..1.7).contains(&x), "{x}");
    let before = walk.world.position(robot).expect("a robot");
    let moved = (before[0] - 2.0).abs();
    assert!(moved < 0.01, "the robot was pushed by {moved} m");
    walk.world.remove(robot);
    walk.check(7.0, [5.0, 0.0, 0.0]);
}

#[test]
fn a_robot_does_not_drive_through_an_avatar() {
    let mut walk = Walk::new("rough", TALL, "2,0,0");
    let robot = init(&mut walk.world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.2}");
    apply(&mut walk.world, robot, "DRIVE {Left 3} {Right 3}");
    walk.check(6.0, [2.0, 0.0, 0.0]);
    let [x, ..] = walk.world.position(robot).expect("a robot");
    assert!((1.3..1.85).contains(&x), "{x}");
}

#[test]
fn an_avatar_climbs_a_slope_and_no_wall() {
    let mut walk = Walk::new("slope-4.5", TALL, "0,0,0");
    let height = |walk: &Walk| walk.world.objects().last().expect("an avatar").pose.translation.z;
    let before = height(&walk);
    walk.must("MOVE {Type Run} {Action New} {Location 6,0}");
    walk.check(2.2, [6.0, 0.0, 0.0]);
    let climbed = before - height(&walk);
    assert!((climbed - 4.0 * 4.5_f64.to_radians().tan()).abs() < 0.01, "{climbed}");
    let mut walk = Walk::new("rescue", TALL, "-6.6,0,0");
    walk.must("MOVE {Type Run} {Action New} {Location -20,0}");
    run(&mut walk.world, 10.0);
    assert!(walk.at()[0] > -9.0, "it went through the wall: {:?}", walk.at());
}

#[test]
fn what_an_avatar_says() {
    let mut walk = Walk::new("rough", NEW, "1,2,0");
    let messages = run(&mut walk.world, 1.0);
    assert_eq!(messages.len(), 40);
    let lines: Vec<String> = messages.iter().map(|message| message.write(Dialect::Udk)).collect();
    let state = "STA {Time 0.0500} {Type USARAvatarNewMale} {Name Ann} {Location 1.00,2.00,-0.85} {Orientation 0.00,0.00,0.00} \
                 {Walking False}";
    let bones = "BSTA {Time 0.0500} {Name Ann} {Bone Bip02-R-UpperArm} {Rotation 0.00,0.00,0.00} {Bone Bip02-R-Forearm} \
                 {Rotation 0.00,0.00,0.00} {Bone Bip02-L-UpperArm} {Rotation 0.00,0.00,0.00} {Bone Bip02-L-Forearm} \
                 {Rotation 0.00,0.00,0.00}";
    assert_eq!([lines[0].as_str(), lines[1].as_str()], [state, bones]);
    assert_eq!(Message::read(&lines[0]).as_ref(), Some(&messages[0]));
    assert_eq!(Message::read(&lines[1]).as_ref(), Some(&messages[1]));
    walk.must("MOVE {Type Walk_Forward} {Action New} {Location 3,2}");
    let lines: Vec<String> = run(&mut walk.world, 1.0).iter().map(|message| message.write(Dialect::Udk)).collect();
    assert!(lines.last().is_some_and(|line| line.starts_with("BSTA") && !line.ends_with("0.00,0.00,0.00}")));
    assert!(lines[lines.len() - 2].ends_with("{Walking True}"), "{lines:?}");
    let mut tall = Walk::new("rough", TALL, "1,2,0");
    assert_eq!(run(&mut tall.world, 1.0), []);
}

#[test]
fn orders_that_cannot_be_followed_are_named() {
    let mut walk = Walk::new("rough", TALL, "0,0,0");
    for (line, expected) in [
        ("MOVE {Type Fly} {Action New} {Location 1,1}", "{Type Fly} is unknown"),
        ("MOVE {Type Run} {Action Now} {Location 1,1}", "{Action Now} is unknown (did you mean `New`?)"),
        ("MOVE {Type Run} {Action New}", "MOVE needs Location or Pathnode"),
        ("MOVE {Type Run} {Action New} {Pathnode x}", "MOVE: there is no path node `x`: expected one of"),
        ("MOVE {Type Run} {Action New} {Location 1e6,0}", "MOVE: `Location` is [1000000, 0, 0]: expected"),
        ("DRIVE {Left 1}", "there is no robot on this connection"),
    ] {
        let said = problems(&mut walk.world, walk.avatar, line);
        assert!(said.first().is_some_and(|said| said.contains(expected)), "{line}: {said:?}");
    }
    let robot = init(&mut walk.world, "INIT {ClassName USARBot.P3AT} {Location 3,0,-0.2}");
    for verb in ["MOVE {Action Pause}", "GOTO {Name x}"] {
        assert!(problems(&mut walk.world, robot, verb)[0].contains("only an avatar walks"), "{verb}");
    }
    for _ in 0..1024 {
        walk.must("MOVE {Type Run} {Action Append} {Location 100,0}");
    }
    let said = problems(&mut walk.world, walk.avatar, "MOVE {Type Run} {Action Append} {Location 100,0}");
    assert!(said[0].contains("1024 places"), "{said:?}");
    let taken = format!("INIT {{ClassName {TALL}}} {{Location 0,0,0}}");
    assert!(problems(&mut walk.world, robot, &taken)[0].contains("the object `Ann` takes it"));
}

#[test]
fn a_saved_avatar_walks_on_with_the_same_bits() {
    let mut walk = Walk::new("rescue", NEW, "-6.6,0,0");
    init(&mut walk.world, "INIT {ClassName USARBot.P3AT} {Location -7.4,3.4,-0.2}");
    walk.must("GOTO {Name Office}");
    run(&mut walk.world, 3.333);
    let saved = serde_json::to_string(&walk.world.save().expect("a saved world")).expect("JSON");
    let saved = serde_json::from_str(&saved).expect("the same");
    let mut other = World::load(walk.world.def().clone(), &saved).expect("a world");
    for _ in 0..500 {
        assert_eq!(walk.world.step(), other.step());
        assert_eq!(walk.world.digest(), other.digest());
    }
    assert!(walk.at()[0] > -6.0, "{:?}", walk.at());
}

#[test]
fn an_avatar_is_in_truth_and_in_a_log_that_replays_and_leaves_with_its_connection() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = Server::start("rough", &[], |config| {
        config.log = Some(path.clone());
        config.listeners.push(gamebots_server::Listener::new(gamebots_server::Service::Truth, 0));
    });
    let mut client = server.client();
    client.send(&format!("INIT {{ClassName {NEW}}} {{Name Ann}} {{Location 1,0,0}}"));
    client.wait_for("a state", |line| line.starts_with("STA ") && line.contains("{Walking False}"));
    client.send("MOVE {Action New} {Location 3.00, 1.00} {Type Walk_Forward}");
    client.wait_for("a walk", |line| line.contains("{Walking True}"));
    let mut truth = server.beside(server.truth);
    truth.send("{class Pawn}");
    let row = truth.line();
    assert!(row.starts_with("{Name USARAvatarNewMale_0} {Class USARAvatarNewMale} {Time "), "{row}");
    assert_eq!(truth.line(), "{End}");
    drop(client);
    system_tests::wait_until(|| {
        truth.send("{class Pawn}");
        let line = truth.line();
        line == "{End}" || truth.line().is_empty()
    });
    server.stop().expect("a good end");
    let log = recorder::read(&path).expect("a log");
    assert!(logbook::replay(&log).expect("a replay").is_same());
}
