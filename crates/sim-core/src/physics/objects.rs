//! Movable objects of a world: spawning, moving, holding, removing and saving them.

use std::sync::Arc;

use nalgebra::Vector3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use scene::{Object, ObjectId, ObjectSnapshot, Pose};
use serde::{Deserialize, Serialize};

use super::articulated::{CompiledObject, MovableObject, SavedObject};
use super::{Fault, Physics, Spring, Tug, convert, shape};

/// An object that was taken out of the world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Lifted {
    pub(crate) def: Arc<Object>,
    /// Pose at which it was spawned.
    start: Pose,
    /// True if the map has it.
    pub(crate) is_of_map: bool,
}

/// Returns the extents of an object at a pose along the world's axes, m.
pub(crate) fn extents(object: &Object, pose: &Pose) -> Vector3<f64> {
    convert::from_vector(shape::shared(&object.solid.shape).compute_aabb(&convert::pose(pose)).extents())
}

impl Physics {
    /// Spawns an object at a pose, at rest. No other may have its id. A held object is not pushed by anything.
    pub(crate) fn spawn_object(&mut self, id: ObjectId, def: Arc<Object>, pose: &Pose, is_held: bool) {
        let object = self.insert_object(id, def, pose, is_held);
        self.wake_near(object.reach());
        let place = self.objects.partition_point(|other| other.id() < id);
        self.objects.insert(place, object);
    }

    /// Sets the velocity of an object's frame, m/s, and its angular velocity, rad/s, in world axes.
    pub(crate) fn push_off(&mut self, id: ObjectId, linear: &Vector3<f64>, angular: &Vector3<f64>) {
        if let Some(place) = self.place_of(id) {
            self.objects[place].push_off(linear, angular);
        }
    }

    /// Applies the effect of a spring to an object for the coming step.
    pub(crate) fn pull_object(&mut self, id: ObjectId, tug: &Tug) {
        if let Some(place) = self.place_of(id) {
            self.objects[place].pull(tug);
        }
    }

    /// Returns the effect of a spring on an object now; `None` if nothing can pull it: it is gone or held.
    pub(crate) fn tug_of_object(&self, id: ObjectId, spring: &Spring) -> Option<Tug> {
        let grasped = self.objects[self.place_of(id)?].grasped()?;
        Some(spring.tug(&grasped, self.world.integration_parameters.dt))
    }

    fn insert_object(&mut self, id: ObjectId, def: Arc<Object>, pose: &Pose, is_held: bool) -> MovableObject {
        let compiled = CompiledObject::new(def, &mut self.materials);
        let mut object = MovableObject::spawn(&mut self.world, &compiled, id, pose, false);
        if is_held {
            object.hold(&mut self.world, true);
        }
        self.is_changed = true;
        self.enter_queries(object.in_engine().as_slice());
        object
    }

    /// Removes an object, if there is one with this id.
    pub(crate) fn remove_object(&mut self, id: ObjectId) {
        let Some(place) = self.place_of(id) else { return };
        let object = self.objects.remove(place);
        self.remove_bodies(object.in_engine().into_iter());
        self.wake_near(object.reach());
    }

    /// Takes an object that nothing leads out of the world, to be put down again.
    pub(crate) fn lift_object(&mut self, id: ObjectId) -> Option<Lifted> {
        let object = &self.objects[self.place_of(id)?];
        let lifted = Lifted { def: object.def.clone(), start: object.start, is_of_map: object.is_of_map };
        (!object.is_held()).then(|| self.remove_object(id))?;
        Some(lifted)
    }

    /// Puts a lifted object back into the world, at a pose and at rest.
    pub(crate) fn put_down(&mut self, id: ObjectId, lifted: Lifted, pose: &Pose) {
        let Lifted { def, start, is_of_map } = lifted;
        self.spawn_object(id, def, pose, false);
        if let Some(place) = self.place_of(id) {
            (self.objects[place].start, self.objects[place].is_of_map) = (start, is_of_map);
        }
    }

    /// Puts an object at a pose, at rest.
    pub(crate) fn put_object(&mut self, id: ObjectId, pose: &Pose) {
        let Some(place) = self.place_of(id) else { return };
        let before = self.objects[place].reach();
        self.objects[place].put(pose);
        self.is_changed = true;
        self.wake_near(before.merged(&self.objects[place].reach()));
    }

    /// Holds an object, so that nothing pushes it, or lets it go.
    pub(crate) fn hold_object(&mut self, id: ObjectId, is_held: bool) {
        let Some(place) = self.place_of(id) else { return };
        self.objects[place].hold(&mut self.world, is_held);
        self.is_changed = true;
        self.wake_near(self.objects[place].reach());
    }

    /// Gives held objects the velocities with which they reach their poses at the end of the coming step. Sleeping objects that they
    /// touch wake; they are looked for once, however many objects are led.
    pub(crate) fn lead_objects(&mut self, led: &[(ObjectId, Pose)]) {
        let is_sleeper = |object: &MovableObject| object.is_asleep() && !object.is_held();
        let has_sleepers = self.objects.iter().any(is_sleeper);
        let time_step = self.world.integration_parameters.dt;
        let mut reaches = Vec::new();
        for (id, pose) in led {
            let Some(place) = self.place_of(*id) else { continue };
            if has_sleepers {
                reaches.push(self.objects[place].reach());
            }
            self.objects[place].lead(pose, time_step);
        }
        let sleepers = self.objects.iter_mut().filter(|object| is_sleeper(object));
        sleepers.filter(|object| reaches.iter().any(|near| object.is_near(near))).for_each(MovableObject::wake);
    }

    /// Moves a led object to its pose at the end of a step.
    pub(crate) fn arrive(&mut self, id: ObjectId, pose: &Pose) {
        if let Some(place) = self.place_of(id) {
            self.objects[place].arrive(pose);
        }
    }

    /// Returns the pose of an object.
    pub(crate) fn object(&self, id: ObjectId) -> Option<Pose> {
        self.place_of(id).map(|place| self.objects[place].pose())
    }

    /// Returns the name of an object.
    pub(crate) fn object_name(&self, id: ObjectId) -> Option<&str> {
        self.place_of(id).map(|place| self.objects[place].name())
    }

    /// Returns a snapshot of every object, by their ids.
    pub(crate) fn objects(&self) -> impl Iterator<Item = ObjectSnapshot> {
        self.objects.iter().map(MovableObject::snapshot)
    }

    /// Puts objects whose state is a fault back to their first poses, at rest. Returns their names and faults.
    pub(crate) fn restore_objects(&mut self) -> Vec<(String, Fault)> {
        let restored = self.objects.iter_mut().filter_map(|object| Some((object.restore()?, object)));
        restored.map(|(fault, object)| (object.name().to_owned(), fault)).collect()
    }

    /// Returns the states of all objects.
    pub(crate) fn save_objects(&self) -> Vec<SavedObject> {
        self.objects.iter().map(MovableObject::save).collect()
    }

    /// Takes saved states of all objects, and the number of unsettled systems. The world must be new. Objects of the map without a state
    /// are removed, and those that it does not have are spawned.
    ///
    /// # Errors
    /// If a state does not fit its object, with the object's id.
    pub(crate) fn load_objects(&mut self, saved: &[SavedObject], unsettled: u64) -> Result<(), ObjectId> {
        self.effort.unsettled = unsettled;
        let removed: Vec<ObjectId> = self.objects.iter().map(MovableObject::id).collect();
        for id in removed.into_iter().filter(|id| !saved.iter().any(|saved| saved.id == *id)) {
            self.remove_object(id);
        }
        for saved in saved {
            if let Some((def, start)) = &saved.spawned {
                if self.objects.last().is_some_and(|last| last.id() >= saved.id) {
                    return Err(saved.id);
                }
                let object = self.insert_object(saved.id, Arc::new(def.clone()), start, saved.is_held);
                self.objects.push(object);
            }
            let place = self.place_of(saved.id).ok_or(saved.id)?;
            if !self.objects[place].load(saved) {
                return Err(saved.id);
            }
        }
        Ok(())
    }

    fn place_of(&self, id: ObjectId) -> Option<usize> {
        self.objects.binary_search_by_key(&id, MovableObject::id).ok()
    }

    /// Wakes the objects that touch a box.
    fn wake_near(&mut self, near: Aabb) {
        let asleep = self.objects.iter_mut().filter(|object| object.is_asleep() && !object.is_held());
        asleep.filter(|object| object.is_near(&near)).for_each(MovableObject::wake);
    }
}
