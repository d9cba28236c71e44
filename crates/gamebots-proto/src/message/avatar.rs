//! `STA` and `BSTA` of an avatar (protocol.md 4.9; USARAvatarNewCommon.uc:120-181).

use crate::field::{Field, Format, record};

record! {
    /// State of an avatar.
    AvatarSta {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(4)).unit("s"),
        /// Its class.
        class: String = Field::new("Type", Format::Word),
        /// Its name.
        name: String = Field::new("Name", Format::Word),
        /// Position of its middle.
        location: [f32; 3] = Field::new("Location", Format::Rounded(2)).unit("m"),
        /// Roll, pitch, yaw.
        orientation: [f32; 3] = Field::new("Orientation", Format::Rounded(2)).unit("rad"),
        /// True while it walks.
        walking: bool = Field::new("Walking", Format::Boolean),
    }
}

record! {
    /// Arms of an avatar.
    AvatarBones {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(4)).unit("s"),
        /// Its name.
        name: String = Field::new("Name", Format::Word),
        ;
        /// Upper arm and forearm, right and left.
        bones: [AvatarBone]
    }
}

record! {
    /// A bone of an avatar.
    AvatarBone {
        /// Name of the bone.
        bone: String = Field::new("Bone", Format::Word),
        /// Roll, pitch, yaw from hanging down.
        rotation: [f32; 3] = Field::new("Rotation", Format::Rounded(2)).unit("rad"),
    }
}
