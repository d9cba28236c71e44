//! World controllers: what becomes of the objects that they create, move and hold.

use gamebots_proto::Command;
use gamebots_proto::message::Message;
use nalgebra::Vector3;
use sim_core::{Options, Report, World};
use system_tests::{Server, Stage, init, run};

/// Puts a controller into a world on a map.
fn stage_on(map: &str) -> Stage {
    Stage::new(map, Options::default())
}

#[test]
fn a_rigid_crate_falls_and_rests_and_one_without_physics_stays_in_the_air() {
    let mut stage = stage_on("rough");
    stage.must("{Type Create} {ClassName WCCrate} {Name falls} {Location 0,0,-1} {Physics RigidBody}");
    stage.must("{Type Create} {ClassName WCCrate} {Name stays} {Location 2,0,-1}");
    run(&mut stage.world, 2.0);
    let (falls, stays) = (stage.at("falls"), stage.at("stays"));
    assert!((falls.z + 0.25).abs() < 0.01, "{falls}");
    assert_eq!(stays, Vector3::new(2.0, 0.0, -1.0));
}

#[test]
fn a_robot_pushes_a_rigid_crate_and_stops_at_one_without_physics() {
    for (physics, moves) in [("RigidBody", true), ("None", false)] {
        for class in ["P3AT", "KUKA_YouBot"] {
            let mut stage = stage_on("rough");
            let robot = init(&mut stage.world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-0.2}}"));
            run(&mut stage.world, 1.0);
            stage.must(&format!(
                "{{Type Create}} {{ClassName WCCrate}} {{Name c}} {{Location 1,0,-0.26}} {{Physics {physics}}}"
            ));
            system_tests::apply(&mut stage.world, robot, "DRIVE {Left 5} {Right 5}");
            run(&mut stage.world, 4.0);
            let (pushed, robot) = (stage.at("c").x - 1.0, stage.world.observe(robot).expect("a robot").body.pose);
            assert_eq!(pushed > 0.1, moves, "{class} against {physics}: pushed by {pushed} m");
            if !moves {
                assert!(robot.translation.x < 0.8, "{class} is in the crate: {robot}");
            }
        }
    }
}

#[test]
fn a_crate_on_top_falls_when_the_one_below_is_removed_or_moved() {
    for order in ["{Type Kill} {Name below}", "{Type AbsMove} {Name below} {Location 5,5,-0.25}"] {
        for physics in ["RigidBody", "None"] {
            let mut stage = stage_on("rough");
            stage.must(&format!(
                "{{Type Create}} {{ClassName WCCrate}} {{Name below}} {{Location 0,0,-0.25}} {{Physics {physics}}}"
            ));
            stage.must("{Type Create} {ClassName WCCrate} {Name top} {Location 0,0,-0.752} {Physics RigidBody}");
            run(&mut stage.world, 2.0);
            assert!((stage.at("top").z + 0.75).abs() < 0.01, "{physics}: {}", stage.at("top"));
            stage.must(order);
            run(&mut stage.world, 2.0);
            assert!((stage.at("top").z + 0.25).abs() < 0.01, "{order} of {physics}: {}", stage.at("top"));
        }
    }
}

/// A platform that follows a path carries a robot and a crate by friction, and one that turns turns them.
#[test]
fn a_moving_platform_carries_what_stands_on_it() {
    for load in ["crate", "P3AT"] {
        let mut stage = stage_on("rough");
        stage.must("{Type Create} {ClassName WCPallet} {Name lift} {Location 0,0,-0.3} {Scale 2,2,1}");
        let robot = if load == "crate" {
            stage.must("{Type Create} {ClassName WCCrate} {Name load} {Location 0,0,-0.63} {Physics RigidBody}");
            None
        } else {
            Some(init(&mut stage.world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.7}"))
        };
        let place = |stage: &Stage| match robot {
            Some(robot) => stage.world.observe(robot).expect("a robot").body.pose.translation.vector,
            None => stage.at("load"),
        };
        run(&mut stage.world, 2.0);
        let start = place(&stage);
        stage.must("{Type SetWP} {Name lift} {Speed 0.25}");
        stage.must("{Type AddWP} {Name lift} {WP 0,0,-0.3;2,0,-0.3;2,0,-0.8}");
        run(&mut stage.world, 6.0);
        let way = place(&stage) - start;
        let lift = stage.at("lift");
        assert!((lift - Vector3::new(1.5, 0.0, -0.3)).norm() < 0.01, "the lift is at {lift}");
        assert!((way - Vector3::new(1.5, 0.0, 0.0)).norm() < 0.03, "{load} was carried by {way}");
        run(&mut stage.world, 3.0);
        let way = place(&stage) - start;
        assert!((way - Vector3::new(2.0, 0.0, -0.25)).norm() < 0.05, "{load} was lifted by {way}");
        // At the end of the path the platform is back at its start, and the load falls.
        run(&mut stage.world, 3.0);
        assert_eq!(stage.at("lift"), Vector3::new(0.0, 0.0, -0.3));
        assert!(place(&stage).z > -0.3, "{load} fell: {}", place(&stage));
    }
}

#[test]
fn a_turning_platform_turns_a_robot() {
    let mut stage = stage_on("rough");
    stage.must("{Type Create} {ClassName WCPallet} {Name table} {Location 0,0,-0.3} {Scale 2,2,1}");
    let robot = init(&mut stage.world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.7}");
    run(&mut stage.world, 1.0);
    stage.must("{Type Rotate} {Name table} {Speed 0,0,0.5}");
    run(&mut stage.world, 2.0);
    let (_, _, yaw) = stage.world.observe(robot).expect("a robot").body.pose.rotation.euler_angles();
    assert!((yaw - 1.0).abs() < 0.02, "{yaw}");
    stage.must("{Type Rotate} {Name table} {Speed 0,0,0}");
    run(&mut stage.world, 1.0);
    let (_, _, still) = stage.world.observe(robot).expect("a robot").body.pose.rotation.euler_angles();
    assert!((still - yaw).abs() < 0.02, "{still} after {yaw}");
}

#[test]
fn a_robot_is_moved_by_its_name_and_put_beside_what_is_there() {
    for class in ["P3AT", "KUKA_YouBot", "YouBotArm"] {
        let mut stage = stage_on("rough");
        let robot =
            init(&mut stage.world, &format!("INIT {{ClassName USARBot.{class}}} {{Name Rob}} {{Location 0,0,-0.2}}"));
        let at = |stage: &Stage| stage.world.observe(robot).expect("a robot").body.pose.translation.vector;
        run(&mut stage.world, 0.5);
        stage.must("{Type AbsMove} {Name Rob} {Location 3,1,-0.3} {Rotation 0,0,1.5}");
        run(&mut stage.world, 0.5);
        assert!((at(&stage) - Vector3::new(3.0, 1.0, at(&stage).z)).norm() < 0.05, "{class}: {}", at(&stage));
        stage.must("{Type RelMove} {Name Rob} {Location 0,1,0}");
        run(&mut stage.world, 0.5);
        assert!((at(&stage).y - 2.0).abs() < 0.05, "{class}: {}", at(&stage));
        stage.must("{Type Create} {ClassName WCCrate} {Name c} {Location 0,0,-0.25}");
        let problems = stage.order("{Type AbsMove} {Name Rob} {Location 0,0,-0.2}");
        assert!(problems[0].contains("the object `c` takes it"), "{problems:?}");
        assert!(stage.order("{Type AbsMove} {Name rob}")[0].contains("no object or robot has that name"));
        run(&mut stage.world, 0.5);
        assert!((0.2..2.0).contains(&at(&stage).xy().norm()), "{class}: {}", at(&stage));
    }
}

#[test]
fn orders_that_cannot_be_followed_say_why() {
    let mut stage = stage_on("rough");
    stage.must("{Type Create} {ClassName WCCrate} {Name c} {Location 0,0,-0.25}");
    for (order, why) in [
        (
            "{Type Create} {ClassName WCCrat} {Name d}",
            "there is no class `WCCrat` (did you mean `WCCrate`?); expected one of",
        ),
        ("{Type Create} {ClassName WCCrate} {Name d} {Location 0.1,0,-0.25}", "the object `c` is there"),
        ("{Type Create} {ClassName WCCrate} {Name d} {Location 2,0,0} {Scale 0,1,1}", "`size` is [0, 0.5, 0.5]"),
        ("{Type Create} {ClassName WCCrate} {Name d} {Location 2,0,0} {Scale -1,1,1}", "`size` is [-0.5, 0.5, 0.5]"),
        ("{Type Create} {ClassName WCCrate} {Name d} {Location 1e6,0,0}", "expected numbers of -100000 to 100000 m"),
        ("{Type Kill} {Name d}", "no object has that name"),
        ("{Type Rotate} {Name c} {Speed 0,0,1000}", "got 1000 rad/s, expected at most 50"),
        (
            "{Type Create} {ClassName WCCrate} {Name ééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééééé}",
            "Name is too long: got 258 bytes, expected at most 256",
        ),
        ("{Type SetWP} {Name c} {Speed 1000}", "got 1000 m/s, expected at most 50"),
        ("{Type AddWP} {Name d} {WP 1,2,3}", "this controller has no object of that name"),
        ("{Type Conveyor} {Name belt} {Speed 1}", "there is no such conveyor: the map has none"),
        ("{Type Creat}", "is unknown (did you mean `Create`?)"),
    ] {
        let problems = stage.order(order);
        assert!(problems.first().is_some_and(|problem| problem.contains(why)), "{order}: {problems:?}");
        assert_eq!(stage.world.objects().count(), 1, "{order}");
    }
}

/// As in the original, objects are created whose orders are partly wrong. Programs name classes and materials of packages of their own.
#[test]
fn an_object_is_created_where_only_a_part_of_the_order_is_unknown() {
    let crate_at = |location: [f64; 3]| ("WCCrate", location, false);
    let rows = [
        (
            "{ClassName WCCrate} {Location 2,0,-0.25} {Material WCObjectPkg.Crates.Gold}",
            crate_at([2.0, 0.0, -0.25]),
            "no material `Gold`: expected one of",
        ),
        (
            "{ClassName WCCrate} {Location 2,0,-0.25} {Material WCObjectPkg.Crates.plywood}",
            crate_at([2.0, 0.0, -0.25]),
            "",
        ),
        ("{ClassName WCCrate} {Start Nowhere}", crate_at([0.0; 3]), "there is no start `Nowhere`: expected one of"),
        ("{ClassName USARModels.WCCrate} {Location 2,0,-1}", crate_at([2.0, 0.0, -1.0]), ""),
        ("{ClassName WCCrate} {Location 2,0,-1} {Permanent TRUE}", ("WCCrate", [2.0, 0.0, -1.0], true), ""),
        // Half in the floor, as a known program asks for it: a rigid object is lifted.
        ("{ClassName WCCrate} {Location 1.0000, 4.0000, 0.0000} {Physics RigidBody}", crate_at([1.0, 4.0, -0.25]), ""),
        ("{ClassName WCCrate} {Location 1, 4, 5} {Physics RigidBody}", crate_at([1.0, 4.0, -0.25]), ""),
        // Of el-robotics' objectGen: no blanks between blocks, and a comma is missing.
        (
            "{ClassName WCCrate}{Name foo}{Location 1.0, 2.0, -3.0}{Rotation 0.0, 0.0 0.0}{Scale 1, 1, 1}{Physics RigidBody}{Permanent true}",
            ("WCCrate", [1.0, 2.0, -3.0], true),
            "",
        ),
        ("{ClassName WCCrate} {Location 1.0, 2.0, -3.0} {Rotation  0, 0, 0}", crate_at([1.0, 2.0, -3.0]), ""),
    ];
    for (create, (class, location, stays), problem) in rows {
        let mut stage = stage_on("rough");
        let problems = stage.order(&format!("{{Type Create}} {create}"));
        assert_eq!(problems.is_empty(), problem.is_empty(), "{create}: {problems:?}");
        assert!(problems.iter().all(|it| it.contains(problem)), "{create}: {problems:?}");
        let objects: Vec<_> = stage.world.objects().collect();
        assert_eq!(objects.len(), 1, "{create}");
        let distance = (objects[0].pose.translation.vector - nalgebra::Vector3::from(location)).norm();
        assert!(distance < 1e-6, "{create}: {}", objects[0].pose);
        assert!(stage.world.actors().iter().any(|actor| actor.class == class), "{create}");
        stage.world.remove(stage.controller);
        assert_eq!(stage.world.objects().count(), usize::from(stays), "{create}");
    }
}

/// Returns a Create for a crate in a row of crates.
fn create(number: i32, rest: &str) -> String {
    let (x, y) = (f64::from(number % 32) - 16.0, f64::from(number / 32) - 16.0);
    format!("{{Type Create}} {{ClassName WCCrate}} {{Name c{number}}} {{Location {x},{y},-0.25}} {rest}")
}

/// Objects come and go without end and leave nothing behind.
#[test]
fn five_hundred_objects_come_and_go() {
    let mut stage = stage_on("rough");
    for round in 0..3 {
        (0..512).for_each(|number| stage.must(&create(number, "{Physics RigidBody}")));
        let problems = stage.order("{Type Create} {ClassName WCCrate} {Name more} {Location 0,0,-9}");
        assert!(
            problems[0].contains("would have 513 objects and leave 511 to all others"),
            "round {round}: {problems:?}"
        );
        run(&mut stage.world, 0.02);
        assert_eq!(stage.world.objects().count(), 512);
        stage.must("{Type KillAll}");
        assert_eq!(stage.world.objects().count(), 0);
    }
    stage.world.remove(stage.controller);
    run(&mut stage.world, 0.1);
}

/// However many objects a controller makes, the next one can make some, too.
#[test]
fn every_controller_finds_room_beside_greedy_ones() {
    let mut stage = stage_on("rough");
    let mut number = 0;
    for share in [512, 256, 128, 64] {
        stage.controller = init(&mut stage.world, "INIT {ClassName USARBotAPI.WorldController}");
        for _ in 0..share {
            stage.must(&create(number, ""));
            number += 1;
        }
        let problems = stage.order(&create(number, ""));
        assert!(problems[0].contains("expected at most as many as it leaves"), "{share}: {problems:?}");
    }
}

/// Permanent objects stay, but they block nobody: in a full world the oldest give way to new ones.
#[test]
fn objects_that_a_controller_left_behind_give_way() {
    let mut stage = stage_on("rough");
    let of_map = stage.world.objects().count();
    for round in 0..2 {
        (0..512).for_each(|number| stage.must(&create(round * 512 + number, "{Permanent true}")));
        stage.world.remove(stage.controller);
        stage.controller = init(&mut stage.world, "INIT {ClassName USARBotAPI.WorldController}");
    }
    assert_eq!(stage.world.objects().count(), of_map + 1024);
    for number in 0..512 {
        let said = stage.order(&create(number, "").replace("-0.25", "-5"));
        let expected = format!(
            "CONTROL {{Type Create}} {{Name c{number}}}: the world is full: the object `c{number}`, whose controller has left, is removed"
        );
        assert_eq!(said, [expected]);
    }
    assert_eq!(stage.world.objects().count(), of_map + 1024);
    let names: Vec<String> = stage.world.objects().map(|object| object.def.solid.name.clone()).collect();
    assert!((512..1024).all(|number| names.contains(&format!("c{number}"))), "the newer ones stay");
}

/// The points of all paths together are bounded, so that nobody can fill the memory with them.
#[test]
fn points_of_paths_are_shared_as_objects_are() {
    let mut stage = stage_on("rough");
    let add = |number: i32| {
        let points = vec!["1,2,-3"; 256].join(";");
        format!("{{Type AddWP}} {{Name c{number}}} {{WP {points}}}")
    };
    (0..9).for_each(|number| stage.must(&create(number, "{Permanent true}")));
    for number in 0..8 {
        (0..16).for_each(|_| stage.must(&add(number)));
    }
    let said = stage.order(&add(0));
    assert!(said[0].contains("its path would have 4352 points: expected at most 4096"), "{said:?}");
    let said = stage.order(&add(8));
    assert!(said[0].contains("would have 33024 points of paths and leave 32512 to all others"), "{said:?}");
    // Two controllers leave full paths behind. The oldest gives way.
    stage.world.remove(stage.controller);
    stage.controller = init(&mut stage.world, "INIT {ClassName USARBotAPI.WorldController}");
    (20..28).for_each(|number| stage.must(&create(number, "{Permanent true}")));
    for number in 20..28 {
        (0..16).for_each(|_| stage.must(&add(number)));
    }
    stage.world.remove(stage.controller);
    stage.controller = init(&mut stage.world, "INIT {ClassName USARBotAPI.WorldController}");
    stage.must(&create(40, ""));
    let said = stage.order(&add(40));
    assert!(said[0].contains("the object `c0`, whose controller has left, is removed"), "{said:?}");
    let last: Vec<_> = (0..16).flat_map(|_| stage.order(&add(40))).collect();
    assert!(last.iter().any(|said| said.contains("expected at most 4096")), "{last:?}");
}

/// A saved world names the points of a path alone, as before there were limits, and goes on along it with the same bits.
#[test]
fn a_saved_path_goes_on_where_it_was() {
    let mut stage = stage_on("rough");
    stage.must("{Type Create} {ClassName WCCrate} {Name c} {Location 0,0,-5}");
    stage.must("{Type AddWP} {Name c} {WP 0,0,-5;3,4,-5;3,8,-5}");
    stage.must("{Type SetWP} {Name c} {Speed 2} {Loop true}");
    run(&mut stage.world, 3.0);
    let saved = serde_json::to_value(stage.world.save().expect("a saved world")).expect("text");
    let points = serde_json::json!([[0.0, 0.0, -5.0], [3.0, 4.0, -5.0], [3.0, 8.0, -5.0]]);
    assert_eq!(saved["created"][0]["path"]["points"], points);
    let saved = serde_json::from_value(saved).expect("a saved world");
    let mut loaded = World::load(stage.world.scene().clone(), &saved).expect("a world");
    for world in [&mut stage.world, &mut loaded] {
        run(world, 10.0);
    }
    assert_eq!(loaded.digest(), stage.world.digest());
}

/// A bar of 2 km that turns slowly has fast ends.
#[test]
fn the_farthest_point_of_a_turning_object_is_no_faster_than_one_on_a_path() {
    let mut stage = stage_on("rough");
    stage.must("{Type Create} {ClassName WCCrate} {Name bar} {Location 0,0,-900} {Scale 2000,1,1}");
    stage.must("{Type Create} {ClassName WCCrate} {Name small} {Location 0,0,-5}");
    stage.must("{Type Rotate} {Name small} {Speed 0,0,50}");
    stage.must("{Type Rotate} {Name bar} {Speed 0,0,0.0999}");
    for (speed, got) in [("0,0,0.2", 100), ("0,50,0", 25000), ("0.06,0,0.06", 60)] {
        let said = stage.order(&format!("{{Type Rotate}} {{Name bar}} {{Speed {speed}}}"));
        let expected =
            format!("its farthest point, 500.00 m from its centre, would move at {got} m/s: expected at most 50 m/s");
        assert!(said.len() == 1 && said[0].contains(&expected), "{speed}: {said:?}");
    }
}

/// A client over a socket gets the whole answer, of 150 kB here.
#[test]
fn a_client_reads_the_states_of_many_objects() {
    let server = Server::start("hall", &[], |_| {});
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController}");
    let memory = "m".repeat(250);
    for number in 0..400 {
        let place = format!("{},{},-9", number % 20, number / 20);
        controller.send(&format!(
            "CONTROL {{Type Create}} {{ClassName WCCrate}} {{Name {number}}} {{Memory {memory}}} {{Location {place}}}"
        ));
    }
    controller.send("CONTROL {Type GetSTA}");
    let answer = controller.wait_for("the states", |line| line.starts_with("STA {Name "));
    assert_eq!(answer.matches(&memory).count(), 400, "{} bytes", answer.len());
}

/// The answer to GetSTA stays a line that a client can keep, whatever its objects are called.
#[test]
fn the_states_of_many_objects_are_cut_to_a_line_and_it_is_said() {
    let mut stage = stage_on("rough");
    let long = "n".repeat(250);
    for number in 0..512 {
        let name = format!("{{Name c{number}}}");
        let order = create(number, &format!("{{Memory {long}}}"));
        stage.must(&order.replace(&name, &format!("{{Name {number}{long}}}")));
    }
    let mut problems = Vec::new();
    let ask = |text: &str| Command::parse(text, &mut Vec::new()).expect("a command");
    let mut answer = |text: &str, problems: &mut Vec<_>| {
        let executed = stage.world.execute(Some(stage.controller), &ask(text), problems);
        let [Report::Message(message)] = &executed.answers[..] else { panic!("{:?}", executed.answers) };
        message.write(gamebots_proto::Dialect::Udk)
    };
    let line = answer("CONTROL {Type GetSTA}", &mut problems);
    assert!((250_000..=256 * 1024).contains(&line.len()), "{} bytes", line.len());
    let told = line.matches("{Size").count();
    let said: Vec<String> = problems.iter().map(ToString::to_string).collect();
    assert!(said.len() == 1 && said[0].contains(&format!("the first {told} of 512 objects")), "{said:?}");
    problems.clear();
    let last = answer(&format!("CONTROL {{Type GetSTA}} {{Name 511{long}}}"), &mut problems);
    assert!(last.contains("{Name 511n") && problems.is_empty(), "{last}: {problems:?}");
}

/// Two controllers have their own objects, and each takes only its own along.
#[test]
fn a_controller_that_leaves_takes_only_its_own_objects() {
    let mut stage = stage_on("hall");
    let of_map = stage.world.objects().count();
    stage.must("{Type Create} {ClassName WCCrate} {Name c} {Location -4,0,-0.25}");
    stage.must("{Type Create} {ClassName WCCrate} {Name kept} {Location -4,1,-0.25} {Permanent true}");
    let first = stage.controller;
    stage.controller = init(&mut stage.world, "INIT {ClassName USARBotAPI.WorldController} {Name two}");
    stage.must("{Type Create} {ClassName WCCrate} {Name c} {Location -4,2,-0.25}");
    stage.world.remove(first);
    let names: Vec<String> = stage.world.objects().skip(of_map).map(|object| object.def.solid.name.clone()).collect();
    assert_eq!(names, ["kept", "c"]);
    // Objects of the map are moved and removed by their names.
    let crate_of_map = stage.world.objects().next().expect("an object").def.solid.name.clone();
    stage.must(&format!("{{Type AbsMove}} {{Name {crate_of_map}}} {{Location 0,0,-2}}"));
    assert_eq!(stage.at(&crate_of_map).z, -2.0);
    stage.must(&format!("{{Type Kill}} {{Name {crate_of_map}}}"));
    assert_eq!(stage.world.objects().count(), of_map - 1 + 2);
    let asked = Command::parse("CONTROL {Type GetSTA}", &mut Vec::new()).expect("a command");
    let answers = stage.world.execute(Some(stage.controller), &asked, &mut Vec::new()).answers;
    assert!(matches!(&answers[..], [Report::Message(Message::Objects(objects))] if objects.len() == 1), "{answers:?}");
}
