//! Rollers and contacts of a robot, computed for viewers only.

use nalgebra::Vector3;
use scene::{Contact, wrapped};

use super::{Physics, RobotBodies};

impl Physics {
    /// Returns the angles of a robot's rollers about their own axes, rad, -pi to pi, wheel by wheel.
    pub(crate) fn roller_angles(&self, bodies: &RobotBodies) -> Vec<f64> {
        bodies.mechanism().roller_angles(&self.world).into_iter().map(wrapped).collect()
    }

    /// Returns the contacts of a robot in the last step. Rolling resistance, a force on a hub, is added to the contacts of its wheel, so
    /// the sum is the ground's force.
    pub(crate) fn contacts(&self, bodies: &RobotBodies) -> Vec<Contact> {
        let mut contacts = bodies.mechanism().contacts(&self.world);
        contacts.sort_by_key(|contact| contact.wheel);
        let resistances = bodies.mechanism().resistances();
        for of_part in contacts.chunk_by_mut(|one, other| one.wheel == other.wheel) {
            if let Some(&resistance) = of_part[0].wheel.and_then(|wheel| resistances.get(wheel)) {
                share(of_part, resistance);
            }
        }
        contacts
    }
}

/// Adds a force to contacts, in proportion to their own.
fn share(contacts: &mut [Contact], force: Vector3<f64>) {
    let total: f64 = contacts.iter().map(|contact| contact.force.norm()).sum();
    for contact in contacts.iter_mut().filter(|_| total > 0.0) {
        contact.force += force * (contact.force.norm() / total);
    }
}
