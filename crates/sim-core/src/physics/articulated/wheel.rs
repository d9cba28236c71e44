//! Contacts of a plain wheel with a convex shape.
//!
//! The wheel is a cylinder that gives way a little. Flat on a plane, its load is in the middle, and it moves to an edge as the wheel leans.
//! On other shapes the wheel is a row of discs. Each touches the plane that separates it from the shape. The two edges and the nearest disc
//! count.

use nalgebra::{Vector2, Vector3};

/// Sine of the lean at which a wheel stands on its edge alone. A tyre is round there.
pub(super) const LEANING: f64 = 0.1;
/// Cosine of the normal with the axle above which a surface meets the side of the wheel.
pub(super) const SIDE: f64 = 0.7;
/// Limits within which two planes are one: the cosine of their normals, and their distance, m.
const SAME_NORMAL: f64 = 1.0 - 1e-9;
const SAME_HEIGHT: f64 = 1e-7;
/// Iterations of the search for the point of a disc nearest to a shape.
const ROUNDS: usize = 4;
/// Iterations of the search for the nearest disc. They narrow a width of 0.1 m to a tenth of a millimetre.
const HALVINGS: usize = 15;
/// Part of a disc's radius, inward from the rim, that is treated as round.
const RIM: f64 = 0.25;

/// A contact, in the frame of the query.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    /// Normal, from the other body to the wheel.
    pub(super) normal: Vector3<f64>,
    /// Point on the wheel.
    pub(super) point: Vector3<f64>,
    /// Gap; negative where they overlap, m.
    pub(super) gap: f64,
    /// Share of the stiffness that it has of its surface's contacts with this normal.
    pub(super) share: f64,
    /// The roller in contact, if any.
    pub(super) roller: Option<RollerTouch>,
}

/// Contact of a roller.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollerTouch {
    /// Number of the roller in its wheel.
    pub(super) index: usize,
    /// Axis of the roller.
    pub(super) axis: Vector3<f64>,
    /// Distance of the point from the axis along the normal, m.
    pub(super) radius: f64,
}

/// A wheel in the frame of the other shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel {
    pub(super) hub: Vector3<f64>,
    /// Unit vector.
    pub(super) axle: Vector3<f64>,
    pub(super) radius: f64,
    pub(super) half_width: f64,
}

impl Wheel {
    /// Returns the contact with a plane through a point.
    pub(super) fn on_plane(&self, normal: Vector3<f64>, place: Vector3<f64>) -> Touch {
        let lean = normal.dot(&self.axle);
        let along = (-lean / LEANING).clamp(-1.0, 1.0) * self.half_width;
        let point = self.hub + self.axle * along + self.toward(&normal) * self.radius;
        Touch { normal, point, gap: normal.dot(&(point - place)), share: 1.0, roller: None }
    }

    /// Returns the unit vector from the axle to the rim's nearest point to a plane.
    fn toward(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let across = normal - self.axle * normal.dot(&self.axle);
        across.try_normalize(1e-9).map_or_else(Vector3::zeros, |across| -across)
    }

    /// Returns the largest distance of the wheel's points from its hub.
    pub(super) fn reach(&self) -> f64 {
        Vector2::new(self.radius, self.half_width).norm()
    }

    /// Returns the contacts of the tread with a shape within a distance, m, or `None` if the side of the wheel faces it. `nearest` gives a
    /// point's distance from the shape, and the normal there.
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
            Touch { normal, point, gap: normal.dot(&(point - place)), share: 1.0, roller: None }
        };
        let edges = [touch(-self.half_width, left, left_place), touch(self.half_width, right, right_place)];
        let least = edges.iter().map(|edge| edge.gap).fold(prediction, f64::min);
        let at =
            |along: f64| self.plane_under(along, normal, &nearest).map(|(normal, place)| touch(along, normal, place));
        let between = self.nearest_disc(at).filter(|between| between.gap < least - SAME_HEIGHT);
        let edges = edges.map(|edge| Some(edge).filter(|edge| edge.gap <= prediction));
        Some([edges[0], edges[1], between])
    }

    /// Returns the contact of the nearest disc. The gap to a convex shape is a convex function of the place on the axle, so a golden
    /// section search finds its minimum.
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

    /// Returns the plane that separates the disc at a place on the axle from a shape: its normal and a point on it.
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

    /// Signed distance to a step: a box with its edge on the line x = `edge`, z = 0. Up is z.
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

    /// Beyond a step's edge, the edge holds the wheel. The normal points from there to the hub.
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

    /// A rail under a part of the width holds the wheel there.
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

    /// A wheel half on a kerb stands on the edge above the kerb.
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
