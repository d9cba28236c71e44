//! Driven wheels: those of `[[wheel]]`, and the sprockets of `[[track]]`.

use std::ops::Range;

use scene::{Link, Steering};

use super::joint::Links;
use super::track::read_tracks;
use super::wheel::{RollersEntry, WheelEntry, read_wheel, wrong_wheel};
use crate::document::{Document, Table};
use crate::materials::Materials;
use crate::problem::Unread;

/// Reads the driven wheels; fails unless all of them could be read.
pub(super) fn read_wheels<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &mut Links,
    steering: Option<Steering>,
    materials: &Materials,
) -> Result<Vec<Link>, Unread> {
    let common = document.section::<WheelEntry>(root, "wheels");
    let rollers = document.section::<RollersEntry>(root, "rollers");
    if !root.has("wheel") && !root.has("track") && steering.is_none_or(Steering::is_on_wheels) {
        document.problem(&(0..0), "no [[wheel]] or [[track]]: expected at least one driven wheel or track");
    }
    let noted = document.problems().count();
    let entries = document.list::<WheelEntry>(root, "wheel");
    let (Ok(common), Ok(rollers)) = (common, rollers) else { return Err(Unread) };
    let (place, common) = common.unwrap_or_default();
    let wheel = |(span, entry): (Range<usize>, WheelEntry)| {
        let wheel = read_wheel(document, &span, entry, &common, rollers.as_ref(), links, materials)?;
        Some((span, wheel))
    };
    let count = entries.len();
    let mut wheels: Vec<(Range<usize>, Link)> = entries.into_iter().filter_map(wheel).collect();
    wheels.extend(read_tracks(document, root, links, materials));
    for (span, link) in &wheels {
        document.wrong(span, wrong_wheel(link));
    }
    if !place.is_empty() {
        // A problem of every wheel is one of [wheels].
        let shared = document.problems().take_shared(noted, count);
        document.wrong(&place, shared);
    }
    let wheels = wheels.into_iter().map(|(_, wheel)| wheel).collect();
    if document.problems().count() == noted { Ok(wheels) } else { Err(Unread) }
}
