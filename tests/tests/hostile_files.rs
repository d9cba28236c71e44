//! Files and scenes of strangers. Contents that no world can be made of are refused by name. Contents just within the bounds keep every
//! number finite.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use scene::check::{self, Range};
use scene::sensor::Config;
use scene::{
    Battery, Conveyor, DriveModel, HeightField, Joint, JointKind, MapDef, Material, Motor, Object, Part, RobotDef,
    RobotSnapshot, Rollers, Shape, Solid, Steering, Wheel, WorldDef,
};
use sim_core::{Options, World};
use system_tests::{apply, init};

/// Builds a scene with every built-in robot on a map with a mesh, and an object to push.
fn scene() -> WorldDef {
    let mut def = scene_loader::load("arena", &[]).unwrap_or_else(|error| panic!("{error}"));
    let solid = Solid { name: "crate".to_owned(), shape: Shape::Ball { radius: 0.1 }, ..def.map.solids[1].clone() };
    def.map.objects.push(Object { solid, mass: 1.0 });
    def
}

#[test]
fn what_is_shipped_passes() {
    for map in scene_loader::map_names() {
        let def = scene_loader::load(&map, &[]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(def.check(), Ok(()), "{map}");
    }
    assert_eq!(scene().check(), Ok(()));
}

/// A scene from a log has not passed the file reader, so the world checks it itself.
#[test]
fn what_no_world_can_be_made_with_is_refused_by_name() {
    #[track_caller]
    fn check(change: impl FnOnce(&mut WorldDef), expected: &str) {
        let mut def = scene();
        change(&mut def);
        let problem = def.check().expect_err(expected);
        assert_eq!(problem.to_string(), expected);
    }
    let p3at = |change: fn(&mut RobotDef)| move |def: &mut WorldDef| change(def.robots.get_mut("P3AT").expect("P3AT"));
    let p2dx = |change: fn(&mut RobotDef)| move |def: &mut WorldDef| change(def.robots.get_mut("P2DX").expect("P2DX"));
    let youbot =
        |change: fn(&mut RobotDef)| move |def: &mut WorldDef| change(def.robots.get_mut("YouBot").expect("YouBot"));

    check(
        p3at(|it| wheel(it, 0).radius = 0.0019),
        "robot P3AT, wheel FRWheel: `radius` is 0.0019: expected 0.004 to 10 m",
    );
    check(p3at(|it| wheel(it, 1).width = 1e-7), "robot P3AT, wheel FLWheel: `width` is 1e-7: expected 0.001 to 20 m");
    check(
        p3at(|it| wheel(it, 0).mass = 1e-40),
        "robot P3AT, wheel FRWheel: `mass` is 1e-40: expected 0.001 to 10000 kg",
    );
    check(
        p3at(|it| joint(it, 0).anchor[0] = 1e308),
        "robot P3AT, wheel FRWheel: `position` is [1e308, 0.18, 0.048]: expected numbers of -100 to 100 m",
    );
    check(
        p3at(|it| joint(it, 0).anchor[1] = -0.18),
        "robot P3AT, wheel FRWheel: `position` has y -0.18: expected 0.001 m or more of a right wheel, as y is to the right",
    );
    check(
        p3at(|it| wheel(it, 0).material.friction = f64::NAN),
        "robot P3AT, wheel FRWheel: `friction` is NaN: expected 0 to 10",
    );
    check(
        p3at(|it| it.motors_mut().for_each(|motor| motor.gain = f64::INFINITY)),
        "robot P3AT, wheel FRWheel: `gain` is inf: expected 1e-6 to 1000000 N m s/rad",
    );
    check(
        p3at(|it| it.links[0].solids[0].rotation[1] = f64::NAN),
        "robot P3AT, solid ChassisMiddle: `rotation` is [0, NaN, 0]: expected numbers of -1000 to 1000 rad",
    );
    check(
        p3at(|it| it.links[0].solids[0].shape = Shape::HalfSpace),
        "robot P3AT, solid ChassisMiddle: a shape without an end or without a volume: expected a box, a cylinder, a ball \
         or a hull",
    );
    check(
        p3at(|it| {
            it.links[0].solids[0].shape = Shape::Hull { points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }
        }),
        "robot P3AT, solid ChassisMiddle: a hull of 3 points in one plane: expected a volume",
    );
    check(
        p3at(|it| it.links[0].parts[0].mass = 0.0),
        "robot P3AT, part ChassisMiddle: `mass` is 0: expected 1e-9 to 100000 kg",
    );
    check(
        p3at(|it| it.links[0].parts[0].name = "a\u{7}b".to_owned()),
        "robot P3AT, part a\\u{7}b: name `a\\u{7}b`: expected 1 to 256 characters, none of control",
    );
    for (moments, got) in [
        ([1.0, 1.0, 2.1], "1, 1 and 2.1"),
        ([1.0, 1.0, -1.0], "-1, 1 and 1"),
        ([0.0, 0.0, 0.0], "0, 0 and 0"),
        ([0.0, 1.0, 1.0], "0, 1 and 1"),
    ] {
        let expected = "expected three above 0, none more than the other two together";
        let expected =
            format!("robot P3AT, part ChassisMiddle: `inertia` has the principal moments {got} kg m²: {expected}");
        let set = |def: &mut WorldDef| {
            let robot = def.robots.get_mut("P3AT").expect("P3AT");
            robot.links[0].parts[0].inertia = Matrix3::from_diagonal(&moments.into());
        };
        check(set, &expected);
    }
    check(
        p3at(|it| it.links[0].parts[0].inertia[(0, 1)] = 1e-3),
        "robot P3AT, part ChassisMiddle: `inertia` is not symmetric: expected the same product of inertia for x y and y x",
    );
    check(
        p2dx(|it| it.links[0].parts[0].inertia *= 1e-5),
        "robot P2DX: its body's radius of gyration is 0.000270 m: expected 0.002084 (a hundredth of the way to its farthest wheel) to 100 m",
    );
    check(
        p2dx(|it| {
            it.links[0].parts[0].mass = 300.0;
            wheel(it, 0).mass = 0.002;
        }),
        "robot P2DX: its body, wheels and rollers weigh 0.002 to 300 kg: expected at most 100000 times the lightest",
    );
    check(p3at(|it| it.links.truncate(1)), "robot P3AT: no driven wheel: expected at least one");
    check(
        p3at(|it| {
            let joint = joint(it, 1);
            (joint.drive, joint.kind) = (None, JointKind::Ball);
        }),
        "robot P3AT: a driven wheel behind a caster: expected driven wheels first",
    );
    check(p3at(|it| it.links.extend(vec![it.links[1].clone(); 29])), "robot P3AT: 33 wheels: expected at most 32");
    check(p3at(|it| it.sensors = vec![it.sensors[0].clone(); 257]), "robot P3AT: 257 sensors: expected at most 256");
    check(
        p3at(|it| {
            let Config::Sick(sick) = &mut it.sensors[2].config else { panic!("no SICK") };
            sick.resolution = 0.0005;
            it.sensors = vec![it.sensors[2].clone(); 4];
        }),
        "robot P3AT: 26216 rays: expected at most 20000",
    );
    check(
        p3at(|it| {
            let Config::Camera(camera) = &mut it.sensors[3].config else { panic!("no camera") };
            camera.min_field_of_view = f64::NAN;
        }),
        "robot P3AT, sensor Camera: sensor Camera: expected min_field_of_view <= field_of_view <= max_field_of_view, all 0 \
         to pi",
    );
    check(
        p3at(|it| it.battery = Some(Battery { max_energy: 1.0, life: f64::INFINITY })),
        "robot P3AT: `life` is inf: expected 0.001 to 1e9 s",
    );
    check(p3at(|it| it.class = "a b".to_owned()), "robot a b: class `a b`: expected a name without spaces and braces");

    check(
        youbot(|it| it.links.swap(1, 2)),
        "robot YouBot: steering \"omni\": expected four wheels front left, front right, back left, back right with \
         `roller_angle` +, -, -, +",
    );
    check(
        youbot(|it| it.wheels_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.count = 33)),
        "robot YouBot, wheel FLWheel: `count` is 33: expected 3 to 32 rollers",
    );
    check(
        youbot(|it| it.wheels_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.axis_circle = 0.045)),
        "robot YouBot, wheel FLWheel: `axis_circle` is 0.045: expected 0.0050 to 0.0433 m",
    );
    check(
        youbot(|it| it.wheels_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.last_phase = 0.8)),
        "robot YouBot, wheel FLWheel: `last_phase` is 0.8: expected 0.5236 to 0.7660 rad",
    );

    check(|def| def.map.gravity = f64::NAN, "the map: `gravity` is NaN: expected 0 to 100 m/s²");
    check(
        |def| def.map.starts = vec![def.map.starts[0].clone(); 1001],
        "the map: 1001 start poses: expected at most 1000",
    );
    check(
        |def| def.map.starts[0].position[2] = f64::NEG_INFINITY,
        "the map, pose PlayerStart_0: `position` is [0, 0, -inf]: expected numbers of -100000 to 100000 m",
    );
    check(
        |def| def.map.solids[1].shape = Shape::Box { size: [1.0, 1.0, 2000.0] },
        "the map, solid wall-front: `height` is 2000: expected 0 to 900 m",
    );
    let mesh = |change: fn(&mut Vec<[f64; 3]>, &mut Vec<[u32; 3]>)| {
        move |def: &mut WorldDef| {
            for solid in &mut def.map.solids {
                if let Shape::Mesh { vertices, triangles } = &mut solid.shape {
                    change(vertices, triangles);
                }
            }
        }
    };
    check(
        mesh(|vertices, _| vertices[0] = [1e19, 1.0, 0.0]),
        "the map, solid uneven-ground: `corner` is [1e19, 1, 0]: expected numbers of -100000 to 100000 m",
    );
    check(
        mesh(|_, triangles| triangles[0][0] = 4_000_000_000),
        "the map, solid uneven-ground: a triangle has the corner 4000000000: expected less than 169",
    );
    check(
        mesh(|_, triangles| triangles.clear()),
        "the map, solid uneven-ground: a mesh of 0 triangles and 0 m²: expected a surface",
    );
    check(
        mesh(|_, triangles| triangles.resize(1_000_001, [0, 1, 2])),
        "the map: 1000001 triangles: expected at most 1000000",
    );
    let field = |size: [f64; 2], columns: usize, heights: Vec<f64>| {
        move |def: &mut WorldDef| def.map.solids[1].shape = Shape::HeightField(HeightField { size, columns, heights })
    };
    let edge = [1.0, 1.0];
    for columns in [0, 1, 3, 4, usize::MAX] {
        check(
            field(edge, columns, vec![0.0; 4]),
            &format!(
                "the map, solid wall-front: 4 heights in rows of {columns}: expected at least two full rows of at least two"
            ),
        );
    }
    check(
        field([1.0, 0.0], 2, vec![0.0; 4]),
        "the map, solid wall-front: `size` is [1, 0]: expected numbers of 0.0001 to 100000 m",
    );
    check(
        field(edge, 2, vec![0.0, 0.0, f64::NAN, 0.0]),
        "the map, solid wall-front: `height` is NaN: expected -450 to 450 m",
    );
    check(field(edge, 1000, vec![0.0; 600_000]), "the map: 1197090 triangles: expected at most 1000000");
    let belt = |solid: usize, speed: f64| {
        move |def: &mut WorldDef| def.map.conveyors.push(Conveyor { solid, velocity: [speed, 0.0, 0.0] })
    };
    check(belt(1, 11.0), "the map, conveyor wall-front: `conveyor` is [11, 0, 0]: expected numbers of -10 to 10 m/s");
    check(belt(0, 1.0), "the map, conveyor floor: a conveyor of another shape: expected a box");
    check(belt(999, 1.0), "the map, conveyor 0: a conveyor of another shape: expected a box");
    check(
        |def| {
            let line = Solid { shape: Shape::Ball { radius: -1.0 }, ..def.map.solids[1].clone() };
            def.map.markings.push(line);
        },
        "the map, solid wall-front: `radius` is -1: expected 0.0001 to 100000 m",
    );
    check(
        |def| {
            def.map.objects[0].solid.shape =
                Shape::HeightField(HeightField { size: [1.0; 2], columns: 2, heights: vec![0.0; 4] })
        },
        "the map, solid crate: a mass: expected a box, a cylinder, a ball or a hull",
    );
    check(|def| def.map.objects[0].mass = 1e-10, "the map, solid crate: `mass` is 1e-10: expected 0.001 to 100000 kg");
    check(
        |def| def.map.objects[0].solid.shape = Shape::HalfSpace,
        "the map, solid crate: a mass: expected a box, a cylinder, a ball or a hull",
    );
}

const CART: &str = r#"description = "a cart"
steering = "skid"

[[part]]
name = "body"
mass = 4.0
position = [0.0, 0.0, -0.02]
size = [0.3, 0.2, 0.08]
material = "aluminium"

[wheels]
radius = 0.06
width = 0.03
mass = 0.3
material = "rubber-tyre"
max_speed = 10.0
gain = 1.0
max_torque = 3.0

[[wheel]]
name = "Left"
side = "left"
position = [0.05, -0.13, 0.0]

[[wheel]]
name = "Right"
side = "right"
position = [0.05, 0.13, 0.0]

[[caster]]
name = "Caster"
position = [-0.12, 0.0, 0.04]
radius = 0.02
mass = 0.1
material = "nylon"

[[sensor]]
class = "Odometry"
name = "Odometer"
"#;

const HALL: &str = r#"description = "a hall"
gravity = 9.81

[[half_space]]
name = "floor"
material = "concrete"

[[box]]
name = "crate"
material = "plywood"
position = [1.0, 0.0, -0.1]
rotation = [0.0, 0.0, 0.0]
size = [0.2, 0.2, 0.2]
mass = 1.0

[[ramp]]
name = "ramp"
material = "plywood"
position = [2.0, 1.5, 0.0]
length = 1.5
width = 1.0
height = 0.15

[[mesh]]
name = "ground"
material = "plywood"
file = "ground.obj"

[[start]]
name = "Start"
position = [0.0, 0.0, 0.0]
"#;

/// A tetrahedron as an OBJ file.
const GROUND: &str = "v 3 0 0\nv 4 0 0\nv 3 1 0\nv 3 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const BASE: &str = r#"<robot name="cart">
  <link name="base">
    <inertial><mass value="4"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.04"/></inertial>
    <collision><geometry><mesh filename="package://base.obj" scale="0.1 0.1 0.1"/></geometry></collision>
  </link>
  <link name="left"><inertial><mass value="0.3"/>
    <inertia ixx="1e-3" ixy="0" ixz="0" iyy="1e-3" iyz="0" izz="1e-3"/></inertial></link>
  <joint name="left_wheel" type="continuous">
    <origin xyz="0 0.13 0" rpy="0 0 0"/><parent link="base"/><child link="left"/><limit effort="3" velocity="10"/>
  </joint>
</robot>
"#;

/// Returns the cart with its body and its left wheel taken from the URDF.
fn urdf_cart() -> String {
    let body = CART.find("[[part]]").expect("a part")..CART.find("[wheels]").expect("wheels");
    let mut cart = CART.to_owned();
    cart.replace_range(body, "");
    let cart = cart.replace("steering = \"skid\"", "steering = \"skid\"\nurdf = \"base.urdf\"");
    cart.replace("side = \"left\"\nposition = [0.05, -0.13, 0.0]", "side = \"left\"\njoint = \"left_wheel\"")
}

/// Checks the first of some files and compares all problems, one per line.
#[track_caller]
fn check_files(files: &[(&str, &str)], expected: &[&str]) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    let result = scene_loader::check(&folder.path().join(files[0].0));
    let prefix = format!("{}/", folder.path().display());
    let problems = result.map_or_else(|error| error.to_string().replace(&prefix, ""), |_| "good".to_owned());
    assert_eq!(problems.lines().collect::<Vec<_>>(), expected);
}

#[test]
fn a_map_with_a_hostile_number_is_refused_with_its_line() {
    #[track_caller]
    fn check(from: &str, to: &str, expected: &[&str]) {
        assert!(from.is_empty() || HALL.contains(from), "{from}");
        let text = if from.is_empty() { to.to_owned() } else { HALL.replace(from, to) };
        check_files(&[("map.toml", &text), ("ground.obj", GROUND)], expected);
    }
    check("gravity", "gravity", &["good"]);
    check("9.81", "nan", &["map.toml:2:11: `gravity` is NaN: expected 0 to 100 m/s²"]);
    check(
        "rotation = [0.0, 0.0, 0.0]",
        "rotation = [nan, 0.0, 0.0]",
        &["map.toml:8:1: `rotation` is [NaN, 0, 0]: expected numbers of -1000 to 1000 rad"],
    );
    check(
        "[0.2, 0.2, 0.2]",
        "[0.2, 0.2, 1e-5]",
        &["map.toml:8:1: `size` is [0.2, 0.2, 1e-5]: expected numbers of 0.0001 to 100000 m"],
    );
    check("mass = 1.0", "mass = 1e-40", &["map.toml:8:1: `mass` is 1e-40: expected 0.001 to 100000 kg"]);
    check(
        "[1.0, 0.0, -0.1]",
        "[inf, 0.0, -0.1]",
        &["map.toml:8:1: `position` is [inf, 0, -0.1]: expected numbers of -100000 to 100000 m"],
    );
    check("height = 0.15", "height = 901.0", &["map.toml:16:1: `height` is 901: expected 0 to 900 m"]);
    check("width = 1.0", "width = -1.0", &["map.toml:16:1: `width` is -1: expected 0.0001 to 100000 m"]);
    check(
        "file = \"ground.obj\"",
        "file = \"ground.obj\"\nscale = 0.0",
        &["map.toml:24:1: `scale` is 0: expected 1e-6 to 1000000"],
    );
    check(
        "file = \"ground.obj\"",
        "file = \"ground.obj\"\nscale = 1e6",
        &["map.toml:24:1: `corner` is [3000000, 0, 0]: expected numbers of -100000 to 100000 m"],
    );
    check(
        "\"ground.obj\"",
        "\"/dev/zero.obj\"",
        &["map.toml:24:1: /dev/zero.obj: cannot be read: No such file or directory (os error 2)"],
    );
    let long = "a".repeat(257);
    let expected = format!("map.toml:29:1: name `{}`: expected a name without spaces and braces", "a".repeat(60));
    check("\"Start\"", &format!("\"{long}\""), &[&expected]);
    let starts = "[[start]]\nname = \"S\"\nposition = [0, 0, 0]\n".repeat(1001);
    check("", &format!("description = \"m\"\n{starts}"), &["map.toml:1:1: 1001 start poses: expected at most 1000"]);
    let boxes = "[[box]]\nname = \"b\"\nmaterial = \"plywood\"\nsize = [1, 1, 1]\n".repeat(10_001);
    let boxes = format!("description = \"m\"\n{boxes}[[start]]\nname = \"S\"\nposition = [0, 0, 0]\n");
    check("", &boxes, &["map.toml:1:1: 10001 solids: expected at most 10000"]);
}

#[test]
fn a_mesh_with_a_hostile_number_is_refused_by_its_name() {
    #[track_caller]
    fn check(mesh: &str, expected: &str) {
        check_files(&[("map.toml", HALL), ("ground.obj", mesh)], &[&format!("map.toml:24:1: {expected}")]);
    }
    check(
        &GROUND.replace("v 4 0 0", "v 1e19 0 0"),
        "`corner` is [9.999999980506448e18, 0, 0]: expected numbers of -100000 to 100000 m",
    );
    check(&GROUND.replace("v 4 0 0", "v nan 0 0"), "`corner` is [NaN, 0, 0]: expected numbers of -100000 to 100000 m");
    check(&GROUND.replace("f 1 3 2", "f 1 3 9"), "mesh `ground.obj`: face vertex index out of bounds");
    check(&GROUND.replace("f 1 3 2", "f 1 3 -9"), "mesh `ground.obj`: face vertex index out of bounds");
    check("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", "a mesh of 1 triangles and 0 m²: expected a surface");
    // References to textures and normals are ignored.
    check_files(&[("map.toml", HALL), ("ground.obj", &GROUND.replace("f 1 3 2", "f 1/-11/7 3//99 2/5"))], &["good"]);
}

/// Lengths in a file are not trusted, and reading ends at the largest permitted length.
#[cfg(unix)]
#[test]
fn a_file_is_read_only_as_far_as_it_may_be_long() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let problem = |name: &str| {
        let result = scene_loader::check(&path(name));
        let prefix = format!("{}/", folder.path().display());
        result.expect_err("a problem").to_string().replace(&prefix, "")
    };
    let file = std::fs::File::create(path("map.toml")).expect("a file");
    file.set_len(5 << 20).expect("a long file");
    assert_eq!(problem("map.toml"), "map.toml: cannot be read: larger than 4194304 bytes, the most that is read");
    std::fs::write(path("map.toml"), HALL).expect("a file");
    let mesh = std::fs::File::create(path("ground.obj")).expect("a file");
    mesh.set_len(65 << 20).expect("a long file");
    let expected = "map.toml:24:1: ground.obj: cannot be read: larger than 67108864 bytes, the most that is read";
    assert_eq!(problem("map.toml"), expected);
    std::fs::remove_file(path("ground.obj")).expect("a file");
    std::os::unix::fs::symlink("/dev/zero", path("ground.obj")).expect("a link");
    assert_eq!(problem("map.toml"), "map.toml:24:1: ground.obj: cannot be read: not a regular file");
    // A header that promises four thousand million triangles.
    let mut stl = vec![0; 80];
    stl.extend([255; 4]);
    std::fs::write(path("ground.stl"), stl).expect("a file");
    std::fs::write(path("map.toml"), HALL.replace("ground.obj", "ground.stl")).expect("a file");
    assert_eq!(
        problem("map.toml"),
        "map.toml:24:1: mesh `ground.stl`: 84 bytes: expected 214748364834, as its count of triangles says"
    );
}

#[test]
fn what_is_nested_too_deep_is_refused_before_anything_recurses() {
    const MANY: usize = 30_000;
    let toml = [
        (format!("a = {}{}", "[".repeat(MANY), "]".repeat(MANY)), 85),
        (format!("a = {}1{}", "{a=".repeat(MANY), "}".repeat(MANY)), 245),
        (format!("{}a = 1", "a.".repeat(MANY)), 1),
        (format!("[{}a]", "a.".repeat(MANY)), 1),
        (format!("[[{}a]]", "a.".repeat(MANY)), 1),
    ];
    for (text, column) in toml {
        let expected = format!("map.toml:1:{column}: nested too deep: expected at most 80 levels");
        check_files(&[("map.toml", &text)], &[&expected]);
        // With an override the text is read earlier, and refused there.
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("map.toml");
        std::fs::write(&path, &text).expect("a file");
        let set = "map.gravity=1".parse().expect("an override");
        let error = scene_loader::map(path.to_str().expect("a path"), &[set]).expect_err("too deep").to_string();
        assert!(error.ends_with(&format!(":1:{column}: nested too deep: expected at most 80 levels")), "{error}");
    }
    let nested = |open: &str, close: &str| {
        BASE.replace(
            "<link name=\"left\">",
            &format!("{}{}<link name=\"left\">", open.repeat(MANY), close.repeat(MANY)),
        )
    };
    check_files(&[("base.urdf", &nested("<a>", "</a>"))], &["base.urdf:6:189: <a> is too deep: expected 64 levels"]);
    let declared =
        (0..MANY).map(|index| format!("<a xmlns:n{index}=\"x\">")).collect::<String>() + &"</a>".repeat(MANY);
    check_files(
        &[("base.urdf", &BASE.replace("<link name=\"left\">", &format!("{declared}<link name=\"left\">")))],
        &["base.urdf:1:1: 30000 namespaces: expected at most 100"],
    );
}

#[test]
fn a_robot_with_a_hostile_number_is_refused_with_its_line() {
    #[track_caller]
    fn check(from: &str, to: &str, expected: &[&str]) {
        assert!(CART.contains(from), "{from}");
        check_files(&[("robot.toml", &CART.replace(from, to))], expected);
    }
    check("steering", "steering", &["good"]);
    // A value from [wheels] that a wheel inherits is reported once, at the wheel.
    check("radius = 0.06", "radius = 0.0019", &["robot.toml:11:1: `radius` is 0.0019: expected 0.004 to 10 m"]);
    check("width = 0.03", "width = 1e-4", &["robot.toml:11:1: `width` is 0.0001: expected 0.001 to 20 m"]);
    check("mass = 0.3", "mass = 1e-40", &["robot.toml:11:1: `mass` is 1e-40: expected 0.001 to 10000 kg"]);
    check("gain = 1.0", "gain = inf", &["robot.toml:11:1: `gain` is inf: expected 1e-6 to 1000000 N m s/rad"]);
    let tyre = |numbers: &str| format!("gain = 1.0\ntyre = {{ {numbers} }}");
    for (numbers, expected) in [
        ("stiffness = [5.0, 4.0], patch = [0.02, 0.01]", "good"),
        (
            "stiffness = [0.0, 4.0], patch = [0.02, 0.01]",
            "robot.toml:11:1: `stiffness` is [0, 4]: expected numbers of 1 to 10000",
        ),
        (
            "stiffness = [5.0, 4.0], patch = [0.02, 0.04]",
            "robot.toml:11:1: half width in `patch` is 0.04: expected 0.001 to 0.03 m",
        ),
        (
            "stiffness = [5.0, 4.0], patch = [0.02, 0.01], relaxation = 0.5",
            "robot.toml:11:1: `relaxation` is 0.5: expected at most 0.08 m, a third of stiffness times radius",
        ),
        (
            "stiffness = [5.0, 4.0], patch = [0.02, 0.01], friction = [1.0, nan]",
            "robot.toml:11:1: `friction` is [1, NaN]: expected numbers of 0.1 to 10",
        ),
    ] {
        check("gain = 1.0", &tyre(numbers), &[expected]);
    }
    check(
        "name = \"Left\"",
        "name = \"Left\"\narmature = -1.0",
        &["robot.toml:20:1: `armature` is -1: expected 0 to 100 kg m²"],
    );
    check("mass = 4.0", "mass = -4.0", &["robot.toml:4:1: `mass` is -4: expected 1e-9 to 100000 kg"]);
    check(
        "size = [0.3, 0.2, 0.08]",
        "size = [0.3, 0.2, 0.0]\nrotation = [nan, 0.0, 0.0]",
        &[
            "robot.toml:4:1: `rotation` is [NaN, 0, 0]: expected numbers of -1000 to 1000 rad",
            "robot.toml:4:1: `size` is [0.3, 0.2, 0]: expected numbers of 0.0001 to 100 m",
        ],
    );
    check(
        "size = [0.3, 0.2, 0.08]",
        "size = [0.0003, 0.0002, 0.0001]",
        &["robot.toml:1:1: its body's radius of gyration is 0.000065 m: expected 0.001407 (a hundredth of the way to \
             its farthest wheel) to 100 m"],
    );
    check("radius = 0.02", "radius = 1e-3", &["robot.toml:30:1: `radius` is 0.001: expected 0.004 to 10 m"]);
    check(
        "position = [0.05, 0.13, 0.0]",
        "position = [0.05, 0.0, 0.0]",
        &["robot.toml:25:1: `position` has y 0: expected 0.001 m or more of a right wheel, as y is to the right"],
    );
    check(
        "name = \"Odometer\"",
        "name = \"Odometer\"\nscan_interval = 1e-9",
        &["robot.toml:37:1: `scan_interval` is 1e-9: expected 0 or 0.002 to 3600 s"],
    );
    check(
        "class = \"Odometry\"",
        "class = \"Sonar\"\nnumber_of_cones = 100\ntraces_per_cone = 1000",
        &["robot.toml:1:1: 100001 rays: expected at most 20000"],
    );
    check(
        "class = \"Odometry\"",
        "class = \"Camera\"\nmin_field_of_view = 3.0",
        &[
            "robot.toml:37:1: sensor Odometer: expected min_field_of_view <= field_of_view <= max_field_of_view, all 0 to \
             pi",
        ],
    );
    let wheel = &CART[CART.find("[[wheel]]").expect("a wheel")..CART.find("[[caster]]").expect("a caster")];
    check(
        "[[caster]]",
        &format!("{}[[caster]]", wheel.repeat(20)),
        &["robot.toml:1:1: 43 wheels: expected at most 32"],
    );
}

#[test]
fn a_urdf_with_a_hostile_number_is_refused_with_its_line() {
    #[track_caller]
    fn check(from: &str, to: &str, expected: &[&str]) {
        assert!(BASE.contains(from), "{from}");
        let cart = urdf_cart();
        check_files(&[("robot.toml", &cart), ("base.urdf", &BASE.replace(from, to)), ("base.obj", GROUND)], expected);
    }
    check("base", "base", &["good"]);
    check("0 0.13 0", "0 1e308 0", &["base.urdf:9:5: xyz=\"0 1e308 0\": expected -100 to 100 m"]);
    // One mistake is reported alone, without its consequences.
    check("rpy=\"0 0 0\"", "rpy=\"0 0\"", &["base.urdf:9:5: rpy=\"0 0\": expected 3 finite numbers"]);
    check("rpy=\"0 0 0\"", "rpy=\"0 0 nan\"", &["base.urdf:9:5: rpy=\"0 0 nan\": expected 3 finite numbers"]);
    let moments = "expected three above 0, none more than the other two together";
    for (izz, got) in [("0.06", "0.02, 0.03 and 0.06"), ("0", "0, 0.02 and 0.03"), ("-0.04", "-0.04, 0.02 and 0.03")] {
        let expected = format!("base.urdf:2:3: link base: `inertia` has the principal moments {got} kg m²: {moments}");
        check("izz=\"0.04\"", &format!("izz=\"{izz}\""), &[&expected]);
    }
    check(
        "mass value=\"4\"",
        "mass value=\"-4\"",
        &["base.urdf:2:3: link base: `mass` is -4: expected 1e-9 to 100000 kg"],
    );
    // The mass of a wheel is checked at the wheel that uses it.
    check("mass value=\"0.3\"", "mass value=\"0\"", &["robot.toml:14:1: `mass` is 0: expected 0.001 to 10000 kg"]);
    check(
        "0.1 0.1 0.1",
        "0.1 0 0.1",
        &["base.urdf:4:5: link base: `scale` is [0.1, 0, 0.1]: expected numbers of 1e-6 to 1000000, either sign"],
    );
    check("0.1 0.1 0.1", "0.1 inf 0.1", &["base.urdf:4:26: scale=\"0.1 inf 0.1\": expected 3 finite numbers"]);
    check(
        "0.1 0.1 0.1",
        "0.1 0.1 1e-6",
        &["base.urdf:4:5: link base: a hull of 3 points in one plane: expected a volume"],
    );
    let links = "<link name=\"a\"/>".repeat(999);
    check(
        "<link name=\"left\">",
        &format!("{links}<link name=\"left\">"),
        &["base.urdf:1:1: 1001 <link>: expected at most 1000"],
    );
}

#[test]
fn a_mistake_has_no_follow_ups() {
    // A wheel on a missing joint; the message lists the joints that exist.
    let cart = urdf_cart();
    let files = |cart: &str, expected: &[&str]| {
        check_files(&[("robot.toml", cart), ("base.urdf", BASE), ("base.obj", GROUND)], expected);
    };
    files(
        &cart.replace("left_wheel", "${ns}left_wheel"),
        &["robot.toml:14:1: joint `${ns}left_wheel`: expected a continuous joint of the URDF: one of left_wheel"],
    );
    files(
        &cart.replace("base.urdf", "none.urdf"),
        &["robot.toml:3:8: none.urdf: cannot be read: No such file or directory (os error 2)"],
    );
    let unknown = "unknown field `gian`, expected one of `name`, `side`, `joint`, `position`, `radius`, `width`, `mass`, \
                   `material`, `max_speed`, `gain`, `max_torque`, `integral_time`, `armature`, `gear`, `torque_constant`, \
                   `max_current`, `rotor_inertia`, `tyre`, `roller_angle`, `first_roller`, `link` (did you mean `gain`?)";
    check_files(&[("robot.toml", &CART.replace("gain", "gian"))], &[&format!("robot.toml:17:1: {unknown}")]);
    check_files(
        &[("robot.toml", &CART.replace("[wheels]", "[wheels"))],
        &["robot.toml:11:8: unclosed table, expected `]`"],
    );
    // A map with a syntax error.
    let map = |text: &str, expected: &[&str]| check_files(&[("map.toml", text), ("ground.obj", GROUND)], expected);
    map(&HALL.replace("[[start]]", "[[start]"), &["map.toml:29:9: unclosed array table, expected `]`"]);
    map(&HALL.replace("0.2, 0.2]", "0.2, 0.2"), &["map.toml:14:1: missing comma between array elements, expected `,`"]);
    map(&HALL.replace("= \"a hall\"", "\"a hall\""), &["map.toml:1:13: key with no value, expected `=`"]);
    let without_start = &HALL[..HALL.find("[[start]]").expect("a start")];
    map(without_start, &["map.toml:1:1: no [[start]]: expected at least one start pose"]);
}

#[test]
fn an_unexpanded_xacro_is_named_as_such() {
    #[track_caller]
    fn check(from: &str, to: &str, expected: &str) {
        let text = BASE.replace(from, to);
        let how = "is of xacro: expected a URDF; expand it first by `usarsim import robot.xacro`, or `xacro robot.xacro > robot.urdf`";
        let expected = if expected == "good" { expected.to_owned() } else { format!("{expected} {how}") };
        check_files(&[("base.urdf", &text), ("base.obj", GROUND)], &[&expected]);
    }
    let declared = "name=\"cart\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\"";
    let property = ">\n  <xacro:property name=\"mass\" value=\"4\"/>\n  <link name=\"base\">";
    check("left_wheel", "${ns}left_wheel", "base.urdf:8:3: `${ns}left_wheel`");
    check("package://base", "$(find cart)/base", "base.urdf:4:26: `$(find cart)/base.obj`");
    check(
        "name=\"cart\">\n  <link name=\"base\">",
        &format!("{declared}{property}"),
        "base.urdf:2:3: `<xacro:property>`",
    );
    check("name=\"cart\">\n  <link name=\"base\">", &format!("name=\"cart\"{property}"), "base.urdf:2:4: `<xacro:..>`");
    // Expanded files keep the declaration, and often the old source in a comment.
    check("name=\"cart\">", &format!("{declared}><!-- ${{ns}} <xacro:a/> -->"), "good");
}

#[test]
fn what_cannot_be_loaded_is_said_in_one_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    let path = |name: &str| folder.path().join(name).display().to_string();
    write("base.urdf", BASE);
    write("base.yaml", BASE);
    let error = scene_loader::robot(&path("base.yaml"), &[]).expect_err("a robot").to_string();
    assert_eq!(error, format!("{}: expected a robot.toml or a URDF", path("base.yaml")));
    let error = scene_loader::map(&path("base.urdf"), &[]).expect_err("a URDF").to_string();
    assert_eq!(error, format!("{}: expected a map.toml", path("base.urdf")));

    for (overrides, expected) in [
        (
            &["robot.wheels.gian=2"][..],
            "--set robot.wheels.gian=2: nothing that is read here has `wheels.gian` (did you mean `robot.wheels.gain`?); `usar",
        ),
        (&["robot.wheels.gain=2", "robot.wheels.gain=-1"], "--set robot.wheels.gain=-1: robots/"),
        (&["P3AT.wheels.mass=1e-9"], "--set P3AT.wheels.mass=1e-9: robots/P3AT/robot.toml: `mass` is 1e-9: expected"),
        (&["map.gravity=nan"], "--set map.gravity=nan: rough/map.toml: `gravity` is NaN: expected 0 to 100 m/s²"),
        (&["map.gravity=a"], "--set map.gravity=a: rough/map.toml: invalid type: string \"a\", expected f64"),
        (&["material.carpet.friction=99"], "--set material.carpet.friction=99: assets/materials.toml: `friction` is"),
        (
            &["robot.wheelz.gain=2"],
            "--set robot.wheelz.gain=2: nothing that is read here has `wheelz.gain` (did you mean `robot.wheels.gain`?); `usa",
        ),
        (
            &["P3AT.wheels.gian=2"],
            "--set P3AT.wheels.gian=2: nothing that is read here has `wheels.gian` (did you mean `P3AT.wheels.gain`?)",
        ),
        (
            &["map.gravitas=2"],
            "--set map.gravitas=2: rough/map.toml: unknown key `gravitas`: expected one of description, robots, gravity",
        ),
        (
            &["P3TA.wheels.gain=2"],
            "--set P3TA.wheels.gain=2: no `P3TA` (did you mean `P3AT`?): expected robot, map, material or a",
        ),
        // Each override is valid without the other.
        (
            &["YouBot.wheels.radius=0.1", "YouBot.wheels.max_speed=500"],
            "--set YouBot.wheels.radius=0.1 --set YouBot.wheels.max_speed=500: robots/YouBot/robot.toml: `max_speed` 500 rad/s at \
             `radius` 0.1 m is 50.0 m/s at the rim: expected at most 40 m/s",
        ),
        (
            &["YouBot.wheels.max_speed=200", "YouBot.wheels.max_current=1000"],
            "--set YouBot.wheels.max_current=1000: robots/YouBot/robot.toml: its wheels push with 23696 N, 121 times its weight",
        ),
        (
            &["P3AT.wheels.max_torque=1000"],
            "--set P3AT.wheels.max_torque=1000: robots/P3AT/robot.toml: its wheels push with",
        ),
        (
            &["P2DX.part.Chassis.mass=1000", "P2DX.wheel.0.mass=0.002"],
            "--set P2DX.part.Chassis.mass=1000 --set P2DX.wheel.0.mass=0.002: robots/P2DX/robot.toml: its body, wheels",
        ),
    ] {
        let sets: Vec<_> = overrides.iter().map(|text| text.parse().expect("an override")).collect();
        let error = scene_loader::load_with("rough", &[], &sets).expect_err(expected).to_string();
        assert!(error.starts_with(expected) && error.lines().count() == 1, "{error}");
    }
}

/// Spawns a robot on a map and drives it. Fails with the first result that is infinite or NaN.
fn drive(map: &MapDef, robot: &RobotDef, seconds: f64) -> Result<(), String> {
    let def =
        WorldDef { map: map.clone(), robots: [(robot.class.clone(), robot.clone())].into(), ..WorldDef::default() };
    def.check().map_err(|problem| problem.to_string())?;
    let commands = match robot.steering {
        Steering::Skid => ["{Left 60} {Right 60}", "{Left -100} {Right 100}", "{Left 0} {Right 0}"],
        Steering::Omni => [
            "{Front-Left 60} {Front-Right 60} {Back-Left 60} {Back-Right 60}",
            "{Front-Left -100} {Front-Right 100} {Back-Left 100} {Back-Right -100}",
            "{Front-Left 0} {Front-Right 0} {Back-Left 0} {Back-Right 0}",
        ],
        Steering::Ackermann => [
            "{Speed 60} {FrontSteer 0.4} {RearSteer 0}",
            "{Speed -100} {FrontSteer -1e6} {RearSteer 1e6}",
            "{Speed 0} {FrontSteer 0} {RearSteer 0}",
        ],
        Steering::Aerial => [
            "{LinearVelocity 60} {AltitudeVelocity -100}",
            "{LateralVelocity -1e6} {PitchAngle 1e6}",
            "{LinearVelocity 0} {LateralVelocity 0} {AltitudeVelocity 0} {RotationalVelocity 1e6}",
        ],
        Steering::Legged | Steering::None => ["", "", ""],
    };
    let mut world = World::new(def, Options::default());
    let id = init(&mut world, &format!("INIT {{ClassName {}}} {{Start {}}}", robot.class, map.starts[0].name));
    let steps = (seconds / world.time_step()) as usize;
    for step in 0..steps {
        if let (0, Some(command)) = (step % (steps / 3), commands.get(3 * step / steps)) {
            apply(&mut world, id, &format!("DRIVE {{Normalized true}} {command}"));
            let target = [1e6, -1e6, 0.3][3 * step / steps];
            apply(
                &mut world,
                id,
                &format!("SET {{Type Joint}} {{Name AllJoints}} {{Opcode Angle}} {{Params {target}}}"),
            );
        }
        let messages = world.step();
        let Some(RobotSnapshot { body, joints, targets, rollers, contacts, .. }) = world.observe(id) else {
            return Err(format!("step {step}: the robot lost its finite state"));
        };
        let mut numbers = [targets, rollers].concat();
        numbers.extend(joints.iter().flat_map(|joint| [joint.position, joint.speed]));
        numbers.extend([body.linear, body.angular].iter().flatten());
        numbers.extend(contacts.iter().flat_map(|contact| [contact.point, contact.force]).flat_map(<[f64; 3]>::from));
        for pose in world.objects().map(|object| object.pose).chain([body.pose]) {
            numbers.extend(pose.translation.vector.iter().chain(pose.rotation.coords.iter()));
        }
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(format!("step {step}: {numbers:?}"));
        }
        // On the wire a number that is infinite or NaN becomes 0, so the messages themselves are checked.
        let debug = format!("{messages:?}");
        if debug.split(|c: char| !c.is_alphanumeric()).any(|word| word == "NaN" || word == "inf") {
            return Err(format!("step {step}: {debug}"));
        }
    }
    Ok(())
}

/// A change of a map and of the robot on it.
type Change = fn(&mut MapDef, &mut RobotDef);

/// Drives a P2DX, and a youBot in every drive model, after each change.
fn check_driving(seconds: f64, changes: &[(&str, Change)]) {
    for (name, change) in changes {
        let youbots = DriveModel::ALL.map(|(_, model)| ("YouBot", model));
        for (class, model) in [("P2DX", DriveModel::Bodies)].into_iter().chain(youbots) {
            let mut map = scene_loader::map("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
            let mut robot = scene_loader::robot(class, &[]).unwrap_or_else(|error| panic!("{error}"));
            robot.drive_model = model;
            change(&mut map, &mut robot);
            hold_motors(&mut robot);
            drive(&map, &robot, seconds).unwrap_or_else(|problem| panic!("{name}, {class}, {model:?}: {problem}"));
        }
    }
}

/// Lowers the motors' limits to the largest values that the robot's wheels and weight allow.
fn hold_motors(robot: &mut RobotDef) {
    let weight = 0.999 * check::EARTH_GRAVITY * f64::from(robot.mass());
    let push = check::MAX_PUSH * weight / robot.driven().count().max(1) as f64;
    for link in &mut robot.links {
        let Some(radius) = link.wheel.as_ref().map(|wheel| wheel.radius) else { continue };
        let Some(motor) = link.joint.as_mut().and_then(|joint| joint.drive.as_mut()) else { continue };
        motor.max_speed = motor.max_speed.min(0.999 * check::MAX_RIM_SPEED / radius);
        motor.max_torque = motor.max_torque.min(push * radius);
    }
}

/// Returns the wheel with a number.
fn wheel(robot: &mut RobotDef, number: usize) -> &mut Wheel {
    robot.wheels_mut().nth(number).expect("a wheel")
}

/// Returns the joint of the wheel with a number.
fn joint(robot: &mut RobotDef, number: usize) -> &mut Joint {
    robot.links[number + 1].joint.as_mut().expect("a joint")
}

fn rollers(robot: &mut RobotDef) -> impl Iterator<Item = &mut Rollers> {
    robot.wheels_mut().filter_map(|wheel| wheel.rollers.as_mut())
}

/// Sets the masses of body, wheels and rollers.
fn weigh(robot: &mut RobotDef, body: f64, wheel: f64, roller: f64) {
    let before: f64 = robot.parts().map(|part| part.mass).sum();
    for part in robot.parts_mut() {
        part.mass *= body / before;
        part.inertia *= body / before;
    }
    robot.wheels_mut().for_each(|it| it.mass = wheel);
    rollers(robot).for_each(|it| it.mass = roller);
}

/// Resizes the wheels and scales their rollers' form with them.
fn resize(robot: &mut RobotDef, radius: f64, width: f64) {
    for wheel in robot.wheels_mut() {
        wheel.rollers.iter_mut().for_each(|rollers| rollers.axis_circle *= radius / wheel.radius);
        (wheel.radius, wheel.width) = (radius, width);
    }
}

/// Makes the body one part at the origin with these principal moments over its mass.
fn shape_mass(robot: &mut RobotDef, moments: [f64; 3]) {
    let mass = robot.parts().map(|part| part.mass).sum();
    robot.links[0].parts.truncate(1);
    let inertia = Matrix3::from_diagonal(&moments.into()) * mass;
    robot.links[0].parts[0] = Part { mass, centre: Vector3::zeros(), inertia, ..robot.links[0].parts[0].clone() };
}

#[test]
fn a_robot_just_within_the_bounds_stays_finite() {
    check_driving(
        2.0,
        &[
            ("the smallest wheels", |_, robot| resize(robot, 0.004, 0.001)),
            ("the largest wheels", |_, robot| resize(robot, 10.0, 20.0)),
            ("the lightest wheels", |_, robot| weigh(robot, 10.0, 1e-3, 1e-4)),
            ("the heaviest wheels", |_, robot| weigh(robot, 0.1, 1e4, 1e3)),
            ("the lightest robot", |_, robot| weigh(robot, 1.001e-3, 1e-3, 1e-4)),
            ("the heaviest robot", |_, robot| weigh(robot, 9.99e4, 1e4, 1e3)),
            ("the least inertia", |_, robot| shape_mass(robot, [8e-6; 3])),
            ("the largest inertia", |_, robot| shape_mass(robot, [9.9e3; 3])),
            ("an inertia at the edge of the triangle rule", |_, robot| shape_mass(robot, [0.01, 0.01, 0.0202])),
            ("a rod", |_, robot| shape_mass(robot, [8e-6, 0.03, 0.03])),
            ("the weakest motors", |_, robot| {
                robot.motors_mut().for_each(|it| (it.max_speed, it.gain, it.max_torque) = (1e-3, 1e-6, 1e-6));
            }),
            ("the strongest motors", |_, robot| {
                robot.motors_mut().for_each(|it| (it.max_speed, it.gain, it.max_torque) = (1e3, 1e6, 1e6));
                robot.motors_mut().for_each(|it| it.integral_time = Some(1e-3));
            }),
            ("the heaviest rotors", |_, robot| robot.motors_mut().for_each(|it| it.armature = 100.0)),
            ("three long rollers", |_, robot| {
                rollers(robot).for_each(|it| (it.count, it.axis_circle, it.last_phase) = (3, 0.024, PI / 3.0));
                rollers(robot).for_each(|it| it.angle = 0.1 * it.angle.signum());
            }),
            ("the thinnest rollers", |_, robot| {
                rollers(robot).for_each(|it| it.axis_circle = 0.998 * 0.05 * (PI / 6.0).cos());
                rollers(robot).for_each(|it| it.angle = 1.5 * it.angle.signum());
            }),
            ("the stiffest rollers", |_, robot| rollers(robot).for_each(|it| it.damping = 10.0)),
        ],
    );
}

#[test]
fn a_robot_of_many_rollers_stays_finite() {
    // A step of so many bodies takes 20 ms, so the drive is short.
    check_driving(
        0.2,
        &[("32 rollers a wheel", |_, robot| {
            rollers(robot).for_each(|it| (it.count, it.last_phase) = (32, PI / 32.0));
        })],
    );
}

#[test]
fn a_map_just_within_the_bounds_stays_finite() {
    fn materials(map: &mut MapDef, robot: &mut RobotDef, change: fn(&mut Material)) {
        map.solids.iter_mut().chain(&mut robot.links[0].solids).for_each(|it| change(&mut it.material));
        robot.wheels_mut().for_each(|it| change(&mut it.material));
        rollers(robot).for_each(|it| change(&mut it.material));
    }
    fn add(map: &mut MapDef, shape: Shape, position: [f64; 3]) {
        map.solids.push(Solid { name: "more".to_owned(), shape, position, ..map.solids[0].clone() });
    }
    check_driving(
        2.0,
        &[
            ("no gravity", |map, _| map.gravity = 0.0),
            ("the most gravity", |map, _| map.gravity = 100.0),
            ("no friction", |map, robot| materials(map, robot, |it| it.friction = 0.0)),
            ("the most friction", |map, robot| materials(map, robot, |it| it.friction = 10.0)),
            ("what bounces and resists", |map, robot| {
                materials(map, robot, |it| (it.restitution, it.rolling_resistance) = (1.0, 1.0));
            }),
            ("the most damping", |map, robot| {
                materials(map, robot, |it| (it.linear_damping, it.angular_damping) = (1000.0, 1000.0));
            }),
            ("at the end of the map", |map, _| map.starts[0].position = [1e5, -1e5, 0.0]),
            ("in a mountain", |map, _| add(map, Shape::Box { size: [1e5, 1e5, 900.0] }, [0.0, 0.0, 449.0])),
            ("over dust", |map, _| {
                (1..20).for_each(|x| add(map, Shape::Box { size: [1e-4; 3] }, [0.05 * f64::from(x), 0.165, 0.0]));
            }),
            ("over a mesh with triangles that are none", |map, _| {
                let vertices =
                    vec![[-3.0, -3.0, -0.1], [3.0, -3.0, -0.1], [0.0, 3.0, -0.1], [1e5, 1e5, 1e5], [0.0, 0.0, -0.1]];
                let triangles = vec![[0, 0, 0], [0, 1, 1], [0, 1, 2], [0, 1, 2], [0, 2, 1], [4, 4, 4], [2, 3, 2]];
                add(map, Shape::Mesh { vertices, triangles }, [0.0; 3]);
            }),
            ("into the lightest object", |map, _| {
                let shape = Shape::Ball { radius: 0.05 };
                let solid =
                    Solid { name: "ball".to_owned(), shape, position: [0.5, 0.0, -0.05], ..map.solids[0].clone() };
                map.objects.push(Object { solid, mass: 1e-3 });
            }),
            ("into the heaviest object", |map, _| {
                let shape = Shape::Box { size: [0.2; 3] };
                let solid =
                    Solid { name: "box".to_owned(), shape, position: [0.5, 0.0, -0.1], ..map.solids[0].clone() };
                map.objects.push(Object { solid, mass: 1e5 });
            }),
        ],
    );
}

/// Joints drawn from the full range of every value, some of them at its ends.
#[test]
fn joints_drawn_at_random_that_pass_stay_finite() {
    let mut random = ChaCha8Rng::seed_from_u64(13);
    let mut passed = 0;
    while passed < 60 {
        let mut drawn = |range: Range| {
            let least = range.least.max(range.most * 1e-9);
            match random.random_range(0..10) {
                0 => range.least,
                1 => range.most,
                _ => least * (range.most / least).powf(random.random()),
            }
        };
        let class = ["Kenaf", "FrontAckerman", "BasicAckermanRobot"][passed % 3];
        let map = scene_loader::map("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut robot = scene_loader::robot(class, &[]).unwrap_or_else(|error| panic!("{error}"));
        for link in robot.links.iter_mut().filter(|link| link.wheel.is_none()) {
            let Some(joint) = &mut link.joint else { continue };
            joint.damping = drawn(check::JOINT_DAMPING);
            joint.friction = drawn(check::JOINT_FRICTION);
            let most = drawn(Range { least: 1e-6, ..check::JOINT_LIMIT });
            joint.limits = Some([-most, drawn(Range { least: 1e-6, ..check::JOINT_LIMIT })]);
            joint.drive = Some(Motor {
                max_speed: drawn(check::MAX_SPEED),
                gain: drawn(check::GAIN),
                max_torque: drawn(check::MAX_TORQUE),
                stiffness: Some(drawn(check::STIFFNESS)).filter(|_| passed % 2 == 0),
                integral_time: None,
                armature: drawn(check::ARMATURE),
            });
            let mass = drawn(Range { least: 1e-3, most: 1e3, unit: "" });
            for part in &mut link.parts {
                part.inertia *= mass / part.mass;
                part.mass = mass;
            }
        }
        let def =
            WorldDef { map: map.clone(), robots: [(robot.class.clone(), robot.clone())].into(), ..WorldDef::default() };
        if def.check().is_ok() {
            passed += 1;
            drive(&map, &robot, 1.0).unwrap_or_else(|problem| panic!("{passed}: {problem}\n{robot:#?}"));
        }
    }
}

/// Shipped robots stay far below the combined limits of their wheels, so `--set` has room. The fastest are cars at 10 m/s.
#[test]
fn shipped_robots_have_a_wide_margin_to_the_combined_limits() {
    for robot in scene().robots.values() {
        let weight = check::EARTH_GRAVITY * f64::from(robot.mass());
        let motors = || robot.driven().filter_map(|wheel| Some((wheel.drive?, wheel.radius)));
        let rim = motors().map(|(motor, radius)| motor.max_speed * radius).fold(0.0, f64::max);
        let push = motors().map(|(motor, radius)| motor.stall_torque() / radius).sum::<f64>() / weight;
        println!("{}: rim {rim:.2} m/s, push {push:.1} times the weight", robot.class);
        assert!(rim < check::MAX_RIM_SPEED / 3.0 && push < check::MAX_PUSH / 4.0, "{}: {rim}, {push}", robot.class);
    }
}

/// Robots drawn from the full range of every value, some at its ends: none that passes the checks becomes infinite or NaN.
#[test]
fn robots_drawn_at_random_that_pass_stay_finite() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let mut drawn = |range: Range| {
        let least = range.least.max(range.most * 1e-9);
        match random.random_range(0..10) {
            0 => range.least,
            1 => range.most,
            _ => least * (range.most / least).powf(random.random()),
        }
    };
    let mut passed = 0;
    while passed < 60 {
        let class = if passed % 3 == 0 { "P2DX" } else { "YouBot" };
        let mut map = scene_loader::map("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut robot = scene_loader::robot(class, &[]).unwrap_or_else(|error| panic!("{error}"));
        robot.set_drive_model(Some(DriveModel::ALL[passed % 4].1));
        map.gravity = drawn(check::GRAVITY);
        map.solids[0].material.friction = drawn(check::FRICTION);
        let size = drawn(Range { least: 0.1, most: 100.0, unit: "" });
        let radius = drawn(Range { least: 0.02 * size, most: 0.5 * size, unit: "" });
        resize(&mut robot, radius, drawn(check::WHEEL_WIDTH));
        weigh(&mut robot, drawn(check::BODY_MASS), drawn(check::WHEEL_MASS), drawn(check::ROLLER_MASS));
        shape_mass(&mut robot, [drawn(Range { least: 1e-4, most: 0.3, unit: "" }) * size * size; 3]);
        for solid in &mut robot.links[0].solids {
            solid.shape = Shape::Box { size: [size, 0.3 * size, 0.1 * size] };
        }
        let motor = Motor {
            max_speed: drawn(check::MAX_SPEED),
            gain: drawn(check::GAIN),
            max_torque: drawn(check::MAX_TORQUE),
            stiffness: None,
            integral_time: Some(drawn(check::INTEGRAL_TIME)).filter(|_| passed % 2 == 0),
            armature: drawn(check::ARMATURE),
        };
        robot.motors_mut().for_each(|it| *it = motor.clone());
        let (friction, damping) = (drawn(check::FRICTION), drawn(check::ROLLER_DAMPING));
        let (circle, angle) = (drawn(Range { least: 0.1, most: 0.86, unit: "" }), drawn(check::ROLLER_ANGLE));
        for joint in robot.links.iter_mut().filter_map(|link| link.joint.as_mut()) {
            joint.anchor.iter_mut().for_each(|coordinate| *coordinate *= size);
        }
        for wheel in robot.wheels_mut() {
            wheel.material.friction = friction;
            if let Some(rollers) = &mut wheel.rollers {
                rollers.axis_circle = circle * radius;
                rollers.angle = angle * rollers.angle.signum();
                rollers.damping = damping;
                rollers.material.friction = friction;
            }
        }
        let def =
            WorldDef { map: map.clone(), robots: [(robot.class.clone(), robot.clone())].into(), ..WorldDef::default() };
        if def.check().is_ok() {
            passed += 1;
            drive(&map, &robot, 1.0).unwrap_or_else(|problem| panic!("{passed}: {problem}\n{robot:#?}"));
        }
    }
}
