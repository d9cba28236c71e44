//! Pictures of robots' cameras, for viewers and for logs. Threads draw them. No picture changes the world.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{Receiver, Sender, SyncSender, TrySendError, channel, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use picture::{Image, SENSOR_SIZE, Stage};
use recorder::PictureTaken;
use scene::{Sensed, Snapshot};
use sim_core::{CompiledScene, PawnId, World};
use tokio::sync::broadcast;
use tracing::warn;

use crate::messages::pb::message::Content;
use crate::messages::{frame, pb};
use crate::subscribers::board::Board;
use crate::subscribers::present::Present;

/// Simulated time between what a picture in a log shows and its record, s.
const DELAY: f64 = 0.1;
/// Most pictures for logs that are being drawn. Further ones are left out.
const MAX_SHOTS: usize = 256;
/// Least real time between two pictures of a camera.
const INTERVAL: Duration = Duration::from_millis(90);
/// Most pictures that wait to be drawn. A further one is left out.
const MAX_WAITING: usize = 8;
/// Most pictures that a viewer can be behind.
const MAX_BEHIND: usize = 8;
/// Most robots whose pictures a viewer can ask for.
const MAX_ROBOTS: usize = 8;

/// A picture of a robot's camera, as a message to viewers.
#[derive(Debug, Clone)]
pub(crate) struct Picture {
    /// The robot's number.
    pub(crate) robot: u64,
    pub(crate) message: Bytes,
}

/// Robots whose pictures viewers want, with the number of viewers.
#[derive(Debug, Clone, Default)]
pub(crate) struct Demand(Arc<Mutex<BTreeMap<u64, usize>>>);

/// A viewer's part of the demand; it ends with the viewer.
#[derive(Debug)]
pub(crate) struct Wish {
    demand: Demand,
    robots: Vec<u64>,
}

impl Demand {
    /// Creates the wish of a viewer, for nothing.
    pub(crate) fn wish(&self) -> Wish {
        Wish { demand: self.clone(), robots: Vec::new() }
    }

    fn wants(&self, robot: u64) -> bool {
        self.lock().contains_key(&robot)
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, usize>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Wish {
    /// Replaces the robots whose pictures the viewer wants.
    pub(crate) fn set(&mut self, robots: &[u64]) {
        let mut counts = self.demand.lock();
        for robot in self.robots.drain(..) {
            match counts.get_mut(&robot) {
                Some(count) if *count > 1 => *count -= 1,
                _ => {
                    counts.remove(&robot);
                }
            }
        }
        let mut wanted: Vec<u64> = robots.iter().copied().take(MAX_ROBOTS).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.iter().for_each(|robot| *counts.entry(*robot).or_default() += 1);
        drop(counts);
        self.robots = wanted;
    }

    /// True if the viewer wants pictures of a robot.
    pub(crate) fn has(&self, robot: u64) -> bool {
        self.robots.contains(&robot)
    }
}

impl Drop for Wish {
    fn drop(&mut self) {
        self.set(&[]);
    }
}

/// A picture to draw.
struct Job {
    scene: CompiledScene,
    snapshot: Arc<Snapshot>,
    sensed: Sensed,
}

impl Job {
    /// Creates the picture of a camera's reading in a snapshot of the same time.
    fn new(world: &World, sensed: &Sensed, snapshot: Arc<Snapshot>) -> Self {
        Self { scene: world.scene().clone(), snapshot, sensed: sensed.clone() }
    }
}

/// A picture for those who look now.
struct Order {
    job: Job,
    /// True if viewers want it.
    is_wanted: bool,
    /// The number of the world, if the image server shows it.
    shown_in: Option<u64>,
}

/// The world's end of the drawing thread.
pub(crate) struct Cameras {
    demand: Demand,
    board: Board,
    pictures: broadcast::Sender<Picture>,
    /// The thread's queue; it starts with the first picture.
    jobs: Option<SyncSender<Order>>,
    /// Time of each camera's last picture.
    drawn: BTreeMap<(PawnId, usize), Instant>,
}

impl Cameras {
    /// Creates cameras whose pictures a board shows, too.
    pub(crate) fn new(board: Board) -> Self {
        let (pictures, _) = broadcast::channel(MAX_BEHIND);
        Self { demand: Demand::default(), board, pictures, jobs: None, drawn: BTreeMap::new() }
    }

    pub(crate) fn demand(&self) -> Demand {
        self.demand.clone()
    }

    pub(crate) fn pictures(&self) -> broadcast::Sender<Picture> {
        self.pictures.clone()
    }

    /// Draws what a camera sees now, if a viewer or a client of the image server wants it and the thread keeps up.
    pub(crate) fn look(&mut self, world: &World, sensed: &Sensed, present: &mut Present) {
        let camera = (sensed.robot, sensed.sensor);
        let is_wanted = self.demand.wants(sensed.robot.0);
        let cameras = world.tiles().cameras();
        let is_shown = self.board.is_watched() && cameras.contains(&Some(camera));
        let shown_in = is_shown.then(|| {
            self.board.assign(cameras, world.single_tile());
            self.board.worlds()
        });
        if !is_wanted && !is_shown {
            self.drawn.remove(&camera);
            return;
        }
        let now = Instant::now();
        if self.drawn.get(&camera).is_some_and(|last| now.duration_since(*last) < INTERVAL) {
            return;
        }
        if self.jobs.is_none() {
            self.jobs = self.start();
        }
        let Some(jobs) = &self.jobs else { return };
        match jobs.try_send(Order { job: Job::new(world, sensed, present.of(world)), is_wanted, shown_in }) {
            Ok(()) => {
                self.drawn.insert(camera, now);
            }
            Err(TrySendError::Full(_)) => {}
            // The thread has ended by a panic. The next picture starts another.
            Err(TrySendError::Disconnected(_)) => self.jobs = None,
        }
    }

    /// Forgets the cameras of a robot that has left.
    pub(crate) fn forget(&mut self, robot: PawnId) {
        self.drawn.retain(|(drawn, _), _| *drawn != robot);
        self.board.forget(robot);
    }

    /// Forgets the cameras of a world that another one has replaced.
    pub(crate) fn start_over(&mut self) {
        self.drawn.clear();
        self.board.start_over();
    }

    fn start(&self) -> Option<SyncSender<Order>> {
        let (jobs, waiting) = sync_channel(MAX_WAITING);
        let (pictures, board) = (self.pictures.clone(), self.board.clone());
        let thread = std::thread::Builder::new().name("cameras".to_owned());
        let started = thread.spawn(move || draw(&waiting, &pictures, &board));
        started.map_err(|error| warn!("cameras draw nothing: {error}")).ok().map(|_| jobs)
    }
}

/// Pictures for logs. Each is recorded a fixed simulated time after what it shows, and the world waits for it if need be. So a log has the
/// same pictures however fast the machine is.
#[derive(Default)]
pub(crate) struct Shots {
    thread: Option<(Sender<Job>, Receiver<Option<Shot>>)>,
    /// Simulated times at which the pictures being drawn are due, s.
    due: VecDeque<f64>,
}

/// A picture for a log.
pub(crate) struct Shot {
    pub(crate) taken: PictureTaken,
    pub(crate) png: Vec<u8>,
}

impl Shots {
    /// Begins to draw what a camera sees now.
    pub(crate) fn take(&mut self, world: &World, sensed: &Sensed, snapshot: Arc<Snapshot>) {
        if self.due.len() >= MAX_SHOTS {
            return;
        }
        if self.thread.is_none() {
            self.thread = start_shots();
        }
        let Some((jobs, _)) = &self.thread else { return };
        if jobs.send(Job::new(world, sensed, snapshot)).is_ok() {
            self.due.push_back(world.time() + DELAY);
        }
    }

    /// Returns the pictures that are due at a simulated time, s, and waits for them.
    pub(crate) fn due(&mut self, time: f64) -> Vec<Shot> {
        let count = self.due.iter().take_while(|due| **due <= time + 1e-9).count();
        self.due.drain(..count);
        let Some((_, done)) = &self.thread else { return Vec::new() };
        // An error means that the thread has panicked: its pictures are missing.
        let finished: Vec<_> = (0..count).map(|_| done.recv()).collect();
        if finished.iter().any(Result::is_err) {
            self.thread = None;
            self.due.clear();
        }
        finished.into_iter().filter_map(|shot| shot.ok().flatten()).collect()
    }
}

fn start_shots() -> Option<(Sender<Job>, Receiver<Option<Shot>>)> {
    let ((jobs, waiting), (finished, done)) = (channel::<Job>(), channel());
    let thread = std::thread::Builder::new().name("shots".to_owned());
    let started = thread.spawn(move || {
        let mut stage = None;
        while let Ok(job) = waiting.recv() {
            let png = image_of(&job, &mut stage).and_then(|image| image.to_png().ok());
            let shot = png.map(|png| {
                let taken = PictureTaken::new(&job.sensed, job.snapshot.time, &png);
                Shot { taken, png }
            });
            if finished.send(shot).is_err() {
                break;
            }
        }
    });
    started.map_err(|error| warn!("no pictures for logs: {error}")).ok().map(|_| (jobs, done))
}

/// Draws pictures until the world is gone.
fn draw(waiting: &Receiver<Order>, pictures: &broadcast::Sender<Picture>, board: &Board) {
    let mut stage = None;
    while let Ok(Order { job, is_wanted, shown_in }) = waiting.recv() {
        let Some(image) = image_of(&job, &mut stage) else { continue };
        let png = if is_wanted { image.to_png().ok() } else { None };
        if let Some(world) = shown_in {
            board.show(world, (job.sensed.robot, job.sensed.sensor), image);
        }
        if let Some(png) = png {
            let (robot, sensor) = (job.sensed.robot.0, job.sensed.sensor as u32);
            let picture = pb::Picture { robot: robot as u32, sensor, time: job.snapshot.time, png };
            let message = frame::encode(Content::Picture(picture)).into();
            // The last viewer may have left.
            let _ = pictures.send(Picture { robot, message });
        }
    }
}

/// Draws a picture. `prepared` keeps the scene for the next one.
fn image_of(job: &Job, prepared: &mut Option<(CompiledScene, Stage)>) -> Option<Image> {
    if prepared.as_ref().is_none_or(|(scene, _)| !std::ptr::eq(scene.def(), job.scene.def())) {
        *prepared = Some((job.scene.clone(), Stage::new(job.scene.def())));
    }
    let (_, stage) = prepared.as_ref()?;
    picture::of_sensor(stage, job.scene.def(), &job.snapshot, &job.sensed, SENSOR_SIZE)
}
