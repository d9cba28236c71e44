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

/// Writes the states of objects as one line. Two closing braces are missing, and the height is negative, as in the original
/// (WorldController.uc:347-352): clients read it so.
pub(super) fn write(objects: &[ObjectSta]) -> String {
    let numbers = |vector: &[f32; 3]| vector.map(|number| fixed(number, 4)).join(",");
    let object = |ObjectSta { name, size: [x, y, z], location, memory, rotation }: &ObjectSta| {
        let (size, location) = (numbers(&[*x, *y, -z]), numbers(location));
        let rotation = numbers(rotation);
        format!(" {{Name {name}}} {{Size {size}}} {{Location {location} {{Memory {{{memory}}} {{Rotation {rotation}}}")
    };
    std::iter::once("STA".to_owned()).chain(objects.iter().map(object)).collect()
}
