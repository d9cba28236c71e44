//! Avatars: people who walk through the world (USARAvatar/classes; protocol.md 3.1).
//!
//! An avatar is a pawn with a body that nothing pushes: a held object, led from place to place. It stands still before whatever is in its way,
//! and does not climb more than a stair.

use std::sync::Arc;

use gamebots_proto::command::{Gait, GoTo, Init, Target, Walk};
use gamebots_proto::message::{AvatarBone, AvatarBones, AvatarSta, Message};
use gamebots_proto::{Problem, shown};
use nalgebra::{Point3, Vector2, Vector3};
use scene::{Material, NamedPose, Object, ObjectId, PawnId, Pose, Shape, Solid, check};
use serde::{Deserialize, Serialize};

use super::{Report, World};
use crate::physics::{Identity, Light};
use crate::sensor::floats;

/// Interval at which an avatar looks ahead, and reports its state (DefaultUSAR.ini, msgTimerSTA), s.
const INTERVAL: f64 = 0.05;
/// Distance from a place at which the avatar is there, m (USARAIController.uc, CloseEnough: 10 UU).
const CLOSE: f64 = 0.04;
/// Free distance that it keeps before it, m.
const MARGIN: f64 = 0.1;
/// Highest step that it climbs or goes down, m (Engine.Pawn, MaxStepHeight: 35 UU with the scale of a person).
const STEP: f64 = 0.35;
/// Rate at which it turns, rad/s. The original turns at once.
const TURN: f64 = 6.0;
/// Speeds of Walk_Forward and Run, m/s (USARAIController.uc: 180 and 750 UU/s). Walk_Backward keeps the speed before it, at first 180.
const WALK: f64 = 0.72;
const RUN: f64 = 3.0;
/// Length of two steps, m, and largest angle of an arm that swings, rad. The original's are in its lost animations.
const STRIDE: f64 = 1.4;
const SWING: f64 = 0.5;
/// Most places that it has still to go to.
const MAX_LEGS: usize = 1024;
/// Most lines of sight between path nodes that one GOTO looks along.
const MAX_SIGHTS: usize = 20_000;
/// Bones of its report.
const BONES: [&str; 4] = ["Bip02-R-UpperArm", "Bip02-R-Forearm", "Bip02-L-UpperArm", "Bip02-L-Forearm"];

/// A class of avatars.
struct Class {
    name: &'static str,
    /// Height, m.
    height: f64,
    /// Speed on the way to a path node, m/s (GroundSpeed).
    speed: f64,
    /// True if it reports its state.
    reports: bool,
    colour: [f64; 3],
}

const fn tall(name: &'static str, colour: [f64; 3]) -> Class {
    Class { name, height: 1.8, speed: WALK, reports: false, colour }
}

/// The classes, in the order of [`Init::AVATARS`]. Heights of the last two are in their comments.
const CLASSES: [Class; 6] = [
    tall(Init::AVATARS[0], [0.20, 0.35, 0.60]),
    tall(Init::AVATARS[1], [0.55, 0.25, 0.20]),
    tall(Init::AVATARS[2], [0.25, 0.45, 0.30]),
    tall(Init::AVATARS[3], [0.45, 0.40, 0.35]),
    Class { name: Init::AVATARS[4], height: 1.7, speed: 1.2, reports: true, colour: [0.30, 0.30, 0.45] },
    Class { name: Init::AVATARS[5], height: 1.6, speed: 1.76, reports: true, colour: [0.60, 0.35, 0.45] },
];

/// An avatar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Avatar {
    class: usize,
    /// Its name from INIT.
    name: String,
    body: ObjectId,
    /// Places that it goes to, one after the other.
    legs: Vec<Leg>,
    is_paused: bool,
    /// Velocity until it looks ahead again, m/s.
    velocity: [f64; 3],
    /// Yaw that it turns to, rad.
    heading: f64,
    /// Way that it has gone, m.
    way: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Leg {
    to: [f64; 2],
    /// m/s.
    speed: f64,
    is_backward: bool,
}

impl Avatar {
    fn class(&self) -> &'static Class {
        CLASSES.get(self.class).unwrap_or(&CLASSES[0])
    }

    pub(super) fn class_name(&self) -> &'static str {
        self.class().name
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn body(&self) -> ObjectId {
        self.body
    }

    /// True if its numbers are such as an avatar can have. Saved ones may come from a stranger.
    pub(super) fn is_sound(&self) -> bool {
        let is_leg = |leg: &Leg| {
            check::MAP_REACH.holds(leg.to[0]) && check::MAP_REACH.holds(leg.to[1]) && (0.0..=RUN).contains(&leg.speed)
        };
        let is_fast = |part: &f64| !(-RUN..=RUN).contains(part);
        let is_slow = !self.velocity[..2].iter().any(is_fast) && self.velocity[2].abs() <= STEP / INTERVAL + 1.0;
        self.class < CLASSES.len()
            && self.legs.len() <= MAX_LEGS
            && self.legs.iter().all(is_leg)
            && is_slow
            && self.heading.is_finite()
            && self.way.is_finite()
    }

    fn is_walking(&self) -> bool {
        self.velocity != [0.0; 3]
    }

    /// Returns its messages at a pose and a time, s.
    fn reports(&self, pose: &Pose, time: f64) -> [Message; 2] {
        let (location, orientation) = scene::position_and_rotation(pose);
        let (time, name) = (time as f32, self.name.clone());
        // The zero of an angle has no sign.
        let angles = |angles: [f64; 3]| floats(angles.map(|angle| angle + 0.0));
        let swing = if self.is_walking() { SWING * libm::sin(std::f64::consts::TAU * self.way / STRIDE) } else { 0.0 };
        let bone = |(number, bone): (usize, &&str)| {
            let angle = [swing, swing / 2.0, -swing, -swing / 2.0][number];
            AvatarBone { bone: (*bone).to_owned(), rotation: angles([0.0, angle, 0.0]) }
        };
        let bones = AvatarBones { time, name: name.clone(), bones: BONES.iter().enumerate().map(bone).collect() };
        let state = AvatarSta {
            time,
            class: self.class_name().to_owned(),
            name,
            location: floats(location),
            orientation: angles(orientation),
            walking: self.is_walking(),
        };
        [Message::Avatar(state), Message::Bones(bones)]
    }
}

/// Rings around a body of height 1, from its feet to the top of its head: height above the middle, and half axes ahead and aside.
const RINGS: [[f64; 3]; 6] = [
    [-0.5, 0.07, 0.09],
    [-0.05, 0.08, 0.11],
    [0.25, 0.075, 0.13],
    [0.33, 0.065, 0.12],
    [0.45, 0.05, 0.05],
    [0.5, 0.025, 0.025],
];
/// Corners of a ring.
const CORNERS: usize = 12;

/// Returns the body of a class, around its middle. It is convex, as engines like it: a person in a coat.
fn body(class: &Class, name: &str) -> Object {
    let ring = |[up, ahead, aside]: [f64; 3]| {
        (0..CORNERS).map(move |corner| {
            let angle = std::f64::consts::TAU * corner as f64 / CORNERS as f64;
            [ahead * libm::cos(angle), aside * libm::sin(angle), -up]
        })
    };
    let points = RINGS.into_iter().flat_map(ring).map(|point| point.map(|part| part * class.height)).collect();
    let source = "an estimate: a person in clothes".to_owned();
    let material =
        Material { name: "clothes".to_owned(), friction: 0.7, colour: class.colour, source, ..Material::default() };
    let (shape, name) = (Shape::Hull { points }, name.to_owned());
    Object { solid: Solid { name, shape, position: [0.0; 3], rotation: [0.0; 3], material }, mass: 70.0 }
}

/// Returns half of the width of a body, m.
fn radius(class: &Class) -> f64 {
    0.15 * class.height
}

impl World {
    /// Spawns an avatar on the floor at the wanted place.
    ///
    /// # Errors
    /// If there is no floor, or something takes the place.
    pub(super) fn spawn_avatar(&mut self, class: &str, name: String, wanted: &Pose) -> Result<PawnId, String> {
        let number = CLASSES.iter().position(|known| known.name == class).unwrap_or_default();
        let class = &CLASSES[number];
        let at = wanted.translation.vector;
        if !at.iter().all(|number| check::MAP_REACH.holds(*number)) {
            return Err("it is outside the map".to_owned());
        }
        self.enter_shapes();
        let floor = self.physics.floor_below(at).ok_or("there is no floor")?;
        let (_, [.., yaw]) = scene::position_and_rotation(wanted);
        let object = body(class, &name);
        let pose = scene::pose([at.x, at.y, floor - class.height / 2.0], [0.0, 0.0, yaw]);
        if let Some(obstacle) = self.physics.obstacle(&object, &pose) {
            return Err(format!("{} takes it", self.describe(obstacle)));
        }
        let (id, body) = (self.number(), ObjectId(self.next_object));
        self.next_object += 1;
        self.physics.spawn_object(body, Arc::new(object), &pose, true);
        let avatar = Avatar {
            class: number,
            name,
            body,
            legs: Vec::new(),
            is_paused: false,
            velocity: [0.0; 3],
            heading: yaw,
            way: 0.0,
        };
        self.engine_names.add(id, class.name);
        self.avatars.insert(id, avatar);
        Ok(id)
    }

    pub(super) fn remove_avatar(&mut self, id: PawnId) {
        if let Some(avatar) = self.avatars.remove(&id) {
            self.physics.remove_object(avatar.body);
        }
    }

    /// Follows an order to walk.
    pub(super) fn walk(&mut self, pawn: Option<PawnId>, order: &Walk, problems: &mut Vec<Problem>) {
        let Some(avatar) = pawn.and_then(|pawn| self.avatars.get_mut(&pawn)) else {
            problems.push(Problem::NoAvatar { verb: "MOVE" });
            return;
        };
        let (gait, appends, target) = match order {
            Walk::Pause | Walk::Resume => {
                avatar.is_paused = *order == Walk::Pause;
                return;
            }
            Walk::Nothing => return,
            Walk::To { gait, appends, target } => (gait, appends, target),
        };
        let mut refuse = |why: String| problems.push(Problem::NoWay { verb: "MOVE", why });
        let to = match target {
            Target::Place(place) => *place,
            Target::Node(name) => match node(&self.scene.def().map.path_nodes, name) {
                Ok(node) => [node.position[0], node.position[1]],
                Err(why) => return refuse(why),
            },
        };
        if let Some(wrong) = check::MAP_REACH.problem_in("Location", &[to[0], to[1], 0.0]) {
            return refuse(wrong);
        }
        if !appends {
            avatar.legs.clear();
        }
        if avatar.legs.len() >= MAX_LEGS {
            return refuse(format!("it has {MAX_LEGS} places to go to already"));
        }
        let last = avatar.legs.last().map_or(WALK, |leg| leg.speed);
        let (speed, is_backward) = match gait {
            Gait::Forward => (WALK, false),
            Gait::Backward => (last, true),
            Gait::Run => (RUN, false),
        };
        avatar.legs.push(Leg { to, speed, is_backward });
    }

    /// Sends an avatar to a path node by the shortest way along nodes that see each other.
    pub(super) fn go_to(&mut self, pawn: Option<PawnId>, order: &GoTo, problems: &mut Vec<Problem>) {
        let Some((id, avatar)) = pawn.and_then(|pawn| Some((pawn, self.avatars.get(&pawn)?))) else {
            problems.push(Problem::NoAvatar { verb: "GOTO" });
            return;
        };
        let (class, body) = (avatar.class(), avatar.body);
        let legs = self
            .route(class, body, &order.name)
            .map(|places| places.into_iter().map(|to| Leg { to, speed: class.speed, is_backward: false }).collect());
        match (legs, self.avatars.get_mut(&id)) {
            (Ok(legs), Some(avatar)) => avatar.legs = legs,
            (Err(why), _) => problems.push(Problem::NoWay { verb: "GOTO", why }),
            (Ok(_), None) => {}
        }
    }

    /// Finds the shortest way (Dijkstra).
    fn route(&mut self, class: &Class, body: ObjectId, name: &str) -> Result<Vec<[f64; 2]>, String> {
        self.enter_shapes_for_question();
        let nodes = &self.scene.def().map.path_nodes;
        let goal = node(nodes, name)?;
        let goal = nodes.iter().position(|it| std::ptr::eq(it, goal)).unwrap_or_default() + 1;
        let here = self.physics.object(body).ok_or("it is gone")?.translation.vector;
        let middle = |node: &NamedPose| {
            let place = Vector3::from(node.position);
            let floor = self.physics.floor_below(place - Vector3::z() * 0.1).unwrap_or(place.z);
            Vector3::new(place.x, place.y, floor - class.height / 2.0)
        };
        let places: Vec<Vector3<f64>> = std::iter::once(here).chain(nodes.iter().map(middle)).collect();
        let mut sights = 0;
        let mut is_clear = |from: Vector3<f64>, to: Vector3<f64>| {
            sights += 1;
            sights <= MAX_SIGHTS && self.is_clear(class, from, to)
        };
        let mut costs = vec![f64::INFINITY; places.len()];
        let mut before = vec![0; places.len()];
        let mut is_done = vec![false; places.len()];
        costs[0] = 0.0;
        while let Some(at) = nearest(&costs, &is_done) {
            if at == goal {
                break;
            }
            is_done[at] = true;
            for next in 1..places.len() {
                let cost = costs[at] + (places[next] - places[at]).norm();
                if !is_done[next] && cost < costs[next] && is_clear(places[at], places[next]) {
                    (costs[next], before[next]) = (cost, at);
                }
            }
        }
        if !costs[goal].is_finite() {
            return Err(format!("no way to `{}` leads along path nodes that see each other", shown(name)));
        }
        let mut way = vec![goal];
        while let Some(&at) = way.last().filter(|&&at| before[at] != 0) {
            way.push(before[at]);
        }
        Ok(way.iter().rev().map(|&at| [places[at].x, places[at].y]).collect())
    }

    /// True if no solid of the map is on the line between two places, nor beside it.
    fn is_clear(&self, class: &Class, from: Vector3<f64>, to: Vector3<f64>) -> bool {
        let way = to - from;
        let Some(direction) = way.try_normalize(1e-9) else { return true };
        let aside = Vector3::new(-direction.y, direction.x, 0.0) * radius(class);
        [-1.0, 0.0, 1.0].into_iter().all(|side| {
            let origin = Point3::from(from + aside * side);
            let hit = self.physics.sight(Light::Visible, &origin, way.norm(), PawnId(u64::MAX)).cast_ray(&direction);
            !hit.is_some_and(|hit| matches!(hit.identity, Identity::Solid(_)))
        })
    }

    /// True if an avatar looks ahead after some steps.
    pub(super) fn do_avatars_look(&self, steps: u64) -> bool {
        !self.avatars.is_empty() && steps.is_multiple_of(self.avatar_interval())
    }

    /// Returns the steps between two looks.
    fn avatar_interval(&self) -> u64 {
        ((INTERVAL / self.options.time_step).round() as u64).max(1)
    }

    /// Lets avatars look ahead, and returns what they report. Shapes must be where they are.
    pub(super) fn look_ahead(&mut self) -> Vec<(PawnId, Report)> {
        let (time, interval) = (self.time(), self.avatar_interval() as f64 * self.options.time_step);
        let mut reports = Vec::new();
        let mut avatars = std::mem::take(&mut self.avatars);
        for (&id, avatar) in &mut avatars {
            let Some(pose) = self.physics.object(avatar.body) else { continue };
            let at = pose.translation.vector;
            avatar.velocity = [0.0; 3];
            let there = |leg: &Leg| (Vector2::from(leg.to) - at.xy()).norm() <= CLOSE;
            if !avatar.is_paused {
                let gone = avatar.legs.iter().take_while(|leg| there(leg)).count();
                avatar.legs.drain(..gone);
                if let Some(leg) = avatar.legs.first().copied() {
                    let way = Vector2::from(leg.to) - at.xy();
                    let direction = way / way.norm();
                    let ahead = if leg.is_backward { -direction } else { direction };
                    avatar.heading = libm::atan2(ahead.y, ahead.x);
                    let speed = leg.speed.min(way.norm() / interval);
                    if let Some(velocity) = self.velocity(avatar.class(), at, direction * speed, interval) {
                        avatar.velocity = velocity;
                        avatar.way += speed * interval;
                    }
                }
            }
            if avatar.class().reports {
                reports.extend(avatar.reports(&pose, time).map(|message| (id, message.into())));
            }
        }
        self.avatars = avatars;
        reports
    }

    /// Returns the velocity with which a body goes on, m/s; `None` if something is in its way, or the floor falls off.
    fn velocity(&self, class: &Class, at: Vector3<f64>, wanted: Vector2<f64>, interval: f64) -> Option<[f64; 3]> {
        let (half, radius) = (class.height / 2.0, radius(class));
        let direction = Vector3::new(wanted.x, wanted.y, 0.0).normalize();
        let aside = Vector3::new(-direction.y, direction.x, 0.0);
        let reach = wanted.norm() * interval + MARGIN;
        // Heights above the feet. Low solids of the map may be stairs; the floor below says.
        for (height, stops_at_solids) in
            [(0.1, false), (0.25, false), (STEP + 0.05, true), (half, true), (1.7 * half, true)]
        {
            for side in [-0.8, 0.0, 0.8] {
                let origin = at + direction * radius + aside * (side * radius) + Vector3::z() * (half - height);
                let sight = self.physics.sight(Light::Visible, &origin.into(), reach, PawnId(u64::MAX));
                let hit = sight.cast_ray(&direction);
                if hit.is_some_and(|hit| stops_at_solids || !matches!(hit.identity, Identity::Solid(_))) {
                    return None;
                }
            }
        }
        let next = at + Vector3::new(wanted.x, wanted.y, 0.0) * interval;
        let floor = self.physics.floor_below(next + Vector3::z() * (half - STEP))?;
        let rise = floor - half - at.z;
        (rise.abs() <= STEP).then(|| [wanted.x, wanted.y, rise / interval])
    }

    /// Returns the bodies of avatars that move, with their poses at the end of the coming step.
    pub(super) fn lead_avatars(&mut self) -> Vec<(ObjectId, Pose)> {
        let time_step = self.options.time_step;
        let mut led = Vec::new();
        for avatar in self.avatars.values() {
            let Some(now) = self.physics.object(avatar.body) else { continue };
            let (_, [.., yaw]) = scene::position_and_rotation(&now);
            let turn = turn_to(avatar.heading - yaw).clamp(-TURN * time_step, TURN * time_step);
            if !avatar.is_walking() && turn == 0.0 {
                continue;
            }
            let position = now.translation.vector + Vector3::from(avatar.velocity) * time_step;
            let pose = scene::pose(position.into(), [0.0, 0.0, yaw + turn]);
            led.push((avatar.body, pose));
        }
        led
    }
}

/// Returns the shortest turn by an angle, rad; 0 if it is too small.
fn turn_to(angle: f64) -> f64 {
    let angle = libm::remainder(angle, std::f64::consts::TAU);
    if angle.abs() < 1e-9 { 0.0 } else { angle }
}

/// Finds a path node by its name, in any case.
fn node<'a>(nodes: &'a [NamedPose], name: &str) -> Result<&'a NamedPose, String> {
    let found = nodes.iter().find(|node| node.name.eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        let known: Vec<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
        let known = if known.is_empty() { "the map has none".to_owned() } else { known.join(", ") };
        format!("there is no path node `{}`: expected one of {known}", shown(name))
    })
}

/// Returns the cheapest place that is not done.
fn nearest(costs: &[f64], is_done: &[bool]) -> Option<usize> {
    let open = costs.iter().enumerate().filter(|(at, cost)| !is_done[*at] && cost.is_finite());
    open.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(at, _)| at)
}
