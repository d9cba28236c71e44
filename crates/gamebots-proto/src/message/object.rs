//! `STA` of the objects of a world controller, the answer to `CONTROL {Type GetSTA}` (protocol.md 4.8).

use crate::number::fixed;

/// State of an object that a world controller created.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectSta {
    /// Its name.
    pub name: String,
    /// Extents along the world's axes, m.
    pub size: [f32; 3],
    /// Position, m.
    pub location: [f32; 3],
    /// The text that was given when it was created.
    pub memory: String,
    /// Roll, pitch, yaw, rad.
    pub rotation: [f32; 3],
}

/// Longest line with states of objects, bytes without its end. Each of 512 objects, as many as a controller has, fits with texts of 330 bytes.
pub const MAX_OBJECTS_BYTES: usize = 256 * 1024;

/// Returns the number of the first objects whose states fit into one line.
pub fn objects_that_fit(objects: &[ObjectSta]) -> usize {
    let mut left = MAX_OBJECTS_BYTES - VERB.len();
    let fits = |object: &&ObjectSta| {
        let rest = left.checked_sub(write_one(object).len());
        left = rest.unwrap_or_default();
        rest.is_some()
    };
    objects.iter().take_while(fits).count()
}

const VERB: &str = "STA";

/// Writes the states of objects as one line. Two closing braces are missing, and the height is negative, as in the original
/// (WorldController.uc:347-352): clients read it so.
pub(super) fn write(objects: &[ObjectSta]) -> String {
    std::iter::once(VERB.to_owned()).chain(objects.iter().map(write_one)).collect()
}

fn write_one(ObjectSta { name, size: [x, y, z], location, memory, rotation }: &ObjectSta) -> String {
    let numbers = |vector: &[f32; 3]| vector.map(|number| fixed(number, 4)).join(",");
    let (size, location) = (numbers(&[*x, *y, -z]), numbers(location));
    let rotation = numbers(rotation);
    format!(" {{Name {name}}} {{Size {size}}} {{Location {location} {{Memory {{{memory}}} {{Rotation {rotation}}}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_that_fit_into_a_line_do_not_make_it_longer_than_its_limit() {
        let state = |length: usize| ObjectSta {
            name: "n".repeat(length),
            size: [1.0; 3],
            location: [-2.5; 3],
            memory: String::new(),
            rotation: [0.0; 3],
        };
        for (count, length, whole) in [(0, 0, true), (512, 300, true), (512, 600, false), (3, 200_000, false)] {
            let objects = vec![state(length); count];
            let fitting = objects_that_fit(&objects);
            assert_eq!(fitting == count, whole, "{count} of {length}: {fitting}");
            assert!(write(&objects[..fitting]).len() <= MAX_OBJECTS_BYTES);
            if !whole {
                assert!(write(&objects[..=fitting]).len() > MAX_OBJECTS_BYTES);
            }
        }
    }
}
