//! Questions about the geometry: rays for sensors, and where a robot can stand.

use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::query::{Ray, RayCast, RayIntersection};
use rapier3d::prelude::*;

use scene::{MountedWheel, Pose, Steering};

use super::compile::CompiledRobot;
use super::identity::{Identity, Mark};
use super::{Physics, convert};
use crate::RobotId;

/// A clear gap left under a robot that is put on a surface, m: it settles by this in a few steps.
const CLEARANCE: f64 = 0.001;
/// Surfaces are looked for from this far above the wanted place, m.
const SKY: f64 = 1000.0;
/// Most surfaces above each other that are looked at.
const MAX_LAYERS: usize = 64;
/// How often a robot is lifted out of others: once for each of a full world.
const MAX_LIFTS: usize = 256;

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

    /// The pose at which a robot asked for at `pose` is put: where it is if it stands free above a surface,
    /// otherwise lifted (or lowered into the world from below) onto the surface next above it.
    ///
    /// Other robots count as surfaces: the second of two at one place stands on the first. Where it would still be inside
    /// another robot or an object, it is lifted above that.
    pub(crate) fn standing_pose(&self, robot: &CompiledRobot, pose: &Pose) -> Pose {
        if robot.def.steering == Steering::None {
            return *pose;
        }
        let lift = |lowest: Point3<f64>| Some(lowest.z - self.surface_to_stand_on(&lowest, pose.translation.z)?);
        let of_wheel = |wheel: MountedWheel| pose * Point3::from(wheel.position) + Vector3::z() * wheel.radius;
        let mut lifts: Vec<f64> = robot.def.wheels().filter_map(|wheel| lift(of_wheel(wheel))).collect();
        if robot.def.wheels().next().is_none() {
            let bottom = |(local, part): &(Pose, SharedShape)| {
                let bounds = part.compute_aabb(&convert::pose(&(pose * local)));
                Point3::from(convert::from_vector(bounds.center())).xy().coords.push(bounds.maxs.z).into()
            };
            lifts.extend(robot.outlines.iter().map(bottom).filter_map(lift));
        }
        let lift = lifts.into_iter().fold(0.0, f64::max);
        let mut standing = *pose;
        if lift > 0.0 {
            standing.translation.z -= lift + CLEARANCE;
        }
        self.lifted_out_of_bodies(robot, standing)
    }

    /// What moves must not start inside something else that moves: the engine would fling them apart.
    fn lifted_out_of_bodies(&self, robot: &CompiledRobot, mut pose: Pose) -> Pose {
        for _ in 0..MAX_LIFTS {
            let query = self.world.query_pipeline_with_filter(QueryFilter::exclude_fixed());
            // Up is negative.
            let (mut bottom, mut top) = (f64::NEG_INFINITY, f64::INFINITY);
            for (local, part) in &robot.outlines {
                let place = convert::pose(&(pose * local));
                bottom = bottom.max(part.compute_aabb(&place).maxs.z);
                let met = query.intersect_shape(place, part.as_ref());
                top = met.map(|(_, other)| other.compute_aabb().mins.z).fold(top, f64::min);
            }
            if !top.is_finite() {
                break;
            }
            pose.translation.z -= bottom - top + CLEARANCE;
        }
        pose
    }

    /// Height (z) of the surface that something at a place belongs on: the first one below the reference height
    /// if there is any and the place is not inside its solid, otherwise the nearest one above.
    fn surface_to_stand_on(&self, place: &Point3<f64>, reference: f64) -> Option<f64> {
        let layers = self.layers(place, reference);
        let inside = layers.iter().any(|layer| layer.top < reference && reference <= layer.bottom);
        let below = layers.iter().find(|layer| layer.top >= reference);
        let above = layers.iter().rev().find(|layer| layer.top < reference);
        match (inside, below, above) {
            (false, Some(below), _) => Some(below.top),
            (_, _, above) => above.map(|layer| layer.top),
        }
    }

    /// The solids crossed by the vertical line through a place, from above to below.
    fn layers(&self, place: &Point3<f64>, reference: f64) -> Vec<Layer> {
        let query = self.world.query_pipeline();
        let ray = Ray::new(convert::vector([place.x, place.y, reference - SKY]), Vector::Z);
        let mut layers: Vec<Layer> =
            query.intersect_ray(ray, 2.0 * SKY, true).flat_map(|(_, collider, _)| layers_of(collider, ray)).collect();
        layers.sort_by(|a, b| a.top.total_cmp(&b.top));
        // What touches or overlaps is one: a box on the floor goes on in the floor.
        layers.dedup_by(|lower, upper| {
            let joined = lower.top <= upper.bottom + CLEARANCE;
            if joined {
                upper.bottom = upper.bottom.max(lower.bottom);
            }
            joined
        });
        layers
    }
}

/// The layers of one collider on a ray that points down: one for a convex solid, one for each upward face of a mesh.
fn layers_of(collider: &Collider, mut ray: Ray) -> Vec<Layer> {
    let cast = |ray: &Ray| collider.shape().cast_ray_and_get_normal(collider.position(), ray, 2.0 * SKY, false);
    let mut layers = Vec::new();
    let mesh = collider.shape().as_trimesh().map(|mesh| mesh.num_triangles() as u32);
    while layers.len() < MAX_LAYERS
        && let Some(hit) = cast(&ray)
    {
        let top = ray.point_at(hit.time_of_impact).z;
        ray.origin = ray.point_at(hit.time_of_impact + 1e-3);
        match (mesh, hit.feature) {
            // A face hit from behind has a number beyond those of the faces.
            (Some(faces), FeatureId::Face(face)) if face >= faces => {}
            (Some(_), _) => layers.push(Layer { top, bottom: top }),
            (None, _) => {
                let bottom = cast(&ray).map_or(f64::INFINITY, |exit| ray.point_at(exit.time_of_impact).z);
                return vec![Layer { top, bottom }];
            }
        }
    }
    layers
}

/// One solid on a vertical line.
struct Layer {
    /// z where the line enters it from above.
    top: f64,
    /// z where it leaves it; `top` for a surface without volume.
    bottom: f64,
}
