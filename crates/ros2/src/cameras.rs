//! Pictures of robots' cameras, for the topics that somebody subscribes to. A thread draws them.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use jpeg_encoder::{ColorType, Encoder};
use picture::Drawer;
use scene::{Reading, Sensed, Snapshot};
use sim_core::CompiledScene;
use tokio::sync::mpsc::UnboundedSender;
use tracing::warn;

/// Width and height of a picture, pixels.
pub(crate) const SIZE: [usize; 2] = [640, 480];
/// Quality of a picture as JPEG, of 100: some 30 kB.
const QUALITY: u8 = 80;
/// Most pictures that wait to be drawn. A further one is left out.
const MOST_WAITING: usize = 4;

/// A picture to draw.
pub(crate) struct View {
    pub(crate) scene: CompiledScene,
    pub(crate) snapshot: Arc<Snapshot>,
    pub(crate) sensed: Sensed,
}

/// A picture that is drawn.
pub(crate) struct Drawn {
    /// Simulated time of what it shows, s.
    pub(crate) time: f64,
    pub(crate) robot: u64,
    pub(crate) sensor: usize,
    /// Angle from the left to the right edge, rad.
    pub(crate) angle: f64,
    pub(crate) jpeg: Vec<u8>,
}

/// The drawing thread; it starts with the first picture.
pub(crate) struct Cameras {
    views: Option<SyncSender<View>>,
    drawn: UnboundedSender<Drawn>,
}

impl Cameras {
    /// Creates cameras whose pictures come back by a channel. There are never more than wait to be drawn and one.
    pub(crate) fn new(drawn: UnboundedSender<Drawn>) -> Self {
        Self { views: None, drawn }
    }

    /// Draws a view, if the thread keeps up.
    pub(crate) fn draw(&mut self, view: View) {
        if self.views.is_none() {
            let (views, waiting) = sync_channel(MOST_WAITING);
            let drawn = self.drawn.clone();
            let started =
                std::thread::Builder::new().name("ROS 2 cameras".to_owned()).spawn(move || run(&waiting, &drawn));
            self.views = started.map_err(|error| warn!("no pictures for ROS 2: {error}")).ok().map(|_| views);
        }
        let Some(views) = &self.views else { return };
        if let Err(TrySendError::Disconnected(_)) = views.try_send(view) {
            // The thread has ended by a panic. The next picture starts another.
            self.views = None;
        }
    }
}

fn run(waiting: &Receiver<View>, drawn: &UnboundedSender<Drawn>) {
    let mut drawer = Drawer::default();
    while let Ok(View { scene, snapshot, sensed }) = waiting.recv() {
        let Reading::Camera(reading) = &sensed.reading else { continue };
        let Some(image) = drawer.of_sensor(&scene, &snapshot, &sensed, SIZE) else { continue };
        let mut jpeg = Vec::new();
        let [width, height] = SIZE.map(|size| size as u16);
        if Encoder::new(&mut jpeg, QUALITY).encode(image.pixels.as_flattened(), width, height, ColorType::Rgb).is_err()
        {
            continue;
        }
        let picture = Drawn {
            time: snapshot.time,
            robot: sensed.robot.0,
            sensor: sensed.sensor,
            angle: reading.field_of_view,
            jpeg,
        };
        if drawn.send(picture).is_err() {
            return;
        }
    }
}
