//! A world in which everything happens that robots do to each other.

use scene::{Material, Object, Shape, Solid, WorldDef};
use sim_core::{Options, World};

use crate::{apply, init};

/// Robots on the arena: alone, side by side, in heaps, in the air, in the engine's model, and against crates.
const ROBOTS: [(&str, &str, &str); 14] = [
    ("P3AT", "-3,-3,-0.2", "DRIVE {Left 2}{Right -1}"),
    ("P3AT", "-3,-1,-0.2", "DRIVE {Left 1}{Right 2}"),
    ("P3AT", "-3,-1,-0.6", "DRIVE {Left 2}{Right 2}"),
    ("Kenaf", "-3,1,-0.3", "DRIVE {Left 2}{Right 2}"),
    ("Kenaf", "-3,1.1,-0.8", "DRIVE {Left -2}{Right 2}"),
    ("YouBot", "0,0,-0.2", "DRIVE {Left 3}{Right 3}"),
    ("YouBot", "0,1,-0.2", "DRIVE {Front-Left 3}{Front-Right -3}{Back-Left -3}{Back-Right 3}"),
    ("KUKA_YouBot", "0,-1,-0.2", "DRIVE {Left 3}{Right 3}"),
    ("P3AT", "0.8,-1,-0.2", "DRIVE {Left 0}{Right 0}"),
    ("AirRobot", "-1,-3,-1", "DRIVE {LinearVelocity 0.5} {AltitudeVelocity -0.3}"),
    ("P2AT", "2,-2,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("P2AT", "2,0,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("P2AT", "2,2,-0.2", "DRIVE {Left 2}{Right 2}"),
    ("BasicSkidRobot", "-1,3,-0.2", "DRIVE {Left 2}{Right 1}"),
];

/// Returns the arena with crates.
///
/// # Panics
/// If the map does not load.
pub fn busy_scene() -> WorldDef {
    let mut def = scene_loader::load("arena", &[]).unwrap_or_else(|error| panic!("{error}"));
    for (number, x) in [0.5, 1.0, 2.6].into_iter().enumerate() {
        let (name, shape) = (format!("crate {number}"), Shape::Box { size: [0.2; 3] });
        let solid = Solid { name, shape, position: [x, 0.0, -0.1], rotation: [0.0; 3], material: Material::default() };
        def.map.objects.push(Object { solid, mass: 1.0 });
    }
    def
}

/// Returns a world of the busy scene at time zero, in which robots drive.
pub fn busy_world(scene: WorldDef) -> World {
    let mut world = World::new(scene, Options { seed: 7, ..Options::default() });
    for (class, place, line) in ROBOTS {
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}"));
        apply(&mut world, robot, line);
    }
    world
}
