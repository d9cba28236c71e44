//! Contacts of a robot, with the engine's solution.

use nalgebra::Vector3;
use rapier3d::geometry::ContactData;
use rapier3d::prelude::*;
use scene::Contact;

use super::super::convert;
use super::super::rolling::Load;
use super::super::surface::Materials;
use super::MultibodyRobot;

impl MultibodyRobot {
    /// Returns the contacts of the chassis and the wheels in the last step.
    pub(in super::super) fn contacts(&self, world: &PhysicsWorld) -> Vec<Contact> {
        let chassis = world.bodies.get(self.links[0]).map_or(&[][..], RigidBody::colliders);
        let wheels = self.treads.iter().enumerate().map(|(number, tread)| (Some(number), tread.as_slice()));
        let parts = std::iter::once((None, chassis)).chain(wheels);
        parts.flat_map(|(wheel, part)| contacts(world, wheel, part)).collect()
    }
}

/// Returns the contacts of the colliders of a wheel, or of the chassis.
fn contacts(world: &PhysicsWorld, wheel: Option<usize>, colliders: &[ColliderHandle]) -> Vec<Contact> {
    let time_step = world.integration_parameters.dt;
    let body_of = |collider: ColliderHandle| world.bodies.get(world.colliders.get(collider)?.parent()?);
    let mut contacts = Vec::new();
    for &own in colliders {
        let Some(body) = body_of(own) else { continue };
        let centre = convert::from_vector(body.center_of_mass());
        for pair in world.narrow_phase.contact_pairs_with(own) {
            let first = pair.collider1 == own;
            let sign = if first { 1.0 } else { -1.0 };
            let other = body_of(if first { pair.collider2 } else { pair.collider1 });
            for manifold in pair.solver_manifolds() {
                let normal = -convert::from_vector(manifold.data.normal);
                for data in solved(manifold).filter(|data| data.impulse > 0.0) {
                    let friction = convert::from_vector(data.warmstart_tangent_world);
                    let point = centre + convert::from_vector(if first { data.solver_dp1 } else { data.solver_dp2 });
                    let moves = |body: &RigidBody| convert::from_vector(body.velocity_at_point(convert::vector(point)));
                    let velocity = moves(body) - other.map_or_else(Vector3::zeros, moves);
                    let most = manifold.data.friction * data.impulse;
                    contacts.push(Contact {
                        point,
                        force: (normal * data.impulse + friction) * (sign / time_step),
                        wheel,
                        slip: velocity - normal * normal.dot(&velocity),
                        friction_share: if most > 0.0 { (friction.norm() / most).min(1.0) } else { 0.0 },
                    });
                }
            }
        }
    }
    contacts
}

/// Computes the load on the colliders of a wheel.
pub(super) fn load(world: &PhysicsWorld, materials: &Materials, wheel: &[ColliderHandle]) -> Load {
    let mut load = Load::default();
    for &own in wheel {
        for pair in world.narrow_phase.contact_pairs_with(own).filter(|pair| pair.has_any_active_contact()) {
            let (sign, other) = if pair.collider1 == own { (-1.0, pair.collider2) } else { (1.0, pair.collider1) };
            // A removed collider is listed until the next step, and carries nothing.
            let (Some(own), Some(other)) = (world.colliders.get(own), world.colliders.get(other)) else { continue };
            let coefficient = materials.of(own).pair_rolling_resistance(materials.of(other));
            let push = |manifold: &ContactManifold| {
                manifold.data.normal * solved(manifold).map(|data| data.impulse).sum::<Real>()
            };
            let impulse = convert::from_vector(pair.solver_manifolds().iter().map(push).sum::<Vector>()) * sign;
            load.normal += impulse;
            load.resistance += coefficient * impulse.norm();
        }
    }
    load
}

/// Returns the contacts of a manifold that the last step solved. The engine chooses at most four of its points. The others keep the
/// impulses of their last solution, which the engine's own sums include.
fn solved(manifold: &ContactManifold) -> impl Iterator<Item = &ContactData> {
    let chosen = |index: usize| {
        let mut contacts = manifold.data.solver_contacts.iter();
        contacts.any(|contact| contact.contact_indices()[0] as usize == index)
    };
    manifold.points.iter().enumerate().filter(move |(index, _)| chosen(*index)).map(|(_, point)| &point.data)
}
