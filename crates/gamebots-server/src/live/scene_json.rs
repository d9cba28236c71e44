//! The scene as a viewer gets it: the definitions, with what a viewer would have to work out itself worked out.

use scene::{Link, MapDef, MountedWheel, NamedPose, Pose, RobotDef, Shape, Solid, WorldDef};
use serde_json::{Value, json};

/// Pieces of cones that a roller is drawn by.
const ROLLER_PIECES: u32 = 8;

/// The map and every class of robot as JSON. Poses are `[x, y, z, qx, qy, qz, qw]` in the frame of what they are in.
pub(crate) fn scene_json(world: &WorldDef, seed: u64, port: u16) -> Value {
    let WorldDef { map, robots } = world;
    let classes: serde_json::Map<String, Value> =
        robots.iter().map(|(class, def)| (class.clone(), class_json(def))).collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "seed": seed,
        "port": port,
        "map": map_json(map),
        "classes": classes,
    })
}

fn map_json(map: &MapDef) -> Value {
    let objects = map.objects.iter().map(|object| solid(&object.solid));
    json!({
        "name": map.name,
        "description": map.description,
        "solids": map.solids.iter().map(solid).collect::<Vec<_>>(),
        "objects": objects.collect::<Vec<_>>(),
        "starts": map.starts.iter().map(named).collect::<Vec<_>>(),
        "path_nodes": map.path_nodes.iter().map(named).collect::<Vec<_>>(),
    })
}

fn class_json(def: &RobotDef) -> Value {
    let sensor = |sensor: &scene::SensorDef| {
        json!({
            "name": sensor.name,
            "pose": pose(&scene::pose(sensor.position, sensor.direction)),
            "max_range": sensor.config.max_range(),
            "fan": sensor.config.fan().map(|fan| json!({
                "first": fan.first, "resolution": fan.resolution, "level": fan.level,
            })),
        })
    };
    let casters = def.wheels().filter(|wheel| wheel.drive.is_none());
    let geometry = def.wheel_geometry();
    json!({
        "description": def.description,
        "steering": def.steering.wire_name(),
        "drive_model": def.drive_model.name(),
        "wheel_radius": geometry.radius,
        "track": geometry.track,
        "wheel_base": geometry.wheel_base,
        "solids": def.body_solids().iter().map(solid).collect::<Vec<_>>(),
        "links": def.links.iter().skip(1).filter(|link| link.wheel.is_none()).map(link).collect::<Vec<_>>(),
        "wheels": def.driven().map(|it| wheel(def, it)).collect::<Vec<_>>(),
        "casters": casters.map(|caster| json!({
            "position": caster.position, "radius": caster.radius, "colour": caster.material.colour,
        })).collect::<Vec<_>>(),
        "sensors": def.sensors.iter().map(sensor).collect::<Vec<_>>(),
    })
}

/// A link with its shapes in its own frame.
fn link(link: &Link) -> Value {
    let moved = |solid: &Solid| solid_at(solid, &link.pose_of(solid));
    json!({ "name": link.name, "solids": link.solids.iter().map(moved).collect::<Vec<_>>() })
}

/// A wheel in the frame of the link that carries it: a number among `links`, or of the body none.
fn wheel(def: &RobotDef, wheel: MountedWheel) -> Value {
    let carrier = def.links.get(wheel.parent).map_or([0.0; 3], Link::origin);
    let links = def.links.iter().enumerate().skip(1).filter(|(_, link)| link.wheel.is_none());
    let link = links.map(|(number, _)| number).position(|number| number == wheel.parent);
    let [x, y, z] = wheel.position;
    let [from_x, from_y, from_z] = carrier;
    let rollers = wheel.rollers.as_ref().map(|rollers| {
        json!({
            "poses": (0..rollers.count).map(|index| pose(&rollers.pose(index))).collect::<Vec<_>>(),
            "outline": rollers.outline(wheel.radius, ROLLER_PIECES),
            "hub_radius": rollers.hub_radius(wheel.radius),
            "colour": rollers.material.colour,
        })
    });
    json!({
        "name": wheel.name,
        "link": link,
        "position": [x - from_x, y - from_y, z - from_z],
        "radius": wheel.radius,
        "width": wheel.width,
        "colour": wheel.material.colour,
        "max_speed": wheel.drive.as_ref().map(|motor| motor.max_speed),
        "rollers": rollers,
    })
}

fn solid(solid: &Solid) -> Value {
    solid_at(solid, &solid.pose())
}

fn solid_at(solid: &Solid, at: &Pose) -> Value {
    let hull = match &solid.shape {
        Shape::Hull { points } => scene::hull_surface(points),
        _ => None,
    };
    json!({
        "name": solid.name,
        "shape": hull.as_ref().unwrap_or(&solid.shape),
        "pose": pose(at),
        "material": solid.material.name,
        "colour": solid.material.colour,
        "friction": solid.material.friction,
    })
}

fn named(place: &NamedPose) -> Value {
    json!({ "name": place.name, "position": place.position, "rotation": place.rotation })
}

fn pose(pose: &Pose) -> Vec<f64> {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).copied().collect()
}
