//! Floors of many faces: a wheel stands on them as on the plane that they make.

use scene::{DriveModel, HeightField, Material, Shape, Solid};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Half the edge of the floors, m, and faces along an edge.
const HALF: f64 = 2.0;
const FACES: usize = 17;

fn solid(shape: Shape, position: [f64; 3]) -> Solid {
    let material =
        Material { name: "floor".to_owned(), friction: 0.6, rolling_resistance: 0.02, ..Material::default() };
    Solid { name: "floor".to_owned(), shape, position, rotation: [0.0; 3], material }
}

/// Returns a flat mesh whose corners are moved about in the plane, so that its triangles have all shapes.
fn mesh() -> Shape {
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
    };
    let edge = 2.0 * HALF / FACES as f64;
    let corner = |index: usize| index as f64 * edge - HALF;
    let places = (0..=FACES).flat_map(|row| (0..=FACES).map(move |column| (row, column)));
    let vertices =
        places.map(|(row, column)| [corner(row) + 0.6 * edge * random(), corner(column) + 0.6 * edge * random(), 0.0]);
    let vertices = vertices.collect();
    let cells = (0..FACES).flat_map(|row| (0..FACES).map(move |column| (row * (FACES + 1) + column) as u32));
    let across = FACES as u32 + 1;
    let triangles = cells.flat_map(|at| [[at, at + across, at + 1], [at + 1, at + across, at + across + 1]]).collect();
    Shape::Mesh { vertices, triangles }
}

fn tiles() -> Vec<Solid> {
    let edge = 2.0 * HALF / FACES as f64;
    let place = |index: usize| (index as f64 + 0.5) * edge - HALF;
    let places = (0..FACES).flat_map(|row| (0..FACES).map(move |column| (row, column)));
    places
        .map(|(row, column)| solid(Shape::Box { size: [edge, edge, 0.2] }, [place(row), place(column), 0.1]))
        .collect()
}

/// Returns where a robot is after some seconds on a floor: x, y and heading.
fn drive(floor: &[Solid], class: &str, line: &str) -> [f64; 3] {
    let mut def = scene_loader::load("smooth", &[]).unwrap_or_else(|error| panic!("{error}"));
    def.map.solids = floor.to_vec();
    if let Some(robot) = def.robots.get_mut(class) {
        robot.set_drive_model(Some(DriveModel::Articulated));
    }
    let mut world = World::new(def, Options::default());
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0.03,0.05,-0.2}}"));
    run(&mut world, 1.0);
    apply(&mut world, robot, line);
    run(&mut world, 5.0);
    let pose = world.state(robot).expect("the robot").0.pose;
    let (_, _, yaw) = pose.rotation.euler_angles();
    [pose.translation.x, pose.translation.y, yaw]
}

#[test]
fn a_robot_drives_on_many_faces_as_on_one_plane() {
    let grid = HeightField { size: [2.0 * HALF; 2], columns: FACES, heights: vec![0.0; FACES * FACES] };
    let floors = [
        ("a box", vec![solid(Shape::Box { size: [2.0 * HALF, 2.0 * HALF, 0.2] }, [0.0, 0.0, 0.1])], 1e-5),
        ("triangles", vec![solid(mesh(), [0.0; 3])], 1e-5),
        ("a grid of heights", vec![solid(Shape::HeightField(grid), [0.0; 3])], 1e-5),
        // In the corner of four tiles a rim may rise by 0.03 mm.
        ("tiles", tiles(), 1e-3),
    ];
    let plane = [solid(Shape::HalfSpace, [0.0; 3])];
    for (class, line) in [
        ("P3AT", "DRIVE {Left 2}{Right -2}"),
        ("P3AT", "DRIVE {Left 3}{Right 1}"),
        ("P2DX", "DRIVE {Left 3}{Right 1}"),
        ("Kenaf", "DRIVE {Left 2}{Right -2}"),
        ("Kenaf", "DRIVE {Left 3}{Right 1}"),
        ("FrontAckerman", "DRIVE {Speed 1.5}{FrontSteer 0.3}{RearSteer 0}"),
    ] {
        let expected = drive(&plane, class, line);
        for (name, floor, most) in &floors {
            let found = drive(floor, class, line);
            let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
            println!("{class} {line} on {name}: off by {off:.6}");
            assert!(off < *most, "{class} {line} on {name}: {found:?}, on a plane {expected:?}");
        }
    }
}
