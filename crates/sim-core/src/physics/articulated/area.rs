//! Areas of contact of a track.
//!
//! The engine finds the areas in which a belt is in contact with a shape. Fixed areas on one plane hold the discs of the belt as a plane does,
//! where they lie under them. Elsewhere, as on the edges of a stair, each area gets contacts along the run.

use nalgebra::Vector3;
use scene::{Belt, LOADED, convex_hull};

use super::finding::CandidateContact;
use super::wheel::{LEANING, Plane, SIDE, Touch};

/// Length of an area along the run below which it has one contact, m.
const SHORT: f64 = 1e-3;
/// Limits within which two areas are on one plane: the cosine of their normals, and their distance, m.
const SAME_NORMAL: f64 = 1.0 - 1e-6;
const SAME_HEIGHT: f64 = 1e-4;
/// Most areas of a track, and most planes on which they lie. The deepest are kept.
const MAX_AREAS: usize = 256;
const MAX_PLANES: usize = 32;
/// Height above the plane of an area that counts as none, m.
const NEAR: f64 = 1e-5;

/// Areas of contact, each given by its corners, the deepest first.
pub(super) type Areas<'a> = Vec<&'a [CandidateContact]>;

/// A belt over areas of contact.
pub(super) struct Belted<'a> {
    /// Direction of its axles.
    pub(super) axle: Vector3<f64>,
    /// Width of the belt, m.
    pub(super) width: f64,
    /// Distance within which contacts count, m.
    pub(super) prediction: f64,
    /// Returns the contacts of its lowest run with a plane.
    pub(super) on_plane: &'a dyn Fn(Plane) -> Vec<Touch>,
}

impl Belted<'_> {
    /// Returns the contacts of areas, each given by its corners.
    pub(super) fn contacts(&self, areas: Areas) -> Vec<CandidateContact> {
        planes(areas).iter().flat_map(|areas| self.on_one_plane(areas)).collect()
    }

    /// Returns the contacts of areas on one plane.
    fn on_one_plane(&self, areas: &Areas) -> Vec<CandidateContact> {
        let deepest = areas[0][0].touch;
        let is_near = |touch: &Touch| touch.gap <= self.prediction;
        let Some(run) = Run::new(&deepest, &self.axle) else {
            return areas.iter().copied().flatten().filter(|corner| is_near(&corner.touch)).cloned().collect();
        };
        let stretches = run.stretches(areas, |touch| is_on_plane(&deepest, touch));
        let hold = |touch: Touch| {
            let stretch = stretches.iter().find(|it| it.holds(&run, &touch, self.width))?;
            Some(CandidateContact { touch, ..stretch.base.clone() })
        };
        let discs = (self.on_plane)((run.normal, deepest.place()));
        if stretches.iter().any(|it| it.length() >= SHORT)
            && let Some(held) = discs.into_iter().map(hold).collect()
        {
            return held;
        }
        let stretches = run.stretches(areas, is_near);
        let whole: f64 = stretches.iter().map(Stretch::length).sum();
        let mut contacts = Vec::new();
        for it in &stretches {
            let part = if it.length() < SHORT { 1.0 } else { it.length() / whole };
            let contact = |touch| CandidateContact { touch, ..it.base.clone() };
            contacts.extend(run.spread(&it.outline, part).into_iter().map(contact));
        }
        contacts
    }
}

/// Axes of a run on a plane.
pub(super) struct Run {
    normal: Vector3<f64>,
    along: Vector3<f64>,
    across: Vector3<f64>,
    /// Point of the other shape from which places are measured.
    start: Vector3<f64>,
}

/// A stretch of a run that areas of the same materials hold without a gap.
struct Stretch<'a> {
    /// A corner of it.
    base: &'a CandidateContact,
    /// Corners of its outline: places along the run and across it, and gaps, m.
    outline: Vec<[f64; 3]>,
    /// Places along the run of its ends, m.
    ends: [f64; 2],
}

impl Stretch<'_> {
    fn length(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// True if it holds a contact on the whole width of the belt, m.
    fn holds(&self, run: &Run, touch: &Touch, width: f64) -> bool {
        let [least, most] = self.ends;
        let [place, ..] = run.flat(touch);
        let [left, right] = section(&self.outline, place.clamp(least, most));
        (least - SHORT..=most + SHORT).contains(&place) && right[0] - left[0] > width - 2.0 * SHORT
    }
}

impl Run {
    /// Returns the axes of a run at a contact. `None` if that is at the side of the belt.
    pub(super) fn new(touch: &Touch, axle: &Vector3<f64>) -> Option<Self> {
        let normal = touch.normal;
        let along = normal.cross(axle).try_normalize(1.0 - SIDE)?;
        Some(Self { normal, along, across: along.cross(&normal), start: touch.place() })
    }

    /// Returns the place of a contact along the run and across it, and its gap, m.
    pub(super) fn flat(&self, touch: &Touch) -> [f64; 3] {
        let arm = touch.point - self.start;
        [self.along.dot(&arm), self.across.dot(&arm), touch.gap]
    }

    /// Joins areas that follow each other along the run, or lie side by side. Only the corners that `counts` names are theirs.
    fn stretches<'a>(&self, areas: &Areas<'a>, counts: impl Fn(&Touch) -> bool) -> Vec<Stretch<'a>> {
        let stretch = |area: &&'a [CandidateContact]| {
            let corners = area.iter().filter(|corner| counts(&corner.touch));
            let outline: Vec<[f64; 3]> = corners.map(|corner| self.flat(&corner.touch)).collect();
            Some(Stretch { base: area.first()?, ends: ends(&outline)?, outline })
        };
        let mut areas: Vec<Stretch> = areas.iter().filter_map(stretch).collect();
        areas.sort_by(|one, other| one.ends[0].total_cmp(&other.ends[0]));
        let mut stretches: Vec<Stretch> = Vec::new();
        for area in areas {
            let follows = |it: &&mut Stretch| area.ends[0] <= it.ends[1] + SHORT && it.base.is_alike(area.base);
            match stretches.iter_mut().find(follows) {
                Some(stretch) => {
                    stretch.ends[1] = stretch.ends[1].max(area.ends[1]);
                    stretch.outline.extend(area.outline);
                    stretch.outline = convex_hull(std::mem::take(&mut stretch.outline), 0.0);
                }
                None => stretches.push(area),
            }
        }
        stretches
    }

    /// Returns contacts along an area of contact, which is given by its outline and has a part of the load.
    pub(super) fn spread(&self, outline: &[[f64; 3]], part: f64) -> Vec<Touch> {
        let Some([least, most]) = ends(outline) else { return Vec::new() };
        let alone = [(0.5, Belt::ALONE)];
        let loaded: &[(f64, f64)] = if most - least < SHORT { &alone } else { &LOADED };
        let contact = |&(at, share): &(f64, f64)| {
            let along = least + (most - least) * at;
            let [across, gap] = middle_of(section(outline, along));
            let point = self.start + self.along * along + self.across * across + self.normal * gap;
            Touch { share: share * part, ..Touch::new(self.normal, point, gap) }
        };
        loaded.iter().map(contact).collect()
    }
}

/// Returns the least and the greatest place of corners along the run, m. `None` without corners.
fn ends(outline: &[[f64; 3]]) -> Option<[f64; 2]> {
    let places = outline.iter().map(|corner| [corner[0]; 2]);
    places.reduce(|[least, most], [place, _]| [least.min(place), most.max(place)])
}

/// Groups areas by the planes on which they lie, the deepest first.
fn planes(mut areas: Areas<'_>) -> Vec<Areas<'_>> {
    areas.sort_by(|one, other| one[0].touch.gap.total_cmp(&other[0].touch.gap));
    areas.truncate(MAX_AREAS);
    let mut planes: Vec<Areas> = Vec::new();
    for area in areas {
        if let Some(plane) = planes.iter_mut().find(|plane| is_on_plane(&plane[0][0].touch, &area[0].touch)) {
            plane.push(area);
        } else if planes.len() < MAX_PLANES {
            planes.push(vec![area]);
        }
    }
    drop_lower(planes)
}

/// Drops the areas that do not rise above the plane of others which rise above theirs. A belt on a plane does not reach below it, so these
/// are edges of tiles and triangles beside it.
fn drop_lower(planes: Vec<Areas<'_>>) -> Vec<Areas<'_>> {
    let mut kept: Vec<Areas> = Vec::new();
    for plane in planes {
        if !kept.iter().any(|it| is_lower(&plane, it)) {
            kept.retain(|it| !is_lower(it, &plane));
            kept.push(plane);
        }
    }
    kept
}

fn is_lower(one: &Areas, other: &Areas) -> bool {
    let rises = |areas: &Areas, base: &Areas| {
        let base = base[0][0].touch;
        let height = |touch: &Touch| base.normal.dot(&(touch.place() - base.place()));
        areas.iter().copied().flatten().any(|corner| height(&corner.touch) > NEAR)
    };
    !rises(one, other) && rises(other, one)
}

/// True if two contacts are with one plane.
fn is_on_plane(one: &Touch, other: &Touch) -> bool {
    one.normal.dot(&other.normal) > SAME_NORMAL && one.normal.dot(&(one.place() - other.place())).abs() < SAME_HEIGHT
}

/// Returns the ends of an area's section at a place along the run: places across it, and gaps.
fn section(corners: &[[f64; 3]], place: f64) -> [[f64; 2]; 2] {
    let mut ends: Option<[[f64; 2]; 2]> = None;
    let mut add = |end: [f64; 2]| {
        let [left, right] = ends.get_or_insert([end; 2]);
        if end[0] < left[0] {
            *left = end;
        } else if end[0] > right[0] {
            *right = end;
        }
    };
    for (number, one) in corners.iter().enumerate() {
        for other in &corners[number..] {
            let (from, to) = (place - one[0], other[0] - one[0]);
            let part = if to.abs() < SHORT { 0.0 } else { from / to };
            let is_near = from.abs() < SHORT || (place - other[0]).abs() < SHORT;
            if to.abs() < SHORT && is_near {
                add([one[1], one[2]]);
                add([other[1], other[2]]);
            } else if (0.0..=1.0).contains(&part) && to.abs() >= SHORT {
                add([one[1] + (other[1] - one[1]) * part, one[2] + (other[2] - one[2]) * part]);
            }
        }
    }
    ends.unwrap_or([[0.0; 2]; 2])
}

/// Returns the place of the contact on a section, and its gap: the middle, or nearer to the deeper end as the track leans.
fn middle_of([left, right]: [[f64; 2]; 2]) -> [f64; 2] {
    let width = right[0] - left[0];
    if width < SHORT {
        return if left[1] < right[1] { left } else { right };
    }
    let lean = (right[1] - left[1]) / width;
    let part = 0.5 - (lean / LEANING).clamp(-1.0, 1.0) / 2.0;
    [left[0] + width * part, left[1] + (right[1] - left[1]) * part]
}

#[cfg(test)]
mod tests {
    use super::super::finding::{Counterpart, Key, Peer};
    use super::*;

    /// Returns a corner of an area on the level at a place, with a gap, m.
    fn corner(x: f64, y: f64, gap: f64) -> CandidateContact {
        CandidateContact {
            key: Key { surface: 0, other: (Peer::Fixed, 0), number: 0 },
            counterpart: Counterpart::Fixed,
            touch: Touch::new(Vector3::z(), Vector3::new(x, y, gap), gap),
            start: Vector3::zeros(),
            age: 0.0,
            drift: Vector3::zeros(),
            friction: 1.0,
            restitution: 0.0,
            resistance: 0.0,
            recovery: 1.0,
        }
    }

    #[test]
    fn a_belt_that_touches_at_one_corner_is_held_there() {
        // The lowest disc is beside the area.
        let beside = |_| vec![Touch::new(Vector3::z(), Vector3::new(-0.1, 0.0, 0.0), 0.0)];
        let belt = Belted { axle: Vector3::y(), width: 0.1, prediction: 1e-3, on_plane: &beside };
        let area =
            [corner(0.0, 0.05, 0.0), corner(0.0, -0.05, 0.01), corner(0.3, 0.05, 0.02), corner(0.3, -0.05, 0.03)];
        let contacts = belt.contacts(vec![&area]);
        assert_eq!(contacts.len(), 1);
        assert!((contacts[0].touch.point - Vector3::new(0.0, 0.05, 0.0)).norm() < 1e-9, "{}", contacts[0].touch.point);
    }
}
