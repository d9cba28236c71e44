//! The scene as a viewer gets it: the definitions, with what a viewer would have to work out itself worked out.

use std::borrow::Cow;

use scene::{Drawn, Geometry, Link, MapDef, MountedWheel, NamedPose, Pose, RobotDef, Shape, Solid, WorldDef};
use serde_json::{Value, json};

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
            "link": link_number(def, sensor.link),
            "pose": def.mount_of(sensor).map(|(_, _, mount)| pose(&mount)),
            "max_range": sensor.config.max_range(),
            "fan": sensor.config.fan().map(|fan| json!({
                "first": fan.first, "resolution": fan.resolution, "level": fan.level,
            })),
        })
    };
    let drawn: Vec<_> = def.drawn().collect();
    let wheels = drawn.iter().enumerate().filter_map(|(number, (link, pieces))| {
        let wheel = MountedWheel::of((number, link)).filter(|wheel| wheel.drive.is_some())?;
        Some(self::wheel(def, wheel, pieces))
    });
    let links = drawn.iter().skip(1).filter(|(link, _)| !link.is_driven_wheel());
    let links = links.map(|(link, pieces)| json!({ "name": link.name, "drawn": still(pieces) }));
    let geometry = def.wheel_geometry();
    let max_steer = [0, 1].map(|axle| most_steered(def, axle));
    json!({
        "description": def.description,
        "steering": def.steering.wire_name(),
        "max_steer": max_steer,
        "drive_model": def.drive_model.name(),
        "wheel_radius": geometry.radius,
        "track": geometry.track,
        "wheel_base": geometry.wheel_base,
        "drawn": drawn.first().map(|(_, pieces)| still(pieces)),
        "links": links.collect::<Vec<_>>(),
        "wheels": wheels.collect::<Vec<_>>(),
        "joints": def.with_values().filter_map(joint).collect::<Vec<_>>(),
        "sensors": def.sensors.iter().map(sensor).collect::<Vec<_>>(),
    })
}

/// A joint that goes to positions by `SET {Type Joint}`, rad or m.
fn joint(link: &Link) -> Option<Value> {
    let joint = link.joint.as_ref()?;
    let goes = joint.drive.as_ref().is_some_and(|motor| motor.stiffness.is_some());
    let [min, max] = joint.limits.filter(|_| goes)?;
    Some(json!({ "name": link.name, "min": min, "max": max }))
}

/// How far the joints of an axle steer to both sides, rad.
fn most_steered(def: &RobotDef, axle: usize) -> f64 {
    def.steering_limits(axle).map(|[least, most]| most.min(-least)).reduce(f64::min).unwrap_or(0.0)
}

/// A wheel in the frame of the link that carries it: a number among `links`, or of the body none.
fn wheel(def: &RobotDef, wheel: MountedWheel, drawn: &[Drawn]) -> Value {
    let carrier = def.links.get(wheel.parent).map_or([0.0; 3], Link::origin);
    let [x, y, z] = wheel.position;
    let [from_x, from_y, from_z] = carrier;
    let rollers: Vec<&Drawn> = drawn.iter().filter(|it| it.is_roller).collect();
    let outline = rollers.first().and_then(|it| match &it.geometry {
        Geometry::Revolved(outline) => Some((outline, it.colour)),
        Geometry::Shape(_) => None,
    });
    json!({
        "name": wheel.name,
        "link": link_number(def, wheel.parent),
        "position": [x - from_x, y - from_y, z - from_z],
        "drawn": still(drawn),
        "max_speed": wheel.drive.as_ref().map(|motor| motor.max_speed),
        "rollers": outline.map(|(outline, colour)| json!({
            "poses": rollers.iter().map(|roller| pose(&roller.pose)).collect::<Vec<_>>(),
            "outline": outline,
            "colour": colour,
        })),
    })
}

/// The number of a link among those that the page has; of the body none.
fn link_number(def: &RobotDef, link: usize) -> Option<usize> {
    let links = def.links.iter().enumerate().skip(1).filter(|(_, link)| !link.is_driven_wheel());
    links.map(|(number, _)| number).position(|number| number == link)
}

/// What is drawn of a link beside rollers, in its frame.
fn still(drawn: &[Drawn]) -> Vec<Value> {
    let piece = |it: &Drawn| match &it.geometry {
        Geometry::Shape(drawn) => Some(json!({ "shape": shape(drawn), "pose": pose(&it.pose), "colour": it.colour })),
        Geometry::Revolved(_) => None,
    };
    drawn.iter().filter_map(piece).collect()
}

/// A shape that a viewer can draw: a hull as its surface.
fn shape(shape: &Shape) -> Cow<'_, Shape> {
    match shape {
        Shape::Hull { points } => scene::hull_surface(points).map_or(Cow::Borrowed(shape), Cow::Owned),
        _ => Cow::Borrowed(shape),
    }
}

fn solid(solid: &Solid) -> Value {
    json!({
        "name": solid.name,
        "shape": shape(&solid.shape),
        "pose": pose(&solid.pose()),
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
