//! Questions of a league about robots and victims.

use nalgebra::{Point3, Vector3};
use scene::PawnId;

use super::World;
use crate::physics::{Identity, Light};

/// Height above the robot frame from which a robot looks for victims, m: about that of the cameras on rescue robots.
const EYE: f64 = 0.3;
/// Greatest distance between a contact and the surface that it is on, m.
const SURFACE: f64 = 0.01;
/// Distance from the pelvis within which all of a victim lies, m, and from the robot frame within which all of a robot lies.
const REACH: f64 = 3.0;

impl World {
    /// Returns the position of a robot's frame, m.
    pub fn position(&self, robot: PawnId) -> Option<[f64; 3]> {
        let robot = self.robots.get(&robot)?;
        Some(self.physics.body(robot.bodies()).pose.translation.vector.into())
    }

    /// True if a robot sees a victim of the map: a ray from 0.3 m above its frame to the middle of a part meets this victim first.
    pub fn sees(&mut self, robot: PawnId, victim: usize) -> bool {
        let Some(position) = self.position(robot) else { return false };
        self.enter_shapes_for_question();
        let eye = Point3::from(position) - Vector3::z() * EYE;
        let parts = || self.physics.site().body_parts.iter().filter(|part| part.victim == victim);
        let is_it = |identity| parts().any(|part| identity == Identity::Solid(part.solid));
        parts().any(|part| {
            let way = part.position - eye;
            let Some(direction) = way.try_normalize(1e-9) else { return false };
            let hit = self.physics.sight(Light::Visible, &eye, way.norm(), robot).cast_ray(&direction);
            hit.is_none_or(|hit| is_it(hit.identity))
        })
    }

    /// Returns the victims of the map that a robot touched in the last step.
    pub fn touched(&self, robot: PawnId) -> Vec<usize> {
        let Some((position, robot)) = self.position(robot).zip(self.robots.get(&robot)) else { return Vec::new() };
        let place = |victim: &scene::Victim| (Point3::from(victim.position) - Point3::from(position)).norm();
        let site = self.physics.site();
        if site.victims.iter().all(|victim| place(victim) > 2.0 * REACH) {
            return Vec::new();
        }
        let mut touched: Vec<usize> = Vec::new();
        for contact in self.physics.contacts(robot.bodies()) {
            let solids = self.physics.solids_at(contact.point, SURFACE);
            let of_victims = site.body_parts.iter().filter(|part| solids.contains(&part.solid));
            touched.extend(of_victims.map(|part| part.victim));
        }
        touched.sort_unstable();
        touched.dedup();
        touched
    }
}
