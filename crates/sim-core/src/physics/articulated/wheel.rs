//! Where a plain wheel touches a convex shape.
//!
//! The wheel is a cylinder that gives way a little: flat on a plane its load is in the middle, and moves to an edge as the wheel leans.
//! On anything else it is a row of discs, each of which touches the plane that holds it off the shape: its edges count, and the nearest.

use nalgebra::Vector3;

/// Sine of the angle at which a wheel leans on its edge alone: a tyre is round there.
const LEANING: f64 = 0.1;
/// A surface whose normal leans toward the axle by more than this cosine meets the side of the wheel.
pub(super) const SIDE: f64 = 0.7;
/// Cosine above which two normals are of one plane, and distance of two planes that are one, m.
const SAME_NORMAL: f64 = 1.0 - 1e-9;
const SAME_HEIGHT: f64 = 1e-7;
/// Rounds in which the point of a disc nearest to a shape is found.
const ROUNDS: usize = 4;
/// Steps in which the nearest disc of a wheel is found: a width of 0.1 m is a tenth of a millimetre then.
const HALVINGS: usize = 15;
/// The part of a disc's radius from its rim inward that is taken for round there.
const RIM: f64 = 0.25;

/// A touch, in whatever frame it was asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// From the other to the wheel.
    pub(super) normal: Vector3<f64>,
    /// On the wheel.
    pub(super) point: Vector3<f64>,
    /// Gap; negative where they overlap, m.
    pub(super) gap: f64,
    /// The roller that touches.
    pub(super) roller: Option<RollerTouch>,
}

/// How a roller touches.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollerTouch {
    /// Which of the wheel's.
    pub(super) index: usize,
    /// Its axis.
    pub(super) axis: Vector3<f64>,
    /// Distance of the point from the axis along the normal, m.
    pub(super) radius: f64,
}

/// A wheel in the frame of what it may touch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel {
    pub(super) hub: Vector3<f64>,
    /// Unit vector.
    pub(super) axle: Vector3<f64>,
    pub(super) radius: f64,
    pub(super) half_width: f64,
}

impl Wheel {
    /// The touch with a plane through a place.
    pub(super) fn on_plane(&self, normal: Vector3<f64>, place: Vector3<f64>) -> Touch {
        let lean = normal.dot(&self.axle);
        let along = (-lean / LEANING).clamp(-1.0, 1.0) * self.half_width;
        let point = self.hub + self.axle * along + self.toward(&normal) * self.radius;
        Touch { normal, point, gap: normal.dot(&(point - place)), roller: None }
    }

    /// From the axle to where the rim is nearest to a plane.
    fn toward(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let across = normal - self.axle * normal.dot(&self.axle);
        across.try_normalize(1e-9).map_or_else(Vector3::zeros, |across| -across)
    }

    /// How far any of it is from its hub.
    pub(super) fn reach(&self) -> f64 {
        self.radius.hypot(self.half_width)
    }

    /// The touches of its tread with a shape within a distance, m, `None` where it meets it with its side; `nearest` is the distance of a point from it, and the normal there.
    pub(super) fn on_shape(
        &self,
        prediction: f64,
        nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>,
    ) -> Option<[Option<Touch>; 3]> {
        let nothing = Some([None; 3]);
        let Some((distance, normal)) = nearest(self.hub) else { return nothing };
        if distance > self.reach() + prediction {
            return nothing;
        }
        if normal.dot(&self.axle).abs() > SIDE {
            return None;
        }
        let planes = [-1.0, 1.0].map(|side| self.plane_under(side * self.half_width, normal, &nearest));
        let [Some((left, left_place)), Some((right, right_place))] = planes else { return nothing };
        if left.dot(&right) > SAME_NORMAL && left.dot(&(right_place - left_place)).abs() < SAME_HEIGHT {
            let touch = self.on_plane(left, left_place);
            return Some([Some(touch).filter(|touch| touch.gap <= prediction), None, None]);
        }
        let touch = |along: f64, normal: Vector3<f64>, place: Vector3<f64>| {
            let point = self.hub + self.axle * along + self.toward(&normal) * self.radius;
            Touch { normal, point, gap: normal.dot(&(point - place)), roller: None }
        };
        let edges = [touch(-self.half_width, left, left_place), touch(self.half_width, right, right_place)];
        let least = edges.iter().map(|edge| edge.gap).fold(prediction, f64::min);
        let at =
            |along: f64| self.plane_under(along, normal, &nearest).map(|(normal, place)| touch(along, normal, place));
        let between = self.nearest_disc(at).filter(|between| between.gap < least - SAME_HEIGHT);
        let edges = edges.map(|edge| Some(edge).filter(|edge| edge.gap <= prediction));
        Some([edges[0], edges[1], between])
    }

    /// The touch of the disc that is nearest. The gap of a convex shape is a convex function of the place on the axle, so the ends of
    /// a part of the axle close in on it (golden section).
    fn nearest_disc(&self, at: impl Fn(f64) -> Option<Touch>) -> Option<Touch> {
        const SHARE: f64 = 0.618_033_988_749_895;
        let (mut low, mut high) = (-self.half_width, self.half_width);
        let inner = |low: f64, high: f64| (high - SHARE * (high - low), low + SHARE * (high - low));
        let (one, other) = inner(low, high);
        let (mut left, mut right) = ((one, at(one)?), (other, at(other)?));
        for _ in 0..HALVINGS {
            if left.1.gap < right.1.gap {
                (high, right) = (right.0, left);
                let (place, _) = inner(low, high);
                left = (place, at(place)?);
            } else {
                (low, left) = (left.0, right);
                let (_, place) = inner(low, high);
                right = (place, at(place)?);
            }
        }
        Some(if left.1.gap < right.1.gap { left.1 } else { right.1 })
    }

    /// The plane that holds the disc at a place on the axle off a shape: its normal and a point of it.
    fn plane_under(
        &self,
        along: f64,
        mut normal: Vector3<f64>,
        nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let centre = self.hub + self.axle * along;
        let mut place = None;
        for _ in 0..ROUNDS {
            let inner = centre + self.toward(&normal) * (self.radius * (1.0 - RIM));
            let (distance, found) = nearest(inner)?;
            place = Some(inner - found * distance);
            let is_same = found.dot(&normal) > SAME_NORMAL;
            normal = found;
            if is_same {
                break;
            }
        }
        place.map(|place| (normal, place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEEL: Wheel =
        Wheel { hub: Vector3::new(0.0, 0.0, 0.1), axle: Vector3::new(0.0, 1.0, 0.0), radius: 0.1, half_width: 0.03 };

    fn touches(wheel: Wheel, nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>) -> Vec<Touch> {
        wheel.on_shape(0.001, nearest).into_iter().flatten().flatten().collect()
    }

    /// Up is z; a box with a corner at an edge line x = edge, below z = 0.
    fn step_at(edge: f64) -> impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        move |point| {
            let off = Vector3::new((point.x - edge).max(0.0), 0.0, point.z.max(0.0));
            let inside = (point.x - edge).max(point.z);
            if inside <= 0.0 {
                let normal = if point.z > point.x - edge { Vector3::z() } else { Vector3::x() };
                return Some((inside, normal));
            }
            Some((off.norm(), off.normalize()))
        }
    }

    #[test]
    fn flat_on_a_plane_the_load_is_in_the_middle() {
        let found = touches(WHEEL, |point| Some((point.z, Vector3::z())));
        assert_eq!(found.len(), 1);
        assert!(found[0].gap.abs() < 1e-12 && found[0].point.norm() < 1e-12, "{found:?}");
    }

    #[test]
    fn a_wheel_that_leans_stands_on_its_lower_edge() {
        let (sin, cos) = 0.2_f64.sin_cos();
        let leaning = Wheel { axle: Vector3::new(0.0, cos, sin), ..WHEEL };
        let found = touches(leaning, |point| Some((point.z, Vector3::z())));
        assert!((found[0].point.y + 0.03 * cos - 0.1 * sin).abs() < 1e-9, "{found:?}");
        assert!((found[0].gap - (0.1 - 0.1 * cos - 0.03 * sin)).abs() < 1e-9, "{found:?}");
    }

    /// Beyond the edge of a step it is the edge that holds the wheel, on the line from there to the hub.
    #[test]
    fn a_wheel_rolls_over_an_edge() {
        let (back, height) = (0.06, 0.08);
        let wheel = Wheel { hub: Vector3::new(back, 0.0, height), ..WHEEL };
        let found = touches(wheel, step_at(0.0));
        let expected = Vector3::new(back, 0.0, height) / 0.1;
        assert!(
            found.iter().all(|touch| (touch.normal - expected).norm() < 1e-6 && touch.gap.abs() < 1e-9),
            "{found:?}"
        );
        assert!(!found.is_empty());
    }

    /// A rail under a part of its width holds it there.
    #[test]
    fn a_wheel_stands_on_a_rail_between_its_edges() {
        // A cylinder along x.
        let (radius, aside) = (0.004, 0.011);
        let rail = |point: Vector3<f64>| {
            let away = Vector3::new(0.0, point.y - aside, point.z + radius);
            Some((away.norm() - radius, away.normalize()))
        };
        let found = touches(WHEEL, rail);
        assert!(found.iter().any(|touch| touch.gap.abs() < 1e-5 && (touch.point.y - aside).abs() < 1e-3), "{found:?}");
    }

    /// Half on a kerb it stands on the edge that is above it.
    #[test]
    fn half_on_a_kerb_it_stands_on_one_edge() {
        let kerb = step_at(0.01);
        let turned = move |point: Vector3<f64>| {
            let (distance, normal) = kerb(Vector3::new(point.y, point.x, point.z))?;
            Some((distance, Vector3::new(normal.y, normal.x, normal.z)))
        };
        let found = touches(WHEEL, turned);
        assert!(found.iter().any(|touch| touch.gap.abs() < 1e-9 && touch.point.y < -0.02), "{found:?}");
        assert!(found.iter().all(|touch| touch.point.y < 0.011 || touch.gap > 1e-4), "{found:?}");
    }
}
