//! The channels of our own log: lines and states, and Foxglove's messages to show them. `docs/logs.md` lists the channels. The
//! frame `map` is z up. The frame `world` in it, half a turn about x, is the wire's: x forward, y right, z down. Every number
//! but that one transform is in `world`, in the robot (x forward, y right, z down) or in the sensor.

use foxglove::messages::log::Level;
use foxglove::messages::scene_entity_deletion::Type as DeletionType;
use foxglove::messages::{
    self as fox, FrameTransform, FrameTransforms, JointState, JointStates, PoseInFrame, SceneEntityDeletion,
    SceneUpdate, Timestamp,
};
use mcap::McapResult;
use scene::{MapDef, Pose, Reading, RobotDef, Sensed, WorldDef};

use crate::file::nanoseconds;
use crate::slots::{Slots, Slotted};
use crate::{
    LEAGUE, LEFT, LeagueScore, LeagueStandings, OBJECTS, ObjectSpawned, ObjectState, PictureTaken, Publish, Record,
    RobotLeft, RobotState, SensorReading, drawing,
};

/// Converts records to messages.
pub(crate) struct Native {
    world: WorldDef,
    /// Robots that have been drawn.
    slots: Slots,
    /// Objects beside the map's that have been drawn.
    objects: Slots,
}

impl Native {
    /// Publishes the static messages: the transform of the world, and the map.
    pub(crate) fn new(world: &WorldDef, file: &mut impl Publish) -> McapResult<Self> {
        let upside_down = scene::pose([0.0; 3], [std::f64::consts::PI, 0.0, 0.0]);
        file.publish(0.0, "/tf_static", &transforms(vec![transform(0.0, "map", "world", &upside_down)]))?;
        file.publish(0.0, "/map/scene", &added(0.0, drawing::map(&world.map)))?;
        draw_objects(0.0, &world.map, file)?;
        Ok(Self { world: world.clone(), slots: Slots::default(), objects: Slots::default() })
    }

    /// Returns the number of the map's objects.
    pub(crate) fn objects_of_map(&self) -> u64 {
        self.world.map.objects.len() as u64
    }

    pub(crate) fn write(&mut self, time: f64, record: &Record, file: &mut impl Publish) -> McapResult<()> {
        match record {
            Record::In(line) => file.publish(time, "/wire/in", line),
            Record::Out(line) => file.publish(time, "/wire/out", line),
            Record::Sensed(sensed) => self.write_reading(time, sensed, file),
            Record::Closed(line) => {
                file.publish(time, "/wire/closed", line)?;
                let text = format!("connection {} ended", line.connection);
                file.publish(time, "/log", &log(time, Level::Info, text))
            }
            Record::Left(robot) => self.write_left(time, *robot, file),
            Record::State(state) => self.write_state(time, state, file),
            Record::Object(object) => self.write_object(time, object, file),
            Record::ObjectSpawned(object) => self.write_spawned(time, object, file),
            Record::ObjectRemoved(object) => {
                file.publish(time, OBJECTS[1], object)?;
                let (number, of_map) = (u64::from(object.object), self.world.map.objects.len() as u64);
                let slot = self.objects.leave(number).map(|slot| of_map + slot);
                let place = slot.or((number < of_map).then_some(number));
                place.map_or(Ok(()), |place| erase_object(time, place, file))
            }
            Record::Picture(taken, png) => self.write_picture(time, taken, png, file),
            Record::Map(map) => {
                let erased = SceneUpdate { deletions: vec![deletion(time)], entities: drawing::map(map) };
                file.publish(time, "/map/scene", &erased)?;
                let before = self.world.map.objects.len() as u64;
                (0..before).try_for_each(|place| erase_object(time, place, file))?;
                self.world.map = (**map).clone();
                draw_objects(time, map, file)
            }
            Record::Scored(score) => {
                file.publish(time, LEAGUE[0], &LeagueScore::new(score))?;
                file.publish(time, "/log", &log(time, Level::Info, score.to_string()))
            }
            Record::Standings(standings) => file.publish(time, LEAGUE[1], &LeagueStandings::new(standings)),
            Record::Warning(text) => file.publish(time, "/log", &log(time, Level::Warning, text.clone())),
        }
    }

    fn write_state(&mut self, time: f64, state: &RobotState, file: &mut impl Publish) -> McapResult<()> {
        let RobotState { robot, class, .. } = state;
        let slot = match self.slots.get(*robot) {
            Some(slotted) => slotted.slot,
            None => self.write_come(time, state, file)?,
        };
        let (frame, pose) = (robot_frame(slot), state.pose());
        let topic = |name: &str| topic(slot, name);
        file.publish(time, &topic("state"), state)?;
        let in_world = PoseInFrame {
            timestamp: Some(timestamp(time)),
            frame_id: "world".to_owned(),
            pose: Some(drawing::fox_pose(&pose)),
        };
        file.publish(time, &topic("pose"), &in_world)?;
        let def = self.world.robots.get(class);
        let states = state.joints();
        let names = def.into_iter().flat_map(RobotDef::with_values).map(|link| link.name.clone());
        let joints = names.zip(&states).map(|(name, joint)| JointState {
            name,
            position: Some(joint.position),
            velocity: Some(joint.speed),
            ..JointState::default()
        });
        let joints = JointStates { timestamp: Some(timestamp(time)), joints: joints.collect() };
        file.publish(time, &topic("joints"), &joints)?;
        let links = def.into_iter().flat_map(|def| def.placed_links(&states)).skip(1);
        let links = links.map(|(link, pose)| transform(time, &frame, &format!("{frame}/{}", link.name), &pose));
        let all = std::iter::once(transform(time, "world", &frame, &pose)).chain(links).collect();
        file.publish(time, &topic("tf"), &transforms(all))
    }

    /// Publishes a robot that is new. Returns its slot.
    fn write_come(&mut self, time: f64, state: &RobotState, file: &mut impl Publish) -> McapResult<u64> {
        let RobotState { robot, class, name, .. } = state;
        let slot = self.slots.come(*robot, class);
        let text = format!("robot {robot} came: {class} {name}");
        file.publish(time, "/log", &log(time, Level::Info, text.trim_end().to_owned()))?;
        let Some(def) = self.world.robots.get(class) else { return Ok(slot) };
        let frame = robot_frame(slot);
        let mount = |sensor: &scene::SensorDef| {
            let (number, link, pose) = def.mount_of(sensor)?;
            let parent = if number == 0 { frame.clone() } else { format!("{frame}/{}", link.name) };
            Some(transform(time, &parent, &format!("{frame}/{}", sensor.name), &pose))
        };
        let mounts = transforms(def.sensors.iter().filter_map(mount).collect());
        file.publish(time, &topic(slot, "tf_static"), &mounts)?;
        file.publish(time, &topic(slot, "scene"), &added(time, drawing::robot(&frame, def)))?;
        Ok(slot)
    }

    fn write_left(&mut self, time: f64, robot: u64, file: &mut impl Publish) -> McapResult<()> {
        file.publish(time, LEFT, &RobotLeft { robot })?;
        // A robot without a slot left before its first state.
        let Some(slot) = self.slots.leave(robot) else { return Ok(()) };
        file.publish(time, "/log", &log(time, Level::Info, format!("robot {robot} left")))?;
        erase(time, slot, file)
    }

    /// Erases every robot and spawned object, because a fresh world begins.
    pub(crate) fn start_over(&mut self, time: f64, file: &mut impl Publish) -> McapResult<()> {
        self.slots.clear().try_for_each(|slot| erase(time, slot, file))?;
        let of_map = self.world.map.objects.len() as u64;
        self.objects.clear().try_for_each(|slot| erase_object(time, of_map + slot, file))?;
        // Some of the map's objects may have been removed.
        draw_objects(time, &self.world.map, file)
    }

    fn write_object(&self, time: f64, object: &ObjectState, file: &mut impl Publish) -> McapResult<()> {
        let number = u64::from(object.object);
        let of_map = self.world.map.objects.len() as u64;
        let place = self.objects.get(number).map_or(number, |slotted| of_map + slotted.slot);
        file.publish(time, &format!("/map/object/{place}"), object)?;
        let placed = transform(time, "world", &drawing::object_frame(place as usize), &object.pose());
        file.publish(time, &format!("/map/object/{place}/tf"), &transforms(vec![placed]))
    }

    fn write_spawned(&mut self, time: f64, object: &ObjectSpawned, file: &mut impl Publish) -> McapResult<()> {
        file.publish(time, OBJECTS[0], object)?;
        let place = self.world.map.objects.len() as u64 + self.objects.come(object.object.into(), "");
        let Some(def) = object.def() else { return Ok(()) };
        let drawn = drawing::object(place as usize, &def.solid);
        file.publish(time, &format!("/map/object/{place}/scene"), &added(time, vec![drawn]))
    }

    fn write_picture(&self, time: f64, taken: &PictureTaken, png: &[u8], file: &mut impl Publish) -> McapResult<()> {
        let Some(Slotted { slot, class }) = self.slots.get(taken.robot) else { return Ok(()) };
        let sensor = self.world.robots.get(class).and_then(|def| def.sensors.get(taken.sensor as usize));
        let Some(sensor) = sensor else { return Ok(()) };
        let topic = |kind: &str| topic(*slot, &format!("sensor/{}/{kind}", sensor.name));
        file.publish(time, &topic("picture"), taken)?;
        let image = fox::CompressedImage {
            timestamp: Some(timestamp(taken.moment)),
            frame_id: format!("{}/{}", robot_frame(*slot), sensor.name),
            data: png.to_vec().into(),
            format: "png".to_owned(),
        };
        file.publish(time, &topic("image"), &image)
    }

    /// Publishes a reading, and the scan of a level laser for Foxglove.
    fn write_reading(&self, time: f64, sensed: &Sensed, file: &mut impl Publish) -> McapResult<()> {
        let Some(Slotted { slot, class }) = self.slots.get(sensed.robot.0) else { return Ok(()) };
        let sensor = self.world.robots.get(class).and_then(|def| def.sensors.get(sensed.sensor));
        let Some(sensor) = sensor else { return Ok(()) };
        let name = &sensor.name;
        file.publish(time, &topic(*slot, &format!("sensor/{name}/reading")), &SensorReading::new(sensed))?;
        let Reading::RangeScanner(scan) = &sensed.reading else { return Ok(()) };
        let Some(fan) = sensor.config.fan().filter(|fan| fan.level) else { return Ok(()) };
        let steps = scan.ranges.len().saturating_sub(1) as f64;
        let scan = fox::LaserScan {
            timestamp: Some(timestamp(time)),
            frame_id: format!("{}/{name}", robot_frame(*slot)),
            pose: Some(drawing::fox_pose(&Pose::identity())),
            // From the right to the left; z is down, so the right is positive.
            start_angle: fan.first,
            end_angle: fan.first - steps * fan.resolution,
            ranges: scan.ranges.to_vec(),
            intensities: Vec::new(),
        };
        file.publish(time, &topic(*slot, &format!("sensor/{name}")), &scan)
    }
}

/// Draws the objects of a map, each on a channel of its own.
fn draw_objects(time: f64, map: &MapDef, file: &mut impl Publish) -> McapResult<()> {
    map.objects.iter().enumerate().try_for_each(|(place, object)| {
        let drawn = drawing::object(place, &object.solid);
        file.publish(time, &format!("/map/object/{place}/scene"), &added(time, vec![drawn]))
    })
}

/// Erases the drawing of an object, by its place.
fn erase_object(time: f64, place: u64, file: &mut impl Publish) -> McapResult<()> {
    let erased = SceneUpdate { deletions: vec![deletion(time)], entities: Vec::new() };
    file.publish(time, &format!("/map/object/{place}/scene"), &erased)?;
    file.forget(&format!("/map/object/{place}/"));
    Ok(())
}

/// Erases the drawing of a robot.
fn erase(time: f64, slot: u64, file: &mut impl Publish) -> McapResult<()> {
    let erased = SceneUpdate { deletions: vec![deletion(time)], entities: Vec::new() };
    file.publish(time, &topic(slot, "scene"), &erased)?;
    file.forget(&topic(slot, ""));
    Ok(())
}

/// Deletes everything on a channel.
fn deletion(time: f64) -> SceneEntityDeletion {
    SceneEntityDeletion {
        timestamp: Some(timestamp(time)),
        r#type: DeletionType::All as i32,
        ..SceneEntityDeletion::default()
    }
}

fn robot_frame(slot: u64) -> String {
    format!("robot/{slot}")
}

fn topic(slot: u64, name: &str) -> String {
    format!("/robot/{slot}/{name}")
}

fn timestamp(time: f64) -> Timestamp {
    let nanoseconds = nanoseconds(time);
    Timestamp::new((nanoseconds / 1_000_000_000) as u32, (nanoseconds % 1_000_000_000) as u32)
}

fn transform(time: f64, parent: &str, child: &str, pose: &Pose) -> FrameTransform {
    let fox::Pose { position, orientation } = drawing::fox_pose(pose);
    FrameTransform {
        timestamp: Some(timestamp(time)),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: position,
        rotation: orientation,
    }
}

fn transforms(transforms: Vec<FrameTransform>) -> FrameTransforms {
    FrameTransforms { transforms }
}

/// Adds entities, which stay until they are deleted.
fn added(time: f64, mut entities: Vec<fox::SceneEntity>) -> SceneUpdate {
    for entity in &mut entities {
        entity.timestamp = Some(timestamp(time));
        entity.lifetime = Some(fox::Duration::new(0, 0));
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

fn log(time: f64, level: Level, message: String) -> fox::Log {
    fox::Log {
        timestamp: Some(timestamp(time)),
        level: level as i32,
        message,
        name: "usarsim".to_owned(),
        ..fox::Log::default()
    }
}
