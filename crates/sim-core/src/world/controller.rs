//! World controllers and the objects that they create (protocol.md 3.2; WorldController.uc).
//!
//! A controller is a pawn without a body. Its objects leave with it, unless they are permanent.

use std::collections::BTreeMap;
use std::sync::Arc;

use gamebots_proto::command::{Control, Create, Move, SetPath};
use gamebots_proto::message::{MAX_OBJECTS_BYTES, Message, ObjectSta, objects_that_fit};
use gamebots_proto::{Problem, shown};
use nalgebra::Vector3;
use scene::{Material, ObjectId, ObjectSnapshot, PawnId, Pose, check};
use serde::{Deserialize, Serialize};

use super::World;
use crate::physics::extents;
use crate::sensor::floats;

/// Most objects that controllers may have in a world.
pub(super) const MAX_OBJECTS: usize = 1024;
/// Most points of an object's path.
const MAX_POINTS: usize = 4096;
/// Most points of the paths of all objects in a world.
const MAX_ALL_POINTS: usize = 65_536;
/// Longest name or memory of an object, bytes.
const MAX_TEXT_BYTES: usize = 256;
/// Largest speed along a path and of the farthest point of an object that turns, m/s.
const MAX_SPEED: f64 = 50.0;
/// Largest rate of turn, rad/s.
const MAX_RATE: f64 = 50.0;

/// A world controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Controller {
    /// Its name from INIT.
    pub(super) name: String,
    /// Pose from its INIT. It does nothing; referees are told it.
    #[serde(default)]
    pub(super) pose: Pose,
}

impl Controller {
    /// True if its numbers are finite. Saved ones may come from a stranger.
    pub(super) fn is_sound(&self) -> bool {
        let Pose { translation, rotation } = &self.pose;
        translation.vector.iter().chain(rotation.coords.iter()).all(|it| it.is_finite())
    }
}

/// An object that a controller created.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Created {
    id: ObjectId,
    by: PawnId,
    class: String,
    name: String,
    memory: String,
    permanent: bool,
    /// True if forces move it while no order does.
    is_rigid: bool,
    /// First position, m, and roll, pitch, yaw, rad.
    start: [[f64; 3]; 2],
    /// Rates of roll, pitch and yaw, rad/s.
    spin: [f64; 3],
    /// Roll, pitch and yaw while it turns or follows its path, rad.
    rotation: [f64; 3],
    path: Path,
}

/// Points of a path, m, with the way from the first to each along straight lines, m. Saved as a list of the points alone.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "Vec<[f64; 3]>", into = "Vec<[f64; 3]>")]
struct Points {
    places: Vec<[f64; 3]>,
    ways: Vec<f64>,
}

impl From<Vec<[f64; 3]>> for Points {
    fn from(places: Vec<[f64; 3]>) -> Self {
        let mut points = Self::default();
        points.extend(&places);
        points
    }
}

impl From<Points> for Vec<[f64; 3]> {
    fn from(points: Points) -> Self {
        points.places
    }
}

impl Points {
    fn extend(&mut self, places: &[[f64; 3]]) {
        for &place in places {
            let way = self.places.last().zip(self.ways.last()).map_or(0.0, |(last, way)| way + distance(last, &place));
            self.places.push(place);
            self.ways.push(way);
        }
    }

    fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns the length of the line from the last point to the first, m.
    fn closing(&self) -> f64 {
        self.places.last().zip(self.places.first()).map_or(0.0, |(last, first)| distance(last, first))
    }
}

fn distance(from: &[f64; 3], to: &[f64; 3]) -> f64 {
    (Vector3::from(*to) - Vector3::from(*from)).norm()
}

/// The path of an object: straight lines between points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Path {
    points: Points,
    /// Length up to its end, m; 0 if there is nothing to follow.
    length: f64,
    /// Way from its beginning, m.
    progress: f64,
    /// m/s.
    speed: f64,
    is_loop: bool,
    moving: bool,
}

impl Default for Path {
    fn default() -> Self {
        Self { points: Points::default(), length: 0.0, progress: 0.0, speed: 0.0, is_loop: false, moving: true }
    }
}

impl Path {
    /// Measures the path. A loop has a line from its last point to its first, too.
    fn measure(&mut self) {
        let closing = if self.is_loop { self.points.closing() } else { 0.0 };
        self.length = self.points.ways.last().copied().unwrap_or_default() + closing;
    }

    fn is_followed(&self) -> bool {
        self.length > 0.0 && self.moving
    }

    /// Advances by a way, m. Returns false at the end of a path that is no loop.
    fn advance(&mut self, way: f64) -> bool {
        self.progress += way;
        if self.progress < self.length {
            self.progress = self.progress.max(0.0);
            return true;
        }
        self.progress = if self.is_loop { self.progress % self.length } else { 0.0 };
        self.is_loop
    }

    /// True if its numbers are such as orders give them. Saved ones may come from a stranger.
    fn is_sound(&self) -> bool {
        let is_place = |point: &[f64; 3]| point.iter().all(|&it| check::MAP_REACH.holds(it));
        self.points.len() <= MAX_POINTS
            && self.points.places.iter().all(is_place)
            && [self.length, self.progress].iter().all(|way| (0.0..=f64::MAX).contains(way))
            && self.speed.abs() <= MAX_SPEED
    }

    /// Returns the position at the present progress, m. It searches the line in the logarithm of their number.
    fn position(&self) -> Vector3<f64> {
        let Points { places, ways } = &self.points;
        let next = ways.partition_point(|&way| way <= self.progress);
        let Some((from, start)) = next.checked_sub(1).and_then(|it| Some((*places.get(it)?, *ways.get(it)?))) else {
            return Vector3::zeros();
        };
        let from = Vector3::from(from);
        let (to, length) = match (places.get(next), ways.get(next)) {
            (Some(&to), Some(end)) => (to, end - start),
            _ if self.is_loop => (places.first().copied().unwrap_or_default(), self.points.closing()),
            _ => return from,
        };
        if length > 0.0 { from + (Vector3::from(to) - from) * ((self.progress - start) / length) } else { from }
    }
}

impl Created {
    pub(super) fn id(&self) -> ObjectId {
        self.id
    }

    /// Returns its controller, which may have left.
    pub(super) fn by(&self) -> PawnId {
        self.by
    }

    /// True if its texts and numbers are such as orders give them. Saved ones may come from a stranger.
    pub(super) fn is_sound(&self) -> bool {
        let is_short = |text: &str| text.len() <= MAX_TEXT_BYTES;
        let [position, rotation] = self.start;
        is_short(&self.name)
            && is_short(&self.memory)
            && position.iter().all(|&it| check::MAP_REACH.holds(it))
            && rotation.iter().chain(&self.rotation).all(|angle| angle.is_finite())
            && self.spin.iter().all(|rate| rate.abs() <= MAX_RATE)
            && self.path.is_sound()
    }

    /// True if orders move it, and no force.
    fn is_led(&self) -> bool {
        self.path.is_followed() || self.spin != [0.0; 3]
    }
}

impl World {
    /// Follows an order of a world controller. Returns the answers to it.
    pub(super) fn control(
        &mut self,
        pawn: Option<PawnId>,
        order: &Control,
        problems: &mut Vec<Problem>,
    ) -> Vec<Message> {
        let Some(by) = pawn.filter(|pawn| self.controllers.contains_key(pawn)) else {
            problems.push(Problem::NoController);
            return Vec::new();
        };
        let done = match order {
            Control::Create(create) => self.create(by, create, problems),
            Control::Move(order) => self.put(by, order, problems),
            Control::Pull(order) => self.pull(by, order),
            Control::Rotate { name, speed } => self.rotate(by, name, *speed),
            Control::AddPoints { name, points } => self.add_points(by, name, points, problems),
            Control::SetPath(set) => self.set_path(by, set),
            Control::ClearPath { name } => self.clear_path(by, name),
            Control::Conveyor { name, speed } => self.set_conveyor(name, *speed),
            Control::Kill { name } => self.kill(by, name),
            Control::KillAll { corners } => {
                self.kill_all(*corners);
                Ok(())
            }
            Control::GetSta { class_name, name } => return vec![self.object_states(by, class_name, name, problems)],
            // The connection has said what is wrong with it.
            Control::Unknown { .. } => Ok(()),
        };
        if let Err(why) = done {
            let (order, name) = (order.type_name().to_owned(), shown(order.name()));
            problems.push(Problem::ObjectRefused { order, name, why });
        }
        Vec::new()
    }

    /// Returns class and name of the objects of controllers, by their ids.
    pub(super) fn created_ids(&self) -> BTreeMap<ObjectId, (&str, &str)> {
        self.created.iter().map(|created| (created.id, (created.class.as_str(), created.name.as_str()))).collect()
    }

    /// Removes the objects of a controller that leaves, except permanent ones.
    pub(super) fn remove_controller(&mut self, id: PawnId) {
        if self.controllers.remove(&id).is_some() {
            self.remove_created(|_, created| created.by == id && !created.permanent);
            self.let_go(id);
        }
    }

    /// Returns the objects that turn or follow a path, with their poses at the end of the coming step.
    pub(super) fn lead_objects(&mut self) -> Vec<(ObjectId, Pose)> {
        let time_step = self.options.time_step;
        let mut led = Vec::new();
        for created in self.created.iter_mut().filter(|created| created.is_led()) {
            let Some(now) = self.physics.object(created.id) else { continue };
            for (angle, rate) in created.rotation.iter_mut().zip(created.spin) {
                *angle += rate * time_step;
            }
            let mut position = now.translation.vector;
            let follows = created.path.is_followed();
            if follows && !created.path.advance(created.path.speed * time_step) {
                // The end of the path: back to the first pose.
                created.path.length = 0.0;
                created.rotation = created.start[1];
                self.physics.put_object(created.id, &scene::pose(created.start[0], created.start[1]));
                self.physics.hold_object(created.id, created.is_led() || !created.is_rigid);
                continue;
            }
            if follows {
                position = created.path.position();
            }
            let pose = scene::pose(position.into(), created.rotation);
            // The first step of a path may begin anywhere.
            if (position - now.translation.vector).norm() > 2.0 * created.path.speed.abs() * time_step + 1e-3 {
                self.physics.put_object(created.id, &pose);
            } else {
                led.push((created.id, pose));
            }
        }
        led
    }

    fn create(&mut self, by: PawnId, create: &Create, problems: &mut Vec<Problem>) -> Result<(), String> {
        let class = self.object_class(&create.class_name)?;
        if self.created_by(by, &create.name).is_some() {
            return Err("this controller has an object of that name".to_owned());
        }
        self.check_share(by, 1, MAX_OBJECTS, "objects", |_| 1)?;
        for (key, text) in [("Name", &create.name), ("Memory", &create.memory)] {
            if text.len() > MAX_TEXT_BYTES {
                return Err(format!("{key} is too long: got {} bytes, expected at most {MAX_TEXT_BYTES}", text.len()));
            }
        }
        // As in the original, an unknown material or start is no reason to leave the object out (WorldController.uc:277-318).
        let mut tell = |why: String| {
            let (order, name) = ("Create".to_owned(), shown(&create.name));
            problems.push(Problem::ObjectChanged { order, name, why });
        };
        let material = self.material(&create.material).unwrap_or_else(|why| {
            tell(format!("{why}; it has that of its class"));
            None
        });
        let (location, rotation) = self.object_start(create).unwrap_or_else(|why| {
            tell(format!("{why}; it is at the origin"));
            Default::default()
        });
        let mut def = self.def().objects.get(&class).cloned().ok_or("there is no such class")?;
        let [x, y, z] = create.scale;
        def.solid.shape = def.solid.shape.scaled(create.scale);
        def.mass *= x * y * z;
        (def.solid.position, def.solid.rotation) = (location, rotation);
        def.solid.material = material.unwrap_or(def.solid.material);
        def.solid.name.clone_from(&create.name);
        if let Some(wrong) = check::spawned_object(&def).into_iter().next() {
            return Err(wrong);
        }
        let wanted = scene::pose(location, rotation);
        self.enter_shapes();
        let pose = if create.is_rigid { self.physics.lifted(&def, &wanted) } else { wanted };
        if let Some(obstacle) = self.physics.obstacle(&def, &pose) {
            return Err(format!("{} is there", self.describe(obstacle)));
        }
        self.make_room("Create", &create.name, 1, MAX_OBJECTS, |_| 1, problems);
        let id = ObjectId(self.next_object);
        self.next_object += 1;
        self.physics.spawn_object(id, Arc::new(def), &pose, !create.is_rigid);
        self.created.push(Created {
            id,
            by,
            class,
            name: create.name.clone(),
            memory: create.memory.clone(),
            permanent: create.permanent,
            is_rigid: create.is_rigid,
            start: [pose.translation.vector.into(), rotation],
            spin: [0.0; 3],
            rotation,
            path: Path::default(),
        });
        Ok(())
    }

    /// Finds a class of objects, in any case. It may have any package: programs name their own.
    fn object_class(&self, class_name: &str) -> Result<String, String> {
        let class = class_name.rsplit('.').next().unwrap_or_default();
        let known = self.def().objects.keys().find(|known| known.eq_ignore_ascii_case(class));
        known.cloned().ok_or_else(|| {
            let all: Vec<&str> = self.def().objects.keys().map(String::as_str).collect();
            let meant = names::did_you_mean(class, all.iter().copied());
            format!("there is no class `{}`{meant}; expected one of {}", shown(class_name), all.join(", "))
        })
    }

    /// Finds a material of the scene by its name, behind its package and group. `None` if no name is given.
    fn material(&self, name: &str) -> Result<Option<Material>, String> {
        let name = name.rsplit('.').next().unwrap_or_default();
        if name.is_empty() {
            return Ok(None);
        }
        let def = self.def();
        let objects = def.map.objects.iter().chain(def.objects.values()).map(|object| &object.solid);
        let materials = || def.map.solids.iter().chain(objects.clone()).map(|solid| &solid.material);
        let found = materials().find(|material| material.name.eq_ignore_ascii_case(name)).cloned();
        found.map(Some).ok_or_else(|| {
            let known: std::collections::BTreeSet<&str> = materials().map(|material| material.name.as_str()).collect();
            let known = known.into_iter().collect::<Vec<_>>().join(", ");
            format!("this world has no material `{}`: expected one of {known}", shown(name))
        })
    }

    /// Returns the position and rotation at which an object is wanted.
    fn object_start(&self, create: &Create) -> Result<([f64; 3], [f64; 3]), String> {
        if create.start.is_empty() {
            return Ok((create.location, create.rotation));
        }
        let start = self.def().map.start(&create.start).ok_or_else(|| {
            let known: Vec<&str> = self.def().map.starts.iter().map(|start| start.name.as_str()).collect();
            format!("there is no start `{}`: expected one of {}", shown(&create.start), known.join(", "))
        })?;
        Ok((start.position, start.rotation))
    }

    fn put(&mut self, by: PawnId, order: &Move, problems: &mut Vec<Problem>) -> Result<(), String> {
        let Move { name, is_relative, location, rotation } = order;
        let add = |a: [f64; 3], b: &[f64; 3]| std::array::from_fn(|axis| a[axis] + b[axis]);
        let wanted = |now: &Pose| match scene::position_and_rotation(now) {
            (position, angles) if *is_relative => (add(position, location), add(angles, rotation)),
            _ => (*location, *rotation),
        };
        let in_reach = |position: &[f64; 3]| {
            let wrong = check::MAP_REACH.problem_in("Location", position);
            wrong.map_or(Ok(()), Err)
        };
        if let Some(id) = self.object_of(by, name) {
            let now = self.physics.object(id).ok_or("a robot holds it")?;
            let (position, angles) = wanted(&now);
            in_reach(&position)?;
            self.physics.put_object(id, &scene::pose(position, angles));
            if let Some(created) = self.created.iter_mut().find(|created| created.id == id) {
                created.rotation = angles;
            }
            return Ok(());
        }
        let id = self.robot_of(name).ok_or("no object or robot has that name")?;
        let now = self.observe(id).ok_or("it is gone")?.body.pose;
        let (position, angles) = wanted(&now);
        in_reach(&position)?;
        self.put_robot(id, &scene::pose(position, angles), problems)
    }

    /// Checks that a controller that gets `more` would have no more than what is left for others. So nobody can have everything.
    /// What controllers left behind counts as free. `amount` is an object's.
    fn check_share(
        &self,
        by: PawnId,
        more: usize,
        most: usize,
        what: &str,
        amount: impl Fn(&Created) -> usize,
    ) -> Result<(), String> {
        let sum = |of: &dyn Fn(&Created) -> bool| -> usize {
            self.created.iter().filter(|created| of(created)).map(&amount).sum()
        };
        let own = sum(&|created| created.by == by);
        let free = most.saturating_sub(sum(&|created| self.controllers.contains_key(&created.by)) + more);
        if own + more <= free {
            return Ok(());
        }
        Err(format!(
            "this controller would have {} {what} and leave {free} to all others: expected at most as many as it leaves; \
             all together have at most {most}",
            own + more
        ))
    }

    /// Removes the oldest objects whose controllers have left, until there is room for `more`.
    fn make_room(
        &mut self,
        order: &str,
        name: &str,
        more: usize,
        most: usize,
        amount: impl Fn(&Created) -> usize,
        problems: &mut Vec<Problem>,
    ) {
        let mut excess = (self.created.iter().map(&amount).sum::<usize>() + more).saturating_sub(most);
        let left_behind = self.created.iter().filter(|created| !self.controllers.contains_key(&created.by));
        let mut removed: Vec<(ObjectId, String)> = Vec::new();
        for created in left_behind.filter(|created| amount(created) > 0) {
            if excess == 0 {
                break;
            }
            excess = excess.saturating_sub(amount(created));
            removed.push((created.id, shown(&created.name)));
        }
        let Some((_, first)) = removed.first() else { return };
        let others = match removed.len() - 1 {
            0 => String::new(),
            others => format!(" and {others} more"),
        };
        let why = format!("the world is full: the object `{first}`{others}, whose controller has left, is removed");
        problems.push(Problem::ObjectChanged { order: order.to_owned(), name: shown(name), why });
        self.created.retain(|created| !removed.iter().any(|(id, _)| *id == created.id));
        removed.into_iter().for_each(|(id, _)| self.remove_object(id));
    }

    fn rotate(&mut self, by: PawnId, name: &str, speed: [f64; 3]) -> Result<(), String> {
        if let Some(rate) = speed.iter().find(|rate| rate.abs() > MAX_RATE) {
            return Err(format!("got {rate} rad/s, expected at most {MAX_RATE}"));
        }
        // The axes of roll and yaw are the same at a pitch of a quarter turn.
        let [roll, pitch, yaw] = speed.map(f64::abs);
        let rate = (pitch * pitch + (roll + yaw) * (roll + yaw)).sqrt();
        let id = self.created_by(by, name).map(|created| created.id);
        let object = self.physics.objects().find(|object| Some(object.id) == id);
        let reach = object.map_or(0.0, |object| object.def.solid.shape.reach());
        if rate * reach > MAX_SPEED {
            let (got, most) = (rate * reach, MAX_SPEED / reach);
            return Err(format!(
                "its farthest point, {reach:.2} m from its centre, would move at {got:.0} m/s: \
                 expected at most {MAX_SPEED} m/s, which is {most:.2} rad/s"
            ));
        }
        self.change(by, name, |created| created.spin = speed)
    }

    fn add_points(
        &mut self,
        by: PawnId,
        name: &str,
        points: &[[f64; 3]],
        problems: &mut Vec<Problem>,
    ) -> Result<(), String> {
        if let Some(wrong) = points.iter().find_map(|point| check::MAP_REACH.problem_in("WP", point)) {
            return Err(wrong);
        }
        let of_path = |created: &Created| created.path.points.len();
        let own = self.created_by(by, name).map_or(0, of_path);
        if own + points.len() > MAX_POINTS {
            let got = own + points.len();
            return Err(format!("its path would have {got} points: expected at most {MAX_POINTS}"));
        }
        self.check_share(by, points.len(), MAX_ALL_POINTS, "points of paths", of_path)?;
        self.change(by, name, |created| {
            created.path.points.extend(points);
            created.path.measure();
        })?;
        self.make_room("AddWP", name, 0, MAX_ALL_POINTS, of_path, problems);
        Ok(())
    }

    fn set_path(&mut self, by: PawnId, set: &SetPath) -> Result<(), String> {
        let &SetPath { speed, is_loop, moving, time, .. } = set;
        if let Some(speed) = speed.filter(|speed| speed.abs() > MAX_SPEED) {
            return Err(format!("got {speed} m/s, expected at most {MAX_SPEED}"));
        }
        self.change(by, &set.name, |created| {
            let path = &mut created.path;
            path.speed = speed.unwrap_or(path.speed);
            path.moving = moving.unwrap_or(path.moving);
            if let Some(is_loop) = is_loop {
                path.is_loop = is_loop;
                path.measure();
            }
            if let Some(time) = time {
                path.progress = (time * path.speed).clamp(0.0, path.length);
            }
        })
    }

    fn clear_path(&mut self, by: PawnId, name: &str) -> Result<(), String> {
        let mut cleared = None;
        self.change(by, name, |created| {
            if created.path.points.len() > 0 {
                created.path = Path::default();
                created.rotation = created.start[1];
                cleared = Some((created.id, created.start));
            }
        })?;
        if let Some((id, [position, rotation])) = cleared {
            self.physics.put_object(id, &scene::pose(position, rotation));
        }
        Ok(())
    }

    /// Finds a controller's own object by its name, in any case.
    fn created_by(&self, by: PawnId, name: &str) -> Option<&Created> {
        self.created.iter().find(|created| created.by == by && created.name.eq_ignore_ascii_case(name))
    }

    /// Changes an object of a controller. Orders hold it while they move it.
    fn change(&mut self, by: PawnId, name: &str, change: impl FnOnce(&mut Created)) -> Result<(), String> {
        let is_it = |created: &&mut Created| created.by == by && created.name.eq_ignore_ascii_case(name);
        let created = self.created.iter_mut().find(is_it).ok_or("this controller has no object of that name")?;
        let was_led = created.is_led();
        change(created);
        let (id, is_led, is_rigid) = (created.id, created.is_led(), created.is_rigid);
        if is_led != was_led {
            if let Some(pose) = self.physics.object(id).filter(|_| is_led) {
                created.rotation = scene::position_and_rotation(&pose).1;
            }
            self.physics.hold_object(id, is_led || !is_rigid);
        }
        Ok(())
    }

    /// Sets the conveyors of a name to a multiple of their velocity on the map.
    fn set_conveyor(&mut self, name: &str, factor: f64) -> Result<(), String> {
        let map = &self.scene.def().map;
        let conveyors = || {
            map.conveyors.iter().enumerate().filter_map(|(number, it)| {
                Some((number, map.solids.get(it.solid)?.name.as_str(), Vector3::from(it.velocity).norm()))
            })
        };
        let meant: Vec<_> = conveyors().filter(|(_, known, _)| known.eq_ignore_ascii_case(name)).collect();
        if meant.is_empty() {
            let known: Vec<&str> = conveyors().map(|(_, known, _)| known).collect();
            let expected = if known.is_empty() {
                "the map has none".to_owned()
            } else {
                format!("expected one of {}", known.join(", "))
            };
            return Err(format!("there is no such conveyor: {expected}"));
        }
        if let Some(speed) =
            meant.iter().map(|(_, _, speed)| speed * factor.abs()).find(|speed| !(0.0..=MAX_SPEED).contains(speed))
        {
            return Err(format!("got {speed} m/s, expected at most {MAX_SPEED}"));
        }
        meant.into_iter().for_each(|(number, ..)| self.physics.set_conveyor(number, factor));
        Ok(())
    }

    fn kill(&mut self, by: PawnId, name: &str) -> Result<(), String> {
        let id = self.object_of(by, name).ok_or("no object has that name")?;
        self.created.retain(|created| created.id != id);
        self.remove_object(id);
        Ok(())
    }

    /// Removes all objects of controllers that are not permanent, or those in a box.
    fn kill_all(&mut self, corners: Option<[[f64; 3]; 2]>) {
        let is_inside = |pose: Pose| {
            let Some([[x, y, z], [to_x, to_y, to_z]]) = corners else { return true };
            let at = pose.translation;
            at.x > x && at.y > y && at.z < z && at.x < to_x && at.y < to_y && at.z > to_z
        };
        self.remove_created(|world, created| !created.permanent && world.place_of(created.id).is_some_and(is_inside));
    }

    fn remove_created(&mut self, is_removed: impl Fn(&Self, &Created) -> bool) {
        let removed = self.created.iter().filter(|created| is_removed(self, created)).map(|created| created.id);
        let removed: Vec<ObjectId> = removed.collect();
        self.created.retain(|created| !removed.contains(&created.id));
        removed.into_iter().for_each(|id| self.remove_object(id));
    }

    /// Finds an object by its name, in any case: first among the controller's own, then among all others, those of the map included.
    pub(super) fn object_of(&self, by: PawnId, name: &str) -> Option<ObjectId> {
        let is_named = |created: &&Created| created.name.eq_ignore_ascii_case(name);
        let own = self.created.iter().filter(|created| created.by == by).find(is_named);
        let created = own.or_else(|| self.created.iter().find(is_named)).map(|created| created.id);
        created.or_else(|| self.objects().find(|it| it.def.solid.name.eq_ignore_ascii_case(name)).map(|it| it.id))
    }

    /// Finds a robot by its name, or one without a name by its number, as `#3`.
    pub(super) fn robot_of(&self, name: &str) -> Option<PawnId> {
        let named = self.robots.values().find(|robot| robot.name() == name).map(|robot| robot.id());
        let numbered = || name.strip_prefix('#')?.parse().ok().map(PawnId).filter(|id| self.robots.contains_key(id));
        named.or_else(numbered)
    }

    /// Answers a question for the states of a controller's objects: those that fit into one line, the oldest first.
    fn object_states(&self, by: PawnId, class_name: &str, name: &str, problems: &mut Vec<Problem>) -> Message {
        let class = class_name.rsplit('.').next().unwrap_or_default();
        let is_meant = |created: &&Created| {
            let is_of_class = class.is_empty() || class == "WCObject" || created.class.eq_ignore_ascii_case(class);
            created.by == by && is_of_class && (name.is_empty() || created.name == name)
        };
        let objects: Vec<ObjectSnapshot> = self.objects().collect();
        let state = |created: &Created| {
            let object = &objects[objects.binary_search_by_key(&created.id, |object| object.id).ok()?];
            let (location, rotation) = scene::position_and_rotation(&object.pose);
            let size = extents(&object.def, &object.pose);
            Some(ObjectSta {
                name: created.name.clone(),
                size: floats(size.into()),
                location: floats(location),
                memory: created.memory.clone(),
                rotation: floats(rotation),
            })
        };
        let mut states: Vec<ObjectSta> = self.created.iter().filter(is_meant).filter_map(state).collect();
        let (all, told) = (states.len(), objects_that_fit(&states));
        if told < all {
            let why = format!(
                "the answer has the first {told} of {all} objects, as a line has at most {MAX_OBJECTS_BYTES} bytes; \
                 ask for the others by ClassName or Name"
            );
            problems.push(Problem::ObjectChanged { order: "GetSTA".to_owned(), name: shown(name), why });
            states.truncate(told);
        }
        Message::Objects(states)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the position on a path by adding up its lines from the first.
    fn added_up(path: &Path) -> Vector3<f64> {
        let places: Vec<Vector3<f64>> = path.points.places.iter().map(|&place| place.into()).collect();
        let mut left = path.progress;
        let closing = places.last().zip(places.first()).filter(|_| path.is_loop);
        for (from, to) in places.iter().zip(places.iter().skip(1)).chain(closing) {
            let length = (to - from).norm();
            if left < length {
                return from + (to - from) * (left / length);
            }
            left -= length;
        }
        *places.last().expect("a point")
    }

    #[test]
    fn a_position_on_a_path_is_that_of_its_lines_added_up() {
        let point = |number: i32| {
            let number = f64::from(number);
            // Every fifth point is there twice.
            [(number / 5.0).floor() + number, (number * number) % 7.0, -number / 3.0]
        };
        for (count, is_loop) in [(1, false), (1, true), (2, true), (50, false), (50, true), (4096, true)] {
            let places: Vec<_> = (0..count).flat_map(|it| vec![point(it); if it % 5 == 0 { 2 } else { 1 }]).collect();
            let mut path = Path { points: places.into(), is_loop, ..Path::default() };
            path.measure();
            for share in [0.0, 1e-9, 0.1, 0.3, 0.5, 0.77, 0.999_999, 1.0] {
                path.progress = path.length * share;
                let (got, expected) = (path.position(), added_up(&path));
                let distance = (got - expected).norm();
                // At its very end a loop is at its first point, which adding up may miss by rounding.
                let is_end = share == 1.0 && is_loop;
                assert!(distance < 1e-8 || is_end, "{count}, {share}: {got} instead of {expected}");
            }
        }
    }
}
