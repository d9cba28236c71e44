//! `RES`, UT2004's answer to every SET, and its answer to a question about a missing item (protocol.md 9).

use crate::field::{Field, Format, record};

record! {
    /// Result of a SET.
    Res {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(2)).unit("s").only_ut2004(),
        /// Type of the item, as the client typed it.
        type_name: String = Field::new("Type", Format::Word).only_ut2004(),
        /// Name of the item, as the client typed it; perhaps empty.
        name: String = Field::new("Name", Format::Word).only_ut2004(),
        /// True if the robot has such an item.
        found: bool = Field::new("Status", Format::Either(["Failed", "OK"])).only_ut2004(),
    }
}

record! {
    /// The question of a GETCONF or GETGEO that nothing fits, given back.
    Nothing {
        /// The type, as the client typed it.
        type_name: String = Field::new("Type", Format::Word).only_ut2004(),
        /// The name, if the client typed one.
        name: Option<String> = Field::new("Name", Format::Word).only_ut2004(),
    }
}
