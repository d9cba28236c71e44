//! What a robot's bodies do that only a viewer asks for: its rollers and what pushes it.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rapier3d::prelude::*;
use scene::Contact;

use super::robot::{Drivetrain, joint_state};
use super::{Physics, RobotBodies, convert, solved};

impl Physics {
    /// Angles of a robot's rollers about their own axes, rad, -pi to pi, wheel by wheel.
    pub(crate) fn roller_angles(&self, bodies: &RobotBodies) -> Vec<f64> {
        match bodies.drivetrain() {
            Drivetrain::Multibody { rollers, .. } => {
                let angle = |&roller| joint_state(&self.world, roller, JointAxis::AngX).position;
                rollers.iter().map(|roller| wrapped(angle(roller))).collect()
            }
            Drivetrain::Articulated(robot) => robot.roller_angles().into_iter().map(wrapped).collect(),
        }
    }

    /// Everything that pushed a robot in the last step. Rolling resistance is a force on a hub; it is added to the
    /// contacts of its wheel, so that the sum is what the ground did.
    pub(crate) fn contacts(&self, bodies: &RobotBodies) -> Vec<Contact> {
        let mut contacts = Vec::new();
        if let Some(chassis) = bodies.all().first().and_then(|&chassis| self.world.bodies.get(chassis)) {
            self.add_contacts(chassis.colliders(), &mut contacts);
        }
        match bodies.drivetrain() {
            Drivetrain::Multibody { treads, .. } => {
                for tread in treads {
                    let before = contacts.len();
                    self.add_contacts(&tread.colliders, &mut contacts);
                    share(&mut contacts[before..], tread.resistance);
                }
            }
            Drivetrain::Articulated(robot) => {
                for &(_, contact) in robot.contacts().iter().filter(|(wheel, _)| wheel.is_none()) {
                    contacts.push(contact);
                }
                for (number, &resistance) in robot.resistances().iter().enumerate() {
                    let before = contacts.len();
                    let of_wheel = robot.contacts().iter().filter(|(wheel, _)| *wheel == Some(number));
                    contacts.extend(of_wheel.map(|&(_, contact)| contact));
                    share(&mut contacts[before..], resistance);
                }
            }
        }
        contacts
    }

    /// What the engine found for some colliders.
    fn add_contacts(&self, colliders: &[ColliderHandle], contacts: &mut Vec<Contact>) {
        let time_step = self.world.integration_parameters.dt;
        for &own in colliders {
            let parent = self.world.colliders.get(own).and_then(Collider::parent);
            let Some(body) = parent.and_then(|body| self.world.bodies.get(body)) else { continue };
            let centre = convert::from_vector(body.center_of_mass());
            for pair in self.world.narrow_phase.contact_pairs_with(own) {
                let first = pair.collider1 == own;
                let sign = if first { 1.0 } else { -1.0 };
                for manifold in pair.solver_manifolds() {
                    let normal = -convert::from_vector(manifold.data.normal);
                    for data in solved(manifold).filter(|data| data.impulse > 0.0) {
                        let friction = convert::from_vector(data.warmstart_tangent_world);
                        let arm = if first { data.solver_dp1 } else { data.solver_dp2 };
                        let force = (normal * data.impulse + friction) * (sign / time_step);
                        contacts.push(Contact { point: centre + convert::from_vector(arm), force });
                    }
                }
            }
        }
    }
}

/// Adds a force to contacts, to each by what it carries.
fn share(contacts: &mut [Contact], force: Vector3<f64>) {
    let total: f64 = contacts.iter().map(|contact| contact.force.norm()).sum();
    for contact in contacts.iter_mut().filter(|_| total > 0.0) {
        contact.force += force * (contact.force.norm() / total);
    }
}

/// The same angle between -pi and pi.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
