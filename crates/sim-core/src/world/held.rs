//! Objects that are part of a robot's link: the tools that its tool changers hold, and what sticks to its vacuums.
//!
//! An object keeps its id meanwhile. The robot's class is compiled again with it. A gripper holds by friction: what it grips stays an object
//! of the world.

use std::sync::Arc;

use scene::{BodyState, Object, ObjectId, ObjectSnapshot, PawnId, Pose, RobotDef, check};
use serde::{Deserialize, Serialize};

use super::World;
use crate::physics::{CompiledRobot, Held, Lifted, Physics};

/// An item that takes and drops objects, by its number among its kind in the robot's class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hand {
    /// A tool changer.
    Changer(usize),
    /// A vacuum.
    Vacuum(usize),
}

/// An object that a robot's item holds, or a tool that it has dropped.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Attachment {
    pub(super) id: ObjectId,
    /// Robot that holds it, or held it last.
    pub(super) robot: PawnId,
    /// Item that holds it; `None` for a tool that lies about.
    pub(super) hand: Option<Hand>,
    /// Name, shape and mass. The pose of the shape is in the frame of the tool changer; at a vacuum, in the robot frame when every joint is
    /// at 0.
    pub(super) object: Arc<Object>,
    pub(super) origin: Origin,
}

/// Origin of an attached object.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Origin {
    /// It came as a tool, with this type on the wire.
    Tool(String),
    /// It was an object of the world.
    World(Lifted),
}

impl Attachment {
    /// Returns the type on the wire, if it is a tool.
    pub(super) fn kind(&self) -> Option<&str> {
        if let Origin::Tool(kind) = &self.origin { Some(kind) } else { None }
    }

    /// Returns the name.
    pub(super) fn name(&self) -> &str {
        &self.object.solid.name
    }

    /// Returns the definition of the object by itself.
    fn def(&self) -> &Arc<Object> {
        match &self.origin {
            Origin::Tool(_) => &self.object,
            Origin::World(lifted) => &lifted.def,
        }
    }

    /// Returns the link that it is part of, and the pose of the frame that the pose of its shape is in, when every joint is at 0; `None` if
    /// nothing holds it.
    fn mount(&self, robot: &RobotDef) -> Option<(usize, Pose)> {
        match self.hand? {
            Hand::Changer(number) => robot.tool_changers.get(number).map(|it| (it.link, it.pose())),
            Hand::Vacuum(number) => robot.vacuums.get(number).map(|it| (it.link, Pose::identity())),
        }
    }

    /// True if it is an object that a world can have: one of the map, or with an id below `next`.
    fn is_sound(&self, of_map: u64, next: u64) -> bool {
        let fits = match (&self.origin, self.hand) {
            (Origin::Tool(_), Some(Hand::Changer(_)) | None) => true,
            (Origin::World(lifted), Some(Hand::Vacuum(_))) => lifted.is_of_map == (self.id.0 < of_map),
            (Origin::Tool(_), Some(Hand::Vacuum(_))) | (Origin::World(_), Some(Hand::Changer(_)) | None) => false,
        };
        let is_good = |object: &Arc<Object>| check::spawned_object(object).is_empty();
        fits && self.id.0 < next && is_good(&self.object) && is_good(self.def())
    }
}

/// All that robots hold, and the tools that they have dropped.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "Stored", into = "Stored")]
pub(super) struct Attachments(Vec<Attachment>);

impl Attachments {
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Attachment> {
        self.0.iter()
    }

    /// Returns what an item of a robot holds.
    pub(super) fn of(&self, robot: PawnId, hand: Hand) -> Option<&Attachment> {
        self.0.iter().find(|it| it.robot == robot && it.hand == Some(hand))
    }

    pub(super) fn get_mut(&mut self, id: ObjectId) -> Option<&mut Attachment> {
        self.0.iter_mut().find(|it| it.id == id)
    }

    pub(super) fn add(&mut self, attachment: Attachment) {
        self.0.push(attachment);
    }

    /// Adds all of others.
    pub(super) fn append(&mut self, others: Self) {
        self.0.extend(others.0);
    }

    /// Removes and returns an object.
    pub(super) fn take(&mut self, id: ObjectId) -> Option<Attachment> {
        let place = self.0.iter().position(|it| it.id == id)?;
        Some(self.0.remove(place))
    }

    /// Removes and returns all objects for which a condition holds.
    pub(super) fn take_where(&mut self, is_meant: impl Fn(&Attachment) -> bool) -> Vec<Attachment> {
        self.0.extract_if(.., |it| is_meant(it)).collect()
    }

    /// Returns the numbers of a world's digest: object, robot and item of all that is held, tool changers before vacuums.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u64> {
        self.in_order()
            .filter_map(|it| {
                let (Hand::Changer(number) | Hand::Vacuum(number)) = it.hand?;
                Some([it.id.0, it.robot.0, number as u64])
            })
            .flatten()
    }

    /// Returns an object that no world has, if there is one: its id has to be of the map or below `next`.
    pub(super) fn unsound(&self, of_map: u64, next: u64) -> Option<ObjectId> {
        self.0.iter().find(|it| !it.is_sound(of_map, next)).map(|it| it.id)
    }

    /// Returns all that tool changers hold, then all that vacuums hold: the order in which they are put on a robot.
    fn in_order(&self) -> impl Iterator<Item = &Attachment> {
        let of_changers = self.0.iter().filter(|it| matches!(it.hand, Some(Hand::Changer(_))));
        of_changers.chain(self.0.iter().filter(|it| matches!(it.hand, Some(Hand::Vacuum(_)))))
    }

    /// Returns a class with all that a robot holds. Fails with the reason in words.
    pub(super) fn fitted(
        &self,
        physics: &mut Physics,
        class: &Arc<CompiledRobot>,
        robot: PawnId,
    ) -> Result<Arc<CompiledRobot>, String> {
        let held = self.in_order().filter(|it| it.robot == robot).filter_map(|it| {
            let (link, mount) = it.mount(&class.def)?;
            Some(Held { link, at: mount * it.object.solid.pose(), object: &it.object })
        });
        physics.fitted(class, held)
    }
}

impl World {
    /// Gives a robot the class with all that it holds now.
    pub(super) fn refit(&mut self, id: PawnId) -> Result<(), String> {
        let name = self.robots.get(&id).map(|robot| robot.def().class.clone()).ok_or("the robot is gone")?;
        let class = self.compiled(&name).ok_or("its class is gone")?;
        let fitted = self.attached.fitted(&mut self.physics, &class, id)?;
        let robot = self.robots.get_mut(&id).ok_or("the robot is gone")?;
        let is_refitted = self.physics.refit(robot.bodies_mut(), id, fitted);
        is_refitted.then_some(()).ok_or("the drive model `bodies` cannot change tools".to_owned())
    }

    /// Returns the robot frame as it moves with a link.
    pub(super) fn carrier(&self, robot: PawnId, link: usize) -> Option<BodyState> {
        let bodies = self.robots.get(&robot)?.bodies();
        Some(self.physics.carrier(bodies, link).unwrap_or_else(|| self.physics.body(bodies)))
    }

    /// Returns the carrier of an object that a robot holds, and the pose of the object.
    pub(super) fn carried(&self, attachment: &Attachment) -> Option<(BodyState, Pose)> {
        let (link, mount) = attachment.mount(self.robot(attachment.robot)?)?;
        let carrier = self.carrier(attachment.robot, link)?;
        let pose = carrier.pose * mount * attachment.object.solid.pose();
        Some((carrier, pose))
    }

    /// Gives an object that comes off a link at a pose the velocity of the link.
    pub(super) fn leave_link(&mut self, id: ObjectId, carrier: &BodyState, pose: &Pose) {
        let lever = pose.translation.vector - carrier.pose.translation.vector;
        self.physics.push_off(id, &(carrier.linear + carrier.angular.cross(&lever)), &carrier.angular);
    }

    /// Returns snapshots of the objects that robots hold.
    pub(super) fn attached_objects(&self) -> impl Iterator<Item = ObjectSnapshot> {
        self.attached.iter().filter_map(|it| {
            let (_, pose) = self.carried(it)?;
            Some(ObjectSnapshot { id: it.id, def: it.def().clone(), pose })
        })
    }

    /// Returns the pose of an object, be it held by a robot.
    pub(super) fn place_of(&self, id: ObjectId) -> Option<Pose> {
        let held = || self.carried(self.attached.iter().find(|it| it.id == id)?).map(|(_, pose)| pose);
        self.physics.object(id).or_else(held)
    }

    /// Removes an object from the world, be it held by a robot.
    pub(super) fn remove_object(&mut self, id: ObjectId) {
        self.physics.remove_object(id);
        if let Some(held) = self.attached.take(id) {
            _ = self.refit(held.robot);
        }
    }
}

/// Attachments in the file of a saved world: tools, and what sticks to vacuums.
#[derive(Serialize, Deserialize)]
struct Stored {
    #[serde(default)]
    tools: Vec<StoredTool>,
    #[serde(default)]
    stuck: Vec<StoredStuck>,
}

#[derive(Serialize, Deserialize)]
struct StoredTool {
    id: ObjectId,
    robot: PawnId,
    changer: Option<usize>,
    kind: String,
    object: Arc<Object>,
}

#[derive(Serialize, Deserialize)]
struct StoredStuck {
    id: ObjectId,
    robot: PawnId,
    vacuum: usize,
    lifted: Lifted,
    fixed: Arc<Object>,
}

impl From<Stored> for Attachments {
    fn from(Stored { tools, stuck }: Stored) -> Self {
        let tools = tools.into_iter().map(|StoredTool { id, robot, changer, kind, object }| {
            let hand = changer.map(Hand::Changer);
            Attachment { id, robot, hand, object, origin: Origin::Tool(kind) }
        });
        let stuck = stuck.into_iter().map(|StoredStuck { id, robot, vacuum, lifted, fixed }| {
            let (hand, origin) = (Some(Hand::Vacuum(vacuum)), Origin::World(lifted));
            Attachment { id, robot, hand, object: fixed, origin }
        });
        Self(tools.chain(stuck).collect())
    }
}

impl From<Attachments> for Stored {
    fn from(Attachments(all): Attachments) -> Self {
        let mut stored = Self { tools: Vec::new(), stuck: Vec::new() };
        for Attachment { id, robot, hand, object, origin } in all {
            match (origin, hand) {
                (Origin::Tool(kind), hand) => {
                    let changer = if let Some(Hand::Changer(number)) = hand { Some(number) } else { None };
                    stored.tools.push(StoredTool { id, robot, changer, kind, object });
                }
                (Origin::World(lifted), Some(Hand::Vacuum(vacuum))) => {
                    stored.stuck.push(StoredStuck { id, robot, vacuum, lifted, fixed: object });
                }
                // Nothing else sticks to a robot.
                (Origin::World(_), Some(Hand::Changer(_)) | None) => {}
            }
        }
        stored
    }
}
