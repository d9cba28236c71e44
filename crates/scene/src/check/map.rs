//! Checks of maps.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::limits::*;
use super::shape::{hull_points, solid, triangles};
use super::{SceneProblem, count, first, shown, text, wire_name};
use crate::{Conveyor, MapDef, Material, NamedPose, Object, RfidTag, Shape, Smoke, Solid, Sound, Victim};

pub(super) fn check_map(def: &MapDef) -> Result<(), SceneProblem> {
    first("the map", map(def))?;
    let solids = def.solids.iter().map(|it| (it, map_solid(it)));
    let objects = def.objects.iter().map(|it| (&it.solid, object(it)));
    let markings = def.markings.iter().map(|it| (it, map_solid(it)));
    for (it, wrong) in solids.chain(objects).chain(markings) {
        first(&format!("the map, solid {}", shown(&it.name)), wrong.into_iter().chain(material(&it.material)))?;
    }
    for (number, it) in def.conveyors.iter().enumerate() {
        let solid = def.solids.get(it.solid);
        let wrong = conveyor(it, solid.map(|solid| &solid.shape));
        let name = solid.map_or_else(|| number.to_string(), |solid| shown(&solid.name));
        first(&format!("the map, conveyor {name}"), wrong)?;
    }
    for pose in def.starts.iter().chain(&def.path_nodes) {
        first(&format!("the map, pose {}", shown(&pose.name)), named_pose(pose))?;
    }
    let victims = def.victims.iter().map(|it| (it.name.clone(), victim(it)));
    let tags = def.tags.iter().map(|it| (format!("tag {}", it.id), tag(it)));
    let smoke = def.smoke.iter().map(|it| (it.name.clone(), smoke(it)));
    let sounds = def.sounds.iter().map(|it| (it.name.clone(), sound(it)));
    let mut all = victims.chain(tags).chain(smoke).chain(sounds);
    all.try_for_each(|(name, wrong)| first(&format!("the map, {}", shown(&name)), wrong))
}

/// Lists the problems of a victim; its solids have their own checks.
pub fn victim(def: &Victim) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong.extend(SHARE.problem("co2", def.co2));
    wrong
}

/// Lists the problems of an RFID tag.
pub fn tag(def: &RfidTag) -> Vec<String> {
    let mut wrong: Vec<String> = MAP_REACH.problem_in("position", &def.position).into_iter().collect();
    let length = def.memory.chars().count();
    let good = length <= MAX_NAME && !def.memory.contains(|c: char| c.is_control() || c == '{' || c == '}');
    wrong.extend((!good).then(|| format!("`memory`: expected at most {MAX_NAME} characters without braces")));
    wrong
}

/// Lists the problems of a box of smoke.
pub fn smoke(def: &Smoke) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(MAP_SIZE.problem_in("size", &def.size));
    wrong.extend(SMOKE_DENSITY.problem("density", def.density));
    wrong
}

/// Lists the problems of a source of sounds.
pub fn sound(def: &Sound) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(SHARE.problem("volume", def.volume));
    wrong.extend(SOUND_TIME.problem("duration", def.duration));
    wrong.extend(SOUND_TIME.problem("interval", def.interval));
    wrong
}

/// Checks the classes of objects.
pub(super) fn check_classes(classes: &BTreeMap<String, Object>) -> Result<(), SceneProblem> {
    first("the classes of objects", count("classes of objects", classes.len(), MAX_OBJECTS))?;
    classes.iter().try_for_each(|(name, class)| {
        let wrong = object(class).into_iter().chain(material(&class.solid.material));
        first(&format!("the class of objects {}", shown(name)), wrong)
    })
}

/// Lists the problems of a map as a whole; its solids and poses have their own checks.
pub fn map(def: &MapDef) -> Vec<String> {
    let objects = || def.objects.iter().map(|object| &object.solid);
    let shapes = || def.solids.iter().chain(&def.markings).chain(objects()).map(|solid| &solid.shape);
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(text("description", &def.description));
    wrong.extend(GRAVITY.problem("gravity", def.gravity));
    wrong.extend(count("solids", def.solids.len(), MAX_SOLIDS));
    wrong.extend(count("markings", def.markings.len(), MAX_SOLIDS));
    wrong.extend(count("conveyors", def.conveyors.len(), MAX_SOLIDS));
    wrong.extend(count("objects", def.objects.len(), MAX_OBJECTS));
    wrong.extend(count("start poses", def.starts.len(), MAX_POSES));
    wrong.extend(count("path nodes", def.path_nodes.len(), MAX_POSES));
    wrong.extend(ANGLE.problem("north", def.north));
    wrong.extend(def.origin.and_then(|origin| LATITUDE.problem("latitude", origin.latitude)));
    wrong.extend(def.origin.and_then(|origin| LONGITUDE.problem("longitude", origin.longitude)));
    wrong.extend(count("victims", def.victims.len(), MAX_POSES));
    wrong.extend(count("RFID tags", def.tags.len(), MAX_TAGS));
    wrong.extend(count("boxes of smoke", def.smoke.len(), MAX_SMOKE));
    wrong.extend(count("sounds", def.sounds.len(), MAX_POSES));
    wrong.extend(count("robots", def.robots.len(), MAX_ROBOTS));
    wrong.extend(def.robots.iter().flat_map(|class| wire_name("robots", class)));
    wrong.extend(count("triangles", shapes().map(triangles).sum(), MAX_TRIANGLES));
    wrong.extend(count("corners of hulls", shapes().map(hull_points).sum(), MAX_HULL_POINTS));
    wrong
}

/// Lists the problems of a material.
pub fn material(def: &Material) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    for (range, key, value) in [
        (FRICTION, "friction", def.friction),
        (SHARE, "restitution", def.restitution),
        (SHARE, "rolling_resistance", def.rolling_resistance),
        (BODY_DAMPING, "linear_damping", def.linear_damping),
        (BODY_DAMPING, "angular_damping", def.angular_damping),
    ] {
        wrong.extend(range.problem(key, value));
    }
    wrong.extend(SHARE.problem_in("colour", &def.colour));
    wrong.extend(text("source", &def.source));
    wrong
}

/// Lists the problems of a named pose on a map.
pub fn named_pose(def: &NamedPose) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(MAP_REACH.problem_in("position", &def.position));
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong
}

/// Lists the problems of a solid of a map; its material has its own check.
pub fn map_solid(def: &Solid) -> Vec<String> {
    let mut wrong = wire_name("name", &def.name);
    wrong.extend(solid(def, MAP_REACH, MAP_SIZE));
    if wrong.is_empty() {
        wrong.extend(height(def));
    }
    wrong
}

/// Lists the problems of a conveyor with the shape of its solid.
pub fn conveyor(def: &Conveyor, shape: Option<&Shape>) -> Vec<String> {
    let is_box = matches!(shape, Some(Shape::Box { .. }));
    let mut wrong: Vec<String> = CONVEYOR_SPEED.problem_in("conveyor", &def.velocity).into_iter().collect();
    wrong.extend((!is_box).then(|| "a conveyor of another shape: expected a box".to_owned()));
    wrong
}

/// Lists the problems of an object of a map; its material has its own check.
pub fn object(def: &Object) -> Vec<String> {
    let mut wrong = map_solid(&def.solid);
    if matches!(def.solid.shape, Shape::HalfSpace | Shape::Mesh { .. } | Shape::HeightField(_)) {
        wrong.push("a mass: expected a box, a cylinder, a ball or a hull".to_owned());
    }
    wrong.extend(BODY_MASS.problem("mass", def.mass));
    wrong
}

/// Lists the problems of an object that the map does not have. Its name came over the wire and may hold what a map's cannot.
pub fn spawned_object(def: &Object) -> Vec<String> {
    let solid = Solid { name: "object".to_owned(), ..def.solid.clone() };
    let mut wrong = object(&Object { solid, mass: def.mass });
    wrong.extend(material(&def.solid.material));
    wrong.extend(text("name", &def.solid.name));
    wrong
}

/// Checks the height from the lowest to the highest point of a solid in its pose.
fn height(def: &Solid) -> Option<String> {
    let turn = def.pose().rotation;
    let down = turn.inverse() * Vector3::z();
    let height = match &def.shape {
        Shape::HalfSpace | Shape::Mesh { .. } | Shape::HeightField(_) => return None,
        Shape::Box { size } => Vector3::from(*size).dot(&down.abs()),
        Shape::Cylinder { radius, length } => length * down.z.abs() + 2.0 * radius * down.xy().norm(),
        Shape::Ball { radius } => 2.0 * radius,
        Shape::Hull { points } => {
            let depths = || points.iter().map(|point| Vector3::from(*point).dot(&down));
            depths().fold(f64::MIN, f64::max) - depths().fold(f64::MAX, f64::min)
        }
    };
    SOLID_HEIGHT.problem("height", height)
}
