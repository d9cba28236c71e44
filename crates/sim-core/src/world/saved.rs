//! Saving a world as plain data, and going on from it.

use std::collections::{BTreeMap, BTreeSet};

use scene::{ObjectId, Options, PawnId, RfidTag, check};
use serde::{Deserialize, Serialize};

use super::actors::EngineNames;
use super::avatar::Avatar;
use super::controller::{Controller, Created, MAX_OBJECTS};
use super::held::Attachments;
use super::pull::{MAX_PULLS, Pull};
use super::robot::{Robot, SavedRobot};
use super::tiles::Tiles;
use super::{MAX_NAME_CHARS, MAX_ROBOTS, World};
use crate::CompiledScene;
use crate::physics::SavedObject;

/// Most steps and numbers of pawns or objects: 17 000 years of default steps, after which clocks and counters still work.
const MAX_COUNT: u64 = 1 << 48;

/// The state of a world at the end of a step. The scene is not in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedWorld {
    options: Options,
    steps: u64,
    next_id: u64,
    controllers: BTreeMap<PawnId, Controller>,
    #[serde(default)]
    avatars: BTreeMap<PawnId, Avatar>,
    created: Vec<Created>,
    next_object: u64,
    #[serde(default)]
    pulls: Vec<Pull>,
    #[serde(flatten)]
    attached: Attachments,
    #[serde(default)]
    engine_names: EngineNames,
    #[serde(default)]
    tiles: Tiles,
    #[serde(default)]
    single_view: Option<PawnId>,
    /// `None` in files from before there were any: then those of the map.
    #[serde(default)]
    tags: Option<Vec<RfidTag>>,
    /// Factors at which conveyors run, in the order of the map; empty in worlds that were saved before there were any.
    #[serde(default)]
    conveyors: Vec<f64>,
    unsettled: u64,
    objects: Vec<SavedObject>,
    robots: Vec<SavedRobot>,
}

impl SavedWorld {
    /// Returns the options that the world ran with.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Checks options, counters and numbers of entries, which do not depend on the scene.
    fn check(&self) -> Result<(), LoadError> {
        let Options { time_step, speed_unit, .. } = self.options;
        let ranges = [("time_step", check::TIME_STEP, time_step), ("speed_unit", check::SPEED_UNIT, speed_unit)];
        if let Some(problem) = ranges.into_iter().find_map(|(name, range, value)| range.problem(name, value)) {
            return Err(LoadError::BadOption { problem });
        }
        let counters = [
            ("steps", self.steps),
            ("next_id", self.next_id),
            ("next_object", self.next_object),
            ("unsettled", self.unsettled),
            ("engine_names", self.engine_names.highest()),
        ];
        if let Some((name, got)) = counters.into_iter().find(|(_, got)| *got > MAX_COUNT) {
            return Err(LoadError::TooHigh { name, got, most: MAX_COUNT });
        }
        let pawns = self.robots.len() + self.controllers.len() + self.avatars.len();
        let objects = self.objects.len() + self.attached.len();
        let lists = [
            ("pawns", pawns, MAX_ROBOTS),
            ("objects of controllers", self.created.len(), MAX_OBJECTS),
            ("things that are pulled", self.pulls.len(), MAX_PULLS),
            ("objects", objects, check::MAX_SOLIDS),
        ];
        if let Some((what, got, most)) = lists.into_iter().find(|(_, got, most)| got > most) {
            return Err(LoadError::TooMany { what, got, most });
        }
        self.check_pawns()
    }

    /// Checks the numbers and names of pawns.
    fn check_pawns(&self) -> Result<(), LoadError> {
        let robots = self.robots.iter().map(|robot| (robot.id, robot.name.as_str()));
        let controllers = self.controllers.iter().map(|(id, controller)| (*id, controller.name.as_str()));
        let avatars = self.avatars.iter().map(|(id, avatar)| (*id, avatar.name()));
        let mut ids = BTreeSet::new();
        for (id, name) in robots.chain(controllers).chain(avatars) {
            if id.0 >= self.next_id || !ids.insert(id) {
                return Err(LoadError::OutOfOrder { id });
            }
            let got = name.chars().count();
            if got > MAX_NAME_CHARS {
                return Err(LoadError::LongName { id, got, most: MAX_NAME_CHARS });
            }
        }
        let is_unsound = |(_, controller): &(&PawnId, &Controller)| !controller.is_sound();
        self.controllers.iter().find(is_unsound).map_or(Ok(()), |(&id, _)| Err(LoadError::Controller { id }))
    }
}

/// Reason why a world cannot be saved.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SaveError {
    /// The engine moves a robot, and keeps part of its state to itself.
    #[error("robot {} of class {class} is moved by the engine (drive model `bodies`), which cannot be saved; expected another drive model", id.0)]
    OfEngine {
        /// The robot.
        id: PawnId,
        /// Its class.
        class: String,
    },
}

/// Reason why a saved world cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// The scene has no such class.
    #[error("robot {}: got the class {class}, expected one of {expected}", id.0)]
    UnknownClass {
        /// The robot.
        id: PawnId,
        /// Its class when it was saved.
        class: String,
        /// Classes of the scene.
        expected: String,
    },
    /// The class has other links or sensors than when the robot was saved.
    #[error("robot {}: its state does not fit the class {class} of this scene", id.0)]
    OtherClass {
        /// The robot.
        id: PawnId,
        /// Its class.
        class: String,
    },
    /// The map has other objects than when the world was saved.
    #[error("object {}: its state does not fit the map of this scene", id.0)]
    OtherMap {
        /// The object.
        id: ObjectId,
    },
    /// There are too many RFID tags, or one has a text or a position that no tag can have.
    #[error("RFID tags: expected at most {}, each within the map and with a text without braces", check::MAX_TAGS)]
    Tags,
    /// A spring pulls to a place that no order gives.
    #[error("pulls: expected places within the map")]
    Pulls,
    /// The map has other conveyors than when the world was saved.
    #[error("got factors of {got} conveyors, expected finite ones of {expected}")]
    OtherConveyors {
        /// Number of the saved ones.
        got: usize,
        /// Number of those of the map.
        expected: usize,
    },
    /// Robots are not in the order of their numbers, or a pawn has a number that is taken or still to be given.
    #[error("robot {}: its number is out of order", id.0)]
    OutOfOrder {
        /// The pawn.
        id: PawnId,
    },
    /// An option has a value that no run can have.
    #[error("options: {problem}")]
    BadOption {
        /// Description of the option, its value and the expected one.
        problem: String,
    },
    /// A counter is so high that it would overflow, or that clocks would stop.
    #[error("`{name}` is {got}: expected at most {most}")]
    TooHigh {
        /// The counter.
        name: &'static str,
        /// Its value.
        got: u64,
        /// Highest value.
        most: u64,
    },
    /// A list is longer than a world can have it.
    #[error("got {got} {what}, expected at most {most}")]
    TooMany {
        /// The kind of the entries.
        what: &'static str,
        /// Length of the list.
        got: usize,
        /// Greatest length.
        most: usize,
    },
    /// The name of a pawn is longer than INIT takes it.
    #[error("robot {}: its name has {got} characters, expected at most {most}", id.0)]
    LongName {
        /// The pawn.
        id: PawnId,
        /// Length of the name.
        got: usize,
        /// Greatest length.
        most: usize,
    },
    /// The pose of a world controller is not finite.
    #[error("world controller {}: expected a finite pose", id.0)]
    Controller {
        /// The controller.
        id: PawnId,
    },
    /// An object of a world controller has another's number, or a name, pose, spin or path that no order gives.
    #[error("object {}: expected a number, a name, a pose, a spin and a path as world controllers give them", id.0)]
    Created {
        /// The object.
        id: ObjectId,
    },
}

impl World {
    /// Returns the state.
    ///
    /// # Errors
    /// If the engine moves a robot.
    pub fn save(&self) -> Result<SavedWorld, SaveError> {
        let save = |robot: &Robot| {
            let class = || robot.def().class.clone();
            robot.save().ok_or_else(|| SaveError::OfEngine { id: robot.id(), class: class() })
        };
        Ok(SavedWorld {
            options: self.options,
            steps: self.steps,
            next_id: self.next_id,
            controllers: self.controllers.clone(),
            avatars: self.avatars.clone(),
            created: self.created.clone(),
            next_object: self.next_object,
            pulls: self.pulls.clone(),
            attached: self.attached.clone(),
            engine_names: self.engine_names.clone(),
            tiles: self.tiles,
            single_view: self.single_view,
            tags: Some(self.physics.tags.clone()),
            conveyors: self.physics.conveyor_factors().collect(),
            unsettled: self.unsettled_steps(),
            objects: self.physics.save_objects(),
            robots: self.robots.values().map(save).collect::<Result<_, _>>()?,
        })
    }

    /// Creates a world that goes on from a saved state with the same bits, if the scene is the same.
    ///
    /// # Errors
    /// If the state does not fit the scene, or has numbers that no world has.
    pub fn load(scene: impl Into<CompiledScene>, saved: &SavedWorld) -> Result<Self, LoadError> {
        saved.check()?;
        let mut world = Self::new(scene, saved.options);
        (world.steps, world.next_id) = (saved.steps, saved.next_id);
        world.avatars = saved.avatars.clone();
        (world.controllers, world.created) = (saved.controllers.clone(), saved.created.clone());
        (world.next_object, world.attached) = (saved.next_object, saved.attached.clone());
        world.engine_names = saved.engine_names.clone();
        (world.tiles, world.single_view) = (saved.tiles, saved.single_view);
        let (of_map, next) = (world.def().map.objects.len() as u64, saved.next_object);
        let fits = |it: &SavedObject| it.spawned.is_none() == (it.id.0 < of_map) && it.id.0 < next && it.is_sound();
        if let Some(SavedObject { id, .. }) = saved.objects.iter().find(|it| !fits(it)) {
            return Err(LoadError::OtherMap { id: *id });
        }
        if let Some(id) = saved.attached.unsound(of_map, next) {
            return Err(LoadError::OtherMap { id });
        }
        let is_saved = |body| saved.objects.iter().any(|object| object.id == body && object.spawned.is_some());
        let fits = |(_, avatar): &(&PawnId, &Avatar)| is_saved(avatar.body()) && avatar.is_sound();
        if let Some((_, avatar)) = saved.avatars.iter().find(|avatar| !fits(avatar)) {
            return Err(LoadError::OtherMap { id: avatar.body() });
        }
        let fits = |it: &Created| (of_map..next).contains(&it.id().0) && it.by().0 < saved.next_id && it.is_sound();
        if let Some(created) = saved.created.iter().find(|it| !fits(it)) {
            return Err(LoadError::Created { id: created.id() });
        }
        if !saved.pulls.iter().all(Pull::is_sound) {
            return Err(LoadError::Pulls);
        }
        world.pulls = saved.pulls.clone();
        let is_sound = |tag: &RfidTag| check::tag(tag).is_empty();
        if let Some(tags) = &saved.tags {
            if tags.len() > check::MAX_TAGS || !tags.iter().all(is_sound) {
                return Err(LoadError::Tags);
            }
            world.physics.tags = tags.clone();
        }
        let (got, expected) = (saved.conveyors.len(), world.def().map.conveyors.len());
        if got > 0 && got != expected || !saved.conveyors.iter().all(|factor| factor.is_finite()) {
            return Err(LoadError::OtherConveyors { got, expected });
        }
        world.physics.load_conveyors(&saved.conveyors);
        let objects = world.physics.load_objects(&saved.objects, saved.unsettled);
        objects.map_err(|id| LoadError::OtherMap { id })?;
        for robot in &saved.robots {
            let (id, class) = (robot.id, robot.class.clone());
            if world.robots.last_key_value().is_some_and(|(last, _)| *last >= id) {
                return Err(LoadError::OutOfOrder { id });
            }
            let Some(compiled) = world.compiled(&class) else {
                let expected = world.def().robots.keys().cloned().collect::<Vec<_>>().join(", ");
                return Err(LoadError::UnknownClass { id, class, expected });
            };
            let fitted = saved.attached.fitted(&mut world.physics, &compiled, id);
            let fitted = fitted.map_err(|_| LoadError::OtherClass { id, class: class.clone() })?;
            let loaded = Robot::load(&mut world.physics, fitted, robot, saved.steps, saved.options);
            world.robots.insert(id, loaded.ok_or(LoadError::OtherClass { id, class })?);
            world.tell_tiles(id);
        }
        Ok(world)
    }
}
