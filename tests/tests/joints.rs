//! Joints besides those of wheels: links on a robot swing, slide, hold and stop at their limits.

use std::f64::consts::TAU;

use scene::{JointState, WorldDef};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, init, run};

/// A heavy cart with a joint to a link of 0.5 kg, whose centre of mass is 0.2 m from the joint.
const CART: &str = r#"
description = "a cart with a joint"
steering = "skid"
[[part]]
name = "Chassis"
mass = 200.0
position = [0.0, 0.0, -0.1]
size = [0.5, 0.4, 0.1]
material = "aluminium"
[wheels]
radius = 0.1
width = 0.05
mass = 1.0
material = "rubber-tyre"
max_speed = 10.0
gain = 50.0
max_torque = 100.0
[[wheel]]
name = "FL"
side = "left"
position = [0.2, -0.25, 0.0]
[[wheel]]
name = "FR"
side = "right"
position = [0.2, 0.25, 0.0]
[[wheel]]
name = "BL"
side = "left"
position = [-0.2, -0.25, 0.0]
[[wheel]]
name = "BR"
side = "right"
position = [-0.2, 0.25, 0.0]
[[joint]]
name = "Arm"
position = [0.0, 0.0, -1.0]
JOINT
[[part]]
name = "Bob"
link = "Arm"
mass = 0.5
position = CENTRE
size = [0.02, 0.02, 0.02]
material = "aluminium"
"#;

/// Returns the cart with a joint, and the centre of mass of the link on it.
fn cart(joint: &str, centre: &str) -> String {
    CART.replace("JOINT", joint).replace("CENTRE", centre)
}

/// Loads a scene with a robot file, or returns all errors in it.
fn load(robot: &str) -> Result<WorldDef, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("Cart/robot.toml");
    std::fs::create_dir(folder.path().join("Cart")).expect("a folder");
    std::fs::write(&path, robot).expect("a file");
    scene_loader::load("rough", &[&path]).map_err(|error| error.to_string())
}

/// Builds a world with such a robot.
fn world_of(robot: &str) -> (World, PawnId) {
    let mut world = World::new(load(robot).unwrap_or_else(|error| panic!("{error}")), Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.Cart} {Location 0,0,0}");
    (world, robot)
}

fn world(joint: &str, centre: &str) -> (World, PawnId) {
    world_of(&cart(joint, centre))
}

fn arm(world: &World) -> JointState {
    world.snapshot().robots[0].joints[0]
}

#[test]
fn a_free_joint_swings_as_a_pendulum_does() {
    // The link starts 0.1 rad ahead of straight down.
    let (sin, cos) = 0.1f64.sin_cos();
    let centre = format!("[{}, 0.0, {}]", 0.2 * sin, -1.0 + 0.2 * cos);
    let (mut world, _) = world("kind = \"continuous\"\naxis = [0, 1, 0]", &centre);
    run(&mut world, 0.5);
    // Straight down is at -0.1 rad. Ten periods are measured, from one backward passage to the tenth after it.
    let mut passages = Vec::new();
    let mut before = arm(&world).position;
    while passages.len() < 11 && world.time() < 15.0 {
        world.step();
        let now = arm(&world).position;
        if before > -0.1 && now <= -0.1 {
            passages.push(world.time() - world.time_step() * (now + 0.1) / (now - before));
        }
        before = now;
    }
    let period = (passages[10] - passages[0]) / 10.0;
    let inertia = 0.5 * 0.2f64.powi(2) + 0.5 * 2.0 * 0.02f64.powi(2) / 12.0;
    // With an amplitude of 0.1 rad the period is longer by its square over 16.
    let exact = TAU * (inertia / (0.5 * 9.81 * 0.2)).sqrt() * (1.0 + 0.1f64.powi(2) / 16.0);
    println!("period {period:.5} s, exact {exact:.5} s");
    assert!((period / exact - 1.0).abs() < 0.002, "{period} s, expected {exact} s");
}

#[test]
fn a_slide_falls_to_its_end_and_stays() {
    let (mut world, _) = world("kind = \"prismatic\"\naxis = [0, 0, 1]\nlimits = [0.0, 0.3]", "[0.2, 0.0, -1.0]");
    run(&mut world, 0.1);
    let JointState { position, speed } = arm(&world);
    assert!((speed - 0.981).abs() < 0.02 && (position - 0.5 * 9.81 * 0.01).abs() < 0.002, "{position} m, {speed} m/s");
    run(&mut world, 2.0);
    let JointState { position, speed } = arm(&world);
    assert!((position - 0.3).abs() < 0.001 && speed.abs() < 0.001, "{position} m, {speed} m/s");
}

const SERVO: &str = "kind = \"revolute\"\naxis = [0, 1, 0]\nlimits = [-1.0, 1.5]\nmax_speed = 0.5\nmax_torque = 20\n\
                     gain = 5\nstiffness = 500";

#[test]
fn a_servo_goes_to_its_target_no_faster_than_it_may_and_gives_way_by_torque_over_stiffness() {
    let (mut world, robot) = world(SERVO, "[0.2, 0.0, -1.0]");
    run(&mut world, 1.0);
    let sag = 0.5 * 9.81 * 0.2 / 500.0;
    // About y, right-handed with z down, a positive angle lifts a link that is ahead.
    assert!((arm(&world).position + sag).abs() < 0.1 * sag, "{:?}, expected a sag of {sag}", arm(&world));
    apply(&mut world, robot, "SET {Type Joint} {Name arm} {Opcode Angle} {Params 0.8}");
    run(&mut world, 1.0);
    assert!((arm(&world).position - 0.5).abs() < 0.01 && (arm(&world).speed - 0.5).abs() < 0.01, "{:?}", arm(&world));
    run(&mut world, 2.0);
    let expected = 0.8 - sag * 0.8f64.cos();
    assert!((arm(&world).position - expected).abs() < 1e-4, "{:?}, expected {expected}", arm(&world));
}

#[test]
fn a_joint_stops_at_its_limit() {
    let (mut world, robot) = world(SERVO, "[0.2, 0.0, -1.0]");
    apply(&mut world, robot, "SET {Type Joint} {Name AllAngles} {Opcode Target} {Params 5}");
    run(&mut world, 12.0);
    assert!((arm(&world).position - 1.5).abs() < 0.01 && arm(&world).speed.abs() < 1e-3, "{:?}", arm(&world));
}

#[test]
fn dry_friction_slows_what_slides_by_the_same_at_any_speed_and_holds_what_it_can() {
    let slide = |friction: f64| {
        let joint = "kind = \"prismatic\"\naxis = [0, 0, 1]\nlimits = [0.0, 5.0]\nfriction = ";
        let (mut world, _) = world(&format!("{joint}{friction}"), "[0.2, 0.0, -1.0]");
        // The cart comes to rest first.
        run(&mut world, 0.2);
        let before = arm(&world);
        run(&mut world, 0.2);
        (arm(&world).speed - before.speed, arm(&world).position - before.position)
    };
    // The link weighs 4.905 N.
    for friction in [1.0, 3.0] {
        let ((gained, _), expected) = (slide(friction), (4.905 - friction) / 0.5 * 0.2);
        println!("friction {friction} N: {gained:.5} m/s, expected {expected:.5} m/s");
        assert!((gained / expected - 1.0).abs() < 1e-3, "{friction} N: {gained} m/s, expected {expected} m/s");
    }
    let (_, held) = slide(6.0);
    println!("held: {held:.2e} m");
    assert!(held.abs() < 1e-5, "{held} m");
}

#[test]
fn a_swing_ends_where_dry_friction_holds_it() {
    let (mut world, _) = world("kind = \"continuous\"\naxis = [0, 1, 0]\nfriction = 0.2", "[0.2, 0.0, -1.0]");
    run(&mut world, 10.0);
    // Straight down is at -pi/2. At rest the torque of gravity is not larger than the friction.
    let JointState { position, speed } = arm(&world);
    let torque = 0.5 * 9.81 * 0.2 * position.cos();
    println!("rests at {position:.3} rad with {torque:.3} N m");
    assert!(speed.abs() < 1e-4 && torque.abs() < 0.2 && position < -1.0, "{position} rad, {speed} rad/s, {torque} N m");
}

#[test]
fn a_joint_follows_another_by_where_it_is_or_by_its_target() {
    let follower = |servo: &str, coupling: &str| {
        let joint = format!("kind = \"revolute\"\naxis = [0, 1, 0]\nlimits = [-2.0, 2.0]\n{servo}");
        let second =
            format!("[[joint]]\nname = \"Second\"\nposition = [0.0, 0.0, -1.0]\n{joint}\ncoupling = {coupling}\n");
        let part = "[[part]]\nname = \"Other\"\nlink = \"Second\"\nmass = 0.5\nposition = [0.0, 0.0, -1.0]\n\
                    size = [0.02, 0.02, 0.02]\nmaterial = \"aluminium\"\n";
        // The follower comes first in the file and leads nothing.
        let cart = cart(SERVO, "[0.0, 0.0, -1.0]").replacen("[[joint]]", &format!("{second}[[joint]]"), 1);
        let (mut world, robot) = world_of(&(cart + part));
        apply(&mut world, robot, "SET {Type Joint} {Name Second} {Opcode Angle} {Params 0.9}");
        apply(&mut world, robot, "SET {Type Joint} {Name Arm} {Opcode Angle} {Params 0.6}");
        run(&mut world, 0.6);
        let on_the_way = world.snapshot().robots[0].joints[0].position;
        run(&mut world, 4.0);
        (on_the_way, world.snapshot().robots[0].joints[0].position)
    };
    // The leader moves at 0.5 rad/s.
    let (on_the_way, there) = follower("", "{ joint = \"Arm\", multiplier = -2.0, offset = 0.1 }");
    assert!((on_the_way + 0.5).abs() < 0.02 && (there + 1.1).abs() < 0.001, "{on_the_way}, {there}");
    let servo = "max_speed = 0.5\nmax_torque = 20\ngain = 5\nstiffness = 500";
    let (on_the_way, there) = follower(servo, "{ joint = \"Arm\", multiplier = -1.0, kind = \"target\" }");
    assert!((on_the_way - 0.3).abs() < 0.01 && (there - 0.3).abs() < 0.001, "{on_the_way}, {there}");
}

/// Front wheels on knuckles are both turned to the right by one angle, so some wheels have to slide. The robot drives the circle on which
/// all friction balances, at the speeds that the soft servos permit.
#[test]
fn a_robot_with_steered_wheels_drives_a_circle() {
    let knuckle = |name: &str, y: f64| {
        format!(
            "[[joint]]\nname = \"{name}Steer\"\nkind = \"revolute\"\nposition = [0.2, {y}, 0.0]\naxis = [0, 0, 1]\n\
             limits = [-0.6, 0.6]\nmax_speed = 2\nmax_torque = 200\ngain = 50\nstiffness = 5000\n\
             [[part]]\nname = \"{name}Knuckle\"\nlink = \"{name}Steer\"\nmass = 1\nposition = [0.2, {y}, 0.0]\n\
             size = [0.05, 0.05, 0.05]\nmaterial = \"aluminium\"\ncollides = false\n"
        )
    };
    let cart = CART.split("[[joint]]").next().expect("a cart").replace("-0.25, 0.0]", "-0.1, 0.0]");
    let cart = cart.replace("0.25, 0.0]", "0.1, 0.0]").replace("gain = 50.0", "gain = 1.0");
    let cart = ["FL", "FR"].iter().fold(cart, |cart, name| {
        cart.replace(&format!("name = \"{name}\""), &format!("name = \"{name}\"\nlink = \"{name}Steer\""))
    });
    let (mut world, robot) = world_of(&(cart + &knuckle("FL", -0.1) + &knuckle("FR", 0.1)));
    apply(&mut world, robot, "SET {Type Joint} {Name AllJoints} {Opcode Angle} {Params 0.3}");
    run(&mut world, 1.0);
    apply(&mut world, robot, "DRIVE {Left 3} {Right 3}");
    run(&mut world, 2.0);
    let at = |world: &World| world.snapshot().robots[0].body;
    let (from, steps) = (at(&world), 1000);
    let (mut way, mut last) = (0.0, from.pose.translation.vector);
    for _ in 0..steps {
        world.step();
        let now = at(&world).pose.translation.vector;
        (way, last) = (way + (now - last).norm(), now);
    }
    let turned = (from.pose.rotation.inverse() * at(&world).pose.rotation).euler_angles().2;
    let snapshot = &world.snapshot().robots[0];
    let own = snapshot.body.pose.inverse();
    let (_, wheels) = world.state(robot).expect("the robot is there");
    let contacts = snapshot.contacts.iter().map(|contact| {
        let at = own * nalgebra::Point3::from(contact.point);
        let number = usize::from(at.x < 0.0) * 2 + usize::from(at.y > 0.0);
        let (sin, cos) = if at.x > 0.0 { 0.3f64.sin_cos() } else { (0.0, 1.0) };
        let speed = 0.1 * wheels[number].speed;
        let (position, rolling, friction) = ([at.x, at.y], [speed * cos, speed * sin], -contact.force.z);
        kinematics::coulomb::Contact { position, rolling, friction, along: None }
    });
    let twist = kinematics::coulomb::quasi_static(&contacts.collect::<Vec<_>>());
    let (radius, expected) = (way / turned, twist.forward.hypot(twist.right) / twist.clockwise);
    println!("radius {radius:.3} m, expected {expected:.3} m");
    assert!((radius / expected - 1.0).abs() < 0.01, "{radius} m, expected {expected} m");
}

#[test]
fn a_set_that_names_no_joint_moves_none() {
    let (mut world, robot) = world(SERVO, "[0.2, 0.0, -1.0]");
    for line in [
        "SET {Type joint} {Name Arm} {Opcode Angle} {Params 0.8}",
        "SET {Type Joint} {Name Arm} {Opcode angle} {Params 0.8}",
        "SET {Type Joint} {Name Leg} {Opcode Angle} {Params 0.8}",
        "SET {Type Joint} {Name Arm} {Opcode Angle} {Params up}",
        "SET {Type Joint} {Name FL} {Opcode Angle} {Params 5}",
    ] {
        apply(&mut world, robot, line);
    }
    run(&mut world, 1.0);
    assert!(world.snapshot().robots[0].joints.iter().all(|joint| joint.position.abs() < 0.01));
}

#[test]
fn what_a_link_weighs_counts() {
    let (world, _) = world("kind = \"fixed\"", "[0.2, 0.0, -1.0]");
    let def = &world.def().robots["Cart"];
    assert_eq!(def.mass(), 204.5);
    assert!((def.total_mass().mass - 204.5).abs() < 1e-9);
    // A fixed joint has no value.
    assert_eq!(world.snapshot().robots[0].joints.len(), 4);
}

#[test]
fn a_joint_that_makes_no_sense_is_refused_with_the_nearest_name() {
    let check = |joint: &str, expected: &str| {
        let error = load(&cart(joint, "[0.2, 0, -1]")).map(|_| ()).expect_err(expected);
        let lines: Vec<&str> = error.lines().collect();
        let is_one = lines.len() == 1 && lines[0].contains(expected) && lines[0].contains("robot.toml:");
        assert!(is_one, "{error}\nexpected one line: {expected}");
    };
    check("kind = \"revolut\"\nlimits = [0, 1]", "`kind` is `revolut`: expected one of fixed, revolute");
    check("kind = \"revolut\"\nlimits = [0, 1]", "(did you mean `revolute`?)");
    check("kind = \"fixed\"\nparent = \"bodi\"", "(did you mean `body`?)");
    check("kind = \"revolute\"", "no `limits`");
    check("kind = \"revolute\"\nlimits = [1, 0]", "expected the least first");
    check("kind = \"continuous\"\nlimits = [0, 1]", "`limits` of a joint without ends");
    check("kind = \"continuous\"\naxis = [0, 0, 0]", "`axis` has the length NaN");
    check("kind = \"continuous\"\nmax_speed = 1\ngain = 1", "missing `max_torque`");
    check("kind = \"continuous\"\ngain = 1\nmax_torque = 1\nmax_speed = -1", "`max_speed` is -1");
    check("kind = \"continuous\"\nfriction = -1", "`friction` is -1");
    check("kind = \"continuous\"\ncoupling = { joint = \"Amr\", multiplier = 1 }", "(did you mean `Arm`?)");
    check("kind = \"continuous\"\ncoupling = { joint = \"Arm\", multiplier = 1 }", "link Arm: it follows link 1");
    check(&format!("{SERVO}\ncoupling = {{ joint = \"Arm\", multiplier = 1 }}"), "a motor of a joint that is moved by");
    check(
        &format!("{SERVO}\ncoupling = {{ joint = \"Arm\", multiplier = 1, kind = \"mimc\" }}"),
        "(did you mean `mimic`?)",
    );
    check(
        "kind = \"continuous\"\ncoupling = { joint = \"Arm\", multiplier = 1, kind = \"target\" }",
        "expected a motor with a `stiffness`",
    );
    check("kind = \"ball\"\ngain = 1\nmax_torque = 1\nmax_speed = 1", "a motor of a joint that has no axis");
}

#[test]
fn a_caster_hangs_on_the_link_that_it_names() {
    let with_caster = |link: &str| {
        let ball = "position = [0.3, 0.0, 0.05]\nradius = 0.05\nmass = 0.2\nmaterial = \"nylon\"\n";
        load(&format!(
            "{}[[caster]]\nname = \"Ball\"\nlink = \"{link}\"\n{ball}",
            cart("kind = \"fixed\"", "[0.2, 0, -1]")
        ))
    };
    let def = &with_caster("Arm").unwrap_or_else(|error| panic!("{error}")).robots["Cart"];
    let parent =
        def.links.iter().find(|link| link.name == "Ball").and_then(|link| link.joint.as_ref()).map(|it| it.parent);
    assert_eq!(parent.map(|number| def.links[number].name.as_str()), Some("Arm"));
    let error = with_caster("Amr").map(|_| ()).expect_err("an unknown link");
    assert!(error.ends_with("(did you mean `Arm`?)"), "{error}");
}

#[test]
fn what_is_wrong_with_every_wheel_is_said_once_and_a_wrong_name_with_the_nearest() {
    let errors = |wrong: &str, right: &str| {
        let cart = cart("kind = \"fixed\"", "[0.2, 0, -1]").replacen(right, wrong, 1);
        let error = load(&cart).map(|_| ()).expect_err(wrong);
        error.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    for (wrong, right, suggested) in [
        ("material = \"rubber\"", "material = \"rubber-tyre\"", "(did you mean `rubber-tyre`?)"),
        ("gian = 50", "gain = 50", "(did you mean `gain`?)"),
        ("side = \"lefft\"", "side = \"left\"", "(did you mean `left`?)"),
        ("sttering = \"skid\"", "steering = \"skid\"", "(did you mean `steering`?)"),
        ("link = \"Amr\"", "link = \"Arm\"", "(did you mean `Arm`?)"),
    ] {
        let errors = errors(wrong, right);
        let said = errors.iter().filter(|line| line.ends_with(suggested)).count();
        assert_eq!(said, 1, "{wrong}: {errors:#?}");
    }
    // The gain is missing in [wheels], which all four wheels share.
    assert_eq!(errors("", "gain = 50.0").len(), 1);
    let nothing_near = errors("material = \"unobtainium\"", "material = \"rubber-tyre\"");
    assert!(nothing_near.len() == 1 && !nothing_near[0].contains("perhaps"), "{nothing_near:?}");
}

/// A log's scene is checked by the rules of a file.
#[test]
fn a_tree_that_is_none_is_refused_by_name() {
    let (world, _) = world(SERVO, "[0.2, 0.0, -1.0]");
    let check = |change: fn(&mut scene::RobotDef), expected: &str| {
        let mut def = world.def().clone();
        change(def.robots.get_mut("Cart").expect("the cart"));
        assert_eq!(def.check().map_err(|problem| problem.to_string()), Err(expected.to_owned()));
    };
    check(|it| joint(it, 1).parent = 1, "robot Cart, link Arm: its parent is link 1: expected one of the 1 before it");
    check(|it| it.links[1].joint = None, "robot Cart, link Arm: no joint: expected one to a parent");
    check(|it| it.links.clear(), "robot Cart: no part: expected at least one with a mass");
    check(
        |it| it.links[0].joint = it.links[1].joint.clone(),
        "robot Cart, link body: a joint: expected none of the first link, which is the root",
    );
    check(
        |it| it.links[1].parts.clear(),
        "robot Cart, link Arm: expected at least one part with a mass, or a wheel without other parts",
    );
    let wheel = "robot Cart, link FL: a wheel's joint: expected a continuous one with a motor about the left, a belt, or a ball";
    check(|it| joint(it, 2).axis = [0.0, 1.0, 0.0], wheel);
    check(|it| joint(it, 2).drive = None, wheel);
    check(|it| joint(it, 1).axis = [0.0, 2.0, 0.0], "robot Cart, link Arm: `axis` has the length 2: expected 1");
    check(
        |it| joint(it, 1).damping = f64::NAN,
        "robot Cart, link Arm: `damping` is NaN: expected 0 to 1000000 N m s/rad",
    );
    check(|it| it.links.extend(vec![it.links[1].clone(); 150]), "robot Cart: 156 links: expected at most 150");
}

fn joint(robot: &mut scene::RobotDef, link: usize) -> &mut scene::Joint {
    robot.links[link].joint.as_mut().expect("a joint")
}
