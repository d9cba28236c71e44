//! Rays for sensors.

use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::query::{Ray, RayCast, RayIntersection};
use rapier3d::prelude::*;

use super::identity::{Identity, Mark};
use super::{Physics, convert};
use crate::RobotId;

/// Most things that each ray of a sensor asks for one by one.
const FEW: usize = 6;

/// What a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayHit {
    /// Distance from the origin of the ray, m.
    pub(crate) distance: f64,
    /// Outward normal of the surface, world axes.
    pub(crate) normal: Vector3<f64>,
    /// What it met.
    pub(crate) identity: Identity,
}

/// What the rays of one sensor can meet.
pub(crate) struct Sight<'a> {
    world: &'a PhysicsWorld,
    robot: RobotId,
    origin: Vector,
    max_distance: f64,
    /// All of it where it is so little that each ray asks for each: a tree of boxes costs more then.
    few: Option<Vec<(&'a Collider, Aabb)>>,
}

impl Sight<'_> {
    /// First hit of a ray in a direction.
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
                let not_own = |_: ColliderHandle, collider: &Collider| !Mark::is_of(collider, self.robot);
                let query = self.world.query_pipeline_with_filter(QueryFilter::default().predicate(&not_own));
                let (met, hit) = query.cast_ray_and_get_normal(&ray, self.max_distance, true)?;
                (&self.world.colliders[met], hit)
            }
        };
        let identity = Mark::of(met).identity;
        Some(RayHit { distance: hit.time_of_impact, normal: convert::from_vector(hit.normal), identity })
    }
}

impl Physics {
    /// What the rays of a sensor can meet; they do not see the robot that carries it, and from inside a solid they read 0.
    pub(crate) fn sight(&self, origin: &Point3<f64>, max_distance: f64, robot: RobotId) -> Sight<'_> {
        let (world, origin) = (&self.world, convert::vector(origin.coords));
        let around = Aabb::from_half_extents(origin, Vector::splat(max_distance));
        let not_own = |_: ColliderHandle, collider: &Collider| !Mark::is_of(collider, robot);
        let query = world.query_pipeline_with_filter(QueryFilter::default().predicate(&not_own));
        let near = query.intersect_aabb_conservative(around).take(FEW + 1);
        let handles: Vec<ColliderHandle> = near.map(|(handle, _)| handle).collect();
        let colliders = handles.iter().filter_map(|&handle| world.colliders.get(handle));
        let near: Vec<(&Collider, Aabb)> = colliders.map(|collider| (collider, collider.compute_aabb())).collect();
        let few = Some(near).filter(|near| near.len() <= FEW);
        Sight { world, robot, origin, max_distance, few }
    }
}
