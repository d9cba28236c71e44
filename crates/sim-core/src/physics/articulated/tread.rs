//! Wheels on several faces: triangles of a mesh, or tiles.
//!
//! Each face finds its own contacts, so a wheel whose edges stand on two faces has one at either edge, and a face beside another repeats its
//! contact. Where the faces are nearly one plane, the wheel stands on that plane as it does on a single face: with its load in the middle,
//! and nearer to an edge as it leans.

use rapier3d::math::Vector;

use super::super::convert;
use super::ArticulatedRobot;
use super::finding::CandidateContact;
use super::form::Form;
use super::wheel::Wheel;

/// Cosine of the angle up to which two faces are nearly one plane: 8 degrees.
const NEARLY_SAME: f64 = 0.99;
/// Distance of a contact from an edge of the wheel, or above the common plane, that counts as none, m.
const NEAR: f64 = 1e-6;

impl ArticulatedRobot {
    /// Joins the contacts at the two edges of each wheel.
    pub(super) fn join_treads(&self, found: &mut Vec<CandidateContact>) {
        // Contacts of a surface with one collider lie together, but tiles are colliders of their own.
        for (number, (surface, at)) in self.compiled.surfaces.iter().zip(&self.placed).enumerate() {
            let Form::Wheel { radius, half_width } = surface.form else { continue };
            if found.iter().filter(|it| it.key.surface == number).nth(1).is_none() {
                continue;
            }
            let hub = convert::from_vector(at.pose.translation);
            let axle = convert::from_vector(at.pose.rotation * Vector::Y);
            let wheel = Wheel { hub, axle, radius, half_width };
            join(&wheel, number, found);
        }
    }
}

/// Joins the contacts of a wheel, the surface of a number.
fn join(wheel: &Wheel, surface: usize, found: &mut Vec<CandidateContact>) {
    let along = |it: &CandidateContact| wheel.axle.dot(&(it.touch.point - wheel.hub));
    let is_own = |it: &CandidateContact| it.key.surface == surface;
    let own = || found.iter().filter(|it| is_own(it));
    // A face under both edges has one contact, at the place of its lean.
    let is_whole = |it: &&CandidateContact| {
        (along(it) - wheel.place_on(&it.touch.normal)).abs() < NEAR && along(it).abs() < wheel.half_width - NEAR
    };
    let whole = own().filter(is_whole).min_by(|one, other| one.touch.gap.total_cmp(&other.touch.gap)).cloned();
    let at_edge = |side: f64| own().filter(move |it| (along(it) - side * wheel.half_width).abs() < NEAR);
    let on_both = || {
        let pairs = at_edge(-1.0).flat_map(|left| at_edge(1.0).map(move |right| (left, right)));
        let pairs = pairs.filter(|(left, right)| is_flat(left, right) && left.is_alike(right));
        // Edges of faces nearby lean.
        let flattest = pairs.max_by(|one, other| flatness(one).total_cmp(&flatness(other)))?;
        on_both(wheel, flattest)
    };
    let Some(base) = whole.or_else(on_both) else { return };
    // What does not rise above the plane on which the wheel stands does not hold it: it repeats the contact, or is an edge that the rim comes
    // to. Another material under the other edge does.
    let height = |it: &CandidateContact| base.touch.normal.dot(&(it.touch.place() - base.touch.place()));
    let is_other = |it: &CandidateContact| is_flat(it, &base) && !it.is_alike(&base);
    found.retain(|it| !is_own(it) || height(it) > NEAR || is_other(it));
    found.push(base);
}

/// Returns the cosine of the angle between the normals of two contacts.
fn flatness((one, other): &(&CandidateContact, &CandidateContact)) -> f64 {
    one.touch.normal.dot(&other.touch.normal)
}

/// Returns the contact of a wheel with the plane under the contacts at its edges.
fn on_both(wheel: &Wheel, (left, right): (&CandidateContact, &CandidateContact)) -> Option<CandidateContact> {
    let start = left.touch.place();
    let line = (right.touch.place() - start).try_normalize(NEAR)?;
    let sum = left.touch.normal + right.touch.normal;
    let normal = (sum - line * line.dot(&sum)).try_normalize(0.1)?;
    let mut both = CandidateContact { touch: wheel.on_plane(normal, start), ..left.clone() };
    both.key.number = 0;
    Some(both)
}

/// True if two contacts are on faces that are nearly one plane.
fn is_flat(one: &CandidateContact, other: &CandidateContact) -> bool {
    flatness(&(one, other)) > NEARLY_SAME
}
