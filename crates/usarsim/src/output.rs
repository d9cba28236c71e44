//! Output files and folders, kept apart from the input files of the same command.

use std::path::{Path, PathBuf};

use crate::signal::stop_signal;
use crate::{Failure, complain, exit};

/// Most tries to remove a folder.
const MAX_TRIES: usize = 100;

/// Refuses an output file that is one of the input files, by the same path, a symbolic link or a hard link.
///
/// A command opens its output after reading its input, so it would silently replace the input.
pub(crate) fn keep_inputs(out: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    let mut inputs = inputs.iter().map(AsRef::as_ref);
    let Some(input) = inputs.find(|input| is_same_file(out, input)) else { return Ok(()) };
    let (out, input) = (out.display(), input.display());
    let message =
        format!("the output {out} is the input file {input}, which would be lost: choose another output file");
    Err(Failure::new(exit::USAGE, message))
}

/// Makes a folder, which must be new: another program may use an empty one.
pub(crate) fn new_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir(folder).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            let message = format_args!("{}: exists already: choose another name, or remove it", folder.display());
            Failure::new(exit::FAILURE, message)
        }
        _ => failed(folder, error),
    })
}

/// Makes a folder and fills it. Leaves nothing if that fails, or if Ctrl-C or SIGTERM ends the program meanwhile.
pub(crate) fn fill_new_folder<T>(folder: &Path, fill: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    new_folder(folder)?;
    let (done, ended) = tokio::sync::oneshot::channel();
    let (ready, watching) = std::sync::mpsc::channel();
    let unfinished = folder.to_owned();
    let watch = move || remove_at_signal(unfinished, ready, ended);
    let watch = std::thread::Builder::new().name("signals".to_owned()).spawn(watch);
    // A signal before the thread listens would end the program and leave the folder. An error says that there is no thread.
    let _ = watching.recv();
    let filled = fill();
    drop(done);
    // After a signal it removes the folder and does not return.
    if let Ok(thread) = watch {
        let _ = thread.join();
    }
    if filled.is_err() {
        let _ = std::fs::remove_dir_all(folder);
    }
    filled
}

/// Removes a folder and ends the program at a signal, until the other end of `ended` is dropped. Says when it is `ready` for signals.
fn remove_at_signal(folder: PathBuf, ready: std::sync::mpsc::Sender<()>, ended: tokio::sync::oneshot::Receiver<()>) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build();
    let Ok(runtime) = runtime else { return };
    let is_stopped = runtime.block_on(async {
        let ended = async {
            let _ = ready.send(());
            ended.await
        };
        // The first poll of `stop_signal` sets up the handlers, so it comes first.
        tokio::select! {
            biased;
            () = stop_signal() => true,
            _ = ended => false,
        }
    });
    if !is_stopped {
        return;
    }
    // The other thread may write a file meanwhile.
    for _ in 0..MAX_TRIES {
        if std::fs::remove_dir_all(&folder).is_ok() {
            break;
        }
    }
    complain(format_args!("{}: stopped, and removed", folder.display()));
    std::process::exit(exit::FAILURE.into());
}

/// Writes a file.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, content).map_err(|error| failed(path, error))
}

/// Returns the failure of a file or folder that cannot be written.
pub(crate) fn failed(path: &Path, error: std::io::Error) -> Failure {
    Failure::new(exit::FAILURE, format_args!("{}: {error}", path.display()))
}

/// Returns the files from which a robot or map given as `NAME|FILE` may be read: the path itself, or a definition in that folder.
pub(crate) fn definition_files(given: &str) -> [PathBuf; 3] {
    let path = Path::new(given);
    [path.to_owned(), path.join("robot.toml"), path.join("map.toml")]
}

/// True if both paths lead to one regular file. Devices store nothing, so one may be both read and written.
#[cfg(unix)]
fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |path| std::fs::metadata(path).ok().filter(|it| it.is_file()).map(|it| (it.dev(), it.ino()));
    identity(a).is_some_and(|a| identity(b) == Some(a))
}

/// True if both paths lead to one regular file. Hard links are not recognised.
#[cfg(not(unix))]
fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok().filter(|path| path.is_file());
    place(a).is_some_and(|a| place(b) == Some(a))
}
