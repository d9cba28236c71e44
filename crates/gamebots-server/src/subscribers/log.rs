//! Logs of a served world, from the start or on request.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use recorder::{Closing, End, LogWriter, RecordError, Recorder, StateTimer, Storage, ros2_path};
use served_world::Told;
use sim_core::{Options, World};

use crate::files::{is_kept, numbered};
use crate::subscribers::subscriber::{Moment, Shot, Subscriber, record_of};

/// Least real time between the beginnings of two logs.
const BEGIN_INTERVAL: Duration = Duration::from_secs(1);
/// Most ended logs that wait for the disk when another starts; each may hold queued records.
const MAX_CLOSING: usize = 4;

/// Settings of logs, the one that is being written, and those that are being completed.
pub(crate) struct Recording {
    options: Options,
    real_time_factor: f64,
    ros2: bool,
    /// File name of a log that nobody has named.
    unnamed: PathBuf,
    open: Option<Open>,
    /// Logs that are being completed, with their files.
    closing: Vec<(PathBuf, Closing)>,
    /// The last number given to a file of each name.
    numbers: BTreeMap<PathBuf, u32>,
    /// Time when the last log was started on request, or because the world started over.
    begun: Option<Instant>,
    states: StateTimer,
    storage: fn(&Path) -> std::io::Result<Box<dyn Storage>>,
}

/// A log that is being written.
struct Open {
    path: PathBuf,
    /// Its name without a number.
    name: PathBuf,
    recorder: Recorder,
}

/// The reason why no log starts.
#[derive(Debug, thiserror::Error)]
pub(crate) enum BeginError {
    /// A client asks for logs too often.
    #[error("the last log was begun less than a second ago: try again in a second")]
    TooSoon,
    /// The disk is too slow for the logs.
    #[error("{0} logs are still being written: the disk is too slow for another one now")]
    TooMany(usize),
    /// The file cannot be written.
    #[error(transparent)]
    Log(#[from] RecordError),
}

impl Recording {
    /// Creates a recording without a log.
    pub(crate) fn new(options: Options, real_time_factor: f64, ros2: bool, unnamed: PathBuf) -> Self {
        let (open, closing, numbers, begun, storage) = (None, Vec::new(), BTreeMap::new(), None, recorder::storage);
        let states = StateTimer::default();
        Self { options, real_time_factor, ros2, unnamed, open, closing, numbers, begun, states, storage }
    }

    /// Returns the file that is being written.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.open.as_ref().filter(|open| open.recorder.is_writing()).map(|open| open.path.as_path())
    }

    /// Starts a log with this name. If the file exists, the name gets the next free number: no file is replaced. An open log
    /// ends.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn start(&mut self, name: &Path, world: &World) -> Result<(), RecordError> {
        let path = self.free(name);
        self.begin(path, name, world)
    }

    /// Starts a log under a free name.
    ///
    /// # Errors
    /// When it is too soon, too many logs are incomplete, or the file cannot be written.
    pub(crate) fn start_unnamed(&mut self, now: Instant, world: &World) -> Result<(), BeginError> {
        self.may_begin(now)?;
        self.begun = Some(now);
        let name = self.unnamed.clone();
        let path = self.free(&name);
        Ok(self.begin(path, &name, world)?)
    }

    /// Ends the log properly. The world does not wait for the disk: a notice reports the end.
    pub(crate) fn stop(&mut self, world: &World) {
        self.close(world);
    }

    /// Checks if the world may start over now: an open log would be followed by another.
    ///
    /// # Errors
    /// When that would be too soon, or too many logs are incomplete.
    pub(crate) fn may_start_over(&self, now: Instant) -> Result<(), BeginError> {
        self.open.as_ref().map_or(Ok(()), |_| self.may_begin(now))
    }

    /// Ends the log of a world that has panicked, with the step that panicked and without a digest.
    fn stop_broken(&mut self, world: &World) {
        if let Some(Open { path, recorder, .. }) = self.open.take() {
            self.closing.push((path, recorder.finish(end_of(world, world.time() + world.time_step(), None))));
        }
    }

    /// Ends the log of the old world. If one was open, starts the next beside it.
    ///
    /// # Errors
    /// When the next file cannot be written.
    fn follow(&mut self, now: Instant, old: &World, new: &World) -> Result<(), RecordError> {
        let Some(name) = self.close(old) else { return Ok(()) };
        self.begun = Some(now);
        let path = self.free(&name);
        self.begin(path, &name, new)
    }

    /// Returns what happened to logs since the last call: those that are complete, and the reason why one ended by itself.
    fn news(&mut self) -> Vec<String> {
        let mut news = Vec::new();
        if let Some(error) = self.open.as_mut().and_then(|open| open.recorder.failure()) {
            news.push(format!("the recording ended: {error}"));
            self.open = None;
        }
        for (path, closing) in self.closing.extract_if(.., |(_, closing)| closing.is_done()) {
            news.push(match closing.wait() {
                Ok(()) => format!("recorded {}", path.display()),
                Err(error) => format!("the recording is not complete: {error}"),
            });
        }
        news
    }

    fn may_begin(&self, now: Instant) -> Result<(), BeginError> {
        if self.begun.is_some_and(|begun| now.duration_since(begun) < BEGIN_INTERVAL) {
            return Err(BeginError::TooSoon);
        }
        let waiting = self.closing.iter().filter(|(_, closing)| !closing.is_done()).count();
        if waiting >= MAX_CLOSING { Err(BeginError::TooMany(waiting)) } else { Ok(()) }
    }

    fn begin(&mut self, path: PathBuf, name: &Path, world: &World) -> Result<(), RecordError> {
        self.close(world);
        let mut description = vec![("real_time_factor".to_owned(), self.real_time_factor.to_string())];
        if !world.is_untouched() {
            description.push(("began".to_owned(), world.time().to_string()));
        }
        let file = (self.storage)(&path).map_err(|reason| RecordError::new(&path, &reason))?;
        let mut log = LogWriter::create_on(file, &path, world.def(), self.options, &description)?;
        if self.ros2 {
            log = log.with_ros2(world.def(), self.storage)?;
        }
        self.open = Some(Open { path, name: name.to_owned(), recorder: Recorder::new(log)? });
        self.states = StateTimer::default();
        Ok(())
    }

    /// Ends the open log, if any, and returns its name.
    fn close(&mut self, world: &World) -> Option<PathBuf> {
        let Open { path, name, recorder, .. } = self.open.take()?;
        self.closing.push((path, recorder.finish(end_of(world, world.time(), Some(world.digest())))));
        Some(name)
    }

    /// Returns the path, or the path with the next number that makes it a new file: `run.mcap`, `run-2.mcap`, `run-3.mcap` ...
    fn free(&mut self, name: &Path) -> PathBuf {
        let last = self.numbers.entry(name.to_owned()).or_default();
        loop {
            *last += 1;
            let path = numbered(name, *last);
            let is_taken = is_kept(&path) || self.ros2 && is_kept(&ros2_path(&path));
            if !is_taken {
                return path;
            }
        }
    }
}

impl Subscriber for Recording {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        if let Some(open) = &mut self.open
            && let Some(record) = record_of(event)
        {
            open.recorder.record(moment.world.time(), record);
        }
    }

    fn see(&mut self, moment: &mut Moment, shot: &Shot) {
        if let Some(open) = &mut self.open {
            open.recorder.record(moment.world.time(), shot.record());
        }
    }

    fn keeps_records(&self) -> bool {
        self.open.is_some()
    }

    /// Records the states of the world, if they are due.
    fn stepped(&mut self, moment: &mut Moment) -> Vec<Shot> {
        if let Some(open) = &mut self.open
            && self.states.is_due(moment.world.time())
        {
            open.recorder.record_states(moment.snapshot());
        }
        Vec::new()
    }

    fn publish(&mut self, _: &mut Moment) -> Vec<String> {
        self.news()
    }

    fn start_over(&mut self, moment: &mut Moment, old: &World) -> Vec<String> {
        self.follow(moment.now, old, moment.world).err().map(|error| error.to_string()).into_iter().collect()
    }

    fn end(&mut self, moment: &mut Moment, panic: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        match panic {
            None => self.stop(moment.world),
            Some(_) => self.stop_broken(moment.world),
        }
        None
    }
}

/// Describes a world's end at a time, with a digest if there is one.
fn end_of(world: &World, time: f64, digest: Option<u64>) -> End {
    End { time, digest, unsettled_steps: world.unsettled_steps(), dropped: 0 }
}

#[cfg(test)]
mod tests {
    use std::io::{Error, ErrorKind, Result as IoResult, Write};
    use std::sync::{Condvar, Mutex};

    use scene::WorldDef;

    use super::*;
    use crate::subscribers::present::Present;

    fn world() -> World {
        World::new(WorldDef::default(), Options::default())
    }

    fn recording(folder: &Path) -> Recording {
        Recording::new(Options::default(), 1.0, false, folder.join("run.mcap"))
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Records a warning.
    fn warn(recording: &mut Recording, world: &World, text: &str) {
        let present = &mut Present::default();
        recording.hear(&mut Moment { world, now: Instant::now(), is_recorded: true, present }, &Told::Warning(text));
    }

    /// Waits until there is news.
    fn news(recording: &mut Recording) -> Vec<String> {
        loop {
            let news = recording.news();
            if !news.is_empty() {
                return news;
            }
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_log_is_begun_at_most_once_a_second() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let (mut recording, now) = (recording(folder.path()), Instant::now());
        let after = |milliseconds| now + Duration::from_millis(milliseconds);
        let begun = |result: Result<(), BeginError>| result.map_err(|error| error.to_string());
        let too_soon = Err("the last log was begun less than a second ago: try again in a second".to_owned());
        assert_eq!(begun(recording.may_start_over(now)), Ok(()), "nothing is written");
        assert_eq!(begun(recording.start_unnamed(now, &world)), Ok(()));
        assert_eq!(begun(recording.start_unnamed(after(999), &world)), too_soon);
        assert_eq!(begun(recording.may_start_over(after(999))), too_soon);
        assert_eq!(begun(recording.may_start_over(after(1000))), Ok(()));
        recording.follow(after(1000), &world, &world).expect("a log");
        assert_eq!(begun(recording.start_unnamed(after(1999), &world)), too_soon);
        recording.stop(&world);
        assert_eq!(begun(recording.may_start_over(after(1001))), Ok(()), "nothing is written");
        assert_eq!(begun(recording.start_unnamed(after(2000), &world)), Ok(()));
        drop(recording);
        assert_eq!(names(folder.path()), ["run-2.mcap", "run-3.mcap", "run.mcap"]);
    }

    #[test]
    fn the_next_log_of_a_name_has_the_next_number() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let (mut recording, now) = (recording(folder.path()), Instant::now());
        std::fs::write(folder.path().join("mine-2.mcap"), "old").expect("a file");
        recording.start(&folder.path().join("mine.mcap"), &world).expect("a log");
        for _ in 0..3 {
            recording.follow(now, &world, &world).expect("a log");
        }
        recording.start_unnamed(now + BEGIN_INTERVAL, &world).expect("a log");
        let path = recording.path().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        assert_eq!(path.as_deref(), Some("run.mcap"));
        drop(recording);
        let expected = ["mine-2.mcap", "mine-3.mcap", "mine-4.mcap", "mine-5.mcap", "mine.mcap", "run.mcap"];
        assert_eq!(names(folder.path()), expected);
        assert_eq!(std::fs::read(folder.path().join("mine-2.mcap")).expect("a file"), b"old");
    }

    #[test]
    fn a_log_replaces_no_file() {
        for (there, ros2, expected) in [
            (&[][..], false, "run.mcap"),
            (&["run.mcap"], false, "run-2.mcap"),
            (&["run.mcap", "run-2.mcap", "run-4.mcap"], false, "run-3.mcap"),
            (&["run.ros2.mcap"], false, "run.mcap"),
            (&["run.ros2.mcap"], true, "run-2.mcap"),
            (&["run.mcap", "run-2.ros2.mcap"], true, "run-3.mcap"),
        ] {
            let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
            let path = |name: &str| folder.path().join(name);
            there.iter().for_each(|name| std::fs::write(path(name), "old").expect("a file"));
            let mut recording = Recording { ros2, ..recording(folder.path()) };
            recording.start(&path("run.mcap"), &world).expect("a log");
            assert_eq!(recording.path(), Some(path(expected).as_path()), "{there:?}");
            recording.stop(&world);
            news(&mut recording);
            for name in there {
                assert_eq!(std::fs::read(path(name)).expect("a file"), b"old", "{there:?}: {name} has changed");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_log_is_written_to_a_device_and_not_through_a_link() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let mut recording = recording(folder.path());
        recording.start(Path::new("/dev/null"), &world).expect("a log");
        assert_eq!(recording.path(), Some(Path::new("/dev/null")));
        for (link, target) in [("old.mcap", "old"), ("dead.mcap", "nothing")] {
            std::fs::write(folder.path().join("old"), "old").expect("a file");
            std::os::unix::fs::symlink(target, folder.path().join(link)).expect("a link");
            recording.start(&folder.path().join(link), &world).expect("a log");
            let numbered = folder.path().join(link.replace(".mcap", "-2.mcap"));
            assert_eq!(recording.path(), Some(numbered.as_path()), "{link}");
        }
        assert_eq!(std::fs::read(folder.path().join("old")).expect("a file"), b"old");
    }

    #[test]
    fn two_servers_do_not_write_one_log() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let path = folder.path().join("run.mcap");
        let [mut first, mut second] = [recording(folder.path()), recording(folder.path())];
        first.start(&path, &world).expect("a log");
        second.start(&path, &world).expect("a log");
        assert_eq!(second.path(), Some(folder.path().join("run-2.mcap").as_path()));
        // The lock refuses a server that found the name free a moment ago.
        let late = second.begin(path.clone(), &path, &world).expect_err("it is written").to_string();
        assert!(late.contains("another program is writing it: end that program"), "{late}");
        first.stop(&world);
        assert_eq!(news(&mut first), [format!("recorded {}", path.display())]);
        assert!(recorder::read(&path).is_ok_and(|log| log.damage.is_none() && !log.end.is_empty()));
    }

    /// A disk with room only for the beginning of a log.
    struct Small(usize);

    impl Write for Small {
        fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(Error::from(ErrorKind::StorageFull))?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    impl Storage for Small {
        fn sync(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    #[test]
    fn a_log_on_a_full_disk_ends_with_a_word_and_the_world_goes_on() {
        let (folder, mut world) = (tempfile::tempdir().expect("a folder"), world());
        let mut recording = recording(folder.path());
        recording.storage = |_| Ok(Box::new(Small(20_000)));
        recording.start_unnamed(Instant::now(), &world).expect("a log");
        assert!(recording.path().is_some() && recording.news().is_empty());
        let mut number = 0_u32;
        while recording.path().is_some() {
            // LZ4 cannot compress these numbers.
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            warn(&mut recording, &world, &format!("{number:x}"));
            world.step();
        }
        let said = news(&mut recording);
        assert!(said.len() == 1 && said[0].starts_with("the recording ended: log "), "{said:?}");
        assert!(said[0].ends_with("run.mcap: no storage space"), "{said:?}");
        assert!(recording.news().is_empty(), "it is said once");
        warn(&mut recording, &world, "nobody hears it");
        recording.stop(&world);
        recording.storage = recorder::storage;
        recording.start_unnamed(Instant::now() + BEGIN_INTERVAL, &world).expect("another disk");
    }

    #[test]
    fn a_folder_that_is_gone_is_named_when_the_next_log_begins() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let (mut recording, now) = (recording(folder.path()), Instant::now());
        recording.start_unnamed(now, &world).expect("a log");
        drop(folder);
        warn(&mut recording, &world, "into nothing");
        let refused = recording.follow(now, &world, &world).expect_err("no folder").to_string();
        assert!(refused.contains("run-2.mcap: No such file or directory"), "{refused}");
        assert_eq!(recording.path(), None);
    }

    /// A disk that stalls. It takes the beginnings of logs, which other threads write, but nothing from the recorder's thread
    /// for a while.
    struct Stalled;

    static TAKES: (Mutex<bool>, Condvar) = (Mutex::new(false), Condvar::new());

    impl Write for Stalled {
        fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
            if std::thread::current().name() == Some("recorder") {
                let takes = TAKES.0.lock().expect("no test panics here");
                drop(TAKES.1.wait_while(takes, |takes| !*takes));
            }
            Ok(bytes.len())
        }

        fn flush(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    impl Storage for Stalled {
        fn sync(&mut self) -> IoResult<()> {
            Ok(())
        }
    }

    #[test]
    fn the_world_does_not_wait_for_the_ends_of_logs_on_a_stalled_disk() {
        let (folder, world) = (tempfile::tempdir().expect("a folder"), world());
        let (mut recording, now) = (recording(folder.path()), Instant::now());
        recording.storage = |_| Ok(Box::new(Stalled));
        let mut later = (0..).map(|second| now + Duration::from_secs(second));
        for _ in 0..MAX_CLOSING {
            recording.start_unnamed(later.next().unwrap_or(now), &world).expect("a log");
            warn(&mut recording, &world, "it waits");
            recording.stop(&world);
            assert_eq!(recording.path(), None);
        }
        assert!(recording.news().is_empty(), "none is complete");
        let refused = recording.start_unnamed(later.next().unwrap_or(now), &world).expect_err("too many").to_string();
        assert!(refused.starts_with("4 logs are still being written: the disk is too slow"), "{refused}");
        *TAKES.0.lock().expect("no test panics here") = true;
        TAKES.1.notify_all();
        let mut complete = Vec::new();
        while complete.len() < MAX_CLOSING {
            complete.extend(news(&mut recording));
        }
        assert!(complete.iter().all(|text| text.starts_with("recorded ")), "{complete:?}");
        recording.start_unnamed(later.next().unwrap_or(now), &world).expect("a log");
    }
}
