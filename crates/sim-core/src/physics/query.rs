//! Rays for sensors.

use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{Ray, RayCast, RayIntersection};
use rapier3d::prelude::*;

use super::identity::{Identity, Mark};
use super::surface::Materials;
use super::{Physics, convert};
use scene::Pose;

use crate::PawnId;

/// Most colliders in reach that each ray tests one by one.
const FEW: usize = 6;

/// Margin by which the engine's tree enlarges the box of a collider that has moved, m (`BroadPhaseBvh::CHANGE_DETECTION_FACTOR`).
const MARGIN: f64 = 0.04;

/// The first hit of a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayHit {
    /// Distance from the origin of the ray, m.
    pub(crate) distance: f64,
    /// Outward normal of the surface, world axes.
    pub(crate) normal: Vector3<f64>,
    /// The entity that was hit.
    pub(crate) identity: Identity,
    /// Number of its material.
    material: u32,
}

/// The kind of a sensor's rays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Light {
    /// Stops at every surface.
    Visible,
    /// Passes through transparent materials.
    Infrared,
}

/// A query for the rays of one sensor.
pub(crate) struct Sight<'a> {
    world: &'a PhysicsWorld,
    materials: &'a Materials,
    light: Light,
    robot: PawnId,
    origin: Vector,
    max_distance: f64,
    /// All colliders in reach, if so few that testing each costs less than a tree of boxes.
    few: Option<Vec<(&'a Collider, Aabb)>>,
}

impl Sight<'_> {
    /// Returns the distance to the first hit of a ray in a direction, m; the largest distance if there is none.
    pub(crate) fn range(&self, direction: &Vector3<f64>) -> f64 {
        self.cast_ray(direction).map_or(self.max_distance, |hit| hit.distance)
    }

    /// Returns the first hit of a ray in a direction.
    pub(crate) fn cast_ray(&self, direction: &Vector3<f64>) -> Option<RayHit> {
        let ray = Ray::new(self.origin, convert::vector(*direction));
        let (met, hit) = match &self.few {
            Some(few) => {
                let mut nearest: Option<(&Collider, RayIntersection)> = None;
                for &(collider, around) in few {
                    let most = nearest.map_or(self.max_distance, |(_, hit)| hit.time_of_impact);
                    if around.cast_local_ray(&ray, most, true).is_some()
                        && let Some(hit) =
                            collider.shape().cast_ray_and_get_normal(collider.position(), &ray, most, true)
                    {
                        nearest = Some((collider, hit));
                    }
                }
                nearest?
            }
            None => {
                let stops =
                    |_: ColliderHandle, collider: &Collider| self.light.stops_at(collider, self.robot, self.materials);
                let query = self.world.query_pipeline_with_filter(QueryFilter::default().predicate(&stops));
                let (met, hit) = query.cast_ray_and_get_normal(&ray, self.max_distance, true)?;
                (&self.world.colliders[met], hit)
            }
        };
        let Mark { identity, material } = Mark::of(met);
        Some(RayHit { distance: hit.time_of_impact, normal: convert::from_vector(hit.normal), identity, material })
    }
}

/// Sets the box of a collider in the engine's tree.
///
/// The tree keeps a box that still holds the collider, but enlarges the boxes around it by the tight one alone (parry 0.31.1,
/// `Bvh::insert_with_change_detection`). Rays then miss a collider that has moved within its margin. So the box is enlarged before.
pub(super) fn set_box(
    broad_phase: &mut DefaultBroadPhase,
    parameters: &IntegrationParameters,
    handle: ColliderHandle,
    collider: &Collider,
) {
    broad_phase.set_aabb(parameters, handle, collider.compute_aabb().loosened(MARGIN));
}

impl Physics {
    /// Prepares a query for the rays of a sensor. They do not hit the robot that carries it, and inside a solid they read 0.
    pub(crate) fn sight(&self, light: Light, origin: &Point3<f64>, max_distance: f64, robot: PawnId) -> Sight<'_> {
        let (world, materials, origin) = (&self.world, &*self.materials, convert::vector(origin.coords));
        let around = Aabb::from_half_extents(origin, Vector::splat(max_distance));
        let stops = |_: ColliderHandle, collider: &Collider| light.stops_at(collider, robot, materials);
        let query = world.query_pipeline_with_filter(QueryFilter::default().predicate(&stops));
        let near = query.intersect_aabb_conservative(around).take(FEW + 1);
        let handles: Vec<ColliderHandle> = near.map(|(handle, _)| handle).collect();
        let colliders = handles.iter().filter_map(|&handle| world.colliders.get(handle));
        let near: Vec<(&Collider, Aabb)> = colliders.map(|collider| (collider, collider.compute_aabb())).collect();
        let few = Some(near).filter(|near| near.len() <= FEW);
        Sight { world, materials, light, robot, origin, max_distance, few }
    }

    /// Returns the name of the material that a ray has hit.
    pub(crate) fn material_of(&self, hit: &RayHit) -> &str {
        self.materials.get(hit.material).map_or("", |material| &material.name)
    }

    /// Returns the name and the pose of the entity that a ray has hit. A robot is named by its number.
    pub(crate) fn named(&self, identity: Identity) -> Option<(String, Pose)> {
        match identity {
            Identity::Solid(number) => self.site.solid(number).map(|(name, pose)| (name.to_owned(), pose)),
            Identity::Object(id) => Some((self.object_name(id)?.to_owned(), self.object(id)?)),
            Identity::Link { robot, .. } => {
                let is_body = |collider: &&Collider| Mark::of(collider).identity == Identity::Link { robot, link: 0 };
                let collider = self.world.colliders.iter().map(|(_, collider)| collider).find(is_body)?;
                let body = self.world.bodies.get(collider.parent()?)?;
                Some((format!("Robot_{}", robot.0), convert::from_pose(body.position())))
            }
        }
    }
}

impl Light {
    /// True if a surface that is not the robot's own stops a ray.
    fn stops_at(self, collider: &Collider, robot: PawnId, materials: &Materials) -> bool {
        let passes = self == Self::Infrared && materials.of(collider).transparent;
        !passes && !Mark::is_of(collider, robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays in the tree and rays that ask every collider agree, however little the colliders have moved since the last time.
    #[test]
    fn a_ray_meets_what_has_moved_a_little() {
        let mut world = PhysicsWorld::new();
        let handles: Vec<ColliderHandle> = (0..40)
            .map(|number| {
                let (row, column) = (f64::from(number / 8), f64::from(number % 8));
                let body = RigidBodyBuilder::kinematic_position_based().translation(Vector::new(row, column, 0.0));
                let body = world.insert_body(body);
                world.insert_collider(ColliderBuilder::cuboid(0.2, 0.1, 0.1), Some(body))
            })
            .collect();
        world.step();
        let mut hits = 0;
        for round in 0..200 {
            for (&handle, direction) in handles.iter().zip(0..) {
                // Steps of 3 mm, each collider in a direction of its own: far less than the margin.
                let (sin, cos) = f64::from(direction).sin_cos();
                let PhysicsWorld { broad_phase, integration_parameters, colliders, .. } = &mut world;
                let collider = colliders.get_mut(handle).expect("a collider");
                let place = collider.translation() + Vector::new(cos, sin, 0.0) * 0.003;
                collider.set_position(rapier3d::math::Pose::from_translation(place));
                set_box(broad_phase, integration_parameters, handle, collider);
            }
            for beam in 0..90 {
                let (sin, cos) = (f64::from(beam) * 0.07 + f64::from(round)).sin_cos();
                let ray = Ray::new(Vector::new(2.5, 3.5, 0.0), Vector::new(cos, sin, 0.0));
                let query = world.query_pipeline_with_filter(QueryFilter::default());
                let found = query.cast_ray(&ray, 10.0, true).map(|(_, distance)| distance);
                let each = world.colliders.iter();
                let each = each.filter_map(|(_, it)| it.shape().cast_ray(it.position(), &ray, 10.0, true));
                let nearest = each.min_by(f64::total_cmp);
                assert_eq!(found, nearest, "beam {beam} of round {round}");
                hits += usize::from(nearest.is_some());
            }
        }
        assert!(hits > 1000, "{hits} hits");
    }
}
