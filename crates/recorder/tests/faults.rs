//! Disks that fail: at every operation in turn, once or from then on. Flushed records are kept, and the failure is reported
//! once.

mod support;

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard};

use recorder::{End, LogWriter, Record, Recorder, Storage};
use sim_core::Options;
use support::{run, world};

/// A disk in memory.
#[derive(Clone, Default)]
struct Disk(Arc<(Mutex<State>, Condvar)>);

#[derive(Default)]
struct State {
    bytes: Vec<u8>,
    operations: usize,
    /// Index of the operation that fails, from 0, and true if all later ones fail as well.
    fails: Option<(usize, bool)>,
    /// True while the disk takes nothing.
    stalled: bool,
}

impl Disk {
    fn failing(at: usize, for_ever: bool) -> Self {
        let disk = Self::default();
        disk.state().fails = Some((at, for_ever));
        disk
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.0.lock().expect("no test panics here")
    }

    fn stall(&self, stalled: bool) {
        self.state().stalled = stalled;
        self.0.1.notify_all();
    }

    fn begin(&self) -> MutexGuard<'_, State> {
        self.0.1.wait_while(self.state(), |state| state.stalled).expect("no test panics here")
    }

    fn operation(state: &mut State) -> io::Result<()> {
        let number = state.operations;
        state.operations += 1;
        match state.fails {
            Some((at, for_ever)) if number == at || for_ever && number > at => {
                Err(io::Error::from(io::ErrorKind::StorageFull))
            }
            _ => Ok(()),
        }
    }

    /// Reads the log on the disk.
    fn read(&self) -> Result<recorder::Log, recorder::ReadError> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), &self.state().bytes).expect("a file");
        recorder::read(file.path())
    }
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.begin();
        let result = Self::operation(&mut state);
        // A disk that fills up takes a part first.
        let taken = if result.is_ok() { bytes.len() } else { bytes.len() / 2 };
        state.bytes.extend_from_slice(&bytes[..taken]);
        result.map(|()| taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Self::operation(&mut self.begin())
    }
}

impl Storage for Disk {
    fn sync(&mut self) -> io::Result<()> {
        Self::operation(&mut self.begin())
    }
}

fn begin(disk: &Disk, ros2: Option<&Disk>) -> Result<LogWriter, recorder::RecordError> {
    let world = world();
    let log = LogWriter::create_on(Box::new(disk.clone()), Path::new("run.mcap"), &world, Options::default(), &[])?;
    match ros2 {
        Some(ros2) => log.with_ros2(&world, |_| Ok(Box::new(ros2.clone()))),
        None => Ok(log),
    }
}

/// Writes a run with a flush after every ten records. Returns the number of records at the last successful flush, and the
/// error.
fn written(disk: &Disk, ros2: Option<&Disk>, records: &[(f64, Record)], end: End) -> (usize, Option<String>) {
    let mut flushed = 0;
    let mut write = || {
        let mut log = begin(disk, ros2)?;
        for (index, (time, record)) in records.iter().enumerate() {
            log.write(*time, record)?;
            if index % 10 == 9 {
                log.flush()?;
                flushed = index + 1;
            }
        }
        log.finish(end)?;
        flushed = records.len();
        Ok(())
    };
    let result: Result<(), recorder::RecordError> = write();
    (flushed, result.err().map(|error| error.to_string()))
}

#[test]
fn whatever_operation_fails_what_was_flushed_before_reads_back() {
    let (records, end) = run();
    let whole = Disk::default();
    assert_eq!(written(&whole, None, &records, end), (records.len(), None));
    let entries = whole.read().expect("a log").entries;
    assert_eq!(entries.len(), records.len());
    let operations = whole.state().operations;
    assert!(operations > 20, "{operations}");
    for at in 0..=operations {
        for for_ever in [false, true] {
            let disk = Disk::failing(at, for_ever);
            let (flushed, error) = written(&disk, None, &records, end);
            assert_eq!(error.is_some(), at < operations, "{at}: {error:?}");
            assert!(
                error.is_none_or(|error| error.starts_with("log run.mcap: ") && error.contains("no storage space"))
            );
            if flushed > 0 {
                let log = disk.read().unwrap_or_else(|error| panic!("{at}: {error}"));
                assert!(log.entries.len() >= flushed, "{at}: {} of {flushed}", log.entries.len());
                assert_eq!(log.entries, entries[..log.entries.len()], "{at}");
            }
        }
    }
}

#[test]
fn a_second_file_that_fails_ends_the_log_with_its_name() {
    let (records, end) = run();
    let [whole, ros2] = [Disk::default(), Disk::default()];
    assert_eq!(written(&whole, Some(&ros2), &records, end).1, None);
    let operations = ros2.state().operations;
    assert!(operations > 5);
    for at in 0..operations {
        let (disk, ros2) = (Disk::default(), Disk::failing(at, true));
        let (flushed, error) = written(&disk, Some(&ros2), &records, end);
        let error = error.expect("an error");
        assert!(error.starts_with("log run.ros2.mcap: "), "{error}");
        assert!(flushed == 0 || disk.read().is_ok_and(|log| log.entries.len() >= flushed));
    }
}

#[test]
fn a_recorder_that_fails_says_so_once_and_takes_on_without_harm() {
    let (records, _) = run();
    let disk = Disk::default();
    let mut recorder = Recorder::new(begin(&disk, None).expect("a log")).expect("a recorder");
    let now = disk.state().operations;
    disk.state().fails = Some((now, true));
    for (time, record) in records.clone() {
        recorder.record(time, record);
    }
    assert!(recorder.failure().is_none());
    // The thread flushes within a second, and ends.
    while recorder.is_writing() {
        std::thread::yield_now();
    }
    let error = recorder.failure().expect("an error").to_string();
    assert!(error.starts_with("log run.mcap: ") && error.contains("no storage space"), "{error}");
    assert!(recorder.failure().is_none(), "it is said once");
    for (time, record) in records {
        recorder.record(time, record);
    }
    assert_eq!(recorder.finish(support::end(1.0)).wait().map_err(|error| error.to_string()), Ok(()));
}

#[test]
fn a_single_record_reaches_the_file_without_anything_after_it() {
    let disk = Disk::default();
    let mut recorder = Recorder::new(begin(&disk, None).expect("a log")).expect("a recorder");
    recorder.record(0.0, Record::In(support::line("DRIVE {Left 1}")));
    while disk.read().map_or(0, |log| log.entries.len()) == 0 {
        std::thread::yield_now();
    }
}

#[test]
fn the_end_of_a_log_on_a_stalled_disk_is_not_waited_for() {
    let disk = Disk::default();
    let (records, end) = run();
    let mut recorder = Recorder::new(begin(&disk, None).expect("a log")).expect("a recorder");
    disk.stall(true);
    records.iter().cloned().for_each(|(time, record)| recorder.record(time, record));
    let closing = recorder.finish(end);
    assert!(!closing.is_done());
    disk.stall(false);
    closing.wait().unwrap_or_else(|error| panic!("{error}"));
    let log = disk.read().expect("a log");
    assert_eq!((log.entries.len(), log.damage), (records.len(), None));
    assert_eq!(log.end["digest"], format!("{:016x}", end.digest.expect("a digest")));
}

#[test]
fn what_waits_for_a_stalled_disk_is_bounded_and_what_is_lost_is_counted() {
    let disk = Disk::default();
    let mut recorder = Recorder::new(begin(&disk, None).expect("a log")).expect("a recorder");
    disk.stall(true);
    // 400 MB of lines, which memory holds uncompressed.
    let (count, length) = (6400, 64 * 1024);
    for number in 0..count {
        let text = format!("{number} {}", "x".repeat(length));
        recorder.record(0.001 * f64::from(number), Record::In(support::line(text)));
    }
    let closing = recorder.finish(support::end(10.0));
    disk.stall(false);
    closing.wait().unwrap_or_else(|error| panic!("{error}"));
    let log = disk.read().expect("a log");
    let dropped: usize = log.end["dropped"].parse().expect("a number");
    assert_eq!(log.entries.len() + dropped, count as usize);
    // 64 MiB of lines that are a little longer than 64 KiB.
    assert!((900..=1023).contains(&log.entries.len()), "{} kept", log.entries.len());
    assert!(logbook::replay(&log).is_err_and(|error| error.to_string().contains("records were dropped")));
}

#[test]
fn a_full_disk_and_a_folder_that_is_not_there_are_named() {
    let refused = |path: &str| {
        let log = LogWriter::create(Path::new(path), &world(), Options::default(), &[]);
        log.err().map_or(String::new(), |error| error.to_string())
    };
    if Path::new("/dev/full").exists() {
        let said = refused("/dev/full");
        assert!(said.starts_with("log /dev/full: ") && said.contains("No space left"), "{said}");
    }
    let said = refused("/nowhere/run.mcap");
    assert!(said.starts_with("log /nowhere/run.mcap: No such file"), "{said}");
}

#[test]
fn a_log_that_somebody_writes_is_not_begun_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let (records, end) = run();
    let begin = || LogWriter::create(&file, &world(), Options::default(), &[]);
    let mut first = begin().expect("a log");
    let said = begin().err().map_or(String::new(), |error| error.to_string());
    assert!(said.contains("another program is writing it: end that program, or choose another file"), "{said}");
    records.iter().for_each(|(time, record)| first.write(*time, record).expect("a record"));
    first.finish(end).expect("an end");
    assert_eq!(recorder::read(&file).expect("a log").entries.len(), records.len());
    begin().expect("it is free again");
}

#[test]
fn ten_thousand_robots_come_and_go_in_one_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let mut records = Vec::new();
    for robot in 0..10_000 {
        let time = 0.02 * robot as f64;
        // One robot stays while the others come and go.
        records.push((time, Record::State(support::state(7, "none"))));
        if robot != 7 {
            records.push((time, Record::State(support::state(robot, "none"))));
            records.push((time, Record::Left(robot)));
        }
    }
    support::write(&file, &world(), &records, support::end(200.0));
    let bytes = std::fs::read(&file).expect("the log");
    let summary = mcap::Summary::read(&bytes).expect("an index").expect("an index");
    let mut topics: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
    topics.sort_unstable();
    let robot = ["joints", "pose", "scene", "state", "tf"].map(|name| format!("/robot/1/{name}"));
    assert_eq!(topics.iter().filter(|topic| topic.starts_with("/robot/1/")).collect::<Vec<_>>(), robot.each_ref());
    // Topics of two slots, and those that exist once.
    assert_eq!(topics.len(), 13, "{topics:?}");
    let log = recorder::read(&file).expect("a log");
    assert_eq!(log.entries.len(), records.len());
    // Messages contain the robot's number.
    let numbers = log.entries.iter().filter_map(|entry| match &entry.record {
        Record::State(state) => Some(state.robot),
        _ => None,
    });
    assert_eq!(numbers.max(), Some(9999));
}
