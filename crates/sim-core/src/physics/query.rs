//! Rays for sensors.

use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query::Ray;
use rapier3d::prelude::*;

use super::identity::{Identity, Mark};
use super::packet::{self, Leaf, Packet, Slab};
use super::ray;
use super::surface::Materials;
use super::{Physics, convert};
use scene::Pose;

use crate::PawnId;

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
}

impl Sight<'_> {
    /// Returns the distance to the first hit of a ray in a direction, m; the largest distance if there is none.
    pub(crate) fn range(&self, direction: &Vector3<f64>) -> f64 {
        self.cast_ray(direction).map_or(self.max_distance, |hit| hit.distance)
    }

    /// Returns the distances to the first hits of rays, m, as [`Sight::range`] does. Neighbours should follow each other.
    pub(crate) fn ranges(&self, directions: impl IntoIterator<Item = Vector3<f64>>) -> Vec<f64> {
        let hits = self.cast_rays(directions).into_iter();
        hits.map(|hit| hit.map_or(self.max_distance, |hit| hit.distance)).collect()
    }

    /// Returns the first hit of a ray in a direction.
    pub(crate) fn cast_ray(&self, direction: &Vector3<f64>) -> Option<RayHit> {
        self.cast_rays([*direction]).pop()?
    }

    /// Returns the first hits of rays. They are found soonest if neighbours follow each other.
    pub(crate) fn cast_rays(&self, directions: impl IntoIterator<Item = Vector3<f64>>) -> Vec<Option<RayHit>> {
        let directions: Vec<[f64; 3]> = directions.into_iter().map(Into::into).collect();
        let tree = self.world.query_pipeline_with_filter(QueryFilter::default()).bvh;
        let (mut leaves, mut hits) = (Vec::new(), Vec::with_capacity(directions.len()));
        for directions in directions.chunks(packet::RAYS) {
            Packet::new(self.origin.to_array(), directions, self.max_distance).leaves(tree, &mut leaves);
            hits.extend(self.cast_packet(directions, &leaves));
        }
        hits
    }

    /// Casts the rays of a packet against its leaves.
    fn cast_packet(&self, directions: &[[f64; 3]], leaves: &[Leaf]) -> impl Iterator<Item = Option<RayHit>> {
        let mut rays: Vec<_> = directions
            .iter()
            .map(|&direction| {
                let ray = Ray::new(self.origin, Vector::from_array(direction));
                (ray, Slab::new(self.origin.to_array(), direction), self.max_distance, None)
            })
            .collect();
        let mut farthest = self.max_distance;
        for leaf in leaves {
            if leaf.nearest > farthest {
                break;
            }
            let Some((collider, _)) = self.world.colliders.get_unknown_gen(leaf.number) else { continue };
            if !self.light.stops_at(collider, self.robot, self.materials) {
                continue;
            }
            farthest = 0.0;
            for (ray, slab, most, nearest) in &mut rays {
                if slab.meets(leaf.node, *most)
                    && let Some(hit) = ray::meet(collider, ray, *most)
                    && (nearest.is_none() || hit.distance < *most)
                {
                    (*most, *nearest) = (hit.distance, Some((collider, hit)));
                }
                farthest = farthest.max(*most);
            }
        }
        rays.into_iter().map(|(.., nearest)| {
            let (met, hit) = nearest?;
            let Mark { identity, material } = Mark::of(met);
            let normal = convert::from_vector(hit.normal);
            Some(RayHit { distance: hit.distance, normal, identity, material })
        })
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
        let origin = convert::vector(origin.coords);
        Sight { world: &self.world, materials: &self.materials, light, robot, origin, max_distance }
    }

    /// Returns the map's solids within a distance of a point, m.
    pub(crate) fn solids_at(&self, point: Vector3<f64>, distance: f64) -> Vec<u32> {
        let point = convert::vector(point);
        let around = Aabb::new(point, point).loosened(distance);
        let near = self.world.query_pipeline_with_filter(QueryFilter::default());
        let solid = |(_, collider): (_, &Collider)| match Mark::of(collider).identity {
            Identity::Solid(solid) => {
                let gap = collider.shape().distance_to_point(collider.position(), point, true);
                (gap <= distance).then_some(solid)
            }
            _ => None,
        };
        near.intersect_aabb_conservative(around).filter_map(solid).collect()
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

    /// A scan's rays and rays that ask every collider agree, however little the colliders have moved since the last time, and whatever
    /// neighbours the rays have.
    #[test]
    fn a_ray_meets_what_has_moved_a_little() {
        let mut world = PhysicsWorld::new();
        let handles: Vec<ColliderHandle> = (0..40)
            .map(|number| {
                let (row, column) = (f64::from(number / 8), f64::from(number % 8));
                let body = RigidBodyBuilder::kinematic_position_based().translation(Vector::new(row, column, 0.0));
                let body = world.insert_body(body);
                let mark = Mark { identity: Identity::Solid(number), material: 0 }.to_bits();
                world.insert_collider(ColliderBuilder::cuboid(0.2, 0.1, 0.1).user_data(mark), Some(body))
            })
            .collect();
        world.step();
        let materials = Materials::default();
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
            // Fans in a plane, along the axes too, and rays to all sides.
            let (step, slope) = [(0.07, 0.0), (0.07, 0.02), (std::f64::consts::FRAC_PI_8, 0.0), (1.9, 0.01)][round % 4];
            let turn = if round % 4 == 2 { 0.0 } else { round as f64 };
            let directions: Vec<Vector3<f64>> = (0..90)
                .map(|beam| {
                    let (sin, cos) = (f64::from(beam) * step + turn).sin_cos();
                    Vector3::new(cos, sin, slope * sin).normalize()
                })
                .collect();
            let origin = Vector::new(2.5, 3.5, 0.0);
            let (light, robot) = (Light::Visible, PawnId(0));
            let sight = Sight { world: &world, materials: &materials, light, robot, origin, max_distance: 10.0 };
            for (beam, (hit, direction)) in sight.cast_rays(directions.clone()).iter().zip(&directions).enumerate() {
                let ray = Ray::new(origin, convert::vector(*direction));
                let each = world.colliders.iter();
                let each = each.filter_map(|(_, it)| {
                    it.shape().cast_ray_and_get_normal(it.position(), &ray, 10.0, true).map(|hit| hit.time_of_impact)
                });
                let nearest = each.min_by(f64::total_cmp);
                assert_eq!(hit.map(|hit| hit.distance), nearest, "beam {beam} of round {round}");
                hits += usize::from(nearest.is_some());
            }
        }
        assert!(hits > 1000, "{hits} hits");
    }
}
