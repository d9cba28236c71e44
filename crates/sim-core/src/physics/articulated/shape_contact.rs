//! Contacts of a robot's surface with a shape.

use nalgebra::{Vector2, Vector3};
use rapier3d::geometry::{ContactData, ContactManifoldData};
use rapier3d::math::{Pose as EnginePose, Vector};
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query::details::{NormalConstraints, contact_support_map_support_map_with_params};
use rapier3d::parry::query::gjk::{GJKResult, VoronoiSimplex};
use rapier3d::parry::query::{ContactManifold, PersistentQueryDispatcher};
use rapier3d::parry::shape::{PolygonalFeature, Shape};

use super::super::contact::{RollerDispatcher, distance};
use super::super::convert;
use super::form::{Form, Surface};
use super::wheel::{Touch, Wheel};

/// Distance below which two contacts are one, m.
const SAME_PLACE: f64 = 1e-5;
/// Distance by which a wheel is lifted off what touches its side, m. Deeper overlaps take the engine's search.
const LIFT: f64 = 0.002;
/// Most contacts between two faces.
const MAX_POINTS: usize = 4;

/// A shape at a pose, which a surface may touch.
pub(super) struct Target<'a> {
    pub(super) shape: &'a dyn Shape,
    pub(super) pose: &'a EnginePose,
    /// True for a part of the map.
    pub(super) is_fixed: bool,
}

/// Adds the contacts of a surface at a pose with a shape, within a distance, m, in world axes.
pub(super) fn touches(own: &Surface, own_pose: &EnginePose, target: &Target, prediction: f64, found: &mut Vec<Touch>) {
    let &Target { shape: other, pose: other_pose, is_fixed } = target;
    if let Some(half_space) = other.as_halfspace() {
        let normal = convert::from_vector(other_pose.rotation * half_space.normal);
        let place = convert::from_vector(other_pose.translation);
        if !on_plane(own, own_pose, normal, place, prediction, found) {
            on_solid(own, own_pose, other, other_pose, prediction, found);
        }
        return;
    }
    if own.form == Form::Solid {
        return on_solid(own, own_pose, other, other_pose, prediction, found);
    }
    let pose = other_pose.inv_mul(own_pose);
    let before = found.len();
    let mut is_side = false;
    let mut on_part = |part_pose: Option<&EnginePose>, part: &dyn Shape, within: Option<&dyn NormalConstraints>| {
        let local = part_pose.map_or(pose, |part_pose| part_pose.inv_mul(&pose));
        let frame = part_pose.map_or(*other_pose, |part_pose| *other_pose * *part_pose);
        let nearest = |point: Vector3<f64>| {
            let (distance, normal) = distance(part, convert::vector(point))?;
            Some((distance, convert::from_vector(normal)))
        };
        let centre = convert::from_vector(local.translation);
        let touches = match own.form {
            Form::Wheel { radius, half_width } => {
                let axle = convert::from_vector(local.rotation * Vector::Y);
                match (Wheel { hub: centre, axle, radius, half_width }).on_shape(prediction, is_fixed, nearest) {
                    Some(touches) => touches,
                    None => {
                        is_side = true;
                        return;
                    }
                }
            }
            Form::Ball { radius } => [on_ball(centre, radius, prediction, nearest), None, None],
            Form::Solid | Form::Rollers(_) | Form::Track(_) => [None; 3],
        };
        for touch in touches.into_iter().flatten() {
            if within.is_some_and(|within| is_inner_edge(within, &local, &touch)) {
                continue;
            }
            let point = convert::from_vector(frame * convert::vector(touch.point));
            let normal = convert::from_vector(frame.rotation * convert::vector(touch.normal));
            let world = Touch::new(normal, point, touch.gap);
            // Two triangles that share an edge find the same contact there.
            if !found[before..].iter().any(|known| (known.point - world.point).amax() < SAME_PLACE) {
                found.push(world);
            }
        }
    };
    match other.as_composite_shape() {
        None => on_part(None, other, None),
        Some(composite) => {
            let near = own.shape.compute_aabb(&pose).loosened(prediction);
            for part in composite.bvh().intersect_aabb(&near) {
                composite.map_part_at(part, &mut on_part);
            }
        }
    }
    if is_side && (is_fixed || !on_side(own, own_pose, target, prediction, found)) {
        on_solid(own, own_pose, other, other_pose, prediction, found);
    }
}

/// Adds the contacts of the side of a wheel with a convex shape that moves. Returns false if it needs the engine's search.
///
/// The engine looks for the depth of an overlap by expanding a polytope, which takes several times as long as to find the distance of shapes
/// apart. The normal is about that at the hub. So the wheel is lifted along it until the shapes are apart, and comes back by what it was
/// lifted.
fn on_side(own: &Surface, own_pose: &EnginePose, target: &Target, prediction: f64, found: &mut Vec<Touch>) -> bool {
    let &Target { shape: other, pose: other_pose, .. } = target;
    let pose = other_pose.inv_mul(own_pose);
    let (Some((features, 0.0)), Some((its_features, 0.0)), Some((_, away))) =
        (own.shape.as_polygonal_feature_map(), other.as_polygonal_feature_map(), distance(other, pose.translation))
    else {
        return false;
    };
    let lifted = EnginePose::from_parts(pose.translation + away * LIFT, pose.rotation);
    let mut simplex = VoronoiSimplex::new();
    let nearest = contact_support_map_support_map_with_params(
        &lifted,
        its_features,
        features,
        prediction + LIFT,
        &mut simplex,
        Some(away),
    );
    let GJKResult::ClosestPoints(its_point, point, normal) = nearest else { return true };
    let back = pose.rotation.inverse() * -normal;
    let point = point - away * LIFT;
    let (mut feature, mut its_feature) = (PolygonalFeature::default(), PolygonalFeature::default());
    its_features.local_support_feature_toward(normal, its_point, &mut its_feature);
    features.local_support_feature_toward(back, pose.inverse_transform_point(point), &mut feature);
    let mut manifold = ContactManifold::<(), ()>::new();
    PolygonalFeature::contacts(&pose, &pose.inverse(), normal, back, &its_feature, &feature, &mut manifold, false);
    let deepest = (its_point, (point - its_point).dot(normal));
    let all = manifold.points.iter().map(|it| (it.local_p1, it.dist)).chain([deepest]);
    let away = convert::from_vector(other_pose.rotation * normal);
    let touches = all.filter(|(_, gap)| *gap <= prediction).map(|(place, gap)| {
        let place = convert::from_vector(*other_pose * place);
        Touch::new(away, place + away * gap, gap)
    });
    spread(touches.collect(), found);
    true
}

/// Adds the contact with a plane. Returns false if it needs the engine's geometry: a solid that reaches the plane, or a wheel's side.
fn on_plane(
    own: &Surface,
    pose: &EnginePose,
    normal: Vector3<f64>,
    place: Vector3<f64>,
    prediction: f64,
    found: &mut Vec<Touch>,
) -> bool {
    let centre = convert::from_vector(pose.translation);
    let touch = match own.form {
        Form::Wheel { radius, half_width } => {
            let axle = convert::from_vector(pose.rotation * Vector::Y);
            if normal.dot(&axle).abs() > super::wheel::SIDE {
                return normal.dot(&(centre - place)) > Vector2::new(radius, half_width).norm() + prediction;
            }
            Wheel { hub: centre, axle, radius, half_width }.on_plane(normal, place)
        }
        Form::Ball { radius } => {
            let height = normal.dot(&(centre - place));
            Touch::new(normal, centre - normal * radius, height - radius)
        }
        Form::Solid | Form::Rollers(_) | Form::Track(_) => {
            // The bounding box, in the surface's own axes.
            let middle = convert::from_vector(*pose * own.around.center());
            let half = own.around.half_extents().to_array();
            let axes = [Vector::X, Vector::Y, Vector::Z].map(|axis| convert::from_vector(pose.rotation * axis));
            let reach: f64 = axes.iter().zip(half).map(|(axis, half)| axis.dot(&normal).abs() * half).sum();
            return normal.dot(&(middle - place)) - reach > prediction;
        }
    };
    if touch.gap <= prediction {
        found.push(touch);
    }
    true
}

fn on_ball(
    centre: Vector3<f64>,
    radius: f64,
    prediction: f64,
    nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>,
) -> Option<Touch> {
    let (distance, normal) = nearest(centre)?;
    let touch = Touch::new(normal, centre - normal * radius, distance - radius);
    (touch.gap <= prediction).then_some(touch)
}

/// True if a contact is on an inner edge of a mesh. The face beside the edge holds the surface.
fn is_inner_edge(within: &dyn NormalConstraints, pose: &EnginePose, touch: &Touch) -> bool {
    use rapier3d::parry::query::details::NormalConstraintsPair;
    let mut normal = convert::vector(touch.normal);
    let mut back = pose.rotation.inverse() * -normal;
    let allowed = (Some(within), None).project_local_normals(pose, &mut normal, &mut back);
    !allowed || convert::from_vector(normal).dot(&touch.normal) < 1.0 - 1e-6
}

/// Adds the contacts that the engine's geometry finds: at most four of a face.
fn on_solid(
    own: &Surface,
    own_pose: &EnginePose,
    other: &dyn Shape,
    other_pose: &EnginePose,
    prediction: f64,
    found: &mut Vec<Touch>,
) {
    let near = |touches: Vec<Touch>| touches.into_iter().filter(|touch| touch.gap <= prediction).collect();
    on_faces(own, own_pose, other, other_pose, prediction, |touches| spread(near(touches), found));
}

/// Finds contacts by the engine's geometry. `on_face` gets all corners of each area that comes within a distance, m, in world axes.
pub(super) fn on_faces(
    own: &Surface,
    own_pose: &EnginePose,
    other: &dyn Shape,
    other_pose: &EnginePose,
    prediction: f64,
    mut on_face: impl FnMut(Vec<Touch>),
) {
    let mut manifolds: Vec<ContactManifold<ContactManifoldData, ContactData>> = Vec::new();
    let between = other_pose.inv_mul(own_pose);
    let dispatcher = RollerDispatcher;
    let known =
        dispatcher.contact_manifolds(&between, other, own.shape.as_ref(), prediction, &mut manifolds, &mut None);
    if known.is_err() {
        return;
    }
    for manifold in &manifolds {
        let frame = manifold.subshape_pos1().map_or(*other_pose, |pose| *other_pose * pose);
        let normal = convert::from_vector(frame.rotation * manifold.local_n1);
        if manifold.points.iter().all(|point| point.dist > prediction) {
            continue;
        }
        let touches = manifold.points.iter().map(|point| {
            let on_other = convert::from_vector(frame * point.local_p1);
            Touch::new(normal, on_other + normal * point.dist, point.dist)
        });
        on_face(touches.collect());
    }
}

/// Reduces many contacts of one face to four: the deepest, the one farthest from it, and those farthest from their line on either side.
fn spread(touches: Vec<Touch>, found: &mut Vec<Touch>) {
    if touches.len() <= MAX_POINTS {
        return found.extend(touches);
    }
    let by = |size: &dyn Fn(&Touch) -> f64| touches.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)));
    let Some(deepest) = by(&|touch| -touch.gap) else { return };
    let Some(farthest) = by(&|touch| (touch.point - deepest.point).norm()) else { return };
    let across = deepest.normal.cross(&(farthest.point - deepest.point));
    let off = |touch: &Touch| across.dot(&(touch.point - deepest.point));
    found.extend([Some(deepest), Some(farthest), by(&off), by(&|touch| -off(touch))].into_iter().flatten());
}
