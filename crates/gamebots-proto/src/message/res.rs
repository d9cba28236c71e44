//! `RES`, UT2004's answer to every SET, and its answer to a question about a missing item (protocol.md 9).

use crate::field::{Field, Format, record};
use crate::number::rounded;

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

/// Result of a `SET {Type Viewports}`; UT2004 only.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewportsRes {
    /// Simulated time, s.
    pub time: f32,
    /// Key and value of `Config` and of each viewport, as the client typed them.
    pub views: Vec<(String, String)>,
    /// True if the robot's cameras have the viewports now. They have all or none.
    pub found: bool,
}

impl ViewportsRes {
    /// Writes the line: a status follows each block.
    pub(super) fn write(&self) -> String {
        let status = if self.found { "OK" } else { "Failed" };
        let view = |(key, value): &(String, String)| format!(" {{{key} {value}}} {{Status {status}}}");
        let views: String = self.views.iter().map(view).collect();
        format!("RES {{Time {}}} {{Type Viewports}}{views}", rounded(self.time, 2))
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
