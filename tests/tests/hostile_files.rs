//! Files and scenes of strangers: what a world cannot be made with is refused by name, what is just within the bounds
//! keeps every number finite.

use nalgebra::Matrix3;
use sim_core::scene::{Battery, Object, RobotDef, Shape, Solid, WorldDef};
use sim_core::sensor::Config;

/// Every built-in robot on a map with a mesh, and something to push.
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

/// A scene from a log has not gone through the reader of files.
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
        p3at(|it| it.wheels[0].radius = 0.0019),
        "robot P3AT, wheel FRWheel: `radius` is 0.0019: expected 0.004 to 10 m",
    );
    check(p3at(|it| it.wheels[1].width = 1e-7), "robot P3AT, wheel FLWheel: `width` is 1e-7: expected 0.001 to 20 m");
    check(
        p3at(|it| it.wheels[0].mass = 1e-40),
        "robot P3AT, wheel FRWheel: `mass` is 1e-40: expected 0.001 to 10000 kg",
    );
    check(
        p3at(|it| it.wheels[0].position[0] = 1e308),
        "robot P3AT, wheel FRWheel: `position` is [1e308, 0.18, 0.048]: expected numbers of -100 to 100 m",
    );
    check(
        p3at(|it| it.wheels[0].position[1] = -0.18),
        "robot P3AT, wheel FRWheel: `position` has y -0.18: expected 0.001 m or more of a right wheel, as y is to the right",
    );
    check(
        p3at(|it| it.wheels[0].material.friction = f64::NAN),
        "robot P3AT, wheel FRWheel: `friction` is NaN: expected 0 to 10",
    );
    check(
        p3at(|it| it.wheels.iter_mut().flat_map(|wheel| &mut wheel.drive).for_each(|motor| motor.gain = f64::INFINITY)),
        "robot P3AT, wheel FRWheel: `gain` is inf: expected 1e-6 to 1000000 N m s/rad",
    );
    check(
        p3at(|it| it.solids[0].rotation[1] = f64::NAN),
        "robot P3AT, solid ChassisMiddle: `rotation` is [0, NaN, 0]: expected numbers of -1000 to 1000 rad",
    );
    check(
        p3at(|it| it.solids[0].shape = Shape::HalfSpace),
        "robot P3AT, solid ChassisMiddle: a shape without an end or without a volume: expected a box, a cylinder, a ball \
         or a hull",
    );
    check(
        p3at(|it| it.solids[0].shape = Shape::Hull { points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] }),
        "robot P3AT, solid ChassisMiddle: a hull of 3 points in one plane: expected a volume",
    );
    check(p3at(|it| it.parts[0].mass = 0.0), "robot P3AT, part ChassisMiddle: `mass` is 0: expected 1e-9 to 100000 kg");
    check(
        p3at(|it| it.parts[0].name = "a\u{7}b".to_owned()),
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
            robot.parts[0].inertia = Matrix3::from_diagonal(&moments.into());
        };
        check(set, &expected);
    }
    check(
        p3at(|it| it.parts[0].inertia[(0, 1)] = 1e-3),
        "robot P3AT, part ChassisMiddle: `inertia` is not symmetric: expected the same product of inertia for x y and y x",
    );
    check(
        p2dx(|it| it.parts[0].inertia *= 1e-5),
        "robot P2DX: its body's radius of gyration is 0.000270 m: expected 0.002084 (a hundredth of the way to its farthest wheel) to 100",
    );
    check(
        p2dx(|it| {
            it.parts[0].mass = 300.0;
            it.wheels[0].mass = 0.002;
        }),
        "robot P2DX: its body, wheels and rollers weigh 0.002 to 300 kg: expected at most 100000 times the lightest",
    );
    check(p3at(|it| it.wheels.clear()), "robot P3AT: no driven wheel: expected at least one");
    check(
        p3at(|it| it.wheels[1].drive = None),
        "robot P3AT: a driven wheel behind a caster: expected driven wheels first",
    );
    check(p3at(|it| it.wheels = vec![it.wheels[0].clone(); 33]), "robot P3AT: 33 wheels: expected at most 32");
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
        youbot(|it| it.wheels.swap(0, 1)),
        "robot YouBot: steering \"omni\": expected four wheels front left, front right, back left, back right with \
         `roller_angle` +, -, -, +",
    );
    check(
        youbot(|it| it.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.count = 33)),
        "robot YouBot, wheel FLWheel: `count` is 33: expected 3 to 32 rollers",
    );
    check(
        youbot(|it| it.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.axis_circle = 0.045)),
        "robot YouBot, wheel FLWheel: `axis_circle` is 0.045: expected 0.0050 to 0.0433 m",
    );
    check(
        youbot(|it| it.wheels.iter_mut().flat_map(|wheel| &mut wheel.rollers).for_each(|it| it.last_phase = 0.8)),
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
    check(|def| def.map.objects[0].mass = 1e-10, "the map, solid crate: `mass` is 1e-10: expected 0.001 to 100000 kg");
    check(
        |def| def.map.objects[0].solid.shape = Shape::HalfSpace,
        "the map, solid crate: a mass: expected a box, a cylinder, a ball or a hull",
    );
}
