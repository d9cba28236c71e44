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

/// Result of a `SET {Type Viewports}`; UT2004 only (KRobot.uc, Tick).
#[derive(Debug, Clone, PartialEq)]
pub struct ViewportsRes {
    /// Simulated time, s.
    pub time: f32,
    /// True for a single view, false for four. It is that after the SET, as are the cameras.
    pub is_single: bool,
    /// True if the SET's configuration is known.
    pub is_known: bool,
    /// Camera of each viewport and true unless the SET wanted another: the name of the robot's camera, `None`, or `Disabled` for a viewport that
    /// the robot does not have.
    pub cameras: [(String, bool); 4],
}

impl ViewportsRes {
    /// Writes the line: a status follows each part.
    pub(super) fn write(&self) -> String {
        let status = |is_done: bool| if is_done { "OK" } else { "Failed" };
        let config = if self.is_single { "SingleView" } else { "QuadView" };
        let (time, config_status) = (rounded(self.time, 2), status(self.is_known));
        let head = format!("RES {{Time {time}}} {{Type Viewports}} {{Config {config}}} {{Status {config_status}}}");
        let view = |(number, (camera, is_done)): (usize, &(String, bool))| {
            format!(" {{Viewport{} {camera}}} {{Status {}}}", number + 1, status(*is_done))
        };
        std::iter::once(head).chain(self.cameras.iter().enumerate().map(view)).collect()
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
