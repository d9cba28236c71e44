//! A scene's map and robot classes, compiled for the engine: shapes, masses and joints.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rapier3d::prelude::*;
use scene::{DriveModel, MapDef, Object, Part, Pose, RfidTag, RobotDef, Shape, Solid, position_and_rotation};

use super::articulated::{Articulated, CompiledObject, uniform};
use super::bodies;
use super::shape;
use super::surface::{Materials, Surface};
use crate::site::Site;

/// The solids and objects of a map.
pub(crate) struct CompiledMap {
    /// Gravity along +z, m/s².
    pub(super) gravity: f64,
    pub(super) solids: Vec<Surface>,
    pub(super) objects: Vec<CompiledObject>,
    pub(super) site: Arc<Site>,
    pub(super) tags: Vec<RfidTag>,
    /// Solids whose surfaces move, by number, with the velocity of the surface, world axes, m/s.
    pub(super) conveyors: Vec<(usize, Vector3<f64>)>,
}

impl CompiledMap {
    pub(crate) fn new(map: &MapDef, materials: &mut Materials) -> Self {
        let mut surface =
            |shape: &Shape, pose: &Pose, material| Surface::new(shape::shared(shape), pose, material, materials);
        let solids = map.solids.iter().map(|solid| surface(&solid.shape, &solid.pose(), &solid.material)).collect();
        let objects = map.objects.iter().map(|object| CompiledObject::new(Arc::new(object.clone()), materials));
        let conveyors = map.conveyors.iter().filter_map(|it| {
            let pose = map.solids.get(it.solid)?.pose();
            Some((it.solid, pose.rotation * Vector3::from(it.velocity)))
        });
        Self {
            gravity: map.gravity,
            objects: objects.collect(),
            conveyors: conveyors.collect(),
            solids,
            site: Arc::new(Site::new(map)),
            tags: map.tags.clone(),
        }
    }
}

impl CompiledObject {
    /// Compiles an object. Its pose is left out.
    pub(super) fn new(def: Arc<Object>, materials: &mut Materials) -> Self {
        let Solid { shape, material, .. } = &def.solid;
        let surface = Surface::new(shape::shared(shape), &Pose::identity(), material, materials);
        let compiled = Arc::new(Articulated::of_object(surface.clone(), def.mass, material));
        Self { def, surface, compiled }
    }
}

/// A robot class, compiled for the engine.
pub(crate) struct CompiledRobot {
    /// Its definition.
    pub(crate) def: RobotDef,
    /// Outlines in the robot frame: solids, wheels as discs, and casters as balls.
    pub(super) outlines: Vec<(Pose, SharedShape)>,
    pub(super) mechanism: CompiledMechanism,
}

/// The tree of a robot class, by drive model.
pub(super) enum CompiledMechanism {
    /// A multibody of the engine.
    Bodies(Arc<bodies::Tree>),
    /// A tree in reduced coordinates.
    Articulated(Arc<Articulated>),
}

/// An object that is part of a robot's link.
pub(crate) struct Held<'a> {
    /// Number of the link.
    pub(crate) link: usize,
    /// Pose of its shape in the robot frame when every joint is at 0.
    pub(crate) at: Pose,
    pub(crate) object: &'a Object,
}

/// Returns a class with objects fixed to its links.
pub(super) fn with_held<'a>(class: &RobotDef, held: impl IntoIterator<Item = Held<'a>>) -> RobotDef {
    let mut fitted = class.clone();
    for Held { link, at, object: tool } in held {
        let Some(link) = fitted.links.get_mut(link) else { continue };
        let mass = uniform(&shape::shared(&tool.solid.shape), tool.mass);
        let turn = at.rotation.to_rotation_matrix();
        link.parts.push(Part {
            name: tool.solid.name.clone(),
            mass: mass.mass,
            centre: (at * Point3::from(mass.centre)).coords,
            inertia: turn * mass.inertia * turn.inverse(),
        });
        let (position, rotation) = position_and_rotation(&at);
        link.solids.push(Solid { position, rotation, ..tool.solid.clone() });
    }
    fitted
}

/// Returns a car whose joints turn as far as its axles do; `None` for any other robot.
fn steered(def: &RobotDef) -> Option<RobotDef> {
    let limits = base_motion::joint_limits(def);
    if limits.is_empty() {
        return None;
    }
    let mut car = def.clone();
    for (number, limits) in limits {
        if let Some(joint) = car.links.get_mut(number).and_then(|link| link.joint.as_mut()) {
            joint.limits = Some(limits);
        }
    }
    Some(car)
}

impl CompiledRobot {
    pub(crate) fn new(def: RobotDef, materials: &mut Materials) -> Self {
        let shapes: Vec<SharedShape> = def.body_solids().iter().map(|solid| shape::shared(&solid.shape)).collect();
        let steered = steered(&def);
        let moving = steered.as_ref().unwrap_or(&def);
        let mechanism = match def.drive_model {
            DriveModel::Bodies => CompiledMechanism::Bodies(Arc::new(bodies::Tree::new(moving, &shapes, materials))),
            _ => CompiledMechanism::Articulated(Arc::new(Articulated::new(moving, &shapes, materials))),
        };
        let solids = def.body_solids().iter().zip(shapes).map(|(solid, shape)| (solid.pose(), shape));
        let carried = def.links.iter().skip(1).flat_map(|link| &link.solids);
        let solids = solids.chain(carried.map(|solid| (solid.pose(), shape::shared(&solid.shape))));
        let wheels = def.wheels().map(|wheel| (wheel.pose(0.0), shape::outline(&wheel)));
        Self { outlines: solids.chain(wheels).collect(), mechanism, def }
    }
}
