//! Contacts of rollers: our own dispatcher for the engine's narrow phase. Every other pair is left to parry.
//!
//! A roller touches a convex shape at one point: on the sphere of its axis that is nearest to the shape. Against a plane this is
//! closed-form. Against anything else the gap is a convex function along the axis, and bisection finds its minimum. This avoids iteration
//! over simplices, which on a large flat face lifts a roller by millimetres.

use rapier3d::geometry::{ContactData, ContactManifoldData};
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::details::{
    NormalConstraints, NormalConstraintsPair, ShapeCastOptions, contact_manifolds_composite_shape_shape,
    contact_manifolds_trimesh_shape_shapes,
};
use rapier3d::parry::query::{
    ClosestPoints, Contact, ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher, NonlinearRigidMotion,
    PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit, ShapeDistance, ShapeIntersection, TrackedContact,
    Unsupported,
};
use rapier3d::parry::shape::{ConvexPolyhedron, PackedFeatureId, Shape};

use super::roller::{HALVINGS, RollerShape};

/// Cosine above which two normals belong to one plane.
const SAME_NORMAL: Real = 1.0 - 1e-6;

/// A query dispatcher that handles rollers by their own geometry and leaves the rest to parry.
pub(super) struct RollerDispatcher;

type Manifold = ContactManifold<ContactManifoldData, ContactData>;

/// A contact of a roller with another shape, in the frame of that shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// Normal, from the other shape to the roller.
    pub(super) normal: Vector,
    /// Place on the roller's axis.
    pub(super) along: Real,
    /// Gap; negative where they overlap.
    pub(super) gap: Real,
}

/// Returns the contact of a roller with a convex shape, or with a part of a shape, within a distance. `pose` is the roller's in the frame
/// of the other.
pub(super) fn touch_part(
    roller: &RollerShape,
    pose: &Pose,
    part: &dyn Shape,
    constraints: Option<&dyn NormalConstraints>,
    prediction: Real,
) -> Option<Touch> {
    let touch = touch(roller, pose, part, prediction)?;
    let Some(constraints) = constraints else { return Some(touch) };
    // An edge inside a mesh does not count: the face beside it holds the roller.
    let (mut normal, mut back) = (touch.normal, pose.rotation.inverse() * -touch.normal);
    let allowed = (Some(constraints), None).project_local_normals(pose, &mut normal, &mut back);
    (allowed && normal.dot(touch.normal) >= SAME_NORMAL).then_some(touch)
}

/// Returns the contact without normal constraints. The gap is convex along the axis, so its value and slope at one place bound it from
/// below. This spares the search if the shape is out of reach.
fn touch(roller: &RollerShape, pose: &Pose, other: &dyn Shape, prediction: Real) -> Option<Touch> {
    let axis = pose.rotation * Vector::X;
    let centre = |along: Real| pose.translation + axis * along;
    if let Some(half_space) = other.as_halfspace() {
        let normal = half_space.normal;
        let along = roller.farthest_along(-normal.dot(axis));
        return within(Touch { normal, along, gap: normal.dot(centre(along)) - roller.radius_at(along) }, prediction);
    }
    let touch_at = |along: Real| {
        let (distance, normal) = distance(other, centre(along))?;
        Some(Touch { normal, along, gap: distance - roller.radius_at(along) })
    };
    let slope = |touch: &Touch| touch.normal.dot(axis) + roller.taper_at(touch.along);
    let (mut low, mut high) = roller.axis_ends();
    let middle = touch_at(0.0)?;
    if middle.gap - slope(&middle).abs() * high > prediction {
        return None;
    }
    let face = touch_at(roller.farthest_along(-middle.normal.dot(axis)))?;
    if face.normal.dot(middle.normal) > SAME_NORMAL {
        return within(face, prediction);
    }
    // An edge or a corner is near.
    let mut touch = face;
    for _ in 0..HALVINGS {
        touch = touch_at((low + high) / 2.0)?;
        let slope = slope(&touch);
        if touch.gap - slope.abs() * (high - low) / 2.0 > prediction {
            return None;
        }
        if slope > 0.0 {
            high = touch.along;
        } else {
            low = touch.along;
        }
    }
    within(touch, prediction)
}

fn within(touch: Touch, prediction: Real) -> Option<Touch> {
    (touch.gap <= prediction).then_some(touch)
}

/// Returns the signed distance of a point from a convex shape, and the direction away from the shape.
pub(super) fn distance(shape: &dyn Shape, point: Vector) -> Option<(Real, Vector)> {
    if let Some(hull) = shape.as_convex_polyhedron()
        && let Some(found) = distance_from_face(hull, point)
    {
        return Some(found);
    }
    let projection = shape.project_local_point(point, false);
    let offset = if projection.is_inside { projection.point - point } else { point - projection.point };
    let length = offset.length();
    let normal = offset.try_normalize();
    let sign = if projection.is_inside { -1.0 } else { 1.0 };
    if let Some(triangle) = shape.as_triangle()
        && let Some(flat) = triangle.normal()
        && let Some(normal) = normal
        && normal.dot(flat).abs() > SAME_NORMAL
    {
        // Barycentric coordinates of a large triangle are coarse; its plane is exact.
        let normal = flat * normal.dot(flat).signum();
        return Some((normal.dot(point - triangle.a), normal));
    }
    Some((sign * length, normal?))
}

/// Returns height and normal of the face that the point is over, if any. It is exact however large the hull is.
fn distance_from_face(hull: &ConvexPolyhedron, point: Vector) -> Option<(Real, Vector)> {
    let faces = hull.faces();
    let corner = |face: usize, index: u32| {
        let index = faces[face].first_vertex_or_edge + index % faces[face].num_vertices_or_edges;
        hull.points()[hull.vertices_adj_to_face()[index as usize] as usize]
    };
    let height = |face: usize| faces[face].normal.dot(point - corner(face, 0));
    let face = (0..faces.len()).max_by(|&a, &b| height(a).total_cmp(&height(b)))?;
    let normal = faces[face].normal;
    let within = (0..faces[face].num_vertices_or_edges).all(|index| {
        let (from, to) = (corner(face, index), corner(face, index + 1));
        normal.dot((to - from).cross(point - from)) >= 0.0
    });
    within.then(|| (height(face), normal))
}

impl RollerDispatcher {
    /// Computes the one contact of a roller with a convex shape. `pose` is the roller's in the frame of the other.
    fn collide(
        roller: &RollerShape,
        other: &dyn Shape,
        pose: &Pose,
        constraints: Option<&dyn NormalConstraints>,
        prediction: Real,
        flipped: bool,
        manifold: &mut Manifold,
    ) {
        let old_points = std::mem::take(&mut manifold.points);
        let Some(Touch { normal, along, gap }) = touch_part(roller, pose, other, constraints, prediction) else {
            return;
        };
        let back = pose.rotation.inverse() * -normal;
        let on_roller = Vector::X * along + back * roller.radius_at(along);
        let on_other = pose * on_roller - normal * gap;
        let feature = PackedFeatureId::face(0);
        manifold.points.push(TrackedContact::flipped(on_other, on_roller, feature, feature, gap, flipped));
        (manifold.local_n1, manifold.local_n2) = if flipped { (back, normal) } else { (normal, back) };
        manifold.match_contacts(&old_points);
    }
}

fn as_roller(shape: &dyn Shape) -> Option<&RollerShape> {
    shape.as_shape::<RollerShape>()
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for RollerDispatcher {
    fn contact_manifolds(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        prediction: Real,
        manifolds: &mut Vec<Manifold>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        if as_roller(shape1).is_none() && as_roller(shape2).is_none() {
            let default = DefaultQueryDispatcher;
            return default.contact_manifolds(pos12, shape1, shape2, prediction, manifolds, workspace);
        }
        if shape1.as_trimesh().is_some() || shape2.as_trimesh().is_some() {
            contact_manifolds_trimesh_shape_shapes(self, pos12, shape1, shape2, prediction, manifolds, workspace);
        } else if let Some(composite) = shape1.as_composite_shape() {
            contact_manifolds_composite_shape_shape(
                self, pos12, composite, shape2, prediction, manifolds, workspace, false,
            );
        } else if let Some(composite) = shape2.as_composite_shape() {
            let pos21 = pos12.inverse();
            contact_manifolds_composite_shape_shape(
                self, &pos21, composite, shape1, prediction, manifolds, workspace, true,
            );
        } else {
            if manifolds.is_empty() {
                manifolds.push(ContactManifold::new());
            }
            let manifold = &mut manifolds[0];
            return self.contact_manifold_convex_convex(pos12, shape1, shape2, None, None, prediction, manifold);
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        pos12: &Pose,
        shape1: &dyn Shape,
        shape2: &dyn Shape,
        constraints1: Option<&dyn NormalConstraints>,
        constraints2: Option<&dyn NormalConstraints>,
        prediction: Real,
        manifold: &mut Manifold,
    ) -> Result<(), Unsupported> {
        if let Some(roller) = as_roller(shape2) {
            Self::collide(roller, shape1, pos12, constraints1, prediction, false, manifold);
        } else if let Some(roller) = as_roller(shape1) {
            Self::collide(roller, shape2, &pos12.inverse(), constraints2, prediction, true, manifold);
        } else {
            return DefaultQueryDispatcher.contact_manifold_convex_convex(
                pos12,
                shape1,
                shape2,
                constraints1,
                constraints2,
                prediction,
                manifold,
            );
        }
        Ok(())
    }
}

/// All queries but contact manifolds are parry's own, which treats a roller as a support map.
impl QueryDispatcher for RollerDispatcher {
    fn intersection_test(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        DefaultQueryDispatcher.intersection_test(pos12, g1, g2)
    }

    fn distance(&self, pos12: &Pose, g1: &dyn Shape, g2: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        DefaultQueryDispatcher.distance(pos12, g1, g2)
    }

    fn contact(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        prediction: Real,
    ) -> Result<Option<Contact>, Unsupported> {
        DefaultQueryDispatcher.contact(pos12, g1, g2, prediction)
    }

    fn closest_points(
        &self,
        pos12: &Pose,
        g1: &dyn Shape,
        g2: &dyn Shape,
        max_dist: Real,
    ) -> Result<ClosestPoints, Unsupported> {
        DefaultQueryDispatcher.closest_points(pos12, g1, g2, max_dist)
    }

    fn cast_shapes(
        &self,
        pos12: &Pose,
        velocity: Vector,
        g1: &dyn Shape,
        g2: &dyn Shape,
        options: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes(pos12, velocity, g1, g2, options)
    }

    fn cast_shapes_nonlinear(
        &self,
        motion1: &NonlinearRigidMotion,
        g1: &dyn Shape,
        motion2: &NonlinearRigidMotion,
        g2: &dyn Shape,
        start: Real,
        end: Real,
        stop_at_penetration: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        DefaultQueryDispatcher.cast_shapes_nonlinear(motion1, g1, motion2, g2, start, end, stop_at_penetration)
    }
}
