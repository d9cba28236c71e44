//! The exact roller of a Mecanum wheel, as a shape of the engine.
//!
//! A roller is the envelope of spheres strung on its axis. The sphere at `s` has the radius `lambda(s) = R - sqrt(a² + s² sin² g)`. R is
//! the wheel radius, a the circle of the roller axes and g the roller angle. A wheel of such rollers rolls like a cylinder (Gfrerrer,
//! "Geometry and kinematics of the Mecanum wheel"). `lambda` is concave, so the envelope is convex. Every query is a search along the axis
//! for the minimum of a convex function: closed-form for planes, bisection for all else. The axis is x.

use rapier3d::parry::bounding_volume::{Aabb, BoundingSphere};
use rapier3d::parry::mass_properties::MassProperties;
use rapier3d::parry::math::{Pose, Real, Vector};
use rapier3d::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use rapier3d::parry::shape::{FeatureId, Shape, ShapeType, SupportMap, TypedShape};

use scene::Rollers;

/// Halvings of the axis in a search: they narrow 60 mm to 4 nm, less than the accuracy of any contact.
pub(super) const HALVINGS: u32 = 24;
/// Distance from the surface at which a ray ends, m.
const RAY_TOLERANCE: Real = 1e-5;
/// Most steps of a ray. Each step goes as far as the surface is away, so few are needed.
const MAX_RAY_STEPS: u32 = 128;

/// The shape of a roller, with its axis along x and its middle at the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollerShape {
    wheel_radius: Real,
    axis_circle: Real,
    sin_angle: Real,
    /// Largest distance of a sphere's centre from the middle, along the axis.
    half_axis: Real,
}

/// Returns the length of a vector in a plane. `f64::hypot` has other bits on other platforms.
fn length(x: Real, y: Real) -> Real {
    (x * x + y * y).sqrt()
}

impl RollerShape {
    /// Builds the roller of a wheel.
    pub(super) fn new(rollers: &Rollers, wheel_radius: f64) -> Self {
        let sin = libm::sin(rollers.angle.abs());
        Self {
            wheel_radius,
            axis_circle: rollers.axis_circle,
            sin_angle: sin,
            half_axis: (rollers.axis_circle * libm::tan(rollers.last_phase) / sin),
        }
    }

    /// Returns the places of the outermost spheres.
    pub(super) fn axis_ends(&self) -> (Real, Real) {
        (-self.half_axis, self.half_axis)
    }

    /// Returns the radius of the sphere at a place on the axis.
    pub(super) fn radius_at(&self, along: Real) -> Real {
        self.wheel_radius - self.axis_distance(along)
    }

    /// Returns the distance from the middle of the wheel's circle of axes to a place on the axis, m.
    fn axis_distance(&self, along: Real) -> Real {
        length(self.axis_circle, along * self.sin_angle)
    }

    /// Returns the decrease of the radius along the axis: `-d lambda / d s`.
    pub(super) fn taper_at(&self, along: Real) -> Real {
        along * self.sin_angle * self.sin_angle / self.axis_distance(along)
    }

    /// Returns the place on the axis whose sphere reaches farthest in a direction with this cosine to the axis.
    pub(super) fn farthest_along(&self, cosine: Real) -> Real {
        let rest = self.sin_angle * self.sin_angle - cosine * cosine;
        if rest <= 1e-9 {
            return self.half_axis.copysign(cosine);
        }
        let along = self.axis_circle * cosine / (self.sin_angle * rest.sqrt());
        along.clamp(-self.half_axis, self.half_axis)
    }

    /// Returns the place on the axis where an increasing function passes zero, or the end next to it.
    fn search(&self, mut grows: impl FnMut(Real) -> Real) -> Real {
        let (mut low, mut high) = (-self.half_axis, self.half_axis);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if grows(middle) > 0.0 {
                high = middle;
            } else {
                low = middle;
            }
        }
        (low + high) / 2.0
    }

    /// Returns the distance of a point from the surface, negative inside, and the outward direction there.
    fn signed_distance(&self, point: Vector) -> (Real, Vector) {
        let radial = length(point.y, point.z);
        let toward = |along: Real| (along - point.x) / length(radial, point.x - along).max(1e-9);
        let along = self.search(|along| toward(along) + self.taper_at(along));
        let offset = point - Vector::X * along;
        let direction = offset.try_normalize().unwrap_or(Vector::Z);
        (offset.length() - self.radius_at(along), direction)
    }

    fn half_extents(&self, axis: Vector) -> Vector {
        // By symmetry the box is centred. Each half extent is the support in a direction of the box.
        let reach = |cosine: Real| {
            let along = self.farthest_along(cosine);
            along * cosine + self.radius_at(along)
        };
        Vector::new(reach(axis.x), reach(axis.y), reach(axis.z))
    }
}

impl SupportMap for RollerShape {
    fn local_support_point(&self, direction: Vector) -> Vector {
        let direction = direction.try_normalize().unwrap_or(Vector::Z);
        let along = self.farthest_along(direction.x);
        Vector::X * along + direction * self.radius_at(along)
    }
}

impl PointQuery for RollerShape {
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        let (distance, direction) = self.signed_distance(point);
        let inside = distance <= 0.0;
        let projection = if inside && solid { point } else { point - direction * distance };
        PointProjection::new(inside, projection)
    }

    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        (self.project_local_point(point, false), FeatureId::Face(0))
    }
}

impl RayCast for RollerShape {
    /// Casts a ray by sphere tracing: each step is the distance from the surface.
    fn cast_local_ray_and_get_normal(&self, ray: &Ray, max_toi: Real, solid: bool) -> Option<RayIntersection> {
        let speed = ray.dir.length();
        let starts_inside = self.signed_distance(ray.origin).0 < 0.0;
        if starts_inside && solid {
            return Some(RayIntersection::new(0.0, Vector::ZERO, FeatureId::Face(0)));
        }
        let mut toi = 0.0;
        for _ in 0..MAX_RAY_STEPS {
            let (distance, direction) = self.signed_distance(ray.point_at(toi));
            let left = if starts_inside { -distance } else { distance };
            if left < RAY_TOLERANCE {
                return Some(RayIntersection::new(toi, direction, FeatureId::Face(0)));
            }
            toi += left / speed;
            if toi.is_nan() || toi > max_toi {
                return None;
            }
        }
        None
    }
}

impl Shape for RollerShape {
    fn compute_local_aabb(&self) -> Aabb {
        Aabb::from_half_extents(Vector::ZERO, self.half_extents(Vector::X))
    }

    fn compute_aabb(&self, position: &Pose) -> Aabb {
        Aabb::from_half_extents(position.translation, self.half_extents(position.rotation * Vector::X))
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        BoundingSphere::new(Vector::ZERO, self.half_extents(Vector::X).x)
    }

    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(*self)
    }

    fn scale_dyn(&self, _scale: Vector, _num_subdivisions: u32) -> Option<Box<dyn Shape>> {
        None
    }

    /// Returns no mass: the caller sets a roller's mass from its definition.
    fn mass_properties(&self, _density: Real) -> MassProperties {
        MassProperties::default()
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        self.radius_at(self.half_axis)
    }

    fn ccd_angular_thickness(&self) -> Real {
        std::f64::consts::PI
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use scene::Material;

    fn youbot() -> RollerShape {
        let angle = std::f64::consts::FRAC_PI_4;
        let material = Material::default();
        let rollers = Rollers {
            count: 6,
            axis_circle: 0.036,
            angle,
            first_roller: 0.0,
            last_phase: PI / 6.0,
            mass: 0.1,
            damping: 0.0,
            bearing_friction: 0.0,
            material,
        };
        RollerShape::new(&rollers, 0.05)
    }

    /// A wheel of six rollers stands equally high at every angle: its outline is a circle of the wheel's radius.
    #[test]
    fn a_ring_of_rollers_is_round() {
        let roller = youbot();
        for degrees in -30..=30 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            // The roller turned by this phase from the bottom (z down); its axis leans 45 degrees toward the axle (y).
            let centre = Vector::new(sin, 0.0, cos) * 0.036;
            let axis = (Vector::new(cos, 0.0, -sin) + Vector::Y) * std::f64::consts::FRAC_1_SQRT_2;
            let along = roller.farthest_along(axis.z);
            let lowest = centre.z + along * axis.z + roller.radius_at(along);
            assert!((lowest - 0.05).abs() < 1e-6, "{degrees} degrees: {lowest}");
        }
    }

    #[test]
    fn points_rays_and_supports_agree() {
        let roller = youbot();
        for direction in [Vector::X, Vector::Y, Vector::new(0.3, 0.5, -0.8), Vector::new(-0.7, 0.1, 0.2)] {
            let direction = direction.normalize();
            let support = roller.local_support_point(direction);
            let outside = support + direction * 0.1;
            let projection = roller.project_local_point(outside, true);
            assert!(
                !projection.is_inside && (projection.point - support).length() < 1e-4,
                "{direction}: {projection:?}"
            );
            let hit = roller.cast_local_ray(&Ray::new(outside, -direction), 1.0, true).expect("a hit");
            assert!((hit - 0.1).abs() < 1e-4, "{direction}: {hit}");
        }
        assert!(roller.project_local_point(Vector::ZERO, true).is_inside);
        assert!(roller.cast_local_ray(&Ray::new(Vector::Y, Vector::X), 10.0, true).is_none());
    }
}
