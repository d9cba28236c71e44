//! Everything with a name and a pose, as referees and wireless simulators ask for it (USARTruthConnection.uc, ComServerNewCon.uc).

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};
use scene::{ObjectId, PawnId, Pose};
use serde::{Deserialize, Serialize};

use super::avatar::Avatar;
use super::{CONTROLLER, World};
use crate::physics::{Identity, Light};

/// Distance behind a hit at which the search for obstacles goes on, m; two hits of one solid within it are one (ComServerNewCon.uc, 50 UU).
const STEP: f64 = 0.2;
/// Most hits of a search for obstacles.
const MAX_HITS: usize = 10_000;
/// Class of a map's victims.
const VICTIM: &str = "MaleVictim";
/// Class of a map's movable objects.
const OF_MAP: &str = "KActor";

/// A pawn, an object or a victim.
#[derive(Debug, Clone, PartialEq)]
pub struct Actor {
    /// Its kind.
    pub kind: ActorKind,
    /// Class without its package.
    pub class: String,
    /// Name in the engine: of a pawn its class and a number, of an object its own.
    pub name: String,
    /// Name from INIT; empty for others than pawns.
    pub called: String,
    /// Pose in the world.
    pub pose: Pose,
    /// True for a robot whose battery is empty.
    pub battery_is_empty: bool,
}

/// A kind of actor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActorKind {
    /// A robot.
    Robot,
    /// A world controller.
    Controller,
    /// An avatar.
    Avatar,
    /// An object that a world controller created.
    Created,
    /// A movable object of the map.
    OfMap,
    /// A victim of the map.
    Victim,
}

impl Actor {
    /// True if it is of a class or of one of its subclasses, in any case.
    pub fn is_a(&self, class: &str) -> bool {
        let above: &[&str] = match self.kind {
            ActorKind::Robot => &["USARVehicle", "Pawn"],
            ActorKind::Controller | ActorKind::Avatar | ActorKind::Victim => &["Pawn"],
            ActorKind::Created => &["WCObject"],
            ActorKind::OfMap => &[],
        };
        above.iter().chain(&["Actor", &self.class]).any(|own| own.eq_ignore_ascii_case(class))
    }
}

/// Numbers of pawns within their classes, as the engine names them: the first P3AT of a world is P3AT_0.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct EngineNames {
    counts: BTreeMap<String, u64>,
    numbers: BTreeMap<PawnId, u64>,
}

impl EngineNames {
    /// Numbers a new pawn.
    pub(super) fn add(&mut self, id: PawnId, class: &str) {
        let count = self.counts.entry(class.to_owned()).or_default();
        self.numbers.insert(id, *count);
        *count += 1;
    }

    /// Forgets a pawn. Its number is not given again.
    pub(super) fn remove(&mut self, id: PawnId) {
        self.numbers.remove(&id);
    }

    /// Returns the highest count or number.
    pub(super) fn highest(&self) -> u64 {
        self.counts.values().chain(self.numbers.values()).copied().max().unwrap_or_default()
    }

    fn of(&self, id: PawnId, class: &str) -> String {
        format!("{class}_{}", self.numbers.get(&id).copied().unwrap_or(id.0))
    }
}

impl World {
    /// Returns all pawns, then the objects and the victims of the map.
    pub fn actors(&self) -> Vec<Actor> {
        let time = self.time();
        let robots = self.robots.iter().map(|(&id, robot)| Actor {
            kind: ActorKind::Robot,
            class: robot.def().class.clone(),
            name: self.engine_names.of(id, &robot.def().class),
            called: robot.name().to_owned(),
            pose: self.physics.body(robot.bodies()).pose,
            battery_is_empty: robot.battery_left(time) <= 0,
        });
        let controllers = self.controllers.iter().map(|(&id, controller)| Actor {
            kind: ActorKind::Controller,
            class: CONTROLLER.to_owned(),
            name: self.engine_names.of(id, CONTROLLER),
            called: controller.name.clone(),
            pose: controller.pose,
            battery_is_empty: false,
        });
        let avatars = self.avatars.iter().filter_map(|(&id, avatar)| {
            Some(Actor {
                kind: ActorKind::Avatar,
                class: avatar.class_name().to_owned(),
                name: self.engine_names.of(id, avatar.class_name()),
                called: avatar.name().to_owned(),
                pose: self.physics.object(avatar.body())?,
                battery_is_empty: false,
            })
        });
        let created = self.created_ids();
        let bodies: BTreeSet<ObjectId> = self.avatars.values().map(Avatar::body).collect();
        let objects = self.objects().filter(|object| !bodies.contains(&object.id)).map(|object| {
            let class = created.get(&object.id);
            Actor {
                kind: if class.is_some() { ActorKind::Created } else { ActorKind::OfMap },
                class: class.map_or_else(|| OF_MAP.to_owned(), |(class, _)| (*class).to_owned()),
                name: class.map_or_else(|| object.def.solid.name.clone(), |(_, name)| (*name).to_owned()),
                called: String::new(),
                pose: object.pose,
                battery_is_empty: false,
            }
        });
        let victims = self.def().map.victims.iter().enumerate().map(|(number, victim)| Actor {
            kind: ActorKind::Victim,
            class: VICTIM.to_owned(),
            name: format!("{VICTIM}_{number}"),
            called: String::new(),
            pose: victim.pose(),
            battery_is_empty: false,
        });
        robots.chain(controllers).chain(avatars).chain(objects).chain(victims).collect()
    }

    /// Counts the solids of the map on the line between two points, m. A wall counts once, however thick. Robots, objects and victims do not
    /// count.
    pub fn obstacles(&mut self, from: [f64; 3], to: [f64; 3]) -> usize {
        let (from, way) = (Point3::from(from), Vector3::from(to) - Vector3::from(from));
        let Some(direction) = way.try_normalize(1e-9) else { return 0 };
        self.enter_shapes_for_question();
        let (length, mut gone, mut last, mut count) = (way.norm(), 0.0, None, 0);
        for _ in 0..MAX_HITS {
            let sight = self.physics.sight(Light::Visible, &(from + direction * gone), length - gone, PawnId(u64::MAX));
            let Some(hit) = sight.cast_ray(&direction) else { break };
            let is_new = last != Some(hit.identity) || hit.distance > STEP;
            let is_wall = |solid| self.physics.site().body_parts.iter().all(|part| part.solid != solid);
            count += usize::from(is_new && matches!(hit.identity, Identity::Solid(solid) if is_wall(solid)));
            last = Some(hit.identity);
            gone += hit.distance + STEP;
            if gone >= length {
                break;
            }
        }
        count
    }
}
