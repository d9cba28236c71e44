//! What viewers get while the world runs. The world's thread makes each thing once, however many look, and only
//! while somebody does.
//!
//! Four channels, by what a slow viewer may miss: of frames (see [`frame`]) and [`Status`] it gets the newest; of [`Notice`]s
//! everything, and of the wire's [`Line`]s if it wants them, until it is too far behind and is told how many it missed.

mod frame;
mod scene_json;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::body::Bytes;
use gamebots_proto::message::{Message, Reading, Sen};
use scene::{Snapshot, WorldDef};
use serde::Serialize;
use sim_core::{RobotId, World};
use tokio::sync::{broadcast, watch};

pub(crate) use scene_json::{About, scene_json};

/// Real time between two frames.
const FRAME_INTERVAL: Duration = Duration::from_micros(33_333);
/// Real time between two statuses, unless something has happened.
const STATUS_INTERVAL: Duration = Duration::from_millis(500);
/// Least real time between two scans of one sensor.
const SCAN_INTERVAL: Duration = Duration::from_millis(100);
/// Notices, and lines, that a viewer may be behind.
const MAX_NOTICES: usize = 1024;

/// Something that is published once.
#[derive(Debug, Clone)]
pub(crate) enum Notice {
    /// What a laser or a sonar measured, see [`frame`].
    Scan(Bytes),
    /// Something that is wrong, or has happened, in words.
    Said(Arc<str>),
}

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

/// What changes seldom.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Status {
    /// Seconds simulated a second, over the last half second.
    pub(crate) real_time_factor: f64,
    /// What is asked for; 0 is as fast as possible.
    pub(crate) speed: f64,
    pub(crate) paused: bool,
    /// Another number than before means another scene: it is to be fetched anew.
    pub(crate) scene: u64,
    /// Pages that are open.
    pub(crate) viewers: usize,
    /// How often the world began anew.
    pub(crate) resets: u64,
    /// Steps of robots that ended before every contact did what it should.
    pub(crate) unsettled_steps: u64,
    /// File of the log that is being written.
    pub(crate) recording: Option<String>,
    pub(crate) robots: Vec<RobotStatus>,
    pub(crate) clients: Vec<ClientStatus>,
}

/// A robot that is there.
#[derive(Debug, Serialize)]
pub(crate) struct RobotStatus {
    pub(crate) id: u64,
    pub(crate) class: String,
    pub(crate) name: String,
    /// The connection that it reports to.
    pub(crate) connection: Option<u64>,
    /// Whole seconds that its battery lasts.
    pub(crate) battery: Option<i32>,
}

/// A client that is connected.
#[derive(Debug, Serialize)]
pub(crate) struct ClientStatus {
    pub(crate) connection: u64,
    /// Its address.
    pub(crate) peer: String,
    /// Lines that came from it.
    pub(crate) lines: u64,
    /// Periodic lines that it was too slow to take.
    pub(crate) dropped: u64,
    /// Bytes on their way to it.
    pub(crate) waiting_bytes: usize,
}

/// What is to be published now beside where everything is.
pub(crate) struct Due {
    pub(crate) status: bool,
}

/// The ends that viewers listen at.
#[derive(Debug, Clone)]
pub(crate) struct Channels {
    frames: watch::Receiver<Bytes>,
    statuses: watch::Receiver<Arc<str>>,
    notices: broadcast::Sender<Notice>,
    lines: broadcast::Sender<Arc<Line>>,
    /// The scene as JSON.
    scene: watch::Receiver<Bytes>,
}

impl Channels {
    pub(crate) fn scene(&self) -> Bytes {
        self.scene.borrow().clone()
    }

    pub(crate) fn frames(&self) -> watch::Receiver<Bytes> {
        self.frames.clone()
    }

    pub(crate) fn statuses(&self) -> watch::Receiver<Arc<str>> {
        self.statuses.clone()
    }

    pub(crate) fn notices(&self) -> broadcast::Receiver<Notice> {
        self.notices.subscribe()
    }

    pub(crate) fn lines(&self) -> broadcast::Receiver<Arc<Line>> {
        self.lines.subscribe()
    }
}

/// The end that the world's thread speaks at.
pub(crate) struct Broadcast {
    frames: watch::Sender<Bytes>,
    statuses: watch::Sender<Arc<str>>,
    notices: broadcast::Sender<Notice>,
    lines: broadcast::Sender<Arc<Line>>,
    scene: watch::Sender<Bytes>,
    /// What the scene says of the server; none where no page is served.
    about: Option<About>,
    /// How often the scene has changed.
    scenes: u64,
    /// When each sensor's last scan was published.
    scanned: BTreeMap<(RobotId, usize), Instant>,
    /// Viewers at the last frame.
    viewers: usize,
    next_frame: Instant,
    next_status: Instant,
    /// Real and simulated time, s, of the last measurement, and the real-time factor that it gave.
    measured: (Instant, f64, f64),
}

/// The scene that a page asks for; nothing where none is served.
fn scene(world: &WorldDef, about: Option<&About>) -> Bytes {
    about.map_or_else(Bytes::new, |about| scene_json(world, Some(about)).into())
}

/// Makes the two ends. Without `about` no page asks for the scene.
pub(crate) fn broadcast(now: Instant, world: &WorldDef, about: Option<About>) -> (Broadcast, Channels) {
    let (frames, frames_end) = watch::channel(Bytes::new());
    let (statuses, statuses_end) = watch::channel(Arc::from("{}"));
    let ((notices, _), (lines, _)) = (broadcast::channel(MAX_NOTICES), broadcast::channel(MAX_NOTICES));
    let (speaking, listening) = (notices.clone(), lines.clone());
    let (scene, scene_end) = watch::channel(scene(world, about.as_ref()));
    let channels =
        Channels { frames: frames_end, statuses: statuses_end, notices: speaking, lines: listening, scene: scene_end };
    let (scanned, measured) = (BTreeMap::new(), (now, 0.0, 0.0));
    let (next_frame, next_status) = (now, now);
    let broadcast = Broadcast {
        frames,
        statuses,
        notices,
        lines,
        scene,
        about,
        scenes: 0,
        scanned,
        viewers: 0,
        next_frame,
        next_status,
        measured,
    };
    (broadcast, channels)
}

impl Broadcast {
    /// Whether anybody looks. The [`Channels`] that new viewers are given hold one end themselves.
    fn is_watched(&self) -> bool {
        self.frames.receiver_count() > 1
    }

    /// A robot has left.
    pub(crate) fn forget(&mut self, robot: RobotId) {
        self.scanned.retain(|(scanned, _), _| *scanned != robot);
    }

    /// There is another map.
    pub(crate) fn show(&mut self, world: &WorldDef) {
        self.scenes += 1;
        self.scene.send_replace(scene(world, self.about.as_ref()));
    }

    /// The next status is due at once: something has happened.
    pub(crate) fn changed(&mut self, now: Instant) {
        self.next_status = now;
    }

    /// What is to be published now; to be asked often.
    pub(crate) fn due(&mut self, now: Instant) -> Option<Due> {
        if now < self.next_frame || !self.is_watched() {
            return None;
        }
        let viewers = self.frames.receiver_count();
        // Who has just come waits for nothing.
        let status = now >= self.next_status || viewers > self.viewers;
        self.viewers = viewers;
        Some(Due { status })
    }

    /// Publishes where everything is, and the status when it is due; its real-time factor is measured here.
    pub(crate) fn publish(&mut self, now: Instant, scene: &WorldDef, snapshot: &Snapshot, status: Option<Status>) {
        self.next_frame = now + FRAME_INTERVAL;
        self.frames.send_replace(frame::frame(scene, snapshot).into());
        if let Some(status) = status {
            self.next_status = now + STATUS_INTERVAL;
            let (before, time, _) = self.measured;
            let elapsed = now.duration_since(before);
            // A shorter time is too uneven to measure by.
            if elapsed >= STATUS_INTERVAL {
                let factor = (snapshot.time - time).max(0.0) / elapsed.as_secs_f64();
                self.measured = (now, snapshot.time, factor);
            }
            let (real_time_factor, scene, viewers) = (self.measured.2, self.scenes, self.viewers.saturating_sub(1));
            let status = Status { real_time_factor, scene, viewers, ..status };
            self.statuses.send_replace(serde_json::json!({ "status": status }).to_string().into());
        }
    }

    /// Publishes a line of the wire to those who want them.
    pub(crate) fn line(&self, line: impl FnOnce() -> Line) {
        if self.lines.receiver_count() > 0 {
            // Without a listener it is nobody's.
            let _ = self.lines.send(Arc::new(line()));
        }
    }

    /// Publishes what a laser or a sonar measured, but no more often than it can be looked at.
    pub(crate) fn scan(&mut self, world: &World, robot: RobotId, message: &Message) {
        let Message::Sen(Sen { reading, sensor: Some(number), .. }) = message else { return };
        let ranges = match reading {
            Reading::RangeScanner(scan) => scan.ranges.as_slice(),
            Reading::Sonar(sonar) => std::slice::from_ref(&sonar.range),
            _ => return,
        };
        if !self.is_watched() {
            self.scanned.clear();
            return;
        }
        let (now, sensor) = (Instant::now(), (robot, *number));
        if self.scanned.get(&sensor).is_some_and(|last| now.duration_since(*last) < SCAN_INTERVAL) {
            return;
        }
        self.scanned.insert(sensor, now);
        if let Some(scan) = world.robot(robot).and_then(|def| frame::scan(def, robot.0, *number, ranges)) {
            let _ = self.notices.send(Notice::Scan(scan.into()));
        }
    }

    /// Publishes something in words.
    pub(crate) fn say(&self, text: &str) {
        let _ = self.notices.send(Notice::Said(text.into()));
    }
}

#[cfg(test)]
mod tests {
    use gamebots_proto::message::Sonar;
    use sim_core::Options;

    use super::*;

    #[test]
    fn when_a_sensor_was_last_shown_is_known_only_while_it_is_there_and_somebody_looks() {
        let world = World::new(WorldDef::default(), Options::default());
        let about = About { seed: 0, time_step: 0.002, port: 0, maps: Vec::new() };
        let (mut broadcast, channels) = broadcast(Instant::now(), world.def(), Some(about));
        let scan = |broadcast: &mut Broadcast, robot| {
            let reading = Reading::Sonar(Sonar { name: "F1".to_owned(), range: 1.0 });
            broadcast.scan(&world, RobotId(robot), &Message::Sen(Sen { time: Some(0.0), reading, sensor: Some(0) }));
            broadcast.scanned.len()
        };
        assert_eq!(scan(&mut broadcast, 0), 0);
        let viewer = channels.frames();
        assert_eq!([scan(&mut broadcast, 0), scan(&mut broadcast, 0), scan(&mut broadcast, 1)], [1, 1, 2]);
        broadcast.forget(RobotId(0));
        assert_eq!(broadcast.scanned.keys().map(|(robot, _)| robot.0).collect::<Vec<_>>(), [1]);
        drop(viewer);
        assert_eq!(scan(&mut broadcast, 1), 0);
    }
}
