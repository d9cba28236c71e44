//! A robot class compiled to a tree in reduced coordinates.

use std::sync::Arc;

use articulated::{Joint, Link, Mass, Tree};
use nalgebra::Vector3;
use rapier3d::prelude::SharedShape;
use scene::{Coupling, CouplingKind, DriveModel, Footing, JointKind, Material, MountedWheel, RobotDef, Rollers};

use super::super::motor::Value;
use super::super::rolling::{Driven, Hub};
use super::super::shape;
use super::super::surface::{Materials, Surface as ColliderSurface};
use super::following::Following;
use super::form::{Form, Surface};
use super::itself;
use super::ring::RollerRing;
use super::track::Track;
use super::tyre::Tread;

/// Data that the robots of a class share.
pub(in super::super) struct Articulated {
    pub(super) tree: Arc<Tree>,
    /// Mass of the robot with its load, kg.
    pub(super) mass: f64,
    /// The tree's link of each link of the definition, and the origin of the latter in it, m.
    pub(super) places: Vec<(usize, Vector3<f64>)>,
    pub(super) surfaces: Vec<Surface>,
    /// Joints that have a value, in the order of the definition's links.
    pub(super) joints: Vec<JointValue>,
    pub(super) gears: Vec<Gear>,
    /// Hubs of the wheels, including casters.
    pub(super) wheels: Vec<Hub>,
    pub(super) rings: Vec<Ring>,
    pub(super) tracks: Vec<Track>,
    /// Data to make the base follow its commands, if it does.
    pub(super) following: Option<Following>,
    /// Pairs of surfaces of the robot that may touch each other.
    pub(super) touching_itself: Vec<(usize, usize)>,
}

/// A movable object.
pub(in super::super) struct CompiledObject {
    pub(in super::super) def: Arc<scene::Object>,
    pub(in super::super) surface: ColliderSurface,
    pub(in super::super) compiled: Arc<Articulated>,
}

/// The rollers of a wheel.
pub(super) struct Ring {
    pub(super) shape: RollerRing,
    /// The link of the wheel.
    pub(super) wheel: usize,
    /// Link of the first roller, with the others behind it. `None` if rollers are not links: then their mass is on the wheel and they turn
    /// without inertia.
    pub(super) first_link: Option<usize>,
    /// Viscous friction of a roller's bearing, N m s/rad.
    pub(super) damping: f64,
    /// Dry friction of the bearing: force at the rim over the load.
    pub(super) bearing_friction: f64,
}

/// A joint that has a value.
pub(super) struct JointValue {
    pub(super) link: usize,
    pub(super) dof: usize,
    pub(super) value: Value,
    /// Dry friction, N m or N.
    pub(super) friction: f64,
}

/// A joint coupled to another. Each is given by its link and degree of freedom.
pub(super) struct Gear {
    pub(super) leader: (usize, usize),
    pub(super) follower: (usize, usize),
    pub(super) multiplier: f64,
    /// rad or m.
    pub(super) offset: f64,
}

impl Articulated {
    pub(in super::super) fn new(def: &RobotDef, shapes: &[SharedShape], materials: &mut Materials) -> Self {
        let mut made = Self {
            tree: Arc::new(Tree::new(Vec::new())),
            mass: f64::from(def.mass()),
            places: Vec::new(),
            surfaces: Vec::new(),
            joints: Vec::new(),
            gears: Vec::new(),
            wheels: Vec::new(),
            rings: Vec::new(),
            tracks: Vec::new(),
            following: Following::of(def),
            touching_itself: Vec::new(),
        };
        let mut links: Vec<Link> = Vec::new();
        for (number, link) in def.links.iter().enumerate() {
            let place = made.add_link(def, number, link, &mut links);
            made.places.push(place);
            match MountedWheel::of((number, link)) {
                Some(wheel) => made.add_wheel(def, &wheel, place, &mut links, materials),
                None => made.add_solids(link, place, if number == 0 { Some(shapes) } else { None }, materials),
            }
        }
        made.tree = Arc::new(Tree::new(links));
        for joint in &mut made.joints {
            joint.dof = made.tree.dof_of(joint.link);
        }
        for (number, link) in def.links.iter().enumerate() {
            if let Some(coupling) = link.joint.as_ref().and_then(|joint| joint.coupling) {
                made.add_coupling(def, number, coupling);
            }
        }
        let moved = made.joints.iter().filter(|joint| !joint.value.is_wheel);
        let moved = moved.filter_map(|joint| Some((joint.dof, joint.value.limits?)));
        made.touching_itself = itself::pairs(&made.tree, &made.surfaces, moved);
        made
    }

    /// Adds a link to the tree, or merges it into the link that it is fixed to.
    fn add_link(
        &mut self,
        def: &RobotDef,
        number: usize,
        link: &scene::Link,
        links: &mut Vec<Link>,
    ) -> (usize, Vector3<f64>) {
        let wheel = MountedWheel::of((number, link));
        let mut mass = match &wheel {
            Some(wheel) if rollers_are_links(def) => wheel.hub_mass(wheel.drive.is_some()),
            Some(wheel) => wheel.mass_with_rollers(wheel.drive.is_some()),
            None => link.mass(),
        };
        if wheel.is_none() {
            mass.centre -= Vector3::from(link.origin());
        }
        // A link without parts has no centre.
        let centre = if mass.mass > 0.0 { mass.centre } else { Vector3::zeros() };
        let mass = Mass { mass: mass.mass, centre, inertia: mass.inertia };
        let Some(joint) = &link.joint else {
            let is_free = def.footing != Footing::Fixed;
            let [linear_damping, damping] = def.body_damping();
            let root = Link::new(0, if is_free { Joint::Free } else { Joint::Fixed }, Vector3::zeros(), mass);
            links.push(Link { damping, linear_damping, ..root });
            return (0, Vector3::zeros());
        };
        let (parent, from) = self.places[joint.parent];
        let anchor = from + Vector3::from(joint.anchor) - Vector3::from(def.links[joint.parent].origin());
        let axis = Vector3::from(joint.axis);
        let kind = match joint.kind {
            JointKind::Fixed => {
                links[parent].mass = links[parent].mass.with(&mass, anchor);
                return (parent, anchor);
            }
            JointKind::Revolute | JointKind::Continuous => Joint::Revolute(axis),
            JointKind::Prismatic => Joint::Prismatic(axis),
            JointKind::Ball => Joint::Ball,
            JointKind::Belt => Joint::Belt { axis, radius: wheel.as_ref().map_or(0.0, |wheel| wheel.radius) },
        };
        links.push(Link {
            is_round: wheel.as_ref().is_some_and(|wheel| wheel.rollers.is_none() || !rollers_are_links(def)),
            damping: joint.damping,
            armature: joint.drive.as_ref().map_or(0.0, |motor| motor.armature)
                + wheel.as_ref().map_or(0.0, belt_inertia),
            ..Link::new(parent, kind, anchor, mass)
        });
        let own = links.len() - 1;
        if let Some(wheel) = &wheel {
            let is_driven = wheel.drive.is_some() && wheel.rollers.is_none();
            let driven = is_driven.then_some(Driven { link: own, radius: wheel.radius });
            self.wheels.push(Hub { carrier: parent, centre: anchor, driven });
        }
        if joint.kind.has_value() {
            let value = Value::new(joint, wheel.is_some());
            self.joints.push(JointValue { link: own, dof: 0, value, friction: joint.friction });
        }
        (own, Vector3::zeros())
    }

    fn add_wheel(
        &mut self,
        def: &RobotDef,
        wheel: &MountedWheel,
        (link, _): (usize, Vector3<f64>),
        links: &mut Vec<Link>,
        materials: &mut Materials,
    ) {
        let (radius, half_width) = (wheel.radius, wheel.width / 2.0);
        let (form, material) = match (wheel.drive, &wheel.rollers) {
            (Some(_), _) if wheel.belt.is_some() => {
                self.tracks.extend(Track::new(wheel));
                (Form::Track(self.tracks.len() - 1), &wheel.material)
            }
            (None, _) => (Form::Ball { radius }, &wheel.material),
            (Some(_), None) => (Form::Wheel { radius, half_width }, &wheel.material),
            (Some(_), Some(rollers)) => {
                let first_link = rollers_are_links(def).then(|| add_rollers(rollers, radius, link, links));
                let shape = RollerRing::new(rollers, radius);
                let Rollers { damping, bearing_friction, .. } = *rollers;
                self.rings.push(Ring { shape, wheel: link, first_link, damping, bearing_friction });
                (Form::Rollers(self.rings.len() - 1), &rollers.material)
            }
        };
        let number = self.wheels.len() - 1;
        let seen = ColliderSurface::new(shape::outline(wheel), &scene::Pose::identity(), material, materials);
        self.add_surface(link, form, material, seen, Some(number));
        if let Some(surface) = self.surfaces.last_mut() {
            surface.tread = wheel.tyre.map(Tread::new);
        }
    }

    fn add_solids(
        &mut self,
        link: &scene::Link,
        (own, offset): (usize, Vector3<f64>),
        shapes: Option<&[SharedShape]>,
        materials: &mut Materials,
    ) {
        for (number, solid) in link.solids.iter().enumerate() {
            let pose = nalgebra::Translation3::from(offset) * link.pose_of(solid);
            let shape = shapes.map_or_else(|| shape::shared(&solid.shape), |shapes| shapes[number].clone());
            let seen = ColliderSurface::new(shape, &pose, &solid.material, materials);
            self.add_surface(own, Form::Solid, &solid.material, seen, None);
        }
    }

    fn add_surface(
        &mut self,
        link: usize,
        form: Form,
        material: &Material,
        seen: ColliderSurface,
        wheel: Option<usize>,
    ) {
        self.surfaces.push(Surface::new(link, form, material, seen, wheel));
    }

    fn add_coupling(&mut self, def: &RobotDef, follower: usize, coupling: Coupling) {
        let Coupling { leader, multiplier, offset, kind } = coupling;
        let place = |link: usize| {
            let own = self.places[link].0;
            def.value_of(link).map(|_| (own, self.tree.dof_of(own)))
        };
        let (Some(leading), Some(following)) = (place(leader), place(follower)) else { return };
        match (kind, def.value_of(leader), def.value_of(follower)) {
            (CouplingKind::Mimic, ..) => {
                self.gears.push(Gear { leader: leading, follower: following, multiplier, offset });
            }
            (CouplingKind::Target, Some(leader), Some(follower)) => {
                self.joints[follower].value.follows = Some(Coupling { leader, ..coupling });
            }
            (CouplingKind::Target, ..) => {}
        }
    }
}

/// Returns the inertia of a track's belt as felt at the sprocket, kg m²; that of a wheel is in its link's mass.
fn belt_inertia(wheel: &MountedWheel) -> f64 {
    if wheel.belt.is_some() { wheel.spin_inertia() } else { 0.0 }
}

/// True if the rollers of a robot's wheels are links of their own.
fn rollers_are_links(def: &RobotDef) -> bool {
    def.drive_model == DriveModel::Articulated
}

/// Adds the rollers of a wheel as links that turn about their axes. Returns the number of the first.
fn add_rollers(rollers: &Rollers, wheel_radius: f64, wheel: usize, links: &mut Vec<Link>) -> usize {
    let first = links.len();
    let own = rollers.inertia(wheel_radius);
    for index in 0..rollers.count {
        let pose = rollers.pose(index);
        let turn = pose.rotation.to_rotation_matrix();
        let mass = Mass { mass: rollers.mass, centre: Vector3::zeros(), inertia: turn * own * turn.inverse() };
        let joint = Joint::Revolute(pose.rotation * Vector3::x());
        let link = Link::new(wheel, joint, pose.translation.vector, mass);
        links.push(Link { is_round: true, damping: rollers.damping, ..link });
    }
    first
}
