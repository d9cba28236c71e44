//! Pictures of robots' cameras, for those who look now: viewers and clients of the port of images. A thread draws them.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use page_protocol::pb;
use page_protocol::pb::message::Content;
use picture::Drawer;
use scene::sensor::camera;
use scene::{Reading, Sensed};
use sim_core::{PawnId, World};
use tokio::sync::broadcast;
use tracing::warn;

use crate::subscribers::board::Board;
use crate::subscribers::job::Job;
use crate::subscribers::present::Present;

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

/// Draws pictures until the world is gone.
fn draw(waiting: &Receiver<Order>, pictures: &broadcast::Sender<Picture>, board: &Board) {
    let mut drawer = Drawer::default();
    while let Ok(Order { job, is_wanted, shown_in }) = waiting.recv() {
        let Some(image) = job.draw(&mut drawer) else { continue };
        let png = if is_wanted { image.to_png().ok() } else { None };
        if let Some(world) = shown_in {
            board.show(world, (job.sensed.robot, job.sensed.sensor), image);
        }
        if let Some(png) = png {
            let (robot, sensor) = (job.sensed.robot.0, job.sensed.sensor as u32);
            let Reading::Camera(camera::Reading { field_of_view }) = job.sensed.reading else { continue };
            let time = job.snapshot.time;
            let picture = pb::Picture { robot: robot as u32, sensor, time, png, field_of_view };
            let message = page_protocol::encode(Content::Picture(picture)).into();
            // The last viewer may have left.
            let _ = pictures.send(Picture { robot, message });
        }
    }
}
