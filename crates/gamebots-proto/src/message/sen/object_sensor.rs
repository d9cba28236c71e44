//! `{Name n}` and per object ` {Object tag}{Location x,y,z}{Orientation r,p,y}{HitLoc x,y,z}{Material m}` (ObjectSensor.uc:88-155).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// An object in view.
    SeenObject {
        /// Name of the object.
        object: String = Field::new("Object", Format::Word),
        /// Its position in the world.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m").tight(),
        /// Its roll, pitch, yaw in the world.
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad").tight(),
        /// The point where the first beam hits it, in the world.
        hit: [f32; 3] = Field::new("HitLoc", Format::Rounded(2)).unit("m").tight(),
        /// Its material.
        material: String = Field::new("Material", Format::Word).tight(),
    }
}

record! {
    /// Objects in view, from the right to the left.
    ObjectSensor {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        ;
        /// The objects, each once.
        objects: [SeenObject]
    }
}

impl Body for ObjectSensor {
    const TYPE: &'static str = "ObjectSensor";
    const TIME: [Format; 2] = [Format::Absent, Format::Absent];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
