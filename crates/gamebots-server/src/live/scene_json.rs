//! The scene for viewers: the definitions, together with derived values, so that a viewer needs no formulas of its own.
//!
//! Shapes are serialized directly: as a tree of JSON values, the meshes of a map would take a gigabyte.

use std::borrow::Cow;
use std::collections::BTreeMap;

use scene::{
    Drawn, Geometry, Gripper, JointKind, Link, MapDef, MountedWheel, NamedPose, ObjectSnapshot, Pose, RobotDef, Shape,
    WorldDef,
};
use serde::Serialize;
use serde_json::{Value, json};

use crate::cameras::SIZE;

/// The server's settings that a page needs beside the world.
#[derive(Debug, Clone)]
pub(crate) struct About {
    pub(crate) seed: u64,
    /// Time step, s.
    pub(crate) time_step: f64,
    /// Port for controllers.
    pub(crate) port: u16,
    /// Maps that it can change to, with their descriptions.
    pub(crate) maps: Vec<(String, String)>,
}

#[derive(Serialize)]
struct Scene<'a> {
    #[serde(flatten)]
    rest: Value,
    map: Map<'a>,
    classes: BTreeMap<&'a str, Class<'a>>,
}

#[derive(Serialize)]
struct Map<'a> {
    #[serde(flatten)]
    rest: Value,
    solids: Vec<Solid<'a>>,
    objects: Vec<Solid<'a>>,
}

#[derive(Serialize)]
struct Solid<'a> {
    #[serde(flatten)]
    rest: Value,
    shape: Cow<'a, Shape>,
}

#[derive(Serialize)]
struct Class<'a> {
    #[serde(flatten)]
    rest: Value,
    /// Pieces of the body.
    drawn: Vec<Piece<'a>>,
    /// Links except the body and driven wheels.
    links: Vec<Part<'a>>,
    /// Driven wheels.
    wheels: Vec<Part<'a>>,
}

#[derive(Serialize)]
struct Spawned<'a> {
    number: u64,
    #[serde(flatten)]
    solid: Solid<'a>,
}

#[derive(Serialize)]
struct Part<'a> {
    #[serde(flatten)]
    rest: Value,
    /// Pieces except rollers.
    drawn: Vec<Piece<'a>>,
}

#[derive(Serialize)]
struct Piece<'a> {
    shape: Cow<'a, Shape>,
    pose: Vec<f64>,
    colour: [f64; 3],
}

/// Returns the map and every robot class as JSON. Poses are `[x, y, z, qx, qy, qz, qw]` in the frame of their parent. Without
/// `about`, as for a log's world, it has no settings of a server.
pub(crate) fn scene_json(world: &WorldDef, about: Option<&About>) -> String {
    let maps = about.iter().flat_map(|about| &about.maps);
    let maps = maps.map(|(name, description)| json!({ "name": name, "description": description }));
    let rest = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "seed": about.map(|about| about.seed),
        "time_step": about.map(|about| about.time_step),
        "port": about.map(|about| about.port),
        "maps": maps.collect::<Vec<_>>(),
    });
    let classes = world.robots.iter().map(|(name, def)| (name.as_str(), class(def))).collect();
    // Every key is a string, so serialization cannot fail.
    serde_json::to_string(&Scene { rest, map: map(&world.map), classes }).unwrap_or_default()
}

fn map(map: &MapDef) -> Map<'_> {
    let rest = json!({
        "name": map.name,
        "description": map.description,
        "starts": map.starts.iter().map(named).collect::<Vec<_>>(),
        "path_nodes": map.path_nodes.iter().map(named).collect::<Vec<_>>(),
    });
    let objects = map.objects.iter().map(|object| solid(&object.solid));
    Map { rest, solids: map.solids.iter().map(solid).collect(), objects: objects.collect() }
}

fn class(def: &RobotDef) -> Class<'_> {
    let sensor = |sensor: &scene::SensorDef| {
        json!({
            "name": sensor.name,
            "link": link_number(def, sensor.link),
            "pose": def.mount_of(sensor).map(|(_, _, mount)| pose(&mount)),
            "camera": sensor.config.is_camera().then(|| json!({ "width": SIZE[0], "height": SIZE[1] })),
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
    // Poses with every joint at 0: logs from before robots were trees do not have them.
    let at_rest = def.placed_links(&[]);
    let links = drawn.iter().zip(&at_rest).skip(1).filter(|((link, _), _)| !link.is_driven_wheel());
    let links = links.map(|((link, pieces), (_, at))| {
        let rest = json!({ "name": link.name, "pose": pose(at) });
        Part { rest, drawn: still(pieces) }
    });
    let geometry = def.wheel_geometry();
    let max_steer = [0, 1].map(|axle| most_steered(def, axle));
    let rest = json!({
        "description": def.description,
        "steering": def.steering.wire_name(),
        "max_steer": max_steer,
        "drive_model": def.drive_model.name(),
        "wheel_radius": geometry.radius,
        "track": geometry.track,
        "wheel_base": geometry.wheel_base,
        // Links in the order of a log's joint_positions.
        "values": def.with_values().map(|link| &link.name).collect::<Vec<_>>(),
        "joints": def.with_values().filter_map(joint).collect::<Vec<_>>(),
        "grippers": def.grippers.iter().map(|it| gripper(def, it)).collect::<Vec<_>>(),
        "sensors": def.sensors.iter().map(sensor).collect::<Vec<_>>(),
    });
    let body = drawn.first().map_or_else(Vec::new, |(_, pieces)| still(pieces));
    Class { rest, drawn: body, links: links.collect(), wheels: wheels.collect() }
}

/// Describes a joint that takes positions by `SET {Type Joint}`, rad or m.
fn joint(link: &Link) -> Option<Value> {
    let [min, max] = link.position_limits()?;
    let slides = link.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Prismatic);
    Some(json!({ "name": link.name, "min": min, "max": max, "unit": if slides { "m" } else { "rad" } }))
}

/// Describes a gripper: its joints by name, and their positions when open and when closed.
fn gripper(def: &RobotDef, gripper: &Gripper) -> Value {
    let joints = gripper.links.iter().filter_map(|&link| def.links.get(link));
    let joints = joints.map(|link| &link.name).collect::<Vec<_>>();
    json!({ "name": gripper.name, "joints": joints, "open": gripper.open, "closed": gripper.closed })
}

/// Returns the largest angle that all joints of an axle can steer to both sides, rad.
fn most_steered(def: &RobotDef, axle: usize) -> f64 {
    def.steering_limits(axle).map(|[least, most]| most.min(-least)).reduce(f64::min).unwrap_or(0.0)
}

/// Describes a wheel in the frame of its carrier. `link` is the carrier's index in `links`, or null for the body.
fn wheel<'a>(def: &RobotDef, wheel: MountedWheel, drawn: &[Drawn<'a>]) -> Part<'a> {
    let carrier = def.links.get(wheel.parent).map_or([0.0; 3], Link::origin);
    let [x, y, z] = wheel.position;
    let [from_x, from_y, from_z] = carrier;
    let rollers: Vec<&Drawn> = drawn.iter().filter(|it| it.is_roller).collect();
    let outline = rollers.first().and_then(|it| match &it.geometry {
        Geometry::Revolved(outline) => Some((outline, it.colour)),
        Geometry::Shape(_) => None,
    });
    let rest = json!({
        "name": wheel.name,
        "link": link_number(def, wheel.parent),
        "position": [x - from_x, y - from_y, z - from_z],
        "max_speed": wheel.drive.as_ref().map(|motor| motor.max_speed),
        "rollers": outline.map(|(outline, colour)| json!({
            "poses": rollers.iter().map(|roller| pose(&roller.pose)).collect::<Vec<_>>(),
            "outline": outline,
            "colour": colour,
        })),
    });
    Part { rest, drawn: still(drawn) }
}

/// Returns a link's index among the page's links; `None` for the body and driven wheels.
fn link_number(def: &RobotDef, link: usize) -> Option<usize> {
    let links = def.links.iter().enumerate().skip(1).filter(|(_, link)| !link.is_driven_wheel());
    links.map(|(number, _)| number).position(|number| number == link)
}

/// Returns the drawn pieces of a link, except rollers, in its frame.
fn still<'a>(drawn: &[Drawn<'a>]) -> Vec<Piece<'a>> {
    let piece = |it: &Drawn<'a>| match &it.geometry {
        Geometry::Shape(drawn) => Some(Piece { shape: shape(drawn.clone()), pose: pose(&it.pose), colour: it.colour }),
        Geometry::Revolved(_) => None,
    };
    drawn.iter().filter_map(piece).collect()
}

/// Returns a shape that a viewer can draw: a hull becomes its surface.
fn shape(shape: Cow<'_, Shape>) -> Cow<'_, Shape> {
    match &*shape {
        Shape::Hull { points } => scene::hull_surface(points).map_or(shape, Cow::Owned),
        _ => shape,
    }
}

fn solid(solid: &scene::Solid) -> Solid<'_> {
    let rest = json!({
        "name": solid.name,
        "pose": pose(&solid.pose()),
        "material": solid.material.name,
        "colour": solid.material.colour,
        "friction": solid.material.friction,
    });
    Solid { rest, shape: shape(Cow::Borrowed(&solid.shape)) }
}

/// Returns objects beside the map's as JSON.
pub(crate) fn objects_json(objects: &[ObjectSnapshot]) -> String {
    let objects = objects.iter().map(|object| Spawned { number: object.id.0, solid: solid(&object.def.solid) });
    serde_json::to_string(&objects.collect::<Vec<_>>()).unwrap_or_default()
}

fn named(place: &NamedPose) -> Value {
    json!({ "name": place.name, "position": place.position, "rotation": place.rotation })
}

fn pose(pose: &Pose) -> Vec<f64> {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).copied().collect()
}
