//! Grip the object and bring it to a point.
//!
//! A robot observes the object in its own frame (3), its gripper in its own frame (3), the point in its own frame (2), its velocities (3),
//! the positions of its joints that are no wheels, and the object's heading in its own frame, as cosine and sine (2). The reward is the
//! distance that the gripper came nearer to the object, m, the height that the object rose, m, the distance that the object came nearer to
//! the point, m, and 1 when the object is there. There is one robot.

use std::sync::Arc;

use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use scene::{RobotDef, Shape, goal};
use sim_core::World;

use crate::rules::{ARRIVAL, Rules, Verdict};
use crate::sight::{Place, RobotSight, Sight, distance, draw};

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Fetch {
    settings: goal::Fetch,
    robot: Arc<RobotDef>,
    /// Links of the fingers.
    fingers: Vec<usize>,
    /// Joints that are no wheels, among those with a value.
    joints: Vec<usize>,
    target: [f64; 2],
    /// Distance of the gripper from the object, height of the object over the floor, and its distance from the point, m.
    progress: [f64; 3],
}

impl Fetch {
    pub(crate) fn new(settings: goal::Fetch, robot: &Arc<RobotDef>) -> Result<Self, String> {
        let gripper = robot.grippers.iter().find(|gripper| gripper.name.eq_ignore_ascii_case(&settings.gripper));
        let Some(gripper) = gripper else {
            return Err(format!("fetch.gripper: {} has no gripper `{}`", robot.class, settings.gripper));
        };
        let joints = robot.with_values().enumerate().filter(|(_, link)| link.wheel.is_none());
        let joints = joints.map(|(number, _)| number).collect();
        let fingers = gripper.links.clone();
        Ok(Self { settings, robot: robot.clone(), fingers, joints, target: [0.0; 2], progress: [0.0; 3] })
    }

    /// Returns the middle between the fingers in the robot frame, m.
    fn grip(&self, seen: &RobotSight) -> Point3<f64> {
        let placed = self.robot.placed_links(&seen.joints);
        let ends = self.fingers.iter().filter_map(|&finger| {
            let (link, pose) = placed.get(finger)?;
            // The middle of the finger's shapes, which is nearer to the tip than its joint.
            let solid = link.solids.iter().find(|solid| matches!(solid.shape, Shape::Box { .. }))?;
            Some((pose * link.pose_of(solid)).translation.vector)
        });
        let ends: Vec<_> = ends.collect();
        Point3::from(ends.iter().sum::<nalgebra::Vector3<f64>>() / ends.len().max(1) as f64)
    }

    fn progress(&self, sight: &Sight) -> [f64; 3] {
        let (seen, object) = (&sight.robots[0], sight.object.unwrap_or_default());
        let object = object.translation.vector;
        let grip = seen.pose * self.grip(seen);
        [(grip.coords - object).norm(), -object.z, distance(object.xy().into(), self.target)]
    }
}

impl Rules for Fetch {
    fn width(&self) -> usize {
        3 + 3 + 2 + 3 + self.joints.len() + 2
    }

    fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        self.target = self.settings.target.map(|range| draw(rng, range));
        self.progress = self.progress(sight);
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let (seen, object) = (&sight.robots[robot], sight.object.unwrap_or_default());
        let heading = seen.place.heading_of(Place::of(&object));
        let object = seen.pose.inverse() * Point3::from(object.translation.vector);
        object.iter().chain(self.grip(seen).iter()).for_each(|number| push(*number));
        seen.place.to_own(self.target).into_iter().chain(seen.velocity).for_each(&mut *push);
        self.joints.iter().for_each(|&joint| push(seen.joints.get(joint).map_or(0.0, |joint| joint.position)));
        heading.into_iter().for_each(push);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
        let [near, height, far] = self.progress(sight);
        let [near_before, height_before, far_before] = std::mem::replace(&mut self.progress, [near, height, far]);
        let is_success = far <= self.settings.tolerance;
        let reward = near_before - near + height - height_before + far_before - far;
        let reward = reward + if is_success { ARRIVAL } else { 0.0 };
        Verdict { rewards: vec![reward], is_over: is_success, is_success }
    }
}
