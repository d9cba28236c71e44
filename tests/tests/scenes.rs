//! Files become the scenes that they describe.

use std::path::Path;

use gamebots_proto::Command;
use scene::{Shape, Side, WorldDef};
use sim_core::{Options, World};
use system_tests::{command, copy_robot, run};

/// Masses and positions of the thesis's Appendix A, through URDF (z up) into the robot frame (z down).
#[test]
fn the_youbot_is_that_of_the_thesis() {
    let youbot = scene_loader::robot("KUKA_YouBot", &[]).expect("a built-in robot");
    let mut parts: Vec<(&str, f64)> = youbot.parts().map(|part| (part.name.as_str(), part.mass)).collect();
    parts.sort_by(|a, b| a.0.cmp(b.0));
    let expected = [
        ("ArmBase", 1.0),
        ("ArmJoint_1", 1.0),
        ("ArmJoint_2", 1.0),
        ("ArmJoint_3", 1.0),
        ("Plate", 1.0),
        ("kukabody", 8.6),
    ];
    assert_eq!(parts, expected);
    assert!((youbot.mass() - 20.0).abs() < 1e-4);
    let places = [(0.2355, -0.15), (0.2355, 0.15), (-0.2355, -0.15), (-0.2355, 0.15)];
    for ((wheel, (x, y)), hand) in youbot.wheels().zip(places).zip([1.0, -1.0, -1.0, 1.0]) {
        let place = wheel.position;
        assert!(
            [place[0] - x, place[1] - y, place[2] + 0.03].iter().all(|error: &f64| error.abs() < 1e-9),
            "{place:?}"
        );
        assert_eq!(wheel.side, if y < 0.0 { Side::Left } else { Side::Right });
        let rollers = wheel.rollers.as_ref().expect("rollers");
        assert_eq!((rollers.count, rollers.axis_circle, wheel.radius), (6, 0.036, 0.05));
        assert!(rollers.angle * hand > 0.0 && rollers.material.friction == 0.9);
        let motor = wheel.drive.as_ref().expect("a motor");
        assert!((motor.max_speed - 2.0 * std::f64::consts::TAU).abs() < 1e-9);
    }
}

/// Torque limit and armature follow from gear, torque constant, current and rotor inertia.
#[test]
fn the_real_youbot_has_geared_motors() {
    let youbot = scene_loader::robot("YouBot", &[]).expect("a built-in robot");
    assert!((youbot.mass() - 20.0).abs() < 0.01, "{}", youbot.mass());
    let motor = youbot.wheels().next().and_then(|wheel| wheel.drive).expect("a motor");
    assert_eq!(motor.max_speed, 14.81);
    assert!((motor.max_torque - 25.838 * 0.0335 * 2.32).abs() < 1e-9, "{}", motor.max_torque);
    assert!((motor.armature - 1.35e-5 * 25.838 * 25.838).abs() < 1e-12, "{}", motor.armature);
}

/// A tetrahedron with three edges of 10 cm at right angles, as a text STL.
const STL: &str = "solid t
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0.1 0
vertex 0.1 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0 0.1
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 0.1
vertex 0 0.1 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0.1 0 0
vertex 0 0.1 0
vertex 0 0 0.1
endloop
endfacet
endsolid t
";

const URDF: &str = r#"<robot name="cart">
  <link name="base">
    <inertial><origin xyz="0.1 0.2 0.3"/><mass value="4"/>
      <inertia ixx="1" ixy="0.1" ixz="0.2" iyy="2" iyz="0.3" izz="2.5"/></inertial>
  </link>
  <link name="mast">
    <inertial><mass value="2"/><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>
    <collision><geometry><mesh filename="package://t.stl"/></geometry></collision>
  </link>
  <joint name="fix" type="fixed">
    <origin xyz="0 0.5 1" rpy="0 0 1.5707963267948966"/><parent link="base"/><child link="mast"/>
  </joint>
  <link name="right"><inertial><mass value="0.5"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="right_wheel" type="continuous">
    <origin xyz="0.1 -0.2 0.05"/><parent link="base"/><child link="right"/><limit effort="3" velocity="7"/>
  </joint>
</robot>"#;

const CART: &str = r#"description = "a cart"
steering = "skid"
urdf = "cart.urdf"
urdf_material = "aluminium"

[wheels]
radius = 0.1
width = 0.05
material = "rubber-tyre"
gain = 10.0

[[wheel]]
name = "Right"
side = "right"
joint = "right_wheel"
"#;

/// x stays, y and z change their signs. A link that is turned by a quarter about z up has its x axis along y left.
#[test]
fn a_urdf_is_turned_into_the_robot_frame_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().join("cart.v2");
    std::fs::create_dir(&folder).expect("a folder");
    for (name, text) in [("t.stl", STL), ("cart.urdf", URDF), ("robot.toml", CART)] {
        std::fs::write(folder.join(name), text).expect("a file");
    }
    let def = scene_loader::load("rough", &[&folder.join("robot.toml")]).unwrap_or_else(|error| panic!("{error}"));
    // A dot in the class name would end it: USARBot.cart.v2 would be read as USARBot.cart.
    let cart = &def.robots["cart_v2"];
    let base = &cart.links[0].parts[0];
    assert!((base.centre - nalgebra::Vector3::new(0.1, -0.2, -0.3)).norm() < 1e-12, "{}", base.centre);
    let inertia = nalgebra::Matrix3::new(1.0, -0.1, -0.2, -0.1, 2.0, 0.3, -0.2, 0.3, 2.5);
    assert!((base.inertia - inertia).norm() < 1e-12, "{}", base.inertia);
    let mast = &cart.links[0].parts[1];
    assert!((mast.centre - nalgebra::Vector3::new(0.0, -0.5, -1.0)).norm() < 1e-12, "{}", mast.centre);
    assert!((mast.inertia.diagonal() - nalgebra::Vector3::new(2.0, 1.0, 3.0)).norm() < 1e-12, "{}", mast.inertia);
    let Shape::Hull { points } = &cart.body_solids()[0].shape else { panic!("{:?}", cart.body_solids()[0].shape) };
    let tips: Vec<_> =
        points.iter().map(|&point| cart.body_solids()[0].pose() * nalgebra::Point3::from(point)).collect();
    // The tip along the mast's x is to the robot's left, the one along its z is up.
    for (x, y, z) in [(0.0, -0.6, -1.0), (0.0, -0.5, -1.1), (-0.1, -0.5, -1.0)] {
        let tip = nalgebra::Point3::new(x, y, z);
        assert!(tips.iter().any(|point| (point - tip).norm() < 1e-6), "no tip at {tip}: {tips:?}");
    }
    let wheel = cart.wheels().next().expect("a wheel");
    let motor = wheel.drive.as_ref().expect("a motor");
    assert_eq!((wheel.mass, motor.max_speed, motor.max_torque), (0.5, 7.0, 3.0));
    assert!(wheel.position.iter().zip([0.1, 0.2, -0.05]).all(|(a, b): (&f64, f64)| (a - b).abs() < 1e-12));
}

/// A robot on a mesh stands as high as the mesh is there.
#[test]
fn meshes_of_a_map_are_stood_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let plate = "v -2 -2 0.3\nv 2 -2 0.3\nv 2 2 0.3\nv -2 2 0.3\nf 1 2 3 4\n";
    let map = r#"description = "a plate in the air"
[[mesh]]
name = "plate"
material = "carpet"
file = "plate.obj"
scale = 2.0
[[start]]
name = "Start"
position = [0, 0, 0]
"#;
    std::fs::write(folder.path().join("plate.obj"), plate).expect("a file");
    std::fs::write(folder.path().join("map.toml"), map).expect("a file");
    let path = folder.path().join("map.toml");
    let def = scene_loader::load(path.to_str().expect("a path"), &[]).unwrap_or_else(|error| panic!("{error}"));
    for class in ["KUKA_YouBot", "P3AT"] {
        let mut world = World::new(def.clone(), Options::default());
        let Command::Init(init) = command(&format!("INIT {{ClassName {class}}} {{Start Start}}")) else {
            panic!("INIT")
        };
        let robot = world.init(&init, &mut Vec::new()).expect("a robot");
        run(&mut world, 1.0);
        let height = -world.state(robot).expect("the robot").0.pose.translation.z;
        let own = if class == "P3AT" { 0.146 } else { 0.02 };
        assert!((height - 0.6 - own).abs() < 0.003, "{class} stands at {height}");
    }
}

/// A map's own material is added to the common ones, or replaces one of them. A colour belongs to a single solid.
#[test]
fn a_map_has_materials_and_colours_of_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("map.toml");
    let start = "[[start]]\nname = \"S\"\nposition = [0, 0, 0]\n";
    let write = |map: &str| std::fs::write(&path, format!("description = \"m\"\n{map}{start}")).expect("a file");
    let floor =
        |material: &str, more: &str| format!("[[half_space]]\nname = \"floor\"\nmaterial = \"{material}\"\n{more}");
    write(&format!(
        "[material.mud]\nfriction = 0.3\nrolling_resistance = 0.1\n{}",
        floor("mud", "colour = [0.3, 0.2, 0.1]\n")
    ));
    let got = |overrides: &[&str]| {
        let overrides: Vec<_> = overrides.iter().map(|text| text.parse().expect("an override")).collect();
        let map = scene_loader::map(path.to_str().expect("a path"), &overrides);
        let material = map.unwrap_or_else(|error| panic!("{error}")).solids[0].material.clone();
        (material.friction, material.rolling_resistance, material.colour)
    };
    assert_eq!(got(&[]), (0.3, 0.1, [0.3, 0.2, 0.1]));
    assert_eq!(got(&["map.material.mud.friction=0.5"]).0, 0.5);
    write(&format!("[material.carpet]\nfriction = 0.2\n{}", floor("carpet", "")));
    assert_eq!(got(&[]), (0.2, 0.0, [0.6; 3]));

    let refused = |map: &str, expected: &str| {
        write(map);
        let error = scene_loader::check(&path).expect_err("a mistake").to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(&format!("[material.mud]\nfriction = -1.0\n{}", floor("mud", "")), ":2:11: `friction` is -1");
    refused(&format!("[material.mud]\n{}", floor("mud", "")), "missing field `friction`");
    refused(&format!("material = 3\n{}", floor("carpet", "")), "expected a table");
    refused(&floor("carpet", "colour = [2, 0, 0]\n"), "`colour` is [2, 0, 0]: expected numbers of 0 to 1");
}

#[test]
fn a_mesh_that_is_missing_or_broken_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let check = |file: &str, expected: &str| {
        let map = format!(
            "description = \"m\"\n[[mesh]]\nname = \"m\"\nmaterial = \"carpet\"\nfile = \"{file}\"\n\
             [[start]]\nname = \"S\"\nposition = [0, 0, 0]\n"
        );
        let path = folder.path().join("map.toml");
        std::fs::write(&path, map).expect("a file");
        let error = scene_loader::check(Path::new(&path)).expect_err("a mistake").to_string();
        assert!(error.contains(":2:1: ") && error.contains(expected), "{error}");
    };
    std::fs::write(folder.path().join("bad.stl"), "hello").expect("a file");
    std::fs::write(folder.path().join("empty.obj"), "v 0 0 0\n").expect("a file");
    check("none.stl", "cannot be read");
    check("bad.stl", "mesh `bad.stl`");
    check("empty.obj", "has 0 triangles: expected 1 to");
    check("thing.fbx", "expected a file that ends in .stl, .obj, .dae, .glb or .gltf");
}

/// Webots' rollers, from the youBot's CAD, are 74.5 mm long. The minimum without a gap is 64.8 mm.
#[test]
fn the_length_of_rollers_is_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let toml = include_str!("../../assets/robots/YouBot/robot.toml");
    copy_robot("YouBot", folder.path());
    let path = folder.path().join("robot.toml");
    let load = |half_length: f64| {
        let text = toml.replace("axis_circle =", &format!("half_length = {half_length}\naxis_circle ="));
        std::fs::write(&path, text).expect("a file");
        scene_loader::robot(path.to_str().expect("a path"), &[])
    };
    let long = load(0.03727).unwrap_or_else(|error| panic!("{error}"));
    let rollers = long.links[1].wheel.as_ref().and_then(|wheel| wheel.rollers.as_ref()).expect("rollers");
    assert!((rollers.half_length_at(rollers.last_phase, 0.05) - 0.03727).abs() < 1e-6, "{}", rollers.last_phase);
    for wrong in [0.02, 0.06] {
        let error = load(wrong).expect_err("a mistake").to_string();
        assert!(error.contains(&format!("`half_length` is {wrong}: expected 0.03237 (no gap) to")), "{error}");
    }
}

#[test]
fn overrides_reach_robots_maps_and_materials() {
    let overrides = [
        "robot.roller_friction=0.7",
        "KUKA_YouBot.link.kukabody.mass=4.6",
        "map.gravity=1.62",
        "material.carpet.friction=0.4",
        "robot.wheel.FLWheel.gain=2.5",
    ]
    .map(|text| text.parse().unwrap_or_else(|error| panic!("{text}: {error}")));
    let def = scene_loader::load_with("rough", &[], &overrides).unwrap_or_else(|error| panic!("{error}"));
    let youbot = &def.robots["KUKA_YouBot"];
    let gains: Vec<f64> = youbot.wheels().filter_map(|wheel| Some(wheel.drive?.gain)).collect();
    assert_eq!(gains, [2.5, 4.0, 4.0, 4.0]);
    assert!(youbot.wheels().flat_map(|wheel| &wheel.wheel.rollers).all(|rollers| rollers.material.friction == 0.7));
    assert!((youbot.mass() - 16.0).abs() < 1e-4, "{}", youbot.mass());
    assert_eq!((def.map.gravity, def.map.solids[0].material.friction), (1.62, 0.4));
    for text in ["robot.wheels.gian=1", "robot.wheels.gain=-1", "P3AT.rollers.mass=1", "material.carpet.friction=99"] {
        let set = text.parse().unwrap_or_else(|error| panic!("{text}: {error}"));
        assert!(scene_loader::load_with("rough", &[], &[set]).is_err(), "{text}");
    }
}

/// A log holds its scene, and a replay needs it bit by bit.
#[test]
fn definitions_written_as_json_read_back_the_same() {
    for map in scene_loader::map_names() {
        let def = scene_loader::load(&map, &[]).unwrap_or_else(|error| panic!("{error}"));
        let text = serde_json::to_string(&def).expect("JSON");
        let back: WorldDef = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{map}: {error}"));
        assert!(back == def, "{map}");
        println!("{map}: {} bytes", text.len());
    }
}
