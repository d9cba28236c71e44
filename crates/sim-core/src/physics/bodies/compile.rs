//! A robot class compiled to a tree of the engine's bodies.

use nalgebra::{Translation3, Vector3};
use rapier3d::prelude::*;
use scene::{Coupling, CouplingKind, Footing, Mass, Material, MountedWheel, Pose, RobotDef};

use super::super::rolling::{Driven, Hub};
use super::super::surface::{Materials, Surface};
use super::super::{convert, shape};
use super::joint::{Gear, Joint, Role, axis_of};
use super::shape::{roller, tread};

/// A robot class, ready to be inserted into the engine.
pub(in super::super) struct Tree {
    /// Mass of the robot with its load, as it is reported, kg.
    pub(super) mass: f64,
    /// Origin of the root's body in the robot frame, m.
    pub(super) centre: Vector3<f64>,
    pub(super) footing: Footing,
    /// Numbers among `links` of the definition's links.
    pub(super) numbers: Vec<usize>,
    /// Links, parents before their children.
    pub(super) links: Vec<Link>,
    /// Hubs of the wheels, including casters.
    pub(super) hubs: Vec<Hub>,
    /// Joints coupled to others.
    pub(super) gears: Vec<Gear>,
    /// Damping of the root's velocity, N s/m, and angular velocity, N m s/rad.
    pub(super) root_damping: [f64; 2],
}

/// A body and its joint to the parent.
pub(super) struct Link {
    /// Pose in the parent's frame when every joint is at 0. The root's is that of the robot frame.
    pub(super) pose: Pose,
    pub(super) mass: MassProperties,
    pub(super) surfaces: Vec<Surface>,
    /// Joint to the parent, `None` for the root.
    pub(super) joint: Option<Joint>,
    /// Number of the wheel that it is part of.
    pub(super) wheel: Option<usize>,
}

impl Tree {
    pub(in super::super) fn new(def: &RobotDef, shapes: &[SharedShape], materials: &mut Materials) -> Self {
        let body = def.body_mass();
        // The engine moves the origin of a multibody's root with the velocity of its centre of mass, so the two must coincide.
        let centre = body.centre;
        let root = Link {
            pose: Pose::identity(),
            mass: convert::mass(&Mass { centre: Vector3::zeros(), ..body }),
            surfaces: body_surfaces(def, shapes, centre, materials),
            joint: None,
            wheel: None,
        };
        let mut tree = Self {
            mass: f64::from(def.mass()),
            centre,
            footing: def.footing,
            numbers: Vec::new(),
            links: vec![root],
            hubs: Vec::new(),
            gears: Vec::new(),
            root_damping: def.body_damping(),
        };
        let mut numbers = vec![0];
        for (number, link) in def.links.iter().enumerate().skip(1) {
            let Some(joint) = &link.joint else { continue };
            let parent = numbers[joint.parent];
            let offset = Vector3::from(joint.anchor) - Vector3::from(def.links[joint.parent].origin());
            // Anchor in the frame of the parent's body.
            let anchor = if parent == 0 { offset - centre } else { offset };
            numbers.push(tree.links.len());
            match MountedWheel::of((number, link)) {
                Some(wheel) => tree.add_wheel(&wheel, joint, parent, offset, anchor, materials),
                None => tree.add_link(link, joint, parent, offset, anchor, materials),
            }
        }
        for (number, link) in def.links.iter().enumerate() {
            if let Some(coupling) = link.joint.as_ref().and_then(|joint| joint.coupling) {
                tree.add_coupling(def, &numbers, number, coupling);
            }
        }
        tree.numbers = numbers;
        tree
    }

    /// Couples the joint of a link to another. `numbers` are the tree's numbers of the definition's links.
    fn add_coupling(&mut self, def: &RobotDef, numbers: &[usize], follower: usize, coupling: Coupling) {
        let Coupling { leader, multiplier, offset, kind } = coupling;
        let axis = |link: usize| Some((numbers[link], axis_of(def.links[link].joint.as_ref()?.kind)?));
        match kind {
            CouplingKind::Mimic => {
                let joints = axis(leader).zip(axis(follower));
                self.gears.extend(joints.map(|(leader, follower)| Gear { leader, follower, multiplier, offset }));
            }
            CouplingKind::Target => {
                if let Some(Joint { role: Role::Value(_, value), .. }) = &mut self.links[numbers[follower]].joint {
                    value.follows = def.value_of(leader).map(|leader| Coupling { leader, ..coupling });
                }
            }
        }
    }

    fn add_link(
        &mut self,
        link: &scene::Link,
        joint: &scene::Joint,
        parent: usize,
        offset: Vector3<f64>,
        anchor: Vector3<f64>,
        materials: &mut Materials,
    ) {
        let mass = link.mass();
        let mass = convert::mass(&Mass { centre: mass.centre - Vector3::from(joint.anchor), ..mass });
        let surface = |solid: &scene::Solid| {
            Surface::new(shape::shared(&solid.shape), &link.pose_of(solid), &solid.material, materials)
        };
        let surfaces = link.solids.iter().map(surface).collect();
        let joint = Joint::new(joint, parent, anchor, false);
        self.links.push(Link {
            pose: Translation3::from(offset).into(),
            mass,
            surfaces,
            joint: Some(joint),
            wheel: None,
        });
    }

    fn add_wheel(
        &mut self,
        wheel: &MountedWheel,
        joint: &scene::Joint,
        parent: usize,
        offset: Vector3<f64>,
        anchor: Vector3<f64>,
        materials: &mut Materials,
    ) {
        let (pose, number) = (Pose::from(Translation3::from(offset)), self.hubs.len());
        let is_driven = wheel.drive.is_some() && wheel.rollers.is_none();
        let driven = is_driven.then_some(Driven { link: self.links.len(), radius: wheel.radius });
        self.hubs.push(Hub { carrier: parent, centre: anchor, driven });
        let mass = convert::principal_mass(&wheel.hub_mass(wheel.drive.is_some()));
        let mut surface = |shape, material: &Material| Surface::new(shape, &Pose::identity(), material, materials);
        let surfaces = match (&wheel.drive, &wheel.rollers) {
            (None, _) => vec![surface(SharedShape::ball(wheel.radius), &wheel.material)],
            (Some(_), None) => vec![surface(tread(wheel.radius, wheel.width), &wheel.material)],
            (Some(_), Some(_)) => Vec::new(),
        };
        let joint = Joint::new(joint, parent, anchor, true);
        let hub = self.links.len();
        self.links.push(Link { pose, mass, surfaces, joint: Some(joint), wheel: Some(number) });
        let Some(rollers) = wheel.rollers.as_ref().filter(|_| wheel.drive.is_some()) else { return };
        let surface = surface(roller(rollers, wheel.radius), &rollers.material);
        let inertia = rollers.inertia(wheel.radius);
        let mass = convert::principal_mass(&Mass { mass: rollers.mass, centre: Vector3::zeros(), inertia });
        for index in 0..rollers.count {
            let pose = rollers.pose(index);
            let mut joint = RevoluteJointBuilder::new(Vector::X).build();
            joint.data.set_local_frame1(convert::pose(&pose));
            let joint = Joint {
                parent: hub,
                joint: joint.into(),
                damping: rollers.damping,
                friction: 0.0,
                armature: 0.0,
                role: Role::Roller,
            };
            let surfaces = vec![surface.clone()];
            self.links.push(Link { pose, mass, surfaces, joint: Some(joint), wheel: Some(number) });
        }
    }
}

/// Returns the surfaces of a robot's body, whose origin is at `centre` in the robot frame.
fn body_surfaces(
    def: &RobotDef,
    shapes: &[SharedShape],
    centre: Vector3<f64>,
    materials: &mut Materials,
) -> Vec<Surface> {
    let surface = |(solid, shape): (&scene::Solid, &SharedShape)| {
        Surface::new(shape.clone(), &(Translation3::from(-centre) * solid.pose()), &solid.material, materials)
    };
    def.body_solids().iter().zip(shapes).map(surface).collect()
}
