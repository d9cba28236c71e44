//! Live data for viewers. The world's thread makes each message once for all viewers, and no frames while nobody watches.
//!
//! The channels differ in what a slow viewer misses. It gets only the newest frame (see [`page_protocol::frame`]) and [`Status`]. It gets
//! every text, and every [`Line`] of the wire and the readings of robots ([`Measured`]) if it wants them. If it falls too far behind, it is told how many it
//! missed. It misses scans and pictures silently. A viewer that takes nothing for half a minute is dropped.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use page_protocol::{About, Line, Measured, Message, Status, objects_json, scene_json};
use scene::{MapDef, ObjectSnapshot, Reading, RobotDef, Sensed, Snapshot, WorldDef};
use served_world::Told;
use sessions::News;
use sim_core::{PawnId, World};
use tokio::sync::{broadcast, watch};

use crate::subscribers::board::Board;
use crate::subscribers::cameras::{Cameras, Demand, Picture, Wish};
use crate::subscribers::past::{Past, Run};
use crate::subscribers::subscriber::{Moment, Subscriber};

/// Real time between two frames.
const FRAME_INTERVAL: Duration = Duration::from_micros(33_333);
/// Real time between two statuses, unless the status changed.
const STATUS_INTERVAL: Duration = Duration::from_millis(500);
/// Least real time between two scans of one sensor.
const SCAN_INTERVAL: Duration = Duration::from_millis(100);
/// Most notices, lines and readings that a viewer can be behind. With the limits below each channel holds 9 MB at most.
const MAX_BEHIND: usize = 1024;
/// Most scans that a viewer can be behind. The next scan replaces a missed one.
const MAX_SCANS: usize = 64;
/// Messages that are due now, beside a frame.
pub(crate) struct Due {
    pub(crate) status: bool,
}

/// The receiving ends of the channels, for viewers.
#[derive(Clone)]
pub(crate) struct Channels {
    frames: watch::Receiver<Bytes>,
    statuses: watch::Receiver<Arc<str>>,
    /// Events and problems, in words.
    notices: broadcast::Sender<Arc<str>>,
    /// Ranges of lasers and sonars, see [`page_protocol::frame`].
    scans: broadcast::Sender<Bytes>,
    lines: broadcast::Sender<Arc<Line>>,
    readings: broadcast::Sender<Arc<Measured>>,
    demand: Demand,
    pictures: broadcast::Sender<Picture>,
    /// The scene as JSON.
    scene: watch::Receiver<Bytes>,
    /// Objects beside the map's, as JSON.
    objects: watch::Receiver<Bytes>,
    run: Run,
}

impl Channels {
    pub(crate) fn scene(&self) -> Bytes {
        self.scene.borrow().clone()
    }

    pub(crate) fn objects(&self) -> Bytes {
        self.objects.borrow().clone()
    }

    /// Returns the parts of the run so far, see [`page_protocol::pb::Past`].
    pub(crate) fn past(&self) -> Vec<Bytes> {
        self.run.parts()
    }

    pub(crate) fn frames(&self) -> watch::Receiver<Bytes> {
        self.frames.clone()
    }

    pub(crate) fn statuses(&self) -> watch::Receiver<Arc<str>> {
        self.statuses.clone()
    }

    pub(crate) fn notices(&self) -> broadcast::Receiver<Arc<str>> {
        self.notices.subscribe()
    }

    pub(crate) fn scans(&self) -> broadcast::Receiver<Bytes> {
        self.scans.subscribe()
    }

    /// Returns the wish of a viewer for pictures, for nothing yet.
    pub(crate) fn wish(&self) -> Wish {
        self.demand.wish()
    }

    pub(crate) fn pictures(&self) -> broadcast::Receiver<Picture> {
        self.pictures.subscribe()
    }

    pub(crate) fn readings(&self) -> broadcast::Receiver<Arc<Measured>> {
        self.readings.subscribe()
    }

    pub(crate) fn lines(&self) -> broadcast::Receiver<Arc<Line>> {
        self.lines.subscribe()
    }
}

/// The sending ends of the channels, for the world's thread.
pub(crate) struct Broadcast {
    frames: watch::Sender<Bytes>,
    statuses: watch::Sender<Arc<str>>,
    /// Events and problems, in words.
    notices: broadcast::Sender<Arc<str>>,
    /// Ranges of lasers and sonars, see [`page_protocol::frame`].
    scans: broadcast::Sender<Bytes>,
    lines: broadcast::Sender<Arc<Line>>,
    readings: broadcast::Sender<Arc<Measured>>,
    scene: watch::Sender<Bytes>,
    /// The server's part of the scene; none if no page is served.
    about: Option<About>,
    /// Number of classes in the scene.
    classes: usize,
    /// Number of changes of the scene.
    scenes: u64,
    cameras: Cameras,
    objects: watch::Sender<Bytes>,
    past: Past,
    /// Objects beside the map's at the last frame, and the number of changes of that list.
    spawned: (Vec<ObjectSnapshot>, u64),
    /// Time of each sensor's last published scan.
    scanned: BTreeMap<(PawnId, usize), Instant>,
    /// Number of viewers at the last frame, plus one: see [`Broadcast::is_watched`].
    viewers: usize,
    next_frame: Instant,
    next_status: Instant,
}

/// Returns the scene for pages; empty if no page is served.
fn scene(world: &WorldDef, about: Option<&About>) -> Bytes {
    about.map_or_else(Bytes::new, |about| scene_json(world, Some(about)).into())
}

/// Creates both ends of the channels. Without `about` no page asks for the scene. `board` is the image server's.
pub(crate) fn broadcast(now: Instant, world: &WorldDef, about: Option<About>, board: Board) -> (Broadcast, Channels) {
    let (frames, frames_end) = watch::channel(Bytes::new());
    let (statuses, statuses_end) = watch::channel(Arc::from("{}"));
    let ((notices, _), (lines, _)) = (broadcast::channel(MAX_BEHIND), broadcast::channel(MAX_BEHIND));
    let ((readings, _), (scans, _)) = (broadcast::channel(MAX_BEHIND), broadcast::channel(MAX_SCANS));
    let (scene, scene_end) = watch::channel(scene(world, about.as_ref()));
    let (objects, objects_end) = watch::channel(Bytes::from_static(b"[]"));
    let (cameras, past) = (Cameras::new(board), Past::new(now));
    let channels = Channels {
        demand: cameras.demand(),
        pictures: cameras.pictures(),
        frames: frames_end,
        statuses: statuses_end,
        notices: notices.clone(),
        scans: scans.clone(),
        lines: lines.clone(),
        readings: readings.clone(),
        scene: scene_end,
        objects: objects_end,
        run: past.run(),
    };
    let scanned = BTreeMap::new();
    let (next_frame, next_status) = (now, now);
    let broadcast = Broadcast {
        frames,
        statuses,
        notices,
        scans,
        lines,
        readings,
        scene,
        about,
        classes: world.robots.len(),
        scenes: 0,
        cameras,
        objects,
        past,
        spawned: (Vec::new(), 0),
        scanned,
        viewers: 0,
        next_frame,
        next_status,
    };
    (broadcast, channels)
}

impl Broadcast {
    /// True if a viewer watches. The [`Channels`] that new viewers get hold one receiver themselves.
    fn is_watched(&self) -> bool {
        self.frames.receiver_count() > 1
    }

    /// Publishes another map.
    fn show(&mut self, world: &WorldDef) {
        self.scenes += 1;
        // A map that came while the server runs can be chosen again.
        if let Some(About { maps, .. }) = &mut self.about
            && !maps.iter().any(|(name, _)| *name == world.map.name)
        {
            maps.push((world.map.name.clone(), world.map.description.clone()));
        }
        self.write_scene(world);
    }

    fn write_scene(&mut self, world: &WorldDef) {
        self.classes = world.robots.len();
        self.scene.send_replace(scene(world, self.about.as_ref()));
    }

    /// Makes the next status due at once: it has changed.
    fn changed(&mut self, now: Instant) {
        self.next_status = now;
    }

    /// Returns what to publish now; to be called often.
    pub(crate) fn due(&mut self, now: Instant) -> Option<Due> {
        if now < self.next_frame || !self.is_watched() {
            return None;
        }
        let viewers = self.frames.receiver_count();
        // A new viewer gets the current status at once.
        let status = now >= self.next_status || viewers > self.viewers;
        self.viewers = viewers;
        Some(Due { status })
    }

    /// Publishes a frame, and the status if it is due.
    pub(crate) fn publish(&mut self, now: Instant, scene: &WorldDef, snapshot: &Snapshot, status: Option<Status>) {
        self.next_frame = now + FRAME_INTERVAL;
        self.show_objects(now, &scene.map, &snapshot.objects);
        self.frames.send_replace(page_protocol::frame(scene, snapshot).into());
        if let Some(status) = status {
            self.next_status = now + STATUS_INTERVAL;
            // A class that came is known to pages that open from now on.
            if self.classes != scene.robots.len() {
                self.write_scene(scene);
            }
            let (scene, viewers) = (self.scenes, self.viewers.saturating_sub(1));
            let objects = self.spawned.1;
            let status = Status { scene, objects, viewers, ..status };
            self.statuses.send_replace(Message::Status(status).text().into());
        }
    }

    /// Keeps a frame of the run for pages that open later, if it is time.
    pub(crate) fn remember(
        &mut self,
        now: Instant,
        scene: &WorldDef,
        time: f64,
        snapshot: impl FnOnce() -> Arc<Snapshot>,
    ) {
        if self.about.is_some() && self.past.is_due(now, time) {
            self.past.keep(now, scene, &snapshot());
        }
    }

    /// Publishes the objects beside the map's, if others than at the last frame are there.
    fn show_objects(&mut self, now: Instant, map: &MapDef, objects: &[ObjectSnapshot]) {
        let of_map = objects.partition_point(|object| object.id.0 < map.objects.len() as u64);
        let (_, spawned) = objects.split_at(of_map);
        let (shown, changes) = &self.spawned;
        // A world that started over gives the same numbers to other objects.
        let is_same =
            |(one, other): (&ObjectSnapshot, &ObjectSnapshot)| one.id == other.id && Arc::ptr_eq(&one.def, &other.def);
        if spawned.len() != shown.len() || !spawned.iter().zip(shown).all(is_same) {
            self.objects.send_replace(objects_json(spawned).into());
            self.spawned = (spawned.to_vec(), changes + 1);
            self.next_status = now;
        }
    }

    /// Publishes a line of the wire to viewers who want lines.
    fn line(&self, line: impl FnOnce() -> Line) {
        if self.lines.receiver_count() > 0 {
            // The last listener may just have left.
            let _ = self.lines.send(Arc::new(line()));
        }
    }

    /// Publishes the numbers of a reading to viewers who want them, at a simulated time, s. The ranges of lasers and sonars go out no more
    /// often than a viewer can follow. `def` is the class of its robot.
    pub(crate) fn measured(&mut self, now: Instant, time: f64, def: Option<&RobotDef>, sensed: &Sensed) {
        if self.readings.receiver_count() > 0 {
            // The last listener may just have left.
            let _ = self.readings.send(Arc::new(Measured::new(time, sensed)));
        }
        let Some(ranges) = sensed.reading.ranges() else { return };
        if !self.is_watched() {
            self.scanned.clear();
            return;
        }
        let sensor = (sensed.robot, sensed.sensor);
        if self.scanned.get(&sensor).is_some_and(|last| now.duration_since(*last) < SCAN_INTERVAL) {
            return;
        }
        self.scanned.insert(sensor, now);
        if let Some(scan) = def.and_then(|def| page_protocol::scan(def, sensed.robot.0, sensed.sensor, ranges)) {
            let _ = self.scans.send(scan.into());
        }
    }

    /// Publishes a text.
    fn say(&self, text: &str) {
        let _ = self.notices.send(Line::cut(text).into());
    }
}

impl Subscriber for Broadcast {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        let (world, now) = (moment.world, moment.now);
        let line = |direction, connection, robot: Option<PawnId>, text: &str| Line {
            time: world.time(),
            direction,
            connection,
            robot: robot.map(|robot| robot.0),
            text: Line::cut(text),
        };
        match event {
            Told::News(news) => match news {
                News::Received { session, pawn, line: text } => self.line(|| line("in", *session, *pawn, text)),
                News::Sent { session, pawn, line: text, .. } => self.line(|| line("out", *session, *pawn, text)),
                News::Sensed(sensed) => {
                    if let Reading::Camera(_) = &sensed.reading {
                        self.cameras.look(world, sensed, moment.present);
                    }
                    self.measured(now, world.time(), world.robot(sensed.robot), sensed);
                }
                News::Left(robot) => {
                    self.scanned.retain(|(scanned, _), _| scanned != robot);
                    self.cameras.forget(*robot);
                }
                News::Came(_) | News::Closed(_) => self.changed(now),
                News::Lost(_) | News::Restored { .. } => {
                    news.warning().iter().for_each(|text| self.say(text));
                    self.changed(now);
                }
                News::Scored(score) => {
                    self.say(&score.to_string());
                    self.changed(now);
                }
                News::Wrong { .. } | News::TimeUp(_) => {}
            },
            Told::Warning(text) => self.say(text),
            Told::Notice(text) => {
                self.say(text);
                self.changed(now);
            }
            Told::Changed => self.changed(now),
            Told::Note(_) | Told::Standings(_) | Told::Result(_) => {}
        }
    }

    fn publish(&mut self, moment: &mut Moment) -> Vec<String> {
        let (world, now) = (moment.world, moment.now);
        self.remember(now, world.def(), world.time(), || moment.snapshot());
        Vec::new()
    }

    fn start_over(&mut self, moment: &mut Moment, old: &World) -> Vec<String> {
        self.cameras.start_over();
        self.past.start_over();
        if !moment.world.scene().is_copy_of(old.scene()) {
            self.show(moment.world.def());
        }
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use sim_core::Options;

    use super::*;
    use crate::subscribers::present::Present;

    #[test]
    fn when_a_sensor_was_last_shown_is_known_only_while_it_is_there_and_somebody_looks() {
        let world = World::new(WorldDef::default(), Options::default());
        let about = About { seed: 0, time_step: 0.002, port: 0, maps: Vec::new() };
        let (mut broadcast, channels) = broadcast(Instant::now(), world.def(), Some(about), Board::default());
        let tell = |broadcast: &mut Broadcast, told: &Told| {
            let present = &mut Present::default();
            broadcast.hear(&mut Moment { world: &world, now: Instant::now(), is_recorded: false, present }, told);
        };
        let scan = |broadcast: &mut Broadcast, robot| {
            let reading = Reading::from(scene::sensor::sonar::Reading { range: 1.0 });
            let sensed = Sensed { robot: PawnId(robot), sensor: 0, reading };
            tell(broadcast, &Told::News(&News::Sensed(&sensed)));
            broadcast.scanned.len()
        };
        assert_eq!(scan(&mut broadcast, 0), 0);
        let viewer = channels.frames();
        assert_eq!([scan(&mut broadcast, 0), scan(&mut broadcast, 0), scan(&mut broadcast, 1)], [1, 1, 2]);
        tell(&mut broadcast, &Told::News(&News::Left(PawnId(0))));
        assert_eq!(broadcast.scanned.keys().map(|(robot, _)| robot.0).collect::<Vec<_>>(), [1]);
        drop(viewer);
        assert_eq!(scan(&mut broadcast, 1), 0);
    }
}
