//! What the engine needs of a scene, worked out once: shapes, masses and joints.
//!
//! A robot is compiled to a tree of links, parents before their children, whatever it is made of; [`super::robot`] inserts
//! links and knows nothing of wheels.

use std::sync::Arc;

use nalgebra::{Translation3, Vector3};
use rapier3d::prelude::*;
use scene::{
    Coupling, CouplingKind, DriveModel, JointKind, MapDef, Mass, Material, MountedWheel, Pose, RobotDef, Shape,
    Steering,
};

use super::articulated::Articulated;
use super::motor::Value;
use super::rolling::TreeWheel;
use super::surface::{Materials, Surface};
use super::{convert, shape};

/// What lies and stands on a map.
pub(crate) struct CompiledMap {
    /// m/s², along +z.
    pub(super) gravity: f64,
    pub(super) solids: Vec<Surface>,
    pub(super) objects: Vec<CompiledObject>,
}

/// Something that can be pushed.
pub(super) struct CompiledObject {
    pub(super) body: RigidBodyBuilder,
    pub(super) surface: Surface,
    /// The same near robots in reduced coordinates.
    pub(super) made_of: Arc<Articulated>,
}

impl CompiledMap {
    pub(crate) fn new(map: &MapDef, materials: &mut Materials) -> Self {
        let mut surface =
            |shape: &Shape, pose: &Pose, material| Surface::new(shape::shared(shape), pose, material, materials);
        let solids = map.solids.iter().map(|solid| surface(&solid.shape, &solid.pose(), &solid.material)).collect();
        let objects = map.objects.iter().map(|object| {
            let (solid, material) = (&object.solid, &object.solid.material);
            let body = RigidBodyBuilder::dynamic().pose(convert::pose(&solid.pose())).can_sleep(false);
            let body = body.linear_damping(material.linear_damping).angular_damping(material.angular_damping);
            let surface = surface(&solid.shape, &Pose::identity(), material).with_mass(object.mass);
            let made_of = Arc::new(Articulated::of_object(surface.clone(), object.mass, material));
            CompiledObject { body, surface, made_of }
        });
        Self { gravity: map.gravity, objects: objects.collect(), solids }
    }
}

/// A class of robots as the engine needs it.
pub(crate) struct CompiledRobot {
    /// What it was made of.
    pub(crate) def: RobotDef,
    /// Mass with everything that it carries, as it is reported, kg.
    pub(super) mass: f64,
    /// The outlines of its solids, its wheels as discs, its casters, in its frame.
    pub(super) outlines: Vec<(Pose, SharedShape)>,
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    /// A multibody.
    Tree(Tree),
    /// A tree in reduced coordinates.
    Articulated(Arc<Articulated>),
}

/// Links, parents before their children.
pub(super) struct Tree {
    /// Origin of the root's body in the robot frame, m.
    pub(super) centre: Vector3<f64>,
    pub(super) footing: Footing,
    /// Of the links of the definition, their numbers among `links`.
    pub(super) numbers: Vec<usize>,
    pub(super) links: Vec<Link>,
    pub(super) wheels: Vec<TreeWheel>,
    /// Joints that are moved by others.
    pub(super) gears: Vec<Gear>,
    /// Damping of the root's velocity, N s/m, and angular velocity, N m s/rad.
    pub(super) root_damping: [f64; 2],
}

/// What holds a tree.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Footing {
    /// What it stands on.
    Free,
    /// Its velocities are given; it weighs nothing.
    Flying,
    /// Its root does not move.
    Fixed,
}

/// A joint that is moved by another: each by its link's number and its axis.
pub(super) struct Gear {
    pub(super) leader: (usize, JointAxis),
    pub(super) follower: (usize, JointAxis),
    pub(super) multiplier: f64,
    /// rad or m.
    pub(super) offset: f64,
}

/// A body and how it hangs on its parent.
pub(super) struct Link {
    /// Pose in the parent's frame when every joint is at 0. The root's frame is the robot frame.
    pub(super) pose: Pose,
    pub(super) mass: MassProperties,
    pub(super) surfaces: Vec<Surface>,
    /// `None` of the root alone.
    pub(super) joint: Option<Joint>,
    /// The wheel that it is a part of, by its number among them.
    pub(super) wheel: Option<usize>,
}

/// A joint to the parent.
pub(super) struct Joint {
    pub(super) parent: usize,
    pub(super) joint: GenericJoint,
    /// Of every degree of freedom, N m s/rad.
    pub(super) damping: f64,
    /// Dry friction of every degree of freedom, N m or N.
    pub(super) friction: f64,
    /// Inertia of a rotor as felt at the joint, kg m².
    pub(super) armature: f64,
    pub(super) role: Role,
}

/// What a joint does.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Role {
    /// Has a value in the robot's state, along the engine's axis.
    Value(JointAxis, Value),
    /// Lets a roller spin.
    Roller,
    /// Holds, or lets a caster turn.
    Free,
}

impl CompiledRobot {
    pub(crate) fn new(def: RobotDef, materials: &mut Materials) -> Self {
        let shapes: Vec<SharedShape> = def.body_solids().iter().map(|solid| shape::shared(&solid.shape)).collect();
        let kind = match def.drive_model {
            DriveModel::Bodies => Kind::Tree(Tree::new(&def, &shapes, materials)),
            _ => Kind::Articulated(Arc::new(Articulated::new(&def, &shapes, materials))),
        };
        let solids = def.body_solids().iter().zip(shapes).map(|(solid, shape)| (solid.pose(), shape));
        let carried = def.links.iter().skip(1).flat_map(|link| &link.solids);
        let solids = solids.chain(carried.map(|solid| (solid.pose(), shape::shared(&solid.shape))));
        let wheels = def.wheels().map(|wheel| (wheel.pose(0.0), shape::outline(&wheel)));
        Self { mass: f64::from(def.mass()), outlines: solids.chain(wheels).collect(), kind, def }
    }

    /// Origin of its root's body in the robot frame, m.
    pub(super) fn centre(&self) -> Vector3<f64> {
        match &self.kind {
            Kind::Tree(tree) => tree.centre,
            Kind::Articulated(_) => Vector3::zeros(),
        }
    }
}

impl Tree {
    fn new(def: &RobotDef, shapes: &[SharedShape], materials: &mut Materials) -> Self {
        let body = def.body_mass();
        // The engine moves the origin of a multibody's root with the velocity of its centre of mass, so they have to be one.
        let centre = body.centre;
        let root = Link {
            pose: Pose::identity(),
            mass: convert::mass(&Mass { centre: Vector3::zeros(), ..body }),
            surfaces: body_surfaces(def, shapes, centre, materials),
            joint: None,
            wheel: None,
        };
        // Damping of a velocity by d per second is a force of d times the mass, a torque of d times the inertia.
        let [linear, angular] = def.body_damping();
        let root_damping = [linear * body.mass, angular * (body.inertia.trace() / 3.0)];
        let (wheels, gears) = (Vec::new(), Vec::new());
        let footing = match def.steering {
            Steering::Aerial => Footing::Flying,
            Steering::None => Footing::Fixed,
            Steering::Skid | Steering::Omni | Steering::Ackermann | Steering::Legged => Footing::Free,
        };
        let mut tree = Self { centre, footing, numbers: Vec::new(), links: vec![root], wheels, gears, root_damping };
        let mut numbers = vec![0];
        for (number, link) in def.links.iter().enumerate().skip(1) {
            let Some(joint) = &link.joint else { continue };
            let parent = numbers[joint.parent];
            let offset = Vector3::from(joint.anchor) - Vector3::from(def.links[joint.parent].origin());
            // Where the joint is in the frame of the parent's body.
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

    /// Couples the joint of a link to another; `numbers` are those of the links here.
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
        let (pose, number) = (Pose::from(Translation3::from(offset)), self.wheels.len());
        let rolls_ahead_only = wheel.drive.is_some() && wheel.rollers.is_none();
        self.wheels.push(TreeWheel { parent, hub: anchor, rolls_ahead_only });
        let mass = convert::principal_mass(&wheel.hub_mass(wheel.drive.is_some()));
        let mut surface = |shape, material: &Material| Surface::new(shape, &Pose::identity(), material, materials);
        let surfaces = match (&wheel.drive, &wheel.rollers) {
            (None, _) => vec![surface(SharedShape::ball(wheel.radius), &wheel.material)],
            (Some(_), None) => vec![surface(shape::tread(wheel.radius, wheel.width), &wheel.material)],
            (Some(_), Some(_)) => Vec::new(),
        };
        let joint = Joint::new(joint, parent, anchor, true);
        let hub = self.links.len();
        self.links.push(Link { pose, mass, surfaces, joint: Some(joint), wheel: Some(number) });
        let Some(rollers) = wheel.rollers.as_ref().filter(|_| wheel.drive.is_some()) else { return };
        let surface = surface(shape::roller(rollers, wheel.radius), &rollers.material);
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

/// The engine's joint at an anchor in the frame of the parent's body; that of the child is its origin.
fn engine_joint(joint: &scene::Joint, anchor: Vector3<f64>) -> GenericJoint {
    let (anchor, axis) = (convert::vector(anchor), convert::vector(joint.axis));
    let mut built: GenericJoint = match joint.kind {
        JointKind::Fixed => FixedJointBuilder::new().local_anchor1(anchor).into(),
        JointKind::Ball => SphericalJointBuilder::new().local_anchor1(anchor).into(),
        JointKind::Revolute | JointKind::Continuous => RevoluteJointBuilder::new(axis).local_anchor1(anchor).into(),
        JointKind::Prismatic => PrismaticJointBuilder::new(axis).local_anchor1(anchor).into(),
    };
    let Some(axis) = axis_of(joint.kind) else { return built };
    if let Some(limits) = joint.limits {
        built.set_limits(axis, limits);
    }
    if let Some(motor) = &joint.drive {
        built.set_motor_velocity(axis, 0.0, motor.gain);
        built.set_motor_max_force(axis, motor.max_torque);
        built.set_motor_model(axis, MotorModel::ForceBased);
    }
    built
}

/// The engine's axis of a joint with one value: its x axis is the joint's.
fn axis_of(kind: JointKind) -> Option<JointAxis> {
    match kind {
        JointKind::Revolute | JointKind::Continuous => Some(JointAxis::AngX),
        JointKind::Prismatic => Some(JointAxis::LinX),
        JointKind::Fixed | JointKind::Ball => None,
    }
}

impl Joint {
    /// A joint of a definition at an anchor in the frame of the body of a link with a number.
    fn new(def: &scene::Joint, parent: usize, anchor: Vector3<f64>, is_wheel: bool) -> Self {
        Self {
            parent,
            joint: engine_joint(def, anchor),
            damping: def.damping,
            friction: def.friction,
            armature: def.drive.as_ref().map_or(0.0, |motor| motor.armature),
            role: axis_of(def.kind).map_or(Role::Free, |axis| Role::Value(axis, Value::new(def, is_wheel))),
        }
    }
}

/// The shapes of a robot's body, whose origin is at `centre` in the robot frame.
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
