//! `ASTA` and `EFF`: state of an actuator and of an effector (protocol.md 4.6). `ASTA` was `MISSTA` in UT2004.

use crate::field::{Field, Format, record};

record! {
    /// Positions of the joints of an actuator.
    Asta {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(4)).unit("s").ut2004(Format::Rounded(2)),
        /// Name of the actuator.
        name: String = Field::new("Name", Format::Word),
        ;
        /// Its joints in order.
        joints: [JointSta]
    }
}

record! {
    /// Position of a joint of an actuator.
    JointSta {
        /// Its number from 1.
        link: usize = Field::new("Link", Format::Integer),
        /// Its angle or displacement.
        value: f32 = Field::new("Value", Format::Rounded(4)).unit("rad or m").ut2004(Format::Fixed(4)),
        /// The torque that holds it, by USARSim its limit with a minus (5 to 1 N m); 0 where it was not on the line.
        torque: f32 = Field::new("Torque", Format::Rounded(2)).unit("N m / 5").only_ut2004(),
    }
}

record! {
    /// State of a gripper or a tool changer.
    Eff {
        /// Simulated time.
        time: f32 = Field::new("Time", Format::Rounded(4)).unit("s"),
        /// Type of the effector.
        is_tool_changer: bool = Field::new("Type", Format::Either(["Gripper", "ToolChanger"])),
        /// Name of the effector.
        name: String = Field::new("Name", Format::Word),
        /// For a gripper, as it was commanded; for a tool changer, whether it holds a tool.
        closed: bool = Field::new("Status", Format::Either(["OPEN", "CLOSED"])),
        /// Type of the tool that a tool changer holds.
        tool_type: Option<String> = Field::new("ToolType", Format::Word).tight(),
        /// Name of that tool.
        tool: Option<String> = Field::new("Tool", Format::Word),
    }
}
