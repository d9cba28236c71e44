//! Robots from URDF: the file's tree, with its masses, joints and visuals.

use nalgebra::{Point3, Vector3};
use scene::{JointKind, JointState, Link, RobotDef, Shape, Steering};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// A base with wheels, a lift that turns with it, an arm on the lift, two coupled fingers, and a flag that swings.
const ARM: &str = r#"<?xml version="1.0"?>
<robot name="arm">
  <material name="green"><color rgba="0.1 0.7 0.2 1"/></material>
  <link name="base">
    <inertial><origin xyz="0 0 0.1"/><mass value="60"/>
      <inertia ixx="2" ixy="0" ixz="0" iyy="3" iyz="0" izz="4"/></inertial>
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.6 0.4 0.1"/></geometry></collision>
  </link>
  <joint name="turn" type="revolute">
    <origin xyz="0.1 0 0.2" rpy="0 0 1.5707963267948966"/><parent link="base"/><child link="column"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="40" velocity="1.5"/>
    <dynamics damping="0.5" friction="0.25"/>
  </joint>
  <link name="column">
    <inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <visual><geometry><cylinder radius="0.05" length="0.3"/></geometry><material name="green"/></visual>
    <visual><geometry><mesh filename="package://arm_description/meshes/part.obj"/></geometry></visual>
    <visual><geometry><mesh filename="package://arm_description/meshes/none.dae"/></geometry></visual>
  </link>
  <joint name="mast_joint" type="fixed"><origin xyz="0 0 0.3"/><parent link="column"/><child link="mast"/></joint>
  <link name="mast">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="mast"/><child link="upper"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="40" velocity="1"/>
  </joint>
  <link name="upper">
    <inertial><origin xyz="0 -0.2 0"/><mass value="1"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <joint name="left_finger" type="prismatic">
    <origin xyz="0.02 -0.4 0"/><parent link="upper"/><child link="left"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.1"/>
  </joint>
  <link name="left"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="right_finger" type="prismatic">
    <origin xyz="-0.02 -0.4 0"/><parent link="upper"/><child link="right"/>
    <axis xyz="-1 0 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.1"/>
    <mimic joint="left_finger"/>
  </joint>
  <link name="right"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <joint name="flag" type="continuous">
    <origin xyz="-0.2 0 0.5"/><parent link="base"/><child link="cloth"/><axis xyz="0 1 0"/>
  </joint>
  <link name="cloth"><inertial><origin xyz="0 0 -0.1"/><mass value="0.2"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
  <transmission name="t1"/><transmission name="t2"/><gazebo/>
</robot>"#;

const CART: &str = r#"description = "a cart with an arm"
steering = "skid"
urdf = "arm.urdf"
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
"#;

/// Loads the cart of such a URDF, in a package as in ROS.
fn load(urdf: &str) -> Result<scene::WorldDef, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let package = folder.path().join("arm_description");
    for part in ["urdf", "meshes"] {
        std::fs::create_dir_all(package.join(part)).expect("a folder");
    }
    std::fs::write(package.join("urdf/arm.urdf"), urdf).expect("a file");
    std::fs::write(package.join("urdf/Cart.toml"), CART).expect("a file");
    std::fs::write(package.join("meshes/part.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a file");
    scene_loader::load("rough", &[&package.join("urdf/Cart.toml")]).map_err(|error| error.to_string())
}

fn cart(world: &scene::WorldDef) -> &RobotDef {
    &world.robots["Cart"]
}

fn joint<'a>(def: &'a RobotDef, name: &str) -> &'a scene::Joint {
    let link = def.links.iter().find(|link| link.name == name).unwrap_or_else(|| panic!("no {name}"));
    link.joint.as_ref().expect("a joint")
}

#[test]
fn joints_have_the_axes_limits_servos_and_friction_of_the_file() {
    let world = load(ARM).unwrap_or_else(|error| panic!("{error}"));
    let def = cart(&world);
    let names: Vec<&str> = def.links.iter().map(|link| link.name.as_str()).collect();
    let moving = ["turn", "shoulder", "left_finger", "right_finger", "flag"];
    assert!(names[0] == "body" && moving.iter().all(|name| names.contains(name)), "{names:?}");
    let turn = joint(def, "turn");
    assert_eq!(
        (turn.kind, turn.limits, turn.damping, turn.friction),
        (JointKind::Revolute, Some([-2.0, 2.0]), 0.5, 0.25)
    );
    let near = |a: [f64; 3], b: [f64; 3]| (Vector3::from(a) - Vector3::from(b)).norm() < 1e-9;
    assert!(near(turn.axis, [0.0, 0.0, -1.0]) && near(turn.anchor, [0.1, 0.0, -0.2]), "{turn:?}");
    // The column is turned by a quarter, so its x axis is the robot's left.
    assert!(near(joint(def, "shoulder").axis, [0.0, -1.0, 0.0]), "{:?}", joint(def, "shoulder"));
    let motor = turn.drive.as_ref().expect("a servo");
    assert_eq!((motor.max_torque, motor.max_speed), (40.0, 1.5));
    assert!(joint(def, "flag").drive.is_none() && joint(def, "right_finger").drive.is_none());
    let coupling = joint(def, "right_finger").coupling.expect("a coupling");
    assert_eq!((def.links[coupling.leader].name.as_str(), coupling.multiplier), ("left_finger", 1.0));
    // Mast and column are one link.
    let column = def.links.iter().find(|link| link.name == "turn").expect("a link");
    assert_eq!(column.parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>(), ["column", "mast"]);
    assert_eq!(column.visuals.len(), 2, "{:?}", column.visuals);
    assert_eq!(column.visuals[0].colour, [0.1, 0.7, 0.2]);
    let said = def.assumptions.join("\n");
    for part in ["2 <transmission> not used", "1 <gazebo> not used", "none.dae", "not drawn"] {
        assert!(said.contains(part), "{said}");
    }
}

/// Worked out by hand in the axes of the URDF: the middle of the fingers is 0.4 m ahead of the shoulder.
#[test]
fn an_arm_is_where_its_joints_put_it() {
    let world = load(ARM).unwrap_or_else(|error| panic!("{error}"));
    let def = cart(&world);
    let state = |name: &str| JointState {
        position: match name {
            "turn" => 0.6,
            "shoulder" => 0.5,
            "left_finger" => 0.03,
            _ => 0.0,
        },
        speed: 0.0,
    };
    let joints: Vec<JointState> = def.with_values().map(|link| state(&link.name)).collect();
    let placed = def.placed_links(&joints);
    let (_, pose) = placed.iter().find(|(link, _)| link.name == "left_finger").expect("a finger");
    // Ahead is forward of the column, which turned to the left. The shoulder turns about the column's left, so the arm goes down.
    let (ahead, left) = (Vector3::new(0.6f64.cos(), 0.6f64.sin(), 0.0), Vector3::new(-0.6f64.sin(), 0.6f64.cos(), 0.0));
    let forward = 0.4 * 0.5f64.cos() * ahead - 0.4 * 0.5f64.sin() * Vector3::z();
    let expected = Vector3::new(0.1, 0.0, 0.5) + forward + left * (0.02 + 0.03);
    let got = pose * Point3::origin();
    let got = Vector3::new(got.x, -got.y, -got.z);
    assert!((got - expected).norm() < 1e-9, "{got:?}, expected {expected:?}");
}

#[test]
fn its_servos_hold_move_and_lead() {
    let world = load(ARM).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(world, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.Cart} {Location 0,0,0}");
    run(&mut world, 1.0);
    let value = |world: &World, name: &str| {
        let def = cart(world.def());
        let number = def.with_values().position(|link| link.name == name).expect("a joint");
        world.snapshot().robots[0].joints[number].position
    };
    // The sag of 1.2 kg at 0.23 m on 2000 N m/rad.
    assert!(value(&world, "shoulder").abs() < 0.005, "{}", value(&world, "shoulder"));
    for (name, target) in [("turn", 1.0), ("shoulder", -0.5), ("left_finger", 0.03), ("right_finger", 0.01)] {
        apply(&mut world, robot, &format!("SET {{Type Joint}} {{Name {name}}} {{Opcode Angle}} {{Params {target}}}"));
    }
    run(&mut world, 3.0);
    for (name, target, tolerance) in
        [("turn", 1.0, 0.002), ("shoulder", -0.5, 0.005), ("left_finger", 0.03, 1e-4), ("right_finger", 0.03, 2e-4)]
    {
        let got = value(&world, name);
        assert!((got - target).abs() < tolerance, "{name}: {got}, expected {target}");
    }
}

#[test]
fn what_is_wrong_with_a_tree_is_said_with_its_line() {
    let check = |from: &str, to: &str, expected: &str| {
        assert!(ARM.contains(from), "{from}");
        let error = load(&ARM.replacen(from, to, 1)).map(|_| ()).expect_err(expected);
        let lines: Vec<&str> = error.lines().collect();
        assert!(lines.len() == 1 && lines[0].contains(expected), "{error}\nexpected one line: {expected}");
    };
    check("friction=\"0.25\"", "friction=\"-1\"", "joint turn: `friction` is -1");
    check("name=\"flag\"", "name=\"turn\"", "second joint `turn`");
    check(
        "<axis xyz=\"0 0 1\"/>",
        "<axis xyz=\"0 0 0\"/>",
        "arm.urdf:11:5: <axis xyz=\"0 0 0\"> is zero: expected a direction, as in xyz=\"0 0 1\"",
    );
    check(
        "<parent link=\"base\"/><child link=\"cloth\"/>",
        "<parent link=\"base\"/><child link=\"left\"/>",
        "arm.urdf:45:3: link `left` has two parents, `upper` by joint `left_finger` and `base` by joint `flag`: expected one; \
         remove one of the joints",
    );
    check(
        "</robot>",
        "<link name=\"more\"/></robot>",
        "arm.urdf:2:1: 2 links without a parent: base, more: expected one",
    );
    check(
        "<parent link=\"base\"/><child link=\"column\"/>",
        "<parent link=\"mast\"/><child link=\"column\"/>",
        "arm.urdf:2:1: link `column`: it is carried in a circle of joints: expected a tree with one root",
    );
    check(
        "<inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"0.2\"/>",
        "<inertial><mass value=\"0\"/>",
        "joint flag: expected at least one part with a mass",
    );
}

#[test]
fn a_zero_axis_of_a_fixed_joint_is_no_mistake() {
    let fixed = "<joint name=\"mast_joint\" type=\"fixed\">";
    let with_axis = format!("{fixed}<axis xyz=\"0 0 0\"/>");
    load(&ARM.replacen(fixed, &with_axis, 1)).unwrap_or_else(|error| panic!("{error}"));
}

/// A robot with two wheels and a ball that slides, like small ROS robots.
const TWO_WHEELS: &str = r#"<?xml version="1.0"?>
<robot name="burger">
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed">
    <parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 0.01"/>
  </joint>
  <link name="base_link">
    <inertial><origin xyz="-0.03 0 0.07"/><mass value="0.8"/>
      <inertia ixx="2e-3" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="1e-3"/></inertial>
    <collision><origin xyz="-0.032 0 0.07"/><geometry><box size="0.14 0.14 0.14"/></geometry></collision>
  </link>
  <joint name="wheel_left_joint" type="continuous">
    <parent link="base_link"/><child link="wheel_left_link"/>
    <origin xyz="0 0.08 0.023" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
  </joint>
  <link name="wheel_left_link">
    <inertial><mass value="0.03"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="2e-5"/></inertial>
    <collision><geometry><cylinder radius="0.033" length="0.018"/></geometry></collision>
  </link>
  <joint name="wheel_right_joint" type="continuous">
    <parent link="base_link"/><child link="wheel_right_link"/>
    <origin xyz="0 -0.08 0.023" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
  </joint>
  <link name="wheel_right_link">
    <inertial><mass value="0.03"/><inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="2e-5"/></inertial>
    <collision><geometry><cylinder radius="0.033" length="0.018"/></geometry></collision>
  </link>
  <joint name="caster_back_joint" type="fixed">
    <parent link="base_link"/><child link="caster_back_link"/><origin xyz="-0.081 0 -0.004"/>
  </joint>
  <link name="caster_back_link">
    <inertial><mass value="0.005"/><inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial>
    <collision><geometry><sphere radius="0.006"/></geometry></collision>
  </link>
  <gazebo reference="wheel_left_link"><mu1>0.1</mu1></gazebo>
</robot>"#;

/// Returns a car: four wheels, two of them on knuckles, with unusual names.
fn car() -> String {
    let link = |name: &str, mass: f64, shape: &str| {
        let inertia = "ixy=\"0\" ixz=\"0\" iyz=\"0\"";
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{0}\" iyy=\"{0}\" izz=\"{0}\" {inertia}/>\
             </inertial>{shape}</link>\n",
            mass * 0.01
        )
    };
    let wheel = "<collision><origin rpy=\"1.5707963 0 0\"/><geometry><cylinder radius=\"0.1\" length=\"0.04\"/></geometry></collision>";
    let body = "<collision><geometry><box size=\"0.6 0.2 0.1\"/></geometry></collision>";
    let mut text = String::from("<robot name=\"car\">\n") + &link("chassis", 20.0, body);
    for (name, x, y) in [("fl", 0.25, 0.1), ("fr", 0.25, -0.1), ("rl", -0.25, 0.1), ("rr", -0.25, -0.1)] {
        let (mut parent, mut origin) = ("chassis".to_owned(), format!("{x} {y} 0"));
        if x > 0.0 {
            text += &link(&format!("{name}_knuckle"), 0.5, "");
            text += &format!(
                "<joint name=\"{name}_steer\" type=\"revolute\"><origin xyz=\"{origin}\"/><parent link=\"chassis\"/>\
                 <child link=\"{name}_knuckle\"/><axis xyz=\"0 0 1\"/>\
                 <limit lower=\"-0.6\" upper=\"0.6\" effort=\"50\" velocity=\"2\"/></joint>\n"
            );
            (parent, origin) = (format!("{name}_knuckle"), "0 0 0".to_owned());
        }
        text += &link(&format!("{name}_wheel"), 1.0, wheel);
        text += &format!(
            "<joint name=\"{name}_spin\" type=\"continuous\"><origin xyz=\"{origin}\"/><parent link=\"{parent}\"/>\
             <child link=\"{name}_wheel\"/><axis xyz=\"0 1 0\"/><limit effort=\"20\" velocity=\"30\"/></joint>\n"
        );
    }
    text + "</robot>"
}

/// Builds a world with a robot from a URDF alone. Returns it with the assumptions made.
fn alone(urdf: &str) -> Result<(World, Vec<String>), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("Robot.urdf");
    std::fs::write(&path, urdf).expect("a file");
    let assumed = scene_loader::check(&path).map_err(|error| error.to_string())?;
    let scene = scene_loader::load("smooth", &[&path]).map_err(|error| error.to_string())?;
    assert_eq!(scene.robots["Robot"].assumptions, assumed);
    Ok((World::new(scene, Options::default()), assumed))
}

#[test]
fn a_urdf_with_two_wheels_is_driven_by_its_sides() {
    let (mut world, assumed) = alone(TWO_WHEELS).unwrap_or_else(|error| panic!("{error}"));
    let robot = init(&mut world, "INIT {ClassName USARBot.Robot} {Location 0,0,0}");
    let def = &world.def().robots["Robot"];
    assert_eq!(def.steering, Steering::Skid);
    let geometry = def.wheel_geometry();
    assert!((geometry.radius - 0.033).abs() < 1e-6 && (geometry.track - 0.16).abs() < 1e-6, "{geometry:?}");
    let said = assumed.join("\n");
    for part in [
        "sides of its wheels",
        "wheel_left_joint, wheel_right_joint",
        "caster_back_link is a caster",
        "1 <gazebo> not used",
    ] {
        assert!(said.contains(part), "{said}");
    }
    run(&mut world, 1.0);
    let before = world.snapshot().robots[0].body;
    assert!(before.pose.rotation.angle() < 0.05, "it stands on its caster: {}", before.pose);
    apply(&mut world, robot, "DRIVE {Left 4} {Right 4}");
    run(&mut world, 1.0);
    let body = world.snapshot().robots[0].body;
    assert!((body.linear.x / (4.0 * 0.033) - 1.0).abs() < 0.02, "{:?}", body.linear);
    apply(&mut world, robot, "DRIVE {Left 4} {Right -4}");
    run(&mut world, 1.0);
    let turn = world.snapshot().robots[0].body.angular.z / (2.0 * 4.0 * 0.033 / 0.16);
    println!("turns at {turn:.4} of its wheels' rate");
    assert!((turn - 1.0).abs() < 0.05, "{turn}");
}

#[test]
fn limits_that_stand_for_none_are_lowered_and_said() {
    let axis = "<axis xyz=\"0 0 1\"/>";
    let limited = format!("{axis}<limit effort=\"1000\" velocity=\"10000\"/>");
    let (world, assumptions) = alone(&TWO_WHEELS.replace(axis, &limited)).unwrap_or_else(|error| panic!("{error}"));
    for expected in [
        "joint wheel_left_joint: velocity in rad/s 10000 is taken as 1000.00, as no robot has more",
        "joint wheel_right_joint: effort in N m 1000 is taken as 13.99, as no robot has more",
    ] {
        assert!(assumptions.iter().any(|it| it == expected), "{expected}: {assumptions:#?}");
    }
    assert_eq!(world.def().check(), Ok(()));
}

#[test]
fn a_urdf_with_knuckles_is_a_car() {
    let (mut world, assumed) = alone(&car()).unwrap_or_else(|error| panic!("{error}"));
    let robot = init(&mut world, "INIT {ClassName USARBot.Robot} {Location 0,0,0}");
    assert_eq!(world.def().robots["Robot"].steering, Steering::Ackermann, "{assumed:?}");
    assert!(
        assumed.iter().any(|it| it.contains("steered as a car by fl_steer_FrontSteer, fr_steer_FrontSteer")),
        "{assumed:?}"
    );
    run(&mut world, 1.0);
    apply(&mut world, robot, "DRIVE {Speed 5} {FrontSteer 0.3} {RearSteer 0}");
    run(&mut world, 2.0);
    // In the URDF a positive angle turns left; DRIVE's turns right.
    let body = world.snapshot().robots[0].body;
    let rear = body.linear - body.angular.cross(&(body.pose.rotation * Vector3::new(0.25, 0.0, 0.0)));
    let (radius, expected) = (rear.norm() / body.angular.z, 0.5 / 0.3f64.tan());
    println!("radius {radius:.3} m, expected {expected:.3} m");
    assert!((radius / expected - 1.0).abs() < 0.03, "{radius} m, expected {expected} m");
}

#[test]
fn a_urdf_without_wheels_is_a_platform_and_xacro_is_named() {
    let (mut world, assumed) = alone(ARM).unwrap_or_else(|error| panic!("{error}"));
    init(&mut world, "INIT {ClassName USARBot.Robot} {Location 0,0,-1}");
    run(&mut world, 1.0);
    assert!(assumed.iter().any(|it| it.contains("fixed to the ground")), "{assumed:?}");
    assert!((world.snapshot().robots[0].body.pose.translation.z + 1.0).abs() < 1e-9);
    let error =
        alone(&ARM.replace("<link name=\"base\">", "<link name=\"${prefix}base\">")).map(|_| ()).expect_err("xacro");
    assert!(error.contains("is of xacro: expected a URDF; expand it first"), "{error}");
}

/// Returns a binary STL of a ball with a number of rings.
fn ball(rings: u32) -> Vec<u8> {
    let corner = |ring: u32, part: u32| {
        let [theta, phi] = [ring, 2 * part].map(|it| (f64::from(it) / f64::from(rings) * std::f64::consts::PI) as f32);
        [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()].map(|it| it * 0.05)
    };
    let mut bytes = vec![0; 80];
    bytes.extend((2 * rings * rings).to_le_bytes());
    for (ring, part) in (0..rings).flat_map(|ring| (0..rings).map(move |part| (ring, part))) {
        for corners in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
            let vertices = corners.map(|(r, p)| corner(ring + r, part + p));
            bytes.extend([[0.0; 3]].iter().chain(&vertices).flatten().flat_map(|it: &f32| it.to_le_bytes()));
            bytes.extend([0, 0]);
        }
    }
    bytes
}

/// Loads the robot of a URDF whose base shows some meshes. Returns it with the assumptions made.
fn with_meshes(files: &[(&str, Vec<u8>)], shown: &[&str]) -> (RobotDef, Vec<String>) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    let visual = |file: &&str| format!("<visual><geometry><mesh filename=\"{file}\"/></geometry></visual>");
    let visuals: String = shown.iter().map(visual).collect();
    let path = folder.path().join("Robot.urdf");
    let body = "<link name=\"base_link\">";
    std::fs::write(&path, TWO_WHEELS.replace(body, &format!("{body}{visuals}"))).expect("a file");
    let robot = scene_loader::robot(&path.display().to_string(), &[]).unwrap_or_else(|error| panic!("{error}"));
    let assumptions = robot.assumptions.iter().map(|it| it.replace(&format!("{}/", folder.path().display()), ""));
    let assumptions = assumptions.collect();
    (robot, assumptions)
}

fn triangles(robot: &RobotDef) -> usize {
    let of_shape = |shape: &Shape| if let Shape::Mesh { triangles, .. } = shape { triangles.len() } else { 0 };
    robot.links.iter().flat_map(|link| &link.visuals).map(|visual| of_shape(&visual.shape)).sum()
}

#[test]
fn a_heavy_urdf_is_drawn_with_fewer_triangles_and_says_so() {
    // Three times 180 000 triangles, and a small mesh that keeps its form.
    let files = [("heavy.stl", ball(300)), ("small.stl", ball(8))];
    let (robot, said) = with_meshes(&files, &["heavy.stl", "small.stl", "heavy.stl", "heavy.stl"]);
    let count = triangles(&robot);
    assert!((100_000..=200_000).contains(&count), "{count}");
    let expected = format!("visuals have 540128 triangles: drawn with {count}, as 200000 are enough");
    assert!(said.contains(&expected), "{expected}: {said:#?}");
    assert_eq!(robot.links[0].visuals.len(), 4);
    let def = scene::WorldDef {
        map: scene_loader::map("smooth", &[]).unwrap_or_else(|error| panic!("{error}")),
        robots: [(robot.class.clone(), robot)].into(),
        ..scene::WorldDef::default()
    };
    assert_eq!(def.check(), Ok(()));
}

#[test]
fn a_link_without_its_meshes_is_drawn_as_its_collision_shape() {
    let huge = {
        let mut bytes = vec![0; 80];
        bytes.extend(1_100_000_u32.to_le_bytes());
        bytes.resize(84 + 50 * 1_100_000, 0);
        bytes
    };
    for (file, bytes, expected) in [
        (
            "none.stl",
            None,
            "link base_link: none.stl: cannot be read: No such file or directory (os error 2): drawn as",
        ),
        ("broken.stl", Some(b"broken".to_vec()), "link base_link: mesh `broken.stl`: "),
        (
            "huge.stl",
            Some(huge),
            "link base_link: mesh `huge.stl` has 1100000 triangles: expected 1 to 1000000: drawn as",
        ),
    ] {
        let files: Vec<_> = bytes.into_iter().map(|bytes| (file, bytes)).collect();
        let (robot, said) = with_meshes(&files, &[file, file]);
        assert!(said.iter().any(|it| it.starts_with(expected)), "{expected}: {said:#?}");
        assert!(said.iter().any(|it| it.ends_with(": drawn as its collision shape")), "{said:#?}");
        let Link { visuals, solids, .. } = &robot.links[0];
        assert_eq!((visuals.len(), &visuals[0].shape), (1, &solids[0].shape), "{file}");
    }
    // Meshes that can be read are still drawn.
    let (robot, said) = with_meshes(&[("small.stl", ball(8))], &["none.stl", "small.stl"]);
    assert!(said.iter().any(|it| it.contains("none.stl") && it.ends_with(": not drawn")), "{said:#?}");
    assert_eq!((robot.links[0].visuals.len(), triangles(&robot)), (1, 128));
}

#[test]
fn the_looks_of_a_hostile_urdf_take_bounded_time_and_memory() {
    // A triangle after 60 MB of comments.
    let mut long = format!("#{}\n", "x".repeat(1 << 20)).repeat(60).into_bytes();
    long.extend(b"v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
    let (robot, said) = with_meshes(&[("long.obj", long)], &["long.obj"; 100]);
    assert_eq!((robot.links[0].visuals.len(), triangles(&robot)), (4, 4));
    let expected = "link base_link: mesh `long.obj`: expected at most 256 MB of meshes in all: not drawn";
    assert_eq!(said.iter().filter(|it| *it == expected).count(), 96, "{said:#?}");
}
