//! Questions about the geometry: rays for sensors, and where a robot can stand.

use nalgebra::{Point3, Vector3};
use rapier3d::parry::query::Ray;
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

impl Physics {
    /// Casts a ray from a sensor; it does not see the robot that carries it, and from inside a solid it reads 0.
    pub(crate) fn cast_ray(
        &self,
        origin: &Point3<f64>,
        direction: &Vector3<f64>,
        max_distance: f64,
        robot: RobotId,
    ) -> Option<RayHit> {
        let not_own = |_: ColliderHandle, collider: &Collider| !Mark::is_of(collider, robot);
        let filter = QueryFilter::default().predicate(&not_own);
        let ray = Ray::new(convert::vector(origin.coords), convert::vector(*direction));
        let query = self.world.query_pipeline_with_filter(filter);
        let (met, hit) = query.cast_ray_and_get_normal(&ray, max_distance, true)?;
        let identity = Mark::of(&self.world.colliders[met]).identity;
        Some(RayHit { distance: hit.time_of_impact, normal: convert::from_vector(hit.normal), identity })
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
