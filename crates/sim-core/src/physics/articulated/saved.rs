//! The state of a tree and of a map's object as plain data.

use articulated::Motion;
use nalgebra::Vector3;
use scene::{Contact, Object, ObjectId, Pose};
use serde::{Deserialize, Serialize};

use super::super::motor::Servo;
use super::super::rolling::Load;
use super::finding::{Key, Known};
use super::object::Sleep;
use super::tyre::Deflection;
use super::{ArticulatedRobot, MovableObject};

/// The state of a tree at the end of a step, as far as later steps depend on it or viewers show it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedTree {
    motion: Motion,
    servos: Vec<Servo>,
    targets: Vec<f64>,
    roller_angles: Vec<Vec<f64>>,
    joint_impulses: Vec<f64>,
    loads: Vec<Load>,
    resistances: Vec<Vector3<f64>>,
    /// Contacts with their wheels. Files from before contacts had a wheel of their own have it only here.
    contacts: Vec<(Option<usize>, Contact)>,
    flies: bool,
    known: Vec<(Key, Vector3<f64>)>,
    /// Points of the known contacts, m, and their ages, s. Files from before robots remembered them have none.
    #[serde(default)]
    known_points: Vec<(Vector3<f64>, f64)>,
    /// Deflections of tyres, m.
    #[serde(default)]
    deflections: Vec<(Key, Deflection)>,
}

/// The state of a movable object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedObject {
    pub(crate) id: ObjectId,
    /// Its definition and first pose; `None` if the map has them.
    pub(crate) spawned: Option<(Object, Pose)>,
    pub(in super::super) is_held: bool,
    tree: SavedTree,
    still: f64,
    /// Files from before objects knew it say that nothing carries it.
    #[serde(default)]
    is_carried: bool,
    sleep: Option<Sleep>,
}

impl ArticulatedRobot {
    /// Returns the state.
    pub(in super::super) fn save(&self) -> SavedTree {
        SavedTree {
            motion: self.body.motion(),
            servos: self.servos.clone(),
            targets: self.targets.clone(),
            roller_angles: self.roller_angles.clone(),
            joint_impulses: self.joint_impulses.clone(),
            loads: self.loads.clone(),
            resistances: self.resistances.clone(),
            contacts: self.contacts.iter().map(|&contact| (contact.wheel, contact)).collect(),
            flies: self.flies,
            known: self.known.iter().map(|known| (known.key, known.impulse)).collect(),
            known_points: self.known.iter().map(|known| (known.point, known.age)).collect(),
            deflections: self.deflections.clone(),
        }
    }

    /// Takes a saved state. Returns false, and changes nothing, if the state is another tree's.
    pub(in super::super) fn load(&mut self, saved: &SavedTree) -> bool {
        let rollers = |angles: &[Vec<f64>]| angles.iter().map(Vec::len).collect::<Vec<_>>();
        let is_like = saved.servos.len() == self.servos.len()
            && saved.targets.len() == self.targets.len()
            && rollers(&saved.roller_angles) == rollers(&self.roller_angles)
            && saved.loads.len() == self.loads.len()
            && saved.resistances.len() == self.resistances.len()
            && saved.contacts.iter().all(|(wheel, _)| wheel.is_none_or(|wheel| wheel < self.loads.len()));
        let fits = is_like && self.body.set_motion(&saved.motion);
        if fits {
            let saved = saved.clone();
            self.servos = saved.servos;
            self.targets = saved.targets;
            self.roller_angles = saved.roller_angles;
            self.joint_impulses = saved.joint_impulses;
            self.loads = saved.loads;
            self.resistances = saved.resistances;
            self.contacts = saved.contacts.into_iter().map(|(wheel, contact)| Contact { wheel, ..contact }).collect();
            self.flies = saved.flies;
            let points = saved.known_points.into_iter().chain(std::iter::repeat((Vector3::zeros(), 0.0)));
            self.known = saved
                .known
                .into_iter()
                .zip(points)
                .map(|((key, impulse), (point, age))| Known { key, impulse, point, age })
                .collect();
            self.deflections = saved.deflections;
            self.forget_near();
        }
        fits
    }
}

impl SavedObject {
    /// True if its definition is one that a world can have.
    pub(crate) fn is_sound(&self) -> bool {
        self.spawned.as_ref().is_none_or(|(def, _)| scene::check::spawned_object(def).is_empty())
    }
}

impl MovableObject {
    /// Returns the state.
    pub(in super::super) fn save(&self) -> SavedObject {
        SavedObject {
            id: self.id,
            spawned: (!self.is_of_map).then(|| ((*self.def).clone(), self.start)),
            is_held: self.is_held,
            tree: self.body.save(),
            still: self.still,
            is_carried: self.is_carried,
            sleep: self.sleep.clone(),
        }
    }

    /// Takes a saved state. Returns false, and changes nothing, if the state is another object's.
    pub(in super::super) fn load(&mut self, saved: &SavedObject) -> bool {
        let fits = self.body.load(&saved.tree);
        if fits {
            (self.still, self.sleep, self.is_entered) = (saved.still, saved.sleep.clone(), false);
            (self.is_held, self.is_carried) = (saved.is_held, saved.is_carried);
        }
        fits
    }
}
