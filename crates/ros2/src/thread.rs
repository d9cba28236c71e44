//! The thread of the node: it publishes what the world tells, and keeps the tasks that listen.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use ros2_topics::{Sink, State, Topics, camera_info, header, interfaces as ros};
use scene::{JointState, MapDef, ObjectId, Pose, RobotDef, RobotSnapshot, Snapshot};
use served_world::Entrance;
use sim_core::CompiledScene;
use tokio::sync::mpsc::{Receiver, unbounded_channel};
use tokio::task::{JoinHandle, LocalSet};
use tokio::time::MissedTickBehavior;
use tracing::warn;

use crate::cameras::{Cameras, Drawn, SIZE};
use crate::clock::Clock;
use crate::feed::{Item, Status, Wanted};
use crate::node::Node;
use crate::orders::{self, Driver, Listening, Present};
use crate::rosbridge::Said;
use crate::services::{Desk, Latest, Replies};
use crate::{Options, operations};

/// Real time between two looks at which cameras somebody wants.
const LOOK_INTERVAL: Duration = Duration::from_millis(200);
/// Most objects that are all told of now and then: more do not fit into one message that arrives whole.
const MOST_OBJECTS: usize = 256;
/// Levels of diagnostics (diagnostic_msgs/msg/DiagnosticStatus).
const OK: u8 = 0;
const WARN: u8 = 1;

/// Settings of the thread, and state that it shares with others.
pub(crate) struct Shared {
    pub(crate) options: Options,
    /// One wheel-speed unit of the protocol, rad/s.
    pub(crate) unit: f64,
    pub(crate) entrance: Entrance,
    pub(crate) wanted: Wanted,
    pub(crate) clock: Clock,
}

/// Runs the node until the world's end of the feed is gone.
pub(crate) fn run(node: Node, items: Receiver<Item>, said: Receiver<Said>, shared: Shared) {
    let runtime = match tokio::runtime::Builder::new_current_thread().enable_time().build() {
        Ok(runtime) => runtime,
        Err(error) => return warn!("ROS 2: {error}"),
    };
    runtime.block_on(LocalSet::new().run_until(serve(node, items, said, shared)));
}

async fn serve(node: Node, mut items: Receiver<Item>, mut said: Receiver<Said>, shared: Shared) {
    let (drawn, mut pictures) = unbounded_channel();
    let (replies, mut replied) = unbounded_channel();
    let mut look = tokio::time::interval(LOOK_INTERVAL);
    look.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut bridge = Bridge::new(node, Cameras::new(drawn), shared, &replies);
    loop {
        tokio::select! {
            // Orders have their turn between two items, as their tasks are woken meanwhile.
            item = items.recv() => match item {
                Some(item) => bridge.take(item),
                None => break,
            },
            event = bridge.node.heard() => bridge.node.take(event),
            Some(reply) = replied.recv() => bridge.node.reply(reply),
            Some(said) = said.recv() => operations::take(&mut bridge.node, said),
            Some(picture) = pictures.recv() => bridge.show(picture),
            _ = look.tick() => {
                bridge.look();
                bridge.node.watch();
            }
        }
        tokio::task::yield_now().await;
    }
    // Tasks end first, then the process leaves its domain.
    let Bridge { node, robots, services, .. } = bridge;
    drop(robots);
    services.iter().for_each(JoinHandle::abort);
    drop(node);
}

/// The world in ROS.
struct Bridge {
    node: Node,
    topics: Topics,
    cameras: Cameras,
    shared: Shared,
    robots: BTreeMap<u64, Robot>,
    /// Poses of objects as they were published last.
    objects: BTreeMap<ObjectId, Pose>,
    /// The newest scene, for services, and what they know of the world.
    scene: Option<CompiledScene>,
    latest: Latest,
    /// Tasks of the services.
    services: Vec<JoinHandle<()>>,
    /// Simulated and real time of the last status, and the messages that had been left out.
    last: Option<(f64, Instant, u64)>,
}

/// A robot that others can listen to and order.
struct Robot {
    joints: Arc<Mutex<Vec<JointState>>>,
    /// The sensors that are cameras, with their topics.
    cameras: Vec<(usize, String)>,
    _listening: Listening,
}

impl Bridge {
    fn new(mut node: Node, cameras: Cameras, shared: Shared, replies: &Replies) -> Self {
        node.open::<ros::Clock>("/clock");
        node.open::<ros::TFMessage>("/tf");
        node.open::<ros::TFMessage>("/tf_static");
        node.open::<ros::DiagnosticArray>("/diagnostics");
        let topics = topics(&shared.options, &MapDef::default());
        let (robots, objects) = (BTreeMap::new(), BTreeMap::new());
        let (scene, latest, last) = (None, Latest::default(), None);
        let services = if shared.options.may_control {
            Desk::new(&shared.entrance, latest.clone(), &shared.options).open(&mut node, replies)
        } else {
            Vec::new()
        };
        Self { node, topics, cameras, shared, robots, objects, scene, latest, services, last }
    }

    fn take(&mut self, item: Item) {
        match item {
            Item::StartOver(scene) => {
                let robots: Vec<u64> = self.robots.keys().copied().collect();
                robots.into_iter().for_each(|robot| self.leave(robot));
                self.topics = topics(&self.shared.options, &scene.def().map);
                self.scene = Some(scene);
                self.objects.clear();
                self.last = None;
            }
            Item::Came { robot, name, def } => self.come(robot, &name, &def),
            Item::Clock(time) => done(self.topics.publish_clock(time, &mut self.node)),
            Item::State(snapshot) => {
                self.publish_state(&snapshot);
                self.follow(snapshot);
            }
            Item::Still(snapshot) => self.follow(snapshot),
            Item::Status(status) => self.publish_status(&status),
            Item::Sensed(time, sensed) => {
                self.node.own(Some(sensed.robot.0));
                done(self.topics.publish_reading(time, &sensed, &mut self.node));
            }
            Item::View(view) => self.cameras.draw(view),
        }
    }

    fn come(&mut self, robot: u64, name: &str, def: &RobotDef) {
        self.leave(robot);
        self.node.own(Some(robot));
        let Shared { options, unit, entrance, clock, .. } = &self.shared;
        let controllers = &options.controllers;
        let controller = controllers.iter().find(|(class, _)| *class == def.class).map(|(_, controller)| controller);
        done(self.topics.come(clock.time(), robot, name, def, controller.cloned(), &mut self.node));
        let Some(space) = self.topics.space(robot) else { return };
        let joints = Arc::<Mutex<Vec<JointState>>>::default();
        let present = Present { clock: clock.clone(), joints: joints.clone() };
        let driver = Driver::of(def, controller, *unit);
        let listening = orders::listen(robot, def, space, driver, &mut self.node, entrance, &present);
        let mut cameras = Vec::new();
        for sensor in 0..def.sensors.len() {
            if let Some([pictures, numbers, _]) = self.topics.camera(robot, sensor) {
                self.node.open::<ros::CompressedImage>(&pictures);
                self.node.open::<ros::CameraInfo>(&numbers);
                cameras.push((sensor, pictures));
            }
        }
        self.robots.insert(robot, Robot { joints, cameras, _listening: listening });
    }

    fn leave(&mut self, robot: u64) {
        if self.robots.remove(&robot).is_some() {
            self.topics.leave(robot);
            self.node.close(Some(robot));
        }
    }

    /// Follows the world to a snapshot: robots that are missing have left, and services know it.
    fn follow(&mut self, snapshot: Arc<Snapshot>) {
        let gone = |robot: &u64| !snapshot.robots.iter().any(|seen| seen.id.0 == *robot);
        let gone: Vec<u64> = self.robots.keys().copied().filter(gone).collect();
        gone.into_iter().for_each(|robot| self.leave(robot));
        let latest = self.scene.clone().map(|scene| (scene, snapshot));
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = latest;
    }

    fn publish_state(&mut self, snapshot: &Snapshot) {
        for RobotSnapshot { id, body, joints, .. } in &snapshot.robots {
            let Some(robot) = self.robots.get(&id.0) else { continue };
            robot.joints.lock().unwrap_or_else(PoisonError::into_inner).clone_from(joints);
            self.node.own(Some(id.0));
            let state = State { pose: body.pose, linear: body.linear, angular: body.angular, joints };
            done(self.topics.publish_state(snapshot.time, id.0, &state, &mut self.node));
        }
        self.node.own(None);
        for object in &snapshot.objects {
            if self.objects.insert(object.id, object.pose) != Some(object.pose) {
                self.topics.place_object(snapshot.time, object.id.0, &object.pose);
            }
        }
        done(self.topics.publish_transforms(snapshot.time, &mut self.node));
    }

    /// Publishes the batteries of robots, and how the world does.
    fn publish_status(&mut self, status: &Status) {
        let Status { time, unsettled, batteries, dropped } = status;
        for &(robot, left) in batteries {
            self.node.own(Some(robot));
            done(self.topics.publish_battery(*time, robot, left, &mut self.node));
        }
        if self.objects.len() <= MOST_OBJECTS {
            // Whoever came since is told of those that do not move.
            self.objects.clear();
        }
        let (now, left_out) = (Instant::now(), dropped + self.node.refused());
        let (before, at, left_out_before) = self.last.replace((*time, now, left_out)).unwrap_or((*time, now, 0));
        let factor = (time - before) / now.duration_since(at).as_secs_f64().max(1e-9);
        let value = |key: &str, value: String| ros::KeyValue { key: key.to_owned(), value };
        let is_whole = left_out == left_out_before;
        let status = ros::DiagnosticStatus {
            level: if is_whole { OK } else { WARN },
            name: "usarsim: world".to_owned(),
            message: if is_whole { "running" } else { "messages are left out" }.to_owned(),
            hardware_id: "usarsim".to_owned(),
            values: vec![
                value("real-time factor", format!("{factor:.3}")),
                value("unsettled steps", unsettled.to_string()),
                value("robots", self.robots.len().to_string()),
                value("messages left out", left_out.to_string()),
            ],
        };
        let message = ros::DiagnosticArray { header: header(*time, ""), status: vec![status] };
        self.node.own(None);
        done(self.node.publish(*time, "/diagnostics", &message));
    }

    /// Publishes a picture that is drawn.
    fn show(&mut self, picture: Drawn) {
        let Drawn { time, robot, sensor, angle, jpeg } = picture;
        let Some([pictures, numbers, frame]) = self.topics.camera(robot, sensor) else { return };
        self.node.own(Some(robot));
        let info = camera_info(header(time, &frame), SIZE.map(|size| size as u32), angle);
        done(self.node.publish(time, &numbers, &info));
        let message =
            ros::CompressedImage { header: header(time, &frame), format: "jpeg".to_owned(), data: ros::Bytes(jpeg) };
        done(self.node.publish(time, &pictures, &message));
    }

    /// Notes the cameras whose pictures somebody subscribes to.
    fn look(&mut self) {
        let mut wanted = BTreeSet::new();
        for (robot, Robot { cameras, .. }) in &self.robots {
            for (sensor, topic) in cameras {
                if self.node.has_subscribers(topic) {
                    wanted.insert((*robot, *sensor));
                }
            }
        }
        *self.shared.wanted.lock().unwrap_or_else(PoisonError::into_inner) = wanted;
    }
}

fn topics(options: &Options, map: &MapDef) -> Topics {
    Topics::new(options.namespaces, options.is_localised, map)
}

/// The node's sink does not fail.
fn done(outcome: Result<(), Infallible>) {
    let Ok(()) = outcome;
}
