use nalgebra::{Matrix3, Vector3};
use scene::{Link, MapDef, Material, Motor, Part, RobotDef, Shape, Side, Solid, Steering, Wheel, WorldDef};

/// Builds the scene of a plane and a class of robots, `Cart`, with four driven wheels of 0.1 m.
pub(crate) fn cart_on_a_plane() -> WorldDef {
    let material = Material { name: "rubber".to_owned(), friction: 0.8, ..Material::default() };
    let solid = |name: &str, shape: Shape| Solid {
        name: name.to_owned(),
        shape,
        position: [0.0; 3],
        rotation: [0.0; 3],
        material: material.clone(),
    };
    let floor = solid("floor", Shape::HalfSpace);
    let map = MapDef { name: "plane".to_owned(), gravity: 9.81, solids: vec![floor], ..MapDef::default() };

    let part =
        Part { name: "frame".to_owned(), mass: 10.0, centre: Vector3::zeros(), inertia: Matrix3::identity() * 0.2 };
    let solids = vec![solid("frame", Shape::Box { size: [0.4, 0.3, 0.1] })];
    let frame = Link { name: "frame".to_owned(), parts: vec![part], solids, ..Link::default() };
    let wheel = |name: &str, x: f64, y: f64, side: Side| {
        let motor = Motor {
            max_speed: 10.0,
            gain: 50.0,
            max_torque: 20.0,
            stiffness: None,
            integral_time: Some(0.05),
            armature: 0.0,
        };
        let material = material.clone();
        let wheel =
            Wheel { side, radius: 0.1, width: 0.05, mass: 0.5, material, rollers: None, belt: None, tyre: None };
        Link::of_wheel(name.to_owned(), [x, y, 0.03], Some(motor), wheel)
    };
    let links = vec![
        frame,
        wheel("FL", 0.15, -0.2, Side::Left),
        wheel("FR", 0.15, 0.2, Side::Right),
        wheel("BL", -0.15, -0.2, Side::Left),
        wheel("BR", -0.15, 0.2, Side::Right),
    ];
    let cart = RobotDef::new("Cart", Steering::Skid, links);
    WorldDef { map, robots: [("Cart".to_owned(), cart)].into(), ..WorldDef::default() }
}
