//! Frames of the whole run, for pages that open later. They lie farther apart the longer the run is.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::body::Bytes;
use page_protocol::{objects_json, pb};
use scene::{ObjectSnapshot, Snapshot, WorldDef};

/// Least real time between two frames.
const INTERVAL: Duration = Duration::from_millis(250);
/// Least simulated time between two frames at first, s.
const FIRST_STEP: f64 = 0.5;
/// Most frames, and most bytes of them.
const MAX_FRAMES: usize = 1200;
const MAX_BYTES: usize = 16 << 20;
/// Most robots, and most objects beside the map's, that are known: the newest.
const MAX_KNOWN: usize = 1024;

/// The run so far, as the world's thread keeps it.
pub(crate) struct Past {
    next: Instant,
    run: Run,
}

/// The run so far, as pages read it.
#[derive(Clone, Default)]
pub(crate) struct Run(Arc<Mutex<Kept>>);

struct Kept {
    resets: u32,
    frames: Vec<Frame>,
    bytes: usize,
    /// Least simulated time between two frames, s.
    step: f64,
    robots: BTreeMap<u64, pb::Known>,
    objects: BTreeMap<u64, ObjectSnapshot>,
    /// Their part of a [`pb::Past`].
    objects_part: Bytes,
}

struct Frame {
    time: f64,
    /// A part of a [`pb::Past`].
    part: Bytes,
}

impl Past {
    pub(crate) fn new(now: Instant) -> Self {
        Self { next: now, run: Run::default() }
    }

    pub(crate) fn run(&self) -> Run {
        self.run.clone()
    }

    /// True if the world at a simulated time, s, is worth a frame.
    pub(crate) fn is_due(&self, now: Instant, time: f64) -> bool {
        now >= self.next && self.run.kept().is_due(time)
    }

    /// Keeps a frame of a world.
    pub(crate) fn keep(&mut self, now: Instant, world: &WorldDef, snapshot: &Snapshot) {
        self.next = now + INTERVAL;
        let frame = page_protocol::frame(world, snapshot);
        let part = page_protocol::past(&pb::Past { frames: vec![frame], ..pb::Past::default() }).into();
        self.run.kept().add(world.map.objects.len(), snapshot, part);
    }

    /// Begins with a fresh world.
    pub(crate) fn start_over(&mut self) {
        let mut kept = self.run.kept();
        *kept = Kept { resets: kept.resets + 1, ..Kept::default() };
    }
}

impl Run {
    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the parts of a [`pb::Past`]. They share the bytes of the frames.
    pub(crate) fn parts(&self) -> Vec<Bytes> {
        let kept = self.kept();
        let robots = kept.robots.values().cloned().collect();
        let about = pb::Past { resets: kept.resets, robots, ..pb::Past::default() };
        let frames = kept.frames.iter().map(|frame| frame.part.clone());
        [page_protocol::past(&about).into(), kept.objects_part.clone()].into_iter().chain(frames).collect()
    }
}

impl Default for Kept {
    fn default() -> Self {
        let (robots, objects) = (BTreeMap::new(), BTreeMap::new());
        let (frames, objects_part) = (Vec::new(), Bytes::new());
        Self { resets: 0, frames, bytes: 0, step: FIRST_STEP, robots, objects, objects_part }
    }
}

impl Kept {
    fn is_due(&self, time: f64) -> bool {
        // Earlier is another world of a program that steps it.
        self.frames.last().is_none_or(|last| time >= last.time + self.step || time < last.time)
    }

    /// Adds a frame of a world whose map has so many objects.
    fn add(&mut self, of_map: usize, snapshot: &Snapshot, part: Bytes) {
        let time = snapshot.time;
        if self.frames.last().is_some_and(|last| time < last.time) {
            *self = Self { resets: self.resets, ..Self::default() };
        }
        self.bytes += part.len();
        self.frames.push(Frame { time, part });
        while self.frames.len() > MAX_FRAMES || (self.bytes > MAX_BYTES && self.frames.len() > 2) {
            self.thin();
        }
        for robot in self.robots.values_mut() {
            if robot.left == 0.0 && !snapshot.robots.iter().any(|it| it.id.0 == u64::from(robot.robot)) {
                robot.left = time;
            }
        }
        for robot in &snapshot.robots {
            self.robots.entry(robot.id.0).or_insert_with(|| pb::Known {
                robot: robot.id.0 as u32,
                class: robot.class.clone(),
                name: robot.name.clone(),
                came: time,
                left: 0.0,
            });
        }
        while self.robots.len() > MAX_KNOWN {
            self.robots.pop_first();
        }
        self.add_objects(snapshot.objects.iter().filter(|object| object.id.0 >= of_map as u64));
    }

    fn add_objects<'a>(&mut self, objects: impl Iterator<Item = &'a ObjectSnapshot>) {
        let newest = self.objects.last_key_value().map(|(id, _)| *id);
        self.objects.extend(objects.filter(|it| Some(it.id.0) > newest).map(|it| (it.id.0, it.clone())));
        if self.objects.last_key_value().map(|(id, _)| *id) == newest {
            return;
        }
        while self.objects.len() > MAX_KNOWN {
            self.objects.pop_first();
        }
        let all: Vec<_> = self.objects.values().cloned().collect();
        let objects = objects_json(&all);
        self.objects_part = page_protocol::past(&pb::Past { objects, ..pb::Past::default() }).into();
    }

    /// Doubles the time between two frames.
    fn thin(&mut self) {
        self.step *= 2.0;
        let (step, mut last) = (self.step, f64::NEG_INFINITY);
        self.frames.retain(|frame| {
            let is_kept = frame.time >= last + step;
            if is_kept {
                last = frame.time;
            }
            is_kept
        });
        self.bytes = self.frames.iter().map(|frame| frame.part.len()).sum();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(kept: &Kept) -> (f64, f64, usize) {
        let time = |frame: Option<&Frame>| frame.expect("a frame").time;
        (time(kept.frames.first()), time(kept.frames.last()), kept.frames.len())
    }

    #[test]
    fn frames_of_the_whole_run_are_kept_within_their_number_and_their_bytes() {
        for (length, least) in [(1000, 600), (MAX_BYTES / 100, 40), (2 * MAX_BYTES, 1)] {
            let mut kept = Kept::default();
            for moment in 0..20_000 {
                let time = 0.25 * f64::from(moment);
                if kept.is_due(time) {
                    kept.add(0, &Snapshot { time, ..Snapshot::default() }, Bytes::from(vec![0; length]));
                }
            }
            let (first, last, count) = times(&kept);
            assert_eq!(first, 0.0);
            assert!(last > 5000.0 - 2.0 * kept.step || count <= 2, "{last} s");
            assert!((least..=MAX_FRAMES).contains(&count), "{count} frames of {length} bytes");
            assert!(kept.bytes <= MAX_BYTES.max(2 * length), "{} bytes", kept.bytes);
        }
    }

    #[test]
    fn an_earlier_time_is_another_world() {
        let mut kept = Kept::default();
        for time in [0.0, 1.0, 2.0, 0.5] {
            kept.add(0, &Snapshot { time, ..Snapshot::default() }, Bytes::new());
        }
        assert_eq!(times(&kept), (0.5, 0.5, 1));
    }
}
