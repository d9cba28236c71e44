//! `RES`, with which UT2004 answers every SET, and its answer to a question about an item that is not there (protocol.md 9).

use crate::field::{Field, Format, record};

record! {
    /// What became of a SET.
    Res {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(2)).unit("s"),
        /// Type of the item, as the client typed it.
        type_name: String = Field::new("Type", Format::Word),
        /// Name of the item, if the client typed one.
        name: Option<String> = Field::new("Name", Format::Word),
        /// Whether the robot has such an item.
        found: bool = Field::new("Status", Format::Either(["Failed", "OK"])),
    }
}

record! {
    /// The question of a GETCONF or GETGEO that nothing fits, given back.
    Nothing {
        /// The type, as the client typed it.
        type_name: String = Field::new("Type", Format::Word),
        /// The name, if the client typed one.
        name: Option<String> = Field::new("Name", Format::Word),
    }
}
