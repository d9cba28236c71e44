//! The client's commands to the server, one file each. Reading and writing a command stand side by side.

mod act;
mod control;
mod drive;
mod get;
mod init;
mod multi_drive;
mod report;
mod set;
mod walk;

pub use act::{Act, MisPkg};
pub use control::{Control, Create, Move, Pull, SetPath};
pub use drive::{Drive, Given};
pub use get::{GetClasses, GetClosestPathNode, GetConf, GetGeo, GetPathNodes, GetStartPoses};
pub use init::Init;
pub use multi_drive::MultiDrive;
pub use report::Report;
pub use set::Set;
pub use walk::{Gait, GoTo, Target, Walk};

use crate::{Block, Line, Problem, shown};

/// A command that can be read from a line and written to one.
pub trait ReadWrite: Sized {
    /// Keys of its blocks. `DRIVE` has those of every kind of robot, and `CONTROL` those of every order.
    const KEYS: &'static [&'static str] = &[];
    /// Reads the blocks. A missing value takes its default; each mistake is noted in `problems`.
    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self;
    /// Writes the command as a client would.
    fn write(&self) -> Line;
}

macro_rules! commands {
    ($($(#[doc = $about:literal])* $verb:literal => $name:ident,)*) => {
        /// Every command that this server acts on.
        #[derive(Debug, Clone, PartialEq)]
        pub enum Command { $($(#[doc = $about])* $name($name),)* }

        impl Command {
            /// The verbs in upper case, in the order of the list.
            pub const VERBS: &'static [&'static str] = &[$($verb),*];

            /// The meaning of each verb, in the same order.
            pub const ABOUT: &'static [&'static str] = &[$(concat!($($about,)*)),*];

            /// The keys of each verb, in the same order.
            pub const KEYS: &'static [&'static [&'static str]] = &[$($name::KEYS),*];

            /// Reads a line as it was sent, see [`Command::read`].
            pub fn parse(text: &str, problems: &mut Vec<Problem>) -> Option<Self> {
                Self::read(&Line::parse(text), problems)
            }

            /// Reads a line. For an unknown verb, returns `None` and notes a [`Problem::UnknownVerb`].
            pub fn read(line: &Line, problems: &mut Vec<Problem>) -> Option<Self> {
                if line.truncated {
                    problems.push(Problem::TooManyBlocks { limit: crate::MAX_BLOCKS });
                }
                let verb = Self::VERBS.iter().any(|verb| line.verb.eq_ignore_ascii_case(verb));
                if verb {
                    note_text_out_of_place(line, problems);
                }
                $(if line.verb.eq_ignore_ascii_case($verb) {
                    return Some(Self::$name($name::read(line, problems)));
                })*
                problems.push(Problem::unknown_verb(&line.verb, Self::VERBS));
                None
            }

            /// Returns its verb in upper case.
            pub fn verb(&self) -> &'static str {
                match self { $(Self::$name(_) => $verb,)* }
            }

            /// Writes the command as a line, without its end.
            pub fn write(&self) -> Line {
                match self { $(Self::$name(command) => command.write(),)* }
            }
        }
    };
}

commands! {
    /// Puts a robot into the world.
    "INIT" => Init,
    /// Sets the speeds of the robot.
    "DRIVE" => Drive,
    /// Sets the targets of joints.
    "MULTIDRIVE" => MultiDrive,
    /// Moves an actuator.
    "ACT" => Act,
    /// Moves an actuator, in the form before ACT.
    "MISPKG" => MisPkg,
    /// Changes a sensor.
    "SET" => Set,
    /// Asks for the configuration of the robot or of its parts.
    "GETCONF" => GetConf,
    /// Asks for the geometry of the robot or of its parts.
    "GETGEO" => GetGeo,
    /// Asks for the start poses of the map.
    "GETSTARTPOSES" => GetStartPoses,
    /// Asks for the path nodes of the map.
    "GETPATHNODES" => GetPathNodes,
    /// Asks for the path node nearest to a place.
    "GETCLOSESTPATHNODE" => GetClosestPathNode,
    /// Creates, moves and removes objects; for world controllers.
    "CONTROL" => Control,
    /// Lets an avatar walk; for avatars.
    "MOVE" => Walk,
    /// Sends an avatar to a path node; for avatars.
    "GOTO" => GoTo,
    /// Asks for reports of the problems with this connection's lines. Not part of USARSim.
    "REPORT" => Report,
    /// Asks for the robot classes that INIT takes. Not part of USARSim.
    "GETCLASSES" => GetClasses,
}

/// Most problems of one kind that are reported of a line.
pub(crate) const MAX_REPORTED: usize = 5;

/// Reports text that is in no block, and blocks that are not closed.
fn note_text_out_of_place(line: &Line, problems: &mut Vec<Problem>) {
    let nested = |block: &&Block| block.key.contains('{') || block.value.contains('{');
    if let Some(Block { key, value }) = line.blocks.iter().find(nested) {
        problems.push(Problem::Nested { got: shown(format!("{key} {value}").trim()) });
    }
    if let Some(got) = line.unclosed.clone() {
        problems.push(Problem::Unclosed { got });
    }
    if let Some(text) = &line.stray {
        problems.push(Problem::Ignored { what: format!("`{text}`"), why: "it is not in braces".to_owned() });
    }
}

/// Reports keys that a command does not have, and blocks after the first with the same key.
fn note_keys(verb: &'static str, line: &Line, known: &[&str], problems: &mut Vec<Problem>) {
    let (mut seen, mut wrong): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    let mut again = 0;
    for Block { key, value } in line.blocks.iter().filter(|block| !block.key.is_empty()) {
        let own = known.iter().find(|known| known.eq_ignore_ascii_case(key));
        match own {
            None if !wrong.contains(&key.as_str()) => {
                wrong.push(key);
                problems.push(Problem::unknown_key(verb, key, known));
            }
            Some(own) if seen.contains(own) => {
                again += 1;
                let what = format!("{{{key} {}}}", shown(value));
                problems.push(Problem::Ignored { what, why: format!("the first {own} of a line counts") });
            }
            Some(own) => seen.push(own),
            None => {}
        }
        if wrong.len() + again >= MAX_REPORTED {
            break;
        }
    }
}

/// Adds a block unless the text is empty: on the wire, an empty block and a missing one are the same.
fn with_text(line: Line, key: &str, text: &str) -> Line {
    if text.is_empty() { line } else { line.with(key, text) }
}

fn with_vector(line: Line, key: &str, [x, y, z]: [f64; 3]) -> Line {
    line.with(key, format_args!("{x},{y},{z}"))
}

/// Returns a copy of a block's text; empty if the block is missing.
fn text(line: &Line, key: &str) -> String {
    line.get(key).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command;
    use proptest::prelude::*;

    /// Golden lines: a client's line, and the command written back.
    #[test]
    fn golden_lines() {
        for (sent, written) in [
            (
                "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}",
                "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}",
            ),
            (
                "init {Classname USARBot.P3AT} {Name R} {Location 1,0000, 2,0000, 0,4000} {Rotation 0 0 1.5}",
                "INIT {ClassName USARBot.P3AT} {Name R} {Location 1,2,0.4} {Rotation 0,0,1.5}",
            ),
            ("INIT {ClassName P3AT} {team red} {Start A}", "INIT {ClassName P3AT} {Start A} {Team red}"),
            ("Drive {Left 3.000000} {Right 3,00}", "DRIVE {Left 3.000000} {Right 3,00}"),
            (
                "DRIVE {Front-Left 1,00}{Front-Right 1,00}{Back-Left 1,00}{Back-Right 1,00}",
                "DRIVE {Front-Left 1,00} {Front-Right 1,00} {Back-Left 1,00} {Back-Right 1,00}",
            ),
            ("DRIVE {Light} {Left 1}{Right 1} {Light true}", "DRIVE {Left 1} {Right 1}"),
            ("DRIVE {Light True} {Normalized false}", "DRIVE {Normalized false} {Light true}"),
            (
                "DRIVE {WheelNumber 0} {WheelSpeed 1} {WheelSteer 0} {WheelNumber 3} {WheelSpeed -2}",
                "DRIVE {WheelNumber 0} {WheelSpeed 1} {WheelSteer 0} {WheelNumber 3} {WheelSpeed -2}",
            ),
            ("MultiDrive {FLFlipper 0,5} {RLFlipper  -1.57}{Light}", "MULTIDRIVE {FLFlipper 0.5} {RLFlipper -1.57}"),
            (
                "ACT {Name Arm} {Link 0} {Value 0,5} {Link 3} {Value -1} {Gripper 1}",
                "ACT {Name Arm} {Link 0} {Value 0.5} {Link 3} {Value -1} {Gripper 1}",
            ),
            (
                "MISPKG {Name Arm} {Link 1} {Value 0.1} {Order 0} {Link 2} {Value 1} {Order 1} {Link 3} {Value 2}",
                "MISPKG {Name Arm} {Link 1} {Value 0.1} {Order 0} {Link 3} {Value 2} {Order 0}",
            ),
            (
                "SET {Type INS} {Name InsTest} {Opcode POSE} {Params 1,2,3,0,0,1} ",
                "SET {Type INS} {Name InsTest} {Opcode POSE} {Params 1,2,3,0,0,1}",
            ),
            (
                "SET {Type Viewports} {Config SingleView} {Viewport1 Cam} {Viewport2 }",
                "SET {Type Viewports} {Config SingleView} {Viewport1 Cam}",
            ),
            (
                "SET {Type Camera} {Robot R1} {Name Camera} {Client 10.0.0.1}",
                "SET {Type Camera} {Name Camera} {Robot R1} {Client 10.0.0.1}",
            ),
            ("GETCONF {Type Robot}", "GETCONF {Type Robot}"),
            ("GETGEO {Type Sonar} {Name F1}", "GETGEO {Type Sonar} {Name F1}"),
            ("getstartposes {x y}", "GETSTARTPOSES"),
            ("GETPATHNODES", "GETPATHNODES"),
            ("GETCLOSESTPATHNODE {Location 1 2 3}", "GETCLOSESTPATHNODE {Location 1,2,3}"),
            ("GetClasses", "GETCLASSES"),
            (
                "CONTROL {Type Create} {ClassName WCCrate} {Name c1} {Memory m} {Location 1,2,-1} {Physics RigidBody}",
                "CONTROL {Type Create} {Name c1} {ClassName WCCrate} {Memory m} {Location 1,2,-1} {Rotation 0,0,0} \
                 {Scale 1,1,1} {Physics RigidBody} {Permanent false}",
            ),
            (
                "CONTROL {Type Create}{ClassName WCCrate}{Name foo}{Scale 0, 0, 0}{Physics None}{Permanent True}",
                "CONTROL {Type Create} {Name foo} {ClassName WCCrate} {Location 0,0,0} {Rotation 0,0,0} {Scale 1,1,1} \
                 {Permanent true}",
            ),
            (
                "CONTROL {Type AbsMove} {Name c1} {Location 1 2 3}",
                "CONTROL {Type AbsMove} {Name c1} {Location 1,2,3} {Rotation 0,0,0}",
            ),
            ("CONTROL {Type Rotate} {Name c1} {Speed 0,0,1}", "CONTROL {Type Rotate} {Name c1} {Speed 0,0,1}"),
            ("CONTROL {Type AddWP} {Name c} {WP 1,2,3;4,5,6;}", "CONTROL {Type AddWP} {Name c} {WP 1,2,3;4,5,6}"),
            (
                "CONTROL {Type SetWP} {Name c} {Speed 0.5} {Loop TRUE} {Moving true} {ResetOnClear false} {Time 2}",
                "CONTROL {Type SetWP} {Name c} {Speed 0.5} {Loop true} {Moving true} {ResetOnClear false} {Time 2}",
            ),
            ("CONTROL {Type ClearWP} {Name c}", "CONTROL {Type ClearWP} {Name c}"),
            ("CONTROL {Type Conveyor} {Name belt} {Speed 2}", "CONTROL {Type Conveyor} {Name belt} {Speed 2}"),
            ("CONTROL {Type Kill} {Name c}", "CONTROL {Type Kill} {Name c}"),
            ("CONTROL {Type KillAll} {MinPos 0,0,5} {MaxPos 0,0,5}", "CONTROL {Type KillAll}"),
            (
                "CONTROL {Type KillAll} {MinPos 0,0,5} {MaxPos 5,5,-5}",
                "CONTROL {Type KillAll} {MinPos 0,0,5} {MaxPos 5,5,-5}",
            ),
            ("CONTROL {Type GetSTA}", "CONTROL {Type GetSTA}"),
            (
                "MOVE {Action New} {Location 3.00, 4.00} {Type Walk_Forward}",
                "MOVE {Type Walk_Forward} {Action New} {Location 3,4}",
            ),
            ("MOVE {Type run}{Action Append}{Location 1,2,3}", "MOVE {Type Run} {Action Append} {Location 1,2}"),
            (
                "MOVE {Action New} {Pathnode n1} {Type Walk_Backward}",
                "MOVE {Type Walk_Backward} {Action New} {Pathnode n1}",
            ),
            ("MOVE {Action pause}", "MOVE {Action Pause}"),
            ("MOVE {Action Resume}", "MOVE {Action Resume}"),
            ("GOTO {Name PathNode_1}", "GOTO {Name PathNode_1}"),
            ("REPORT {Errors True}", "REPORT {Errors true}"),
            ("report", "REPORT {Errors false}"),
        ] {
            let mut problems = Vec::new();
            let command = Command::read(&Line::parse(sent), &mut problems).unwrap();
            assert_eq!(command.write().to_string(), written, "{sent}");
            assert_eq!(problems, [], "{sent}");
        }
    }

    #[test]
    fn every_verb_has_a_golden_line_and_unknown_ones_are_named() {
        for verb in Command::VERBS {
            assert!(Command::read(&Line::new(verb), &mut Vec::new()).is_some(), "{verb}");
        }
        let mut problems = Vec::new();
        assert_eq!(Command::read(&Line::parse("FOO {a b}"), &mut problems), None);
        assert!(problems[0].to_string().starts_with("unknown verb `FOO`; expected one of INIT, DRIVE"));
        assert_eq!(Command::read(&Line::parse("DRVE {Left 1}"), &mut problems), None);
        assert!(problems[1].to_string().starts_with("unknown verb `DRVE` (did you mean `DRIVE`?); expected"));
    }

    /// Returns the problems of a line.
    fn said(line: &str) -> Vec<String> {
        let mut problems = Vec::new();
        Command::read(&Line::parse(line), &mut problems);
        problems.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_a_line_says_in_vain_is_reported() {
        for (line, expected) in [
            ("DRIVE {Left 2", "`{Left 2`: the brace is not closed; the block is ignored"),
            ("DRIVE {Left 2} {Right 2", "`{Right 2`: the brace is not closed; the block is ignored"),
            (
                "DRIVE {Left 2 {Right 2}",
                "`{Left 2 {Right 2}`: a brace is not closed before the next one; all of it is one block",
            ),
            ("DRIVE {Left 2} Right 2", "`Right 2` is ignored: it is not in braces"),
            (
                "DRIVE Left 2 Right 2",
                "unknown verb `DRIVE Left 2 Right 2` (after `DRIVE` come blocks in braces, as in `{Key value}`); expected one of INIT",
            ),
            (
                "ACT {Name Arm} {link 1} {Value 2}",
                "ACT has no key `link` (did you mean `Link`?); expected Name, Link, ",
            ),
            ("MISPKG {Name n} {Rotation 0,1,2}", "MISPKG has no key `Rotation`; expected Name, Link, "),
            ("SET {Type INS} {Opcod RESET}", "SET has no key `Opcod` (did you mean `Opcode`?); expected Type, "),
            ("SET {Type Camera} {Opcode Zoom} {0.5}", "SET has no key `0.5`; expected Type, "),
            ("GETCONF {Typ INS}", "GETCONF has no key `Typ` (did you mean `Type`?); expected Type, Name; "),
            ("GETGEO {Type=INS}", "GETGEO has no key `Type=INS` (did you mean `{Type INS}`?); expected Type, Name; "),
            ("GETGEO {Type INS} {type Sonar}", "{type Sonar} is ignored: the first Type of a line counts"),
            ("GETCLOSESTPATHNODE", "GETCLOSESTPATHNODE needs Location"),
            ("REPORT {Error true}", "REPORT has no key `Error` (did you mean `Errors`?); expected Errors; "),
            ("MOVE {Action Pause} {Speed 2}", "MOVE has no key `Speed`; expected Type, Action, "),
            ("GOTO {Node a}", "GOTO has no key `Node`; expected Name; "),
            (
                "CONTROL {Type SetWP} {Name c} {Spped 1}",
                "CONTROL has no key `Spped` (did you mean `Speed`?); expected Type, Name, Speed, Loop, Moving, ",
            ),
            (
                "CONTROL {Type Create} {Name c} {Physics rigidbody}",
                "{Physics rigidbody} is unknown (did you mean `RigidBody`?); expected one of RigidBody, Falling, Ground, None; the object stays where it is put",
            ),
            (
                "CONTROL {Type KillAll} {MinPos 0,0,0}",
                "{MinPos 0,0,0} is ignored: without MaxPos all objects are meant",
            ),
            ("INIT {ClassName P3AT} {Location 1,2}", "{Location 1,2}: expected three numbers x,y,z; read as 1,0,2"),
            (
                "INIT {ClassName P3AT} {Start A} {Location 1,2,3}",
                "{Location 1,2,3} is ignored: {Start A} says where the robot is put",
            ),
            ("INIT {ClassName P3AT} {Name A} {Name B}", "{Name B} is ignored: the first Name of a line counts"),
            (
                "INIT {ClassName P3AT} {Name My Robot {x}}",
                "`{Name My Robot {x}`: a brace is not closed before the next one; all of it is one block",
            ),
        ] {
            let said = said(line);
            assert_eq!(said.len(), 1, "{line}: {said:?}");
            assert!(said[0].starts_with(expected), "{line}: {said:?}");
        }
        let points = vec!["1,2,3"; 300].join(";");
        let said = said(&format!("CONTROL {{Type AddWP}} {{Name c}} {{WP {points}}}"));
        assert_eq!(said, ["the end of {WP ..} is ignored: got 300 points, expected at most 256 a line"]);
    }

    #[test]
    fn a_line_of_wrong_keys_is_reported_in_a_few_problems() {
        let keys: String = (0..4000).map(|number| format!("{{Key{number} 1}}")).collect();
        assert_eq!(said(&format!("GETCONF {keys}")).len(), MAX_REPORTED);
        assert_eq!(said(&format!("GETCONF {}", "{Type a}".repeat(4000))).len(), MAX_REPORTED);
        assert_eq!(said(&format!("GETCONF {}", "{Typ a}".repeat(4000))).len(), 1);
    }

    #[test]
    fn a_wrong_key_of_init_is_named_with_the_right_one() {
        let said = said("INIT {ClasName USARBot.P3AT} {Start A} {Teapot}");
        assert_eq!(
            said,
            [
                "INIT has no key `ClasName` (did you mean `ClassName`?); expected ClassName, Name, Location, Rotation, \
                 Start, Team; the block is ignored",
                "INIT has no key `Teapot`; expected ClassName, Name, Location, Rotation, Start, \
                 Team; the block is ignored"
            ]
        );
    }

    fn number() -> impl Strategy<Value = f64> {
        -1e6f64..1e6
    }

    /// A word that survives the wire: no braces, no white space.
    fn word() -> impl Strategy<Value = String> {
        "[A-Za-z0-9_.-]{0,12}"
    }

    fn targets() -> impl Strategy<Value = Vec<(usize, f64)>> {
        proptest::collection::vec((0usize..8, number()), 0..5)
    }

    fn any_command() -> impl Strategy<Value = Command> {
        let vector = || [number(), number(), number()];
        prop_oneof![
            (word(), word(), word(), word(), [vector(), vector()]).prop_map(|(class_name, name, team, start, pose)| {
                // `Start` replaces the pose, and is written instead.
                let pose = if start.is_empty() { pose.map(Into::into) } else { [[0.0; 3]; 2] };
                let [location, rotation] = pose;
                Command::Init(Init { class_name, name, start, location, rotation, team })
            }),
            (
                proptest::collection::vec(("[A-Z][A-Za-z-]{0,12}", number()), 0..6),
                (proptest::option::of(any::<bool>()), proptest::option::of(any::<bool>())),
            )
                .prop_filter("a flag", |(numbers, _)| numbers
                    .iter()
                    .all(|(key, _)| key != "Light" && key != "Normalized" && key != "Flip"))
                .prop_map(|(numbers, (normalized, light))| {
                    let drive = Drive { normalized, light, ..Drive::default() };
                    Command::Drive(numbers.iter().fold(drive, |drive, (key, number)| drive.with(key, *number)))
                }),
            proptest::collection::vec(("[A-Z][A-Za-z-]{0,12}", number()), 0..6)
                .prop_map(|targets| Command::MultiDrive(MultiDrive { targets })),
            (word(), targets(), proptest::option::of(number()))
                .prop_map(|(name, targets, gripper)| Command::Act(Act { name, targets, gripper })),
            (word(), targets(), proptest::option::of(number()))
                .prop_map(|(name, targets, gripper)| Command::MisPkg(MisPkg { name, targets, gripper })),
            (word(), word(), word(), word()).prop_map(|(type_name, name, opcode, params)| {
                Command::Set(Set { type_name, name, opcode, params, more: Vec::new() })
            }),
            (word(), word()).prop_map(|(type_name, name)| Command::GetConf(GetConf { type_name, name })),
            (word(), word()).prop_map(|(type_name, name)| Command::GetGeo(GetGeo { type_name, name })),
            Just(Command::GetStartPoses(GetStartPoses)),
            Just(Command::GetPathNodes(GetPathNodes)),
            Just(Command::GetClasses(GetClasses)),
            vector().prop_map(|place| Command::GetClosestPathNode(GetClosestPathNode { location: Some(place) })),
            (word(), vector(), any::<bool>()).prop_map(|(name, location, is_relative)| {
                let rotation = location.map(|number| number / 1e6);
                Command::Control(Control::Move(command::Move { name, is_relative, location, rotation }))
            }),
            (word(), [vector(), vector()], any::<bool>()).prop_map(|(name, [grip, location], is_held)| {
                let location = is_held.then_some(location);
                Command::Control(Control::Pull(command::Pull { name, grip, location, rotation: location }))
            }),
            ([number(), number()], any::<bool>(), word()).prop_map(|(place, appends, node)| {
                let target = if node.is_empty() { Target::Place(place) } else { Target::Node(node) };
                Command::Walk(Walk::To { gait: Gait::Run, appends, target })
            }),
            word().prop_map(|name| Command::GoTo(GoTo { name })),
            any::<bool>().prop_map(|errors| Command::Report(Report { errors })),
        ]
    }

    proptest! {
        #[test]
        fn reading_gives_back_what_was_written(command in any_command()) {
            let text = command.write().to_string();
            let mut problems = Vec::new();
            prop_assert_eq!(Command::read(&Line::parse(&text), &mut problems), Some(command));
            prop_assert_eq!(problems, []);
        }

        #[test]
        fn any_text_is_read_without_a_panic(text in ".*", verb in 0..Command::VERBS.len()) {
            Command::read(&Line::parse(&text), &mut Vec::new());
            Command::read(&Line::parse(&format!("{} {{{text}}} {{Left {text}}}", Command::VERBS[verb])), &mut Vec::new());
        }
    }
}
