//! Files of other programs that somebody brings: a robot's class or a map is made of them, and the server has it from then on.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use axum::body::Bytes;
use scene::{Classes, MapDef, RobotDef};
use serde::Serialize;
use tokio::sync::Semaphore;

use crate::maps::Maps;

/// Most folders around a file, and the longest path, bytes.
const MAX_DEPTH: usize = 16;
const MAX_PATH: usize = 400;
/// Most people whose files are opened at once.
const MAX_AT_ONCE: usize = 2;

/// Reader of the files of other programs: gets a folder with them, a folder to work in, and the name of the file that was chosen.
#[derive(Clone)]
pub struct Open(pub OpenFiles);

/// The function of [`Open`].
pub type OpenFiles = Arc<dyn Fn(&Path, &Path, Option<&str>) -> Result<Opened, NotOpened> + Send + Sync>;

impl std::fmt::Debug for Open {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Open")
    }
}

/// Something that was made of files of other programs.
#[derive(Debug)]
pub struct Opened {
    /// The robot or map.
    pub thing: Thing,
    /// Lines that say what it is.
    pub verdict: Vec<String>,
    /// Guesses, and parts of the files that were replaced or left out.
    pub notes: Vec<String>,
}

/// A robot's class or a map.
#[derive(Debug)]
pub enum Thing {
    /// A class of robots.
    Robot(Box<RobotDef>),
    /// A map.
    Map(Box<MapDef>),
}

/// The reason why files were not opened.
#[derive(Debug)]
pub enum NotOpened {
    /// Several files could be meant: their names.
    Choose(Vec<String>),
    /// The files cannot be read, in words.
    Bad(String),
}

/// Opener of files.
#[derive(Clone)]
pub(crate) struct Opener {
    open: OpenFiles,
    maps: Maps,
    classes: Classes,
    /// True if the world must stay on its map.
    is_league: bool,
    /// Places for those whose files arrive or are opened: each may take some 100 MB.
    pub(crate) places: Arc<Semaphore>,
}

/// The answer to who brought files.
#[derive(Debug, Serialize)]
pub(crate) struct Answer {
    /// Name of the class or map.
    #[serde(flatten)]
    name: Name,
    verdict: Vec<String>,
    notes: Vec<String>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum Name {
    Robot(String),
    Map(String),
}

impl Opener {
    pub(crate) fn new(open: Open, maps: Maps, classes: Classes, is_league: bool) -> Self {
        let Open(open) = open;
        Self { open, maps, classes, is_league, places: Arc::new(Semaphore::new(MAX_AT_ONCE)) }
    }

    /// Opens files, by their paths. They are written to a folder that is removed at the end.
    ///
    /// # Errors
    /// If a path leads elsewhere, or the files cannot be opened.
    pub(crate) fn open(&self, files: &BTreeMap<String, Bytes>, chosen: Option<&str>) -> Result<Answer, NotOpened> {
        let failed = |error: std::io::Error| NotOpened::Bad(format!("the files cannot be written: {error}"));
        if let Some(chosen) = chosen.filter(|chosen| !files.contains_key(*chosen)) {
            return Err(NotOpened::Bad(format!("{chosen} is not among the files")));
        }
        let folder = tempfile::tempdir().map_err(failed)?;
        let (brought, work) = (folder.path().join("files"), folder.path().join("work"));
        std::fs::create_dir(&brought).map_err(failed)?;
        for (name, content) in files {
            let path = brought.join(inside(name).map_err(NotOpened::Bad)?);
            path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(failed)?;
            std::fs::write(&path, content).map_err(failed)?;
        }
        let Opened { thing, verdict, notes } = (self.open)(&brought, &work, chosen)?;
        let name = match thing {
            Thing::Robot(def) => Name::Robot(self.classes.add(*def).map_err(NotOpened::Bad)?.to_owned()),
            Thing::Map(_) if self.is_league => {
                return Err(NotOpened::Bad("a league stays on its map: expected a robot".to_owned()));
            }
            Thing::Map(def) => Name::Map(self.maps.add(*def)),
        };
        Ok(Answer { name, verdict, notes })
    }
}

/// Checks that a path leads into a folder.
fn inside(name: &str) -> Result<PathBuf, String> {
    let path = Path::new(name);
    let is_good = name.len() <= MAX_PATH
        && !name.contains(['\\', '\0'])
        && (1..=MAX_DEPTH).contains(&path.components().count())
        && path.components().all(|part| matches!(part, Component::Normal(_)));
    if is_good {
        return Ok(path.to_owned());
    }
    Err(format!("{}: expected the path of a file in a folder", gamebots_proto::shown(name).escape_debug()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_leads_into_the_folder_or_is_refused() {
        for (name, good) in [
            ("a.urdf", true),
            ("robot/meshes/a b.stl", true),
            ("./a.stl", false),
            ("../a.stl", false),
            ("a/../../b.stl", false),
            ("/etc/passwd", false),
            ("a\\..\\b", false),
            ("", false),
            ("a\0b", false),
            (&"a/".repeat(17), false),
            (&"a".repeat(401), false),
        ] {
            assert_eq!(inside(name).is_ok(), good, "{name:?}");
        }
    }
}
