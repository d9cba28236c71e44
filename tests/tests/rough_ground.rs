//! Wheels against an edge: the height that four driven wheels climb by friction, as plane statics has it.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use scene::{Link, MapDef, Material, Motor, Part, RobotDef, Shape, Side, Solid, Steering, Wheel, WorldDef};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

const RADIUS: f64 = 0.1;
const BASE: f64 = 0.4;
const MASS: f64 = 20.0;

/// Returns a world of a floor with a step of a height ahead, and a robot of four wheels whose mass lies between its axles.
fn world(height: f64, friction: f64) -> World {
    let material = Material { name: "rubber".to_owned(), friction, ..Material::default() };
    let solid = |name: &str, shape: Shape, position: [f64; 3]| Solid {
        name: name.to_owned(),
        shape,
        position,
        rotation: [0.0; 3],
        material: material.clone(),
    };
    let step = solid("step", Shape::Box { size: [4.0, 4.0, 1.0] }, [2.35, 0.0, 0.5 - height]);
    let solids = vec![solid("floor", Shape::HalfSpace, [0.0; 3]), step];
    let map = MapDef { name: "step".to_owned(), gravity: 9.81, solids, ..MapDef::default() };
    let inertia = Matrix3::from_diagonal(&Vector3::new(0.1, 0.3, 0.3));
    let part = Part { name: "body".to_owned(), mass: MASS, centre: Vector3::zeros(), inertia };
    // The body is small, so that it touches no edge.
    let solids = vec![solid("body", Shape::Box { size: [0.1, 0.2, 0.05] }, [0.0; 3])];
    let body = Link { name: "body".to_owned(), parts: vec![part], solids, ..Link::default() };
    let wheel = |name: &str, x: f64, y: f64, side: Side| {
        let motor = Motor {
            max_speed: 10.0,
            gain: 50.0,
            max_torque: 50.0,
            stiffness: None,
            integral_time: Some(0.05),
            armature: 0.0,
        };
        let (material, rollers, belt, tyre) = (material.clone(), None, None, None);
        let wheel = Wheel { side, radius: RADIUS, width: 0.05, mass: 0.01, material, rollers, belt, tyre };
        Link::of_wheel(name.to_owned(), [x, y, 0.0], Some(motor), wheel)
    };
    let links = vec![
        body,
        wheel("FL", BASE / 2.0, -0.2, Side::Left),
        wheel("FR", BASE / 2.0, 0.2, Side::Right),
        wheel("BL", -BASE / 2.0, -0.2, Side::Left),
        wheel("BR", -BASE / 2.0, 0.2, Side::Right),
    ];
    let robots = [("Cart".to_owned(), RobotDef::new("Cart", Steering::Skid, links))].into();
    World::new(WorldDef { map, robots, ..WorldDef::default() }, Options::default())
}

/// True if the front wheels climb the step within some seconds.
fn climbs(height: f64, friction: f64) -> bool {
    let mut world = world(height, friction);
    let robot = init(&mut world, "INIT {ClassName USARBot.Cart} {Location 0,0,-0.1}");
    run(&mut world, 0.5);
    // Slowly: at twice the speed it climbs 5 % more, by its run-up.
    apply(&mut world, robot, "DRIVE {Left 0.15} {Right 0.15}");
    run(&mut world, 25.0);
    let body = world.snapshot().robots[0].body;
    let (_, pitch, _) = body.pose.rotation.euler_angles();
    body.pose.translation.z < -RADIUS - 0.4 * height || pitch > 0.8 * (height / BASE).atan()
}

/// Computes the highest step by statics: with all wheels at the limit of friction the edge holds the front axle at an angle from the
/// vertical, at which forces and moments balance.
fn highest(friction: f64) -> f64 {
    let missing = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        // Loads of the rear axle and of the edge, over the weight, from the balance ahead and upward.
        let balance = Matrix2::new(friction, friction * cos - sin, 1.0, cos + friction * sin);
        let loads = balance.try_inverse().expect("two equations") * Vector2::new(0.0, 1.0);
        let [ahead, up] = [loads[1] * (friction * cos - sin), loads[1] * (cos + friction * sin)];
        // Moments about the rear wheel's contact.
        let (height, arm) = (RADIUS * (1.0 - cos), BASE + RADIUS * sin);
        up * arm - ahead * height - BASE / 2.0
    };
    // The edge takes more than its balance at small angles.
    let (mut low, mut high) = (0.01, 1.57);
    let sign = missing(low).signum();
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if missing(middle).signum() == sign { low = middle } else { high = middle }
    }
    RADIUS * (1.0 - low.cos())
}

#[test]
fn four_driven_wheels_climb_what_statics_lets_them() {
    for friction in [0.3, 0.4, 0.5, 0.6] {
        let highest = highest(friction);
        println!("friction {friction}: {:.2} of the radius", highest / RADIUS);
        for (share, expected) in [(0.5, true), (0.93, true), (1.07, false), (1.3, false)] {
            assert_eq!(climbs(share * highest, friction), expected, "friction {friction}, {share} of {highest:.4} m");
        }
    }
}
