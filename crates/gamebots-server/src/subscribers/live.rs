//! Live data for viewers. The world's thread makes each message once for all viewers, and no frames while nobody watches.
//!
//! The channels differ in what a slow viewer misses. It gets only the newest frame (see [`frame`]) and [`Status`]. It gets every text, and
//! every [`Line`] of the wire and the readings of robots ([`Measured`]) if it wants them. If it falls too far behind, it is told how many it
//! missed. It misses scans and pictures silently. A viewer that takes nothing for half a minute is dropped.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use scene::{MapDef, ObjectSnapshot, Reading, RobotDef, Score, Sensed, Snapshot, Standing, Standings, WorldDef};
use serde::Serialize;
use sessions::News;
use sim_core::{PawnId, World};
use tokio::sync::{broadcast, watch};

use crate::messages::frame;
use crate::messages::scene::{About, objects_json, scene_json};
use crate::subscribers::board::Board;
use crate::subscribers::cameras::{Cameras, Demand, Picture, Wish};
use crate::subscribers::subscriber::{Moment, Subscriber, Told};

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
/// Longest text of a line for viewers, bytes. Longer ones are cut.
const MAX_TEXT: usize = 4096;
/// Most numbers of a quantity for viewers. Further ones are left out.
const MAX_VALUES: usize = 1024;

/// Most changes of points that a status has of each team.
const MAX_SCORES: usize = 8;

/// A line of the wire.
#[derive(Debug, Serialize)]
pub(crate) struct Line {
    /// Simulated time, s.
    pub(crate) time: f64,
    /// `in` from a client, `out` to it.
    pub(crate) direction: &'static str,
    pub(crate) connection: u64,
    pub(crate) robot: Option<u64>,
    pub(crate) text: String,
}

/// A reading of a sensor, for viewers that show its numbers.
#[derive(Debug, Serialize)]
pub(crate) struct Measured {
    /// Simulated time, s.
    time: f64,
    pub(crate) robot: u64,
    /// Number of the sensor in the robot's class.
    sensor: usize,
    #[serde(rename = "type")]
    type_name: &'static str,
    quantities: Vec<scene::Quantity>,
}

impl Line {
    /// Cuts a text that is too long for viewers.
    pub(crate) fn cut(text: &str) -> String {
        if text.len() <= MAX_TEXT {
            return text.to_owned();
        }
        let start = text.char_indices().take_while(|(index, letter)| index + letter.len_utf8() <= MAX_TEXT);
        let start: String = start.map(|(_, letter)| letter).collect();
        format!("{start}.. ({} bytes in all)", text.len())
    }
}

impl Measured {
    fn new(time: f64, Sensed { robot, sensor, reading }: &Sensed) -> Self {
        let (type_name, mut quantities) = (reading.type_name(), reading.quantities());
        quantities.iter_mut().for_each(|quantity| quantity.values.truncate(MAX_VALUES));
        Self { time, robot: robot.0, sensor: *sensor, type_name, quantities }
    }
}

/// State that seldom changes.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Status {
    /// Simulated seconds per real second, over the last half second.
    pub(crate) real_time_factor: f64,
    /// Requested real-time factor; 0 is as fast as possible.
    pub(crate) speed: f64,
    pub(crate) paused: bool,
    /// Number of the scene. When it changes, a page must fetch the scene again.
    pub(crate) scene: u64,
    /// Number of changes of the objects beside the map's. When it changes, a page must fetch them again.
    pub(crate) objects: u64,
    /// Open pages.
    pub(crate) viewers: usize,
    /// Number of times that the world started over.
    pub(crate) resets: u64,
    /// Number of times that the world was saved.
    pub(crate) saves: u64,
    /// Steps of robots whose contacts did not converge.
    pub(crate) unsettled_steps: u64,
    /// File of the log that is being written.
    pub(crate) recording: Option<String>,
    /// The league that is played, if any.
    pub(crate) league: Option<LeagueStatus>,
    pub(crate) robots: Vec<RobotStatus>,
    pub(crate) clients: Vec<ClientStatus>,
}

/// A league.
#[derive(Debug, Serialize)]
pub(crate) struct LeagueStatus {
    name: String,
    /// Simulated time that is left, s.
    time_left: f64,
    /// True from the first robot's arrival.
    has_begun: bool,
    /// True if the time is up.
    is_over: bool,
    /// Teams, the best first.
    teams: Vec<TeamStatus>,
}

/// A team of a league.
#[derive(Debug, Serialize)]
struct TeamStatus {
    /// Place, from 1; equal points share one.
    place: usize,
    name: String,
    points: i64,
    /// Number of victims that it found.
    found: usize,
    /// Numbers of the robots that entered for it.
    robots: Vec<u64>,
    /// The last changes of its points, newest first.
    scores: Vec<Score>,
}

impl LeagueStatus {
    pub(crate) fn new(standings: Standings) -> Self {
        let team = |(place, team): (usize, &Standing)| TeamStatus {
            place,
            name: team.team.clone(),
            points: team.points,
            found: team.scores.iter().filter(|score| score.is_found_victim()).count(),
            robots: team.robots.iter().map(|entrant| entrant.robot).collect(),
            scores: team.scores.iter().rev().take(MAX_SCORES).cloned().collect(),
        };
        Self {
            time_left: standings.time_left(),
            has_begun: standings.began.is_some(),
            is_over: standings.is_over,
            teams: standings.ranking().into_iter().map(team).collect(),
            name: standings.league,
        }
    }
}

/// A robot in the world.
#[derive(Debug, Serialize)]
pub(crate) struct RobotStatus {
    pub(crate) id: u64,
    pub(crate) class: String,
    pub(crate) name: String,
    /// The connection that it reports to.
    pub(crate) connection: Option<u64>,
    /// Battery life left, whole s.
    pub(crate) battery: Option<i32>,
}

/// A connected client.
#[derive(Debug, Serialize)]
pub(crate) struct ClientStatus {
    pub(crate) connection: u64,
    /// Its address.
    pub(crate) peer: String,
    /// Lines received from it.
    pub(crate) lines: u64,
    /// Periodic lines dropped because it was too slow.
    pub(crate) dropped: u64,
    /// Bytes that wait to be sent to it.
    pub(crate) waiting_bytes: usize,
}

/// Messages that are due now, beside a frame.
pub(crate) struct Due {
    pub(crate) status: bool,
}

/// The receiving ends of the channels, for viewers.
#[derive(Debug, Clone)]
pub(crate) struct Channels {
    frames: watch::Receiver<Bytes>,
    statuses: watch::Receiver<Arc<str>>,
    /// Events and problems, in words.
    notices: broadcast::Sender<Arc<str>>,
    /// Ranges of lasers and sonars, see [`frame`].
    scans: broadcast::Sender<Bytes>,
    lines: broadcast::Sender<Arc<Line>>,
    readings: broadcast::Sender<Arc<Measured>>,
    demand: Demand,
    pictures: broadcast::Sender<Picture>,
    /// The scene as JSON.
    scene: watch::Receiver<Bytes>,
    /// Objects beside the map's, as JSON.
    objects: watch::Receiver<Bytes>,
}

impl Channels {
    pub(crate) fn scene(&self) -> Bytes {
        self.scene.borrow().clone()
    }

    pub(crate) fn objects(&self) -> Bytes {
        self.objects.borrow().clone()
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
    /// Ranges of lasers and sonars, see [`frame`].
    scans: broadcast::Sender<Bytes>,
    lines: broadcast::Sender<Arc<Line>>,
    readings: broadcast::Sender<Arc<Measured>>,
    scene: watch::Sender<Bytes>,
    /// The server's part of the scene; none if no page is served.
    about: Option<About>,
    /// Number of changes of the scene.
    scenes: u64,
    cameras: Cameras,
    objects: watch::Sender<Bytes>,
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
    let cameras = Cameras::new(board);
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
        scenes: 0,
        cameras,
        objects,
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
        self.frames.send_replace(frame::frame(scene, snapshot).into());
        if let Some(status) = status {
            self.next_status = now + STATUS_INTERVAL;
            let (scene, viewers) = (self.scenes, self.viewers.saturating_sub(1));
            let objects = self.spawned.1;
            let status = Status { scene, objects, viewers, ..status };
            self.statuses.send_replace(serde_json::json!({ "status": status }).to_string().into());
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
        if let Some(scan) = def.and_then(|def| frame::scan(def, sensed.robot.0, sensed.sensor, ranges)) {
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
                    logbook::warning(news).iter().for_each(|text| self.say(text));
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
            Told::Note(_) | Told::Standings(_) | Told::Result(_) | Told::Picture(..) => {}
        }
    }

    fn start_over(&mut self, moment: &mut Moment, old: &World) -> Vec<String> {
        self.cameras.start_over();
        let def = moment.world.def();
        if def.map.name != old.def().map.name {
            self.show(def);
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
    fn long_texts_are_cut_between_letters() {
        for (text, expected) in [
            ("short".to_owned(), "short".to_owned()),
            ("x".repeat(MAX_TEXT), "x".repeat(MAX_TEXT)),
            ("ä".repeat(5000), format!("{}.. (10000 bytes in all)", "ä".repeat(MAX_TEXT / 2))),
            (format!("x{}", "ä".repeat(5000)), format!("x{}.. (10001 bytes in all)", "ä".repeat(MAX_TEXT / 2 - 1))),
        ] {
            assert_eq!(Line::cut(&text), expected);
        }
    }

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
