//! Contacts of a plain wheel with a convex shape.
//!
//! The wheel is a cylinder that gives way a little. Flat on a plane, its load is in the middle, and it moves to an edge as the wheel leans.
//! On other shapes the wheel is a row of discs. Each touches the plane that separates it from the shape, and of a fixed shape the part that
//! lies in the disc's own plane. The two edges and the nearest disc count.

use nalgebra::{Matrix2, Vector2, Vector3};

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
/// Most tangents in the search for the disc nearest to a shape that moves.
const TANGENTS: usize = 8;
/// Part of a disc's radius, inward from the rim, that is treated as round.
const RIM: f64 = 0.25;
/// Cosine of a normal with the axle below which the plane of a disc is at right angles to a face.
const LEVEL: f64 = 1e-9;
/// Most planes that cut a disc off a shape.
const MAX_CUTS: usize = 8;
/// Distances from a shape within which a point is on it, m: at which the search ends, and at its end.
const EXACT: f64 = 1e-10;
const TIGHT: f64 = 1e-6;

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
    /// For a corner of an area of contact of a track, the area's number among those with the other shape.
    pub(super) area: Option<usize>,
}

impl Touch {
    /// Returns the contact of a surface that has all its stiffness there.
    pub(super) fn new(normal: Vector3<f64>, point: Vector3<f64>, gap: f64) -> Self {
        Self { normal, point, gap, share: 1.0, roller: None, area: None }
    }

    /// Returns the point on the other body.
    pub(super) fn place(&self) -> Vector3<f64> {
        self.point - self.normal * self.gap
    }
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

/// A plane by its normal and a point.
pub(super) type Plane = (Vector3<f64>, Vector3<f64>);

/// A disc of a wheel beside a shape.
#[derive(Debug, Clone, Copy)]
struct Disc {
    /// Its contact; `None` if its plane does not meet the shape.
    touch: Option<Touch>,
    /// Distance of the plane from the shape where both are nearest to the axle, as far as it was looked for, m.
    distance: f64,
}

/// A half-plane in the plane of a disc, in which the shape lies.
#[derive(Debug, Clone, Copy)]
struct Cut {
    /// Its outward normal.
    flat: Vector2<f64>,
    /// Distance of its border from the axle along the normal, m; negative if it does not hold the axle.
    reach: f64,
    /// The normal in space, and the length of its part in the plane of the disc.
    size: f64,
    normal: Vector3<f64>,
}

impl Disc {
    /// Returns what is least for the nearest disc: the gap, and for one beside the shape more than any gap.
    fn rank(&self) -> f64 {
        self.touch.map_or(1e3 + self.distance, |touch| touch.gap)
    }
}

/// Returns the point within all half-planes that is nearest to the axle, and the normal of the plane that bounds it there. In a corner that
/// is the plane between two cuts. `None` if there is no such point, or if the axle is one.
fn nearest_within(cuts: &[Cut]) -> Option<(Vector2<f64>, Vector3<f64>)> {
    let is_within = |at: &Vector2<f64>| cuts.iter().all(|cut| cut.flat.dot(at) <= cut.reach + EXACT);
    let feet = cuts.iter().filter(|cut| cut.reach < 0.0).map(|cut| (cut.flat * cut.reach, cut));
    if let Some((at, cut)) = feet.clone().find(|(at, _)| is_within(at)) {
        return Some((at, cut.normal));
    }
    let pairs = cuts.iter().enumerate().flat_map(|(index, one)| cuts[..index].iter().map(move |other| (one, other)));
    let corners = pairs.filter_map(|(one, other)| {
        let rows = Matrix2::from_rows(&[one.flat.transpose(), other.flat.transpose()]);
        let at = rows.lu().solve(&Vector2::new(one.reach, other.reach)).filter(is_within)?;
        // Both normals together point from the corner to the axle.
        let parts = rows.transpose().lu().solve(&-at)?;
        let normal = one.normal * (parts.x / one.size) + other.normal * (parts.y / other.size);
        Some((at, normal.try_normalize(LEVEL)?))
    });
    corners.min_by(|(one, _), (other, _)| one.norm_squared().total_cmp(&other.norm_squared()))
}

impl Wheel {
    /// Returns the contact with a plane through a point.
    pub(super) fn on_plane(&self, normal: Vector3<f64>, place: Vector3<f64>) -> Touch {
        self.disc_on_plane(self.place_on(&normal), (normal, place))
    }

    /// Returns the contact of the disc at a place on the axle with a plane.
    fn disc_on_plane(&self, along: f64, (normal, place): Plane) -> Touch {
        let point = self.hub + self.axle * along + self.toward(&normal) * self.radius;
        Touch::new(normal, point, normal.dot(&(point - place)))
    }

    /// Returns the place on the axle at which the wheel touches a plane, m.
    pub(super) fn place_on(&self, normal: &Vector3<f64>) -> f64 {
        (-normal.dot(&self.axle) / LEANING).clamp(-1.0, 1.0) * self.half_width
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
    /// point's distance from the shape, and the normal there. On a shape that moves a disc has the first plane that separates them, though
    /// it may touch the shape beside the disc: exact contacts come and go, and a heap on them would not come to rest.
    pub(super) fn on_shape(
        &self,
        prediction: f64,
        is_fixed: bool,
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
        let [Some(left), Some(right)] = planes else { return nothing };
        if left.0.dot(&right.0) > SAME_NORMAL && left.0.dot(&(right.1 - left.1)).abs() < SAME_HEIGHT {
            let touch = self.on_plane(left.0, left.1);
            return Some([Some(touch).filter(|touch| touch.gap <= prediction), None, None]);
        }
        let disc = |along: f64, plane: Plane| {
            if is_fixed {
                self.disc(along, plane, &nearest)
            } else {
                Disc { touch: Some(self.disc_on_plane(along, plane)), distance: 0.0 }
            }
        };
        let edges = [disc(-self.half_width, left), disc(self.half_width, right)];
        let gap = |edge: &Disc| edge.touch.map_or(f64::INFINITY, |touch| touch.gap);
        let least = edges.iter().map(gap).fold(prediction, f64::min);
        let at = |along: f64| Some(disc(along, self.plane_under(along, normal, &nearest)?));
        let between = if !is_fixed {
            self.nearest_by_slope(&edges, least - SAME_HEIGHT, at)
        } else if self.least_between(&edges) < least - SAME_HEIGHT {
            self.nearest_disc(at)
        } else {
            None
        };
        let between = between.filter(|between| between.gap < least - SAME_HEIGHT);
        let is_near = |touch: &Touch| {
            if is_fixed { self.is_near(touch, prediction) } else { touch.gap <= prediction }
        };
        let [left, right] = edges.map(|edge| edge.touch);
        Some([left, right, between].map(|touch| touch.filter(is_near)))
    }

    /// True if a disc is within a distance, m, of what it touches, measured in its own plane: along a normal that leans to the axle the rim
    /// may be near a plane, and far above the edge that the plane goes through.
    fn is_near(&self, touch: &Touch, prediction: f64) -> bool {
        let lean = touch.normal.dot(&self.axle);
        lean.abs() < SIDE && touch.gap <= prediction * (1.0 - lean * lean).sqrt()
    }

    /// Returns a gap that no disc between the edges is below. The gap is a convex function of the place on the axle, so it lies above its
    /// tangents at both edges. An edge beside the shape has none.
    fn least_between(&self, edges: &[Disc; 2]) -> f64 {
        let width = 2.0 * self.half_width;
        // Gap at an edge, and its slope inward.
        let edge =
            |edge: &Disc, inward: f64| edge.touch.map(|touch| (touch.gap, touch.normal.dot(&self.axle) * inward));
        match (edge(&edges[0], 1.0), edge(&edges[1], -1.0)) {
            (Some((gap, slope)), _) | (_, Some((gap, slope))) if slope >= 0.0 => gap,
            (Some((left, falls)), Some((right, rises))) => {
                let along = (right - left + rises * width) / (falls + rises);
                left + falls * along
            }
            (Some((gap, slope)), None) | (None, Some((gap, slope))) => gap + slope * width,
            // A shape that no disc reaches at the edges is no nearer than their distance less the width.
            (None, None) => edges.iter().map(|edge| edge.distance - width).fold(f64::INFINITY, f64::min),
        }
    }

    /// Returns the contact of the nearest disc between the edges, if its gap is below a value, m. Each disc has a contact here, which tells the
    /// slope of the gap along the axle. The gap is convex, so it lies above its tangents, and where the two nearest to the minimum meet is
    /// the next guess.
    fn nearest_by_slope(&self, edges: &[Disc; 2], below: f64, at: impl Fn(f64) -> Option<Disc>) -> Option<Touch> {
        let line = |along: f64, touch: Touch| (along, touch.gap, touch.normal.dot(&self.axle));
        let mut low = line(-self.half_width, edges[0].touch?);
        let mut high = line(self.half_width, edges[1].touch?);
        let (mut nearest, mut below) = (None, below);
        for _ in 0..TANGENTS {
            let ((from, gap, falls), (to, other, rises)) = (low, high);
            if falls >= 0.0 || rises <= 0.0 {
                break;
            }
            let along = (other - gap + falls * from - rises * to) / (falls - rises);
            if gap + falls * (along - from) >= below {
                break;
            }
            let touch = at(along)?.touch?;
            let tangent @ (_, _, slope) = line(along, touch);
            *(if slope < 0.0 { &mut low } else { &mut high }) = tangent;
            if touch.gap < below {
                (nearest, below) = (Some(touch), touch.gap - SAME_HEIGHT);
            }
        }
        nearest
    }

    /// Returns the contact of the nearest disc. The gap to a convex shape is a convex function of the place on the axle, so a golden
    /// section search finds its minimum.
    fn nearest_disc(&self, at: impl Fn(f64) -> Option<Disc>) -> Option<Touch> {
        const SHARE: f64 = 0.618_033_988_749_895;
        let (mut low, mut high) = (-self.half_width, self.half_width);
        let inner = |low: f64, high: f64| (high - SHARE * (high - low), low + SHARE * (high - low));
        let (one, other) = inner(low, high);
        let (mut left, mut right) = ((one, at(one)?), (other, at(other)?));
        for _ in 0..HALVINGS {
            if left.1.rank() < right.1.rank() {
                (high, right) = (right.0, left);
                let (place, _) = inner(low, high);
                left = (place, at(place)?);
            } else {
                (low, left) = (left.0, right);
                let (_, place) = inner(low, high);
                right = (place, at(place)?);
            }
        }
        if left.1.rank() < right.1.rank() { left.1.touch } else { right.1.touch }
    }

    /// Returns the contact of the disc at a place on the axle, from a plane that separates it from the shape. The plane may touch the shape
    /// beside the disc: then further planes cut it off, until they meet the shape in the plane of the disc.
    fn disc(&self, along: f64, plane: Plane, nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>) -> Disc {
        let (mut normal, mut place) = plane;
        if normal.dot(&self.axle).abs() < LEVEL {
            return Disc { touch: Some(self.disc_on_plane(along, plane)), distance: 0.0 };
        }
        let centre = self.hub + self.axle * along;
        let one = self.toward(&normal);
        let two = self.axle.cross(&one);
        let mut cuts = Vec::with_capacity(MAX_CUTS);
        let (mut distance, mut reached) = (f64::INFINITY, None);
        while cuts.len() < MAX_CUTS && distance > EXACT {
            let flat = Vector2::new(normal.dot(&one), normal.dot(&two));
            let size = flat.norm();
            if size < LEVEL {
                break;
            }
            cuts.push(Cut { flat: flat / size, reach: normal.dot(&(place - centre)) / size, size, normal });
            let Some((at, bound)) = nearest_within(&cuts) else { break };
            let point = centre + one * at.x + two * at.y;
            // A point that is on the surface has no normal.
            (distance, normal) = nearest(point).unwrap_or((0.0, normal));
            place = point - normal * distance;
            reached = Some((bound, point)).filter(|_| distance < TIGHT);
        }
        Disc { touch: reached.map(|plane| self.disc_on_plane(along, plane)), distance }
    }

    /// Returns the plane that separates the disc at a place on the axle from a shape: its normal and a point on it.
    fn plane_under(
        &self,
        along: f64,
        mut normal: Vector3<f64>,
        nearest: impl Fn(Vector3<f64>) -> Option<(f64, Vector3<f64>)>,
    ) -> Option<Plane> {
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
        wheel.on_shape(0.001, true, nearest).into_iter().flatten().flatten().collect()
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

    /// A wheel that rolls on a floor does not overlap a tile of it, wherever the tile lies, and however the wheel is turned.
    #[test]
    fn a_wheel_on_the_ground_overlaps_no_tile_of_it() {
        for (turn, x, y) in
            (-8..=8).flat_map(|turn| (-30..=30).flat_map(move |x| (-20..=20).map(move |y| (turn, x, y))))
        {
            let [x, y] = [x, y].map(|place| f64::from(place) * 0.01);
            let tile = |point: Vector3<f64>| {
                let off = point.xy().map(|at| (at.abs() - 0.1).max(0.0).copysign(at));
                let outside = Vector3::new(off.x, off.y, point.z.max(0.0));
                if outside.norm() > 0.0 {
                    return Some((outside.norm(), outside.normalize()));
                }
                let side = point.xy().map(|at| at.abs() - 0.1);
                let [(depth, normal), second, third] = [
                    (point.z, Vector3::z()),
                    (side.x, Vector3::x() * point.x.signum()),
                    (side.y, Vector3::y() * point.y.signum()),
                ];
                Some(
                    [second, third]
                        .into_iter()
                        .fold((depth, normal), |one, other| if other.0 > one.0 { other } else { one }),
                )
            };
            let (sin, cos) = (f64::from(turn) * 0.2).sin_cos();
            let wheel = Wheel { hub: Vector3::new(x, y, 0.1), axle: Vector3::new(-sin, cos, 0.0), ..WHEEL };
            for touch in touches(wheel, tile) {
                assert!(touch.gap > -1e-4, "turned by {turn}, at {x} {y}: {touch:?}");
            }
        }
    }

    /// A triangle under one edge of a wheel, or under both, holds it there.
    #[test]
    fn a_triangle_under_an_edge_holds_it() {
        use rapier3d::math::Vector;
        use rapier3d::parry::shape::Triangle;
        let corners = [[-0.1, -0.08], [0.13, -0.05], [-0.02, 0.11]];
        let [one, two, three] = corners.map(|[x, y]| Vector::new(x, y, 0.0));
        let triangle = Triangle::new(one, two, three);
        let holds = |at: Vector3<f64>| {
            (0..3).all(|side| {
                let [[x, y], [to_x, to_y]] = [corners[side], corners[(side + 1) % 3]];
                (to_x - x) * (at.y - y) - (to_y - y) * (at.x - x) > 1e-4
            })
        };
        let nearest = |point: Vector3<f64>| {
            let (distance, normal) =
                super::super::super::contact::distance(&triangle, super::super::super::convert::vector(point))?;
            Some((distance, super::super::super::convert::from_vector(normal)))
        };
        let mut held = [0; 3];
        for (turn, x, y) in
            (-8..=8).flat_map(|turn| (-30..=30).flat_map(move |x| (-20..=20).map(move |y| (turn, x, y))))
        {
            let (sin, cos) = (f64::from(turn) * 0.2).sin_cos();
            let wheel = Wheel {
                hub: Vector3::new(f64::from(x) * 0.01, f64::from(y) * 0.01, 0.1 - 3e-7),
                // It leans as a robot does that sinks in by less than a micrometre.
                axle: Vector3::new(-sin, cos, 2e-6).normalize(),
                ..WHEEL
            };
            let edges = [-1.0, 1.0].map(|side| wheel.hub + wheel.axle * (side * wheel.half_width) - Vector3::z() * 0.1);
            let under = edges.map(holds);
            let found = touches(wheel, nearest);
            let is_at = |at: Vector3<f64>| found.iter().any(|it| (it.point - at).norm() < 2e-6 && it.normal.z > 0.999);
            let middle = is_at(wheel.hub - Vector3::z() * 0.1);
            held[under.iter().filter(|it| **it).count()] += 1;
            for (at, under) in edges.into_iter().zip(under) {
                assert!(!under || middle || is_at(at), "turned by {turn}, hub {:?}, {under:?}: {found:?}", wheel.hub);
            }
        }
        assert!(held.iter().all(|count| *count > 100), "{held:?}");
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
