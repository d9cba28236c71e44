//! A ray against one shape.

use rapier3d::parry::query::Ray;
use rapier3d::parry::shape::Cylinder;
use rapier3d::prelude::*;

/// A point where a ray meets a shape.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    /// Distance from the ray's origin, in lengths of its direction; 0 inside the shape.
    pub(super) distance: f64,
    /// Outward normal, in the ray's frame; zero inside.
    pub(super) normal: Vector,
}

/// Returns where a ray first meets a collider, within a distance.
pub(super) fn meet(collider: &Collider, ray: &Ray, most: f64) -> Option<Meeting> {
    let (shape, pose) = (collider.shape(), collider.position());
    if let Some(cylinder) = shape.as_cylinder() {
        let local = meet_cylinder(cylinder, &ray.inverse_transform_by(pose), most)?;
        return Some(Meeting { normal: pose.rotation * local.normal, ..local });
    }
    let hit = shape.cast_ray_and_get_normal(pose, ray, most, true)?;
    Some(Meeting { distance: hit.time_of_impact, normal: hit.normal })
}

/// Returns where a ray first meets a cylinder around its y axis.
///
/// The ray is inside where it is between the planes of the caps and within the endless cylinder. Parry searches for the point step by step,
/// which takes ten times as long.
fn meet_cylinder(cylinder: &Cylinder, ray: &Ray, most: f64) -> Option<Meeting> {
    let (from, along) = (ray.origin, ray.dir);
    let cap = cylinder.half_height.copysign(along.y);
    let (enters_caps, leaves_caps) = match along.y {
        0.0 if from.y.abs() <= cylinder.half_height => (f64::NEG_INFINITY, f64::INFINITY),
        0.0 => return None,
        rise => ((-cap - from.y) / rise, (cap - from.y) / rise),
    };
    let squared = along.x * along.x + along.z * along.z;
    let half = from.x * along.x + from.z * along.z;
    let outside = from.x * from.x + from.z * from.z - cylinder.radius * cylinder.radius;
    let (enters_side, leaves_side) = if squared == 0.0 {
        (outside <= 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY))?
    } else {
        let root = half * half - squared * outside;
        let root = if root < 0.0 { None } else { Some(root.sqrt()) }?;
        ((-half - root) / squared, (-half + root) / squared)
    };
    let enters = enters_caps.max(enters_side);
    if enters > leaves_caps.min(leaves_side).min(most) || leaves_caps.min(leaves_side) < 0.0 {
        return None;
    }
    let normal = if enters <= 0.0 {
        Vector::ZERO
    } else if enters_side > enters_caps {
        let at = from + along * enters;
        Vector::new(at.x, 0.0, at.z) / cylinder.radius
    } else {
        Vector::new(0.0, -1.0_f64.copysign(along.y), 0.0)
    };
    Some(Meeting { distance: enters.max(0.0), normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rapier3d::parry::query::RayCast;

    fn check(from: [f64; 3], along: [f64; 3], half_height: f64, radius: f64) {
        let ray = Ray::new(Vector::from_array(from), Vector::from_array(along).normalize());
        let cylinder = Cylinder::new(half_height, radius);
        let own = meet_cylinder(&cylinder, &ray, 10.0);
        // A ray that grazes an edge meets a slightly larger cylinder and not a slightly smaller one.
        let cast = |change: f64| {
            let cylinder = Cylinder::new(half_height + change, radius + change);
            cylinder.cast_local_ray_and_get_normal(&ray, 10.0, true)
        };
        let (smaller, same, larger) = (cast(-1e-4), cast(0.0), cast(1e-4));
        if smaller.is_some() != larger.is_some() {
            return;
        }
        assert_eq!(own.is_some(), same.is_some(), "{from:?} {along:?}: {:?}", same);
        let (Some(own), Some(same)) = (own, same) else { return };
        assert!((own.distance - same.time_of_impact).abs() < 1e-5, "{} and {}", own.distance, same.time_of_impact);
    }

    proptest! {
        #[test]
        fn a_cylinder_is_met_where_parrys_search_ends(
            from in prop::array::uniform3(-3.0..3.0_f64),
            along in prop::array::uniform3(-1.0..1.0_f64),
            half_height in 0.05..1.0_f64,
            radius in 0.05..1.0_f64,
        ) {
            prop_assume!(along.iter().any(|component| component.abs() > 0.01));
            check(from, along, half_height, radius);
        }
    }

    #[test]
    fn rays_along_an_axis_meet_a_cylinder() {
        let met = |from: [f64; 3], along: [f64; 3]| {
            let ray = Ray::new(Vector::from_array(from), Vector::from_array(along));
            meet_cylinder(&Cylinder::new(1.0, 0.5), &ray, 10.0).map(|met| (met.distance, met.normal.to_array()))
        };
        assert_eq!(met([3.0, 0.0, 0.0], [-1.0, 0.0, 0.0]), Some((2.5, [1.0, 0.0, 0.0])));
        assert_eq!(met([0.1, 4.0, 0.1], [0.0, -1.0, 0.0]), Some((3.0, [0.0, 1.0, 0.0])));
        assert_eq!(met([0.1, 0.2, 0.1], [0.0, 0.0, 1.0]), Some((0.0, [0.0; 3])));
        assert_eq!(met([3.0, 2.0, 0.0], [-1.0, 0.0, 0.0]), None);
        assert_eq!(met([0.6, 4.0, 0.0], [0.0, -1.0, 0.0]), None);
        assert_eq!(met([3.0, 0.0, 0.0], [1.0, 0.0, 0.0]), None);
    }
}
