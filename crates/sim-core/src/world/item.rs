//! Items of robots: actuators, grippers, tool changers, vacuums and sensors, in one list in mounting order, with one set of verbs.
//!
//! To add a kind, write its file here, and add its lines to [`Item`] and [`mount`].

mod actuator;
mod gripper;
mod sensor;
mod tool_changer;
mod vacuum;

use gamebots_proto::Problem;
use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, ItemGeo, MountedGeo};
use nalgebra::Vector3;
use scene::{RobotDef, Sensed};

use super::held::{Attachments, Hand};
use super::seed;
use super::{Options, Report};
use crate::drive::Order;
use crate::kinds::kinds;
use crate::sensor::{SavedState, State, TagOrder, View, floats};

/// Seconds between two reports of actuators and effectors, and between two STA lines (USARVehicle.uc:264).
pub(super) const STATUS_INTERVAL: f64 = 0.1;

/// Effect of a command on the world, beside a change of the item.
pub(super) enum Effect {
    /// No effect.
    None,
    /// A reading goes out at once.
    Sensed(Sensed),
    /// The robot follows an order.
    Order(Order),
    /// A hand takes something, or drops what it has.
    Hand { hand: Hand, closed: bool },
    /// A change of the world's RFID tags.
    Tag(TagOrder),
}

/// An ACT or MISPKG.
pub(super) struct Motion<'a> {
    /// Name of the item that it is for, in any case.
    pub(super) name: &'a str,
    /// Number of an actuator's first joint.
    pub(super) first: usize,
    /// Numbers of joints and their targets, rad or m.
    pub(super) targets: &'a [(usize, f64)],
    /// True if it closes a gripper or tool changer, false if it opens one.
    pub(super) closed: Option<bool>,
}

/// Verbs of an item.
pub(super) trait Verbs {
    /// Returns the type and the name on the wire.
    fn identity(&self) -> (&'static str, &str);
    /// Returns the seconds between two reports.
    fn interval(&self) -> f64 {
        STATUS_INTERVAL
    }
    /// Executes a SET. `None` if items of this type do not take it.
    fn set(&mut self, _set: &Set, _view: &View) -> Option<Effect> {
        None
    }
    /// Executes an ACT or MISPKG. `None` if it does not concern the item.
    fn act(&mut self, _motion: &Motion, _robot: &RobotDef, _problems: &mut Vec<Problem>) -> Option<Effect> {
        None
    }
    /// Returns the configuration.
    fn conf(&self, robot: &RobotDef) -> ItemConf;
    /// Returns the geometry.
    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo>;
    /// Returns the report of this moment. `None` if there is nothing to report.
    fn report(&mut self, view: &View, held: &Attachments) -> Option<Report>;
    /// Returns the part that changes; nothing by default.
    fn state(&mut self) -> State<'_> {
        State::default()
    }
}

kinds! {
    /// An item of a robot.
    #[expect(clippy::large_enum_variant, reason = "most items are sensors, the largest variant")]
    pub(super) enum Item of Verbs {
        Actuator(actuator::Item),
        Gripper(gripper::Item),
        ToolChanger(tool_changer::Item),
        Vacuum(vacuum::Item),
        Sensor(sensor::Item),
    }
}

/// Mounts the items of a robot, in the order in which they report.
pub(super) fn mount(view: &View, options: Options) -> Vec<Item> {
    let RobotDef { actuators, grippers, tool_changers, vacuums, sensors, .. } = view.robot;
    let actuators = actuators.iter().map(|def| Item::Actuator(actuator::Item { def: def.clone() }));
    let grippers = grippers.iter().map(|def| Item::Gripper(gripper::Item { def: def.clone(), closed: false }));
    let changers = tool_changers.iter().enumerate();
    let changers = changers.map(|(number, def)| Item::ToolChanger(tool_changer::Item { number, def: def.clone() }));
    let vacuums = vacuums.iter().enumerate();
    let vacuums = vacuums.map(|(number, def)| Item::Vacuum(vacuum::Item { number, def: def.clone() }));
    let sensors = sensors.iter().enumerate().map(|(number, def)| {
        let rng = seed::stream(options.seed, view.id.0, &def.name, number);
        Item::Sensor(sensor::Item::new(number, def, rng, view))
    });
    actuators.chain(grippers).chain(changers).chain(vacuums).chain(sensors).collect()
}

impl Item {
    /// True if type and name match, in any case. An empty name matches every item of the type.
    pub(super) fn is_asked(&self, type_name: &str, name: &str) -> bool {
        let (own_type, own_name) = self.get().identity();
        own_type.eq_ignore_ascii_case(type_name) && (name.is_empty() || own_name.eq_ignore_ascii_case(name))
    }

    /// True if it measures, so that it may look around.
    pub(super) fn is_sensor(&self) -> bool {
        matches!(self, Self::Sensor(_))
    }

    /// Tells a camera the tile of its picture, by the number of the sensor.
    pub(super) fn set_tile(&mut self, tile: impl Fn(usize) -> Option<usize>) {
        if let Self::Sensor(item) = self {
            item.set_tile(tile);
        }
    }

    /// True if a SET can change it.
    pub(super) fn takes_set(&self) -> bool {
        !matches!(self, Self::Actuator(_))
    }

    /// Returns the actuator in the form before ACT, which has a CONF of its own. `None` for other items.
    pub(super) fn mission_package(&self, robot: &RobotDef) -> Option<ItemConf> {
        if let Self::Actuator(item) = self { Some(item.mission_package(robot)) } else { None }
    }

    /// Returns the state.
    pub(super) fn save(&self) -> SavedState {
        self.clone().get_mut().state().save()
    }

    /// Takes a saved state. Returns false, and changes nothing, if the state is another item's.
    pub(super) fn load(&mut self, saved: &SavedState) -> bool {
        self.get_mut().state().load(saved)
    }
}

/// Returns the pose of an item when every joint is at 0, in the robot frame or relative to the actuator's link that carries it.
fn mounted(robot: &RobotDef, name: &str, link: usize, position: Vector3<f64>, orientation: [f64; 3]) -> MountedGeo {
    let (mount, mount_link, origin) = match robot.actuator_of(link).zip(robot.links.get(link)) {
        Some(((actuator, number), link)) => (&actuator.name, Some(number), link.origin()),
        None => (&robot.class, None, [0.0; 3]),
    };
    MountedGeo {
        name: name.to_owned(),
        location: floats((position - Vector3::from(origin)).into()),
        orientation: floats(orientation),
        mount: mount.clone(),
        mount_link,
        tip: None,
    }
}
