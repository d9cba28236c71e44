//! Free places for robots: on the surface at the wanted place and clear of all solids, or else beside it.
//!
//! A pose in the floor, in a ramp or below everything is lifted onto the surface above it. A robot above a surface falls. Where another
//! robot, an object or a solid is in the way, the robot is put at the nearest free place beside it, on the same floor and on the same side
//! of walls. A robot comes to stand on another only if it is asked for above it.

use std::sync::LazyLock;

use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{self, Ray};
use rapier3d::prelude::*;
use scene::{Footing, MountedWheel, Object, Pose};

use super::compile::CompiledRobot;
use super::identity::{Identity, Mark};
use super::{Physics, convert, shape};
use crate::PawnId;

/// Gap left under a robot that is put on a surface, m. It settles by this in a few steps.
const CLEARANCE: f64 = 0.001;
/// Height above the wanted place from which surfaces are searched, m.
const SKY: f64 = 1000.0;
/// Most surfaces above each other that are searched.
const MAX_LAYERS: usize = 64;

/// Overlap with a solid that is accepted, m. Contacts push it out gently.
const OVERLAP: f64 = 0.005;
/// Largest height by which a robot is raised out of a slope, or out of a kerb between its wheels, m.
const MAX_RAISE: f64 = 0.15;
/// Number of heights that are tried.
const RAISES: u32 = 30;

/// Number of places tried on either side in each direction, so a full world of robots fits around one place.
const RINGS: i32 = 40;
/// Distance between neighbouring places, as a part of the robot's larger half size.
const SPACING: f64 = 0.6;
/// Most places that are checked closely. Places that another robot takes are ruled out by boxes before.
const MAX_TRIES: usize = 400;
/// Gap between a robot that is put beside another and everything that moves, m.
const GAP: f64 = 0.02;
/// Largest difference in height between the floors under a robot's wheels, and between the floors at a wanted place and beside it, m.
const MAX_DROP: f64 = 0.3;
/// Height above the floor at which no solid may stand between two places, m.
const KERB: f64 = 0.1;

/// A place for a robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Placement {
    /// Pose of the robot frame.
    pub(crate) pose: Pose,
    /// Obstacle at the wanted place, if the robot is put beside it.
    pub(crate) obstacle: Option<Identity>,
}

impl Physics {
    /// Finds a pose for a robot that is wanted at `pose`. It stays there if it stands free above a surface. It is lifted onto the surface
    /// if it is inside the floor or below it. Otherwise it goes to the nearest free place beside.
    ///
    /// A robot stands on another one only if it is wanted above it. Fails with the obstacle if there is no free place. `moved` is the robot,
    /// if it is in the world: it is no obstacle to itself.
    pub(crate) fn place(
        &self,
        robot: &CompiledRobot,
        wanted: &Pose,
        moved: Option<PawnId>,
    ) -> Result<Placement, Identity> {
        let pose = self.standing_pose(robot, wanted);
        let Err(obstacle) = self.check_room(robot, &pose, moved) else { return Ok(Placement { pose, obstacle: None }) };
        // Deep in the floor no place is near: it is looked for beside the one above.
        let is_deep = wanted.translation.z - pose.translation.z > MAX_DROP;
        let from = if is_deep { &pose } else { wanted };
        let beside = self.place_beside(robot, from, &pose, (obstacle, moved)).ok_or(obstacle)?;
        Ok(Placement { pose: beside, obstacle: Some(obstacle) })
    }

    /// Returns the pose of a robot on the surface at a wanted place, if it is free there. `None` otherwise.
    pub(crate) fn place_here(&self, robot: &CompiledRobot, wanted: &Pose) -> Option<Pose> {
        let pose = self.standing_pose(robot, wanted);
        self.check_room(robot, &pose, None).is_ok().then_some(pose)
    }

    /// Returns the robot or object that an object at a pose would overlap.
    pub(crate) fn obstacle(&self, object: &Object, pose: &Pose) -> Option<Identity> {
        let movers = self.world.query_pipeline_with_filter(QueryFilter::exclude_fixed());
        let shape = shape::shared(&object.solid.shape);
        let met = movers.intersect_shape(convert::pose(pose), shape.as_ref());
        met.min_by_key(|(handle, _)| handle.into_raw_parts()).map(|(_, met)| Mark::of(met).identity)
    }

    /// Returns the pose of an object that is wanted at a pose, lifted onto the floor that it is in.
    pub(crate) fn lifted(&self, object: &Object, wanted: &Pose) -> Pose {
        let lowest = shape::shared(&object.solid.shape).compute_aabb(&convert::pose(wanted)).maxs.z;
        let deep = self.floor_below(wanted.translation.vector).map_or(0.0, |floor| lowest - floor);
        let up = if deep > OVERLAP { deep } else { 0.0 };
        Pose::from_parts((wanted.translation.vector - Vector3::z() * up).into(), wanted.rotation)
    }

    /// Finds the nearest free place beside a wanted one, where the robot would stand at `standing`. Places behind walls, on top of them or
    /// below them do not count.
    fn place_beside(
        &self,
        robot: &CompiledRobot,
        wanted: &Pose,
        standing: &Pose,
        (obstacle, moved): (Identity, Option<PawnId>),
    ) -> Option<Pose> {
        let bounds = self.bounds(robot, standing);
        let half = bounds.half_extents();
        let step = SPACING * half.x.max(half.y).max(0.05);
        let around = Aabb::from_half_extents(bounds.center(), half + Vector::new(GAP, GAP, MAX_DROP));
        let is_other = is_other_than(moved);
        let movers = self.world.query_pipeline_with_filter(QueryFilter::exclude_fixed().predicate(&is_other));
        let candidates = RINGS_AROUND.iter().filter_map(|&(x, y)| {
            let offset = Vector3::new(f64::from(x) * step, f64::from(y) * step, 0.0);
            let moved = around.translated(convert::vector(offset));
            // The boxes in the tree are larger than those of the colliders.
            let mut near = movers.intersect_aabb_conservative(moved);
            let is_taken = near.any(|(_, collider)| collider.compute_aabb().intersects(&moved));
            (!is_taken).then(|| Pose::from_parts((wanted.translation.vector + offset).into(), wanted.rotation))
        });
        let here = wanted.translation.vector;
        let is_near = |pose: &Pose| self.is_near(here, pose.translation.vector, obstacle);
        let mut standing = candidates.take(MAX_TRIES).filter(is_near).map(|pose| self.standing_pose(robot, &pose));
        standing.find(|pose| self.check_room(robot, pose, moved).is_ok())
    }

    /// True if the floors of two places have nearly the same height and no solid stands between them. If the obstacle is a solid, every
    /// side of it is open, apart from places inside a solid.
    fn is_near(&self, here: Vector3<f64>, there: Vector3<f64>, obstacle: Identity) -> bool {
        let floor = self.floor_below(there);
        if matches!(obstacle, Identity::Solid(_)) {
            return floor.is_some_and(|floor| floor >= there.z - MAX_DROP);
        }
        let (from, to) = match (self.floor_below(here), floor) {
            (Some(from), Some(to)) if (from - to).abs() <= MAX_DROP => (from, to),
            (None, None) => (here.z, there.z),
            _ => return false,
        };
        // A pose may be inside the floor.
        let above = |place: Vector3<f64>, floor: f64| Vector3::new(place.x, place.y, place.z.min(floor - KERB));
        let (from, to) = (above(here, from), above(there, to));
        let ray = Ray::new(convert::vector(from), convert::vector(to - from));
        self.fixed().cast_ray(&ray, 1.0, true).is_none()
    }

    /// Returns the height (z) of the first floor at a place or below it, or above it if the place is inside a solid.
    pub(crate) fn floor_below(&self, place: Vector3<f64>) -> Option<f64> {
        self.surface_to_stand_on(&Point3::from(place), place.z)
    }

    fn fixed(&self) -> QueryPipeline<'_> {
        self.world.query_pipeline_with_filter(QueryFilter::only_fixed())
    }

    /// Returns a box around a robot at a pose.
    fn bounds(&self, robot: &CompiledRobot, pose: &Pose) -> Aabb {
        let boxes = robot.outlines.iter().map(|(local, part)| part.compute_aabb(&convert::pose(&(pose * local))));
        boxes.reduce(|one, other| one.merged(&other)).unwrap_or_else(Aabb::new_invalid)
    }

    /// Fails with the obstacle that a robot at a pose would overlap.
    fn check_room(&self, robot: &CompiledRobot, pose: &Pose, moved: Option<PawnId>) -> Result<(), Identity> {
        let is_other = is_other_than(moved);
        let movers = self.world.query_pipeline_with_filter(QueryFilter::exclude_fixed().predicate(&is_other));
        for (local, part) in &robot.outlines {
            let met = movers.intersect_shape(convert::pose(&(pose * local)), part.as_ref());
            if let Some((_, met)) = met.min_by_key(|(handle, _)| handle.into_raw_parts()) {
                return Err(Mark::of(met).identity);
            }
        }
        match self.deepest_overlap(robot, pose) {
            Some((depth, identity)) if depth > OVERLAP => Err(identity),
            _ => Ok(()),
        }
    }

    /// Returns the deepest overlap of a robot at a pose with a solid, m, and the solid. `None` for a robot that is fixed to the ground,
    /// which may overlap.
    fn deepest_overlap(&self, robot: &CompiledRobot, pose: &Pose) -> Option<(f64, Identity)> {
        if robot.def.footing == Footing::Fixed {
            return None;
        }
        let fixed = self.fixed();
        let overlaps = robot.outlines.iter().flat_map(|(local, part)| {
            let place = convert::pose(&(pose * local));
            let depth = move |solid: &Collider| {
                let contact = query::contact(solid.position(), solid.shape(), &place, part.as_ref(), 0.0);
                contact.ok().flatten().map(|contact| (-contact.dist, Mark::of(solid).identity))
            };
            fixed.intersect_shape(place, part.as_ref()).filter_map(move |(_, solid)| depth(solid))
        });
        overlaps.max_by(|(one, _), (other, _)| one.total_cmp(other))
    }

    /// Returns the pose of a robot on the surface at a place. It stays as it is above a surface, and is otherwise lifted onto the next
    /// surface above.
    fn standing_pose(&self, robot: &CompiledRobot, pose: &Pose) -> Pose {
        if robot.def.footing == Footing::Fixed {
            return *pose;
        }
        let of_disc = |(middle, radius): ([f64; 3], f64)| pose * Point3::from(middle) + Vector3::z() * radius;
        let discs = robot.def.wheels().flat_map(|wheel: MountedWheel| wheel.discs());
        let mut lowest: Vec<Point3<f64>> = discs.map(of_disc).collect();
        let lowest_wheel = lowest.iter().map(|point| point.z).reduce(f64::max);
        if lowest.is_empty() {
            lowest.extend(robot.outlines.iter().map(|(local, part)| {
                let bounds = part.compute_aabb(&convert::pose(&(pose * local)));
                Point3::new(bounds.center().x, bounds.center().y, bounds.maxs.z)
            }));
        }
        let on_surface = |point: &Point3<f64>| Some((point.z, self.surface_to_stand_on(point, pose.translation.z)?));
        let stands: Vec<(f64, f64)> = lowest.iter().filter_map(on_surface).collect();
        // A robot with one wheel in a wall does not belong on top of the wall. It stays in it, and is put beside it.
        let floor = stands.iter().map(|&(_, surface)| surface).fold(f64::NEG_INFINITY, f64::max);
        let lifts =
            stands.iter().filter(|&(_, surface)| floor - surface <= MAX_DROP).map(|(point, surface)| point - surface);
        let lift = lifts.fold(f64::NEG_INFINITY, f64::max);
        let mut standing = *pose;
        // Parts that hang below the wheels must not be in the floor.
        let hanging = lowest_wheel.map_or(0.0, |lowest| (self.bounds(robot, pose).maxs.z - lowest).max(0.0));
        let lift = lift + hanging;
        if lift > 0.0 && lift.is_finite() {
            standing.translation.z -= lift + CLEARANCE;
        }
        self.raised(robot, standing)
    }

    /// Raises a pose out of a slope under the wheels, or out of a kerb between them. Returns it unchanged if that is not enough.
    fn raised(&self, robot: &CompiledRobot, pose: Pose) -> Pose {
        let mut least = 0.0;
        for number in 0..=RAISES {
            let lift = f64::from(number) * MAX_RAISE / f64::from(RAISES);
            if lift < least {
                continue;
            }
            let raised = Pose::from_parts((pose.translation.vector - Vector3::z() * lift).into(), pose.rotation);
            match self.deepest_overlap(robot, &raised) {
                // A metre up makes an overlap smaller by a metre at most, so lower lifts are not enough. Overlaps are known to a micrometre.
                Some((depth, _)) if depth > OVERLAP => least = lift + (depth - OVERLAP) - 1e-6,
                _ => return raised,
            }
        }
        pose
    }

    /// Returns the height (z) of the surface to stand on at a place. It is the first one below the reference height, unless there is none
    /// or the place is inside a solid. Otherwise it is the nearest one above.
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

    /// Returns the solids on the vertical line through a place, from above to below.
    fn layers(&self, place: &Point3<f64>, reference: f64) -> Vec<Layer> {
        let ray = Ray::new(convert::vector([place.x, place.y, reference - SKY]), Vector::Z);
        let fixed = self.fixed();
        let met = fixed.intersect_ray(ray, 2.0 * SKY, true);
        let mut layers: Vec<Layer> = met.flat_map(|(_, collider, _)| layers_of(collider, ray)).collect();
        layers.sort_by(|a, b| a.top.total_cmp(&b.top));
        // Solids that touch or overlap are one layer: a box on the floor continues in the floor.
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

/// Returns a test of a collider: true if it is not part of a robot.
fn is_other_than(robot: Option<PawnId>) -> impl Fn(ColliderHandle, &Collider) -> bool {
    move |_, collider| robot.is_none_or(|robot| !Mark::is_of(collider, robot))
}

/// Offsets of the places around one, the nearest first.
static RINGS_AROUND: LazyLock<Vec<(i32, i32)>> = LazyLock::new(|| {
    let all = (-RINGS..=RINGS).flat_map(|x| (-RINGS..=RINGS).map(move |y| (x, y)));
    let mut around: Vec<(i32, i32)> = all.filter(|&place| place != (0, 0)).collect();
    // Ties go forward and to the right first.
    around.sort_by_key(|&(x, y)| (x * x + y * y, -x, -y));
    around
});

/// Face of a triangle that a ray meets from behind, as parry numbers it.
const BEHIND: FeatureId = FeatureId::Face(1);

/// Returns the layers of one collider on a ray that points down: one for a convex solid; one for each part of a mesh that is a solid, from a
/// face that looks up to the next one that looks down; and one without volume for each face of any other mesh.
fn layers_of(collider: &Collider, mut ray: Ray) -> Vec<Layer> {
    let cast = |ray: &Ray| collider.shape().cast_ray_and_get_normal(collider.position(), ray, 2.0 * SKY, false);
    let mut layers: Vec<Layer> = Vec::new();
    let mesh = collider.shape().as_trimesh();
    let is_solid = mesh.is_some_and(|mesh| !shape::is_two_sided(mesh));
    for _ in 0..2 * MAX_LAYERS {
        let Some(hit) = cast(&ray) else { break };
        let z = ray.point_at(hit.time_of_impact).z;
        ray.origin = ray.point_at(hit.time_of_impact + 1e-3);
        if mesh.is_none() {
            let bottom = cast(&ray).map_or(f64::INFINITY, |exit| ray.point_at(exit.time_of_impact).z);
            return vec![Layer { top: z, bottom }];
        }
        if is_solid && hit.feature == BEHIND {
            layers.last_mut().into_iter().for_each(|layer| layer.bottom = z);
        } else {
            layers.push(Layer { top: z, bottom: z });
        }
    }
    layers
}

/// One solid on a vertical line.
struct Layer {
    /// z at which the line enters the solid from above.
    top: f64,
    /// z at which the line leaves the solid; `top` for a surface without volume.
    bottom: f64,
}
