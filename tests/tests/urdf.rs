//! Robots from URDF: the tree that the file has, with what it weighs, how it moves and what is seen of it.

use nalgebra::{Point3, Vector3};
use scene::{JointKind, JointState, RobotDef};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// A base with wheels, a lift that turns with it, an arm on the lift, two fingers of which one follows, and a flag that swings.
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

/// The cart of such a URDF, in a package as ROS has them.
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
    for part in ["2 <transmission> not looked at", "1 <gazebo> not looked at", "none.dae", "not drawn"] {
        assert!(said.contains(part), "{said}");
    }
}

/// Worked out by hand in the axes of the URDF: the fingers' middle is 0.4 m ahead of the shoulder.
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
    // Ahead is forward of the column, which turned to the left; the shoulder turns about the column's left, so ahead goes down.
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
    // 1.2 kg at 0.23 m on 2000 N m/rad.
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
    check(
        "mimic joint=\"left_finger\"",
        "mimic joint=\"mast_joint\"",
        "arm.urdf:38:3: joint right_finger: it mimics mast_joint",
    );
    check(
        "lower=\"-2\" upper=\"2\"",
        "lower=\"2\" upper=\"-2\"",
        "joint turn: `limits` are 2 and -2: expected the least first",
    );
    check("friction=\"0.25\"", "friction=\"-1\"", "joint turn: `friction` is -1");
    check("name=\"flag\"", "name=\"turn\"", "second joint `turn`");
    check(
        "<inertial><origin xyz=\"0 0 -0.1\"/><mass value=\"0.2\"/>",
        "<inertial><mass value=\"0\"/>",
        "joint flag: expected at least one part with a mass",
    );
}
