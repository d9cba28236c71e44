//! The page of a world that another program steps, such as one in a notebook. It shows; nobody drives or controls.
//!
//! ```text
//! program --moment--> view thread (frames, scans, status) --> web sockets
//! ```

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use page_protocol::{About, RobotStatus, Status};
use scene::{Options, Sensed, Snapshot, WorldDef};
use served_world::{Entrance, Event, Kind};
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinSet;

use crate::access::login::Door;
use crate::access::rights::WorldControl;
use crate::config::{IfTaken, Listener, Service};
use crate::door::accept::{self, Limit};
use crate::error::ServeError;
use crate::maps::Maps;
use crate::page::class::ClassPages;
use crate::page::map::MapPictures;
use crate::page::packed::Packed;
use crate::page::scenario::ScenarioPages;
use crate::page::shared::{Framing, Site};
use crate::page::site::Page;
use crate::scenarios::Scenarios;
use crate::subscribers::board::Board;
use crate::subscribers::live::{self, Broadcast};

/// Interval between two frames, and least time between two snapshots that are worth taking.
const FRAME_INTERVAL: Duration = Duration::from_millis(33);
/// Most connections to the page at once.
const MAX_CONNECTIONS: usize = 64;

/// The page of a world that another program steps. It ends when dropped.
pub struct View {
    address: SocketAddr,
    moments: Option<SyncSender<Moment>>,
    /// Earliest time of the next snapshot.
    next: Instant,
    stop: Option<oneshot::Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

/// Content of a page at one time.
#[derive(Debug)]
pub struct Moment {
    /// The world.
    pub snapshot: Snapshot,
    /// Readings since the last moment, each with its time, s.
    pub readings: Vec<(f64, Sensed)>,
}

impl View {
    /// Serves the page of a world on a port of this machine; 0 takes a free one. Other pages of this machine, such as notebooks, may frame
    /// it.
    ///
    /// # Errors
    /// When it cannot listen on the port, or a thread cannot be started.
    pub fn start(def: &WorldDef, options: Options, port: u16) -> Result<Self, ServeError> {
        let host = Ipv4Addr::LOCALHOST.to_string();
        let listener = Listener { service: Service::Page, port, if_taken: IfTaken::Fail };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(ServeError::Start)?;
        let bound = runtime.block_on(accept::listen(&host, listener))?.ok_or(ServeError::WorldStopped)?;
        let address = bound.local_addr().map_err(ServeError::Start)?;
        let about = About { seed: options.seed, time_step: options.time_step, port: 0, maps: Vec::new() };
        let (live, channels) = live::broadcast(Instant::now(), def, Some(about), Board::default());
        let (entrance, requests) = Entrance::new();
        let Door { access, room, .. } = Door::new(None, MAX_CONNECTIONS);
        let site = Site {
            host,
            protocol: SocketAddr::from((Ipv4Addr::LOCALHOST, 0)),
            channels,
            inquiry: entrance.guest(Kind::Http),
            entrance,
            stall_timeout: Duration::from_secs(30),
            world_control: WorldControl::Nobody,
            access,
            limits: Vec::new(),
            packed: Packed::default(),
            classes: ClassPages::new(&def.robots),
            scenarios: ScenarioPages::new(Scenarios::default(), def),
            maps: MapPictures::new(Maps::default(), def),
            opener: None,
            pages: AtomicU64::new(0),
            framing: Framing::Local,
            #[cfg(feature = "ros2")]
            rosbridge: None,
        };
        let (moments, taken) = sync_channel(1);
        let (stop, stopped) = oneshot::channel();
        let def = def.clone();
        let thread = |name: &str| std::thread::Builder::new().name(name.to_owned());
        let show = move || show(live, &def, &taken, &requests);
        let showing = thread("view").spawn(show).map_err(ServeError::Start)?;
        let serve = move || {
            runtime.block_on(async {
                let (mut clients, page) = (JoinSet::new(), Page::new(Arc::new(site), MAX_CONNECTIONS));
                let next = async |listener: &TcpListener| room.accept(listener).await;
                tokio::select! {
                    () = accept::accept(&mut clients, bound, Limit::Elsewhere, next, |visitor| page.clone().serve(visitor)) => {}
                    _ = stopped => {}
                }
            });
        };
        let serving = thread("view-page").spawn(serve).map_err(ServeError::Start)?;
        let (next, threads) = (Instant::now(), vec![showing, serving]);
        Ok(Self { address, moments: Some(moments), next, stop: Some(stop), threads })
    }

    /// Returns the address of the page.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// True if a new snapshot would be shown.
    pub fn is_due(&self) -> bool {
        Instant::now() >= self.next
    }

    /// Shows a moment, unless the last one still waits for its turn.
    pub fn show(&mut self, moment: Moment) {
        self.next = Instant::now() + FRAME_INTERVAL;
        if let Some(moments) = &self.moments {
            match moments.try_send(moment) {
                // The thread ends only with this value.
                Ok(()) | Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {}
            }
        }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        // Both threads end when their senders are gone.
        (self.moments, self.stop) = (None, None);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Publishes the last moment, its snapshot again for viewers that come later, until the program is gone.
fn show(mut live: Broadcast, def: &WorldDef, moments: &Receiver<Moment>, requests: &mpsc::Receiver<Event>) {
    let (mut shown, mut measured, mut speed) = (Arc::<Snapshot>::default(), (Instant::now(), 0.0), 0.0);
    loop {
        match moments.recv_timeout(FRAME_INTERVAL) {
            Ok(Moment { snapshot, readings }) => {
                shown = Arc::new(snapshot);
                for (time, sensed) in &readings {
                    let robot = shown.robots.iter().find(|robot| robot.id == sensed.robot);
                    live.measured(Instant::now(), *time, robot.and_then(|robot| def.robots.get(&robot.class)), sensed);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        // A request that is dropped is answered as by a world that has ended.
        requests.try_iter().for_each(drop);
        let now = Instant::now();
        let elapsed = now.duration_since(measured.0).as_secs_f64();
        if elapsed >= 0.5 {
            speed = ((shown.time - measured.1) / elapsed).max(0.0);
            measured = (now, shown.time);
        }
        live.remember(now, def, shown.time, || shown.clone());
        if let Some(due) = live.due(now) {
            let status = due.status.then(|| status(&shown, speed));
            live.publish(now, def, &shown, status);
        }
    }
}

fn status(shown: &Snapshot, speed: f64) -> Status {
    let robot = |robot: &scene::RobotSnapshot| RobotStatus {
        id: robot.id.0,
        class: robot.class.clone(),
        name: robot.name.clone(),
        connection: None,
        battery: None,
    };
    Status {
        real_time_factor: speed,
        speed: 1.0,
        robots: shown.robots.iter().map(robot).collect(),
        ..Status::default()
    }
}
