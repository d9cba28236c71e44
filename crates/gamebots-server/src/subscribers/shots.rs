//! Pictures of robots' cameras for logs.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use picture::Drawer;
use recorder::PictureTaken;
use scene::{Reading, Sensed, Snapshot};
use served_world::Told;
use sessions::News;
use sim_core::World;
use tracing::warn;

use crate::subscribers::job::Job;
use crate::subscribers::subscriber::{Moment, Shot, Subscriber};

/// Simulated time between what a picture in a log shows and its record, s.
const DELAY: f64 = 0.1;
/// Most pictures for logs that are being drawn. Further ones are left out.
const MAX_SHOTS: usize = 256;

/// Pictures for logs. Each is recorded a fixed simulated time after what it shows, and the world waits for it if need be. So a log has the
/// same pictures however fast the machine is.
#[derive(Default)]
pub(crate) struct Shots {
    thread: Option<(Sender<Job>, Receiver<Option<Shot>>)>,
    /// Simulated times at which the pictures being drawn are due, s.
    due: VecDeque<f64>,
}

impl Subscriber for Shots {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        if moment.is_recorded
            && let Told::News(News::Sensed(sensed)) = event
            && let Reading::Camera(_) = &sensed.reading
        {
            self.take(moment.world, sensed, moment.snapshot());
        }
    }

    fn stepped(&mut self, moment: &mut Moment) -> Vec<Shot> {
        self.due(moment.world.time())
    }

    fn start_over(&mut self, _: &mut Moment, _: &World) -> Vec<String> {
        // The thread ends by itself: nobody takes the pictures of the old world.
        *self = Self::default();
        Vec::new()
    }
}

impl Shots {
    /// Begins to draw what a camera sees now.
    fn take(&mut self, world: &World, sensed: &Sensed, snapshot: Arc<Snapshot>) {
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
    fn due(&mut self, time: f64) -> Vec<Shot> {
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
        let mut drawer = Drawer::default();
        while let Ok(job) = waiting.recv() {
            let png = job.draw(&mut drawer).and_then(|image| image.to_png().ok());
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
