//! Sources of files: a folder on disk, or one embedded in the program.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use include_dir::Dir;

use crate::{LoadError, xml};

/// Largest text file, bytes: ten thousand solids take 1.5 MB.
pub(crate) const MAX_TEXT: u64 = 4 << 20;
/// Largest mesh, bytes: a million triangles take 50 MB in a binary STL.
pub(crate) const MAX_MESH: u64 = 64 << 20;

/// A folder with the files of a robot or a map.
pub(crate) enum Source {
    BuiltIn(&'static Dir<'static>),
    Folder(PathBuf),
    /// A folder that is not written yet: names with the files that will be copied there.
    Files(BTreeMap<String, PathBuf>),
}

impl Source {
    /// Returns the folder of a file.
    pub(crate) fn of_file(path: &Path) -> Self {
        Self::Folder(path.parent().map(Path::to_owned).unwrap_or_default())
    }

    /// Returns the folder's path; embedded folders and those not written yet have none.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::Folder(folder) => Some(folder),
            Self::BuiltIn(_) | Self::Files(_) => None,
        }
    }

    /// Returns a folder inside this one, which may not exist. Embedded folders have none.
    pub(crate) fn folder(&self, name: &str) -> Option<Self> {
        match self {
            Self::BuiltIn(_) | Self::Files(_) => None,
            Self::Folder(folder) => Some(Self::Folder(folder.join(name))),
        }
    }

    /// True if the file exists.
    pub(crate) fn has(&self, name: &str) -> bool {
        match self {
            Self::BuiltIn(dir) => dir.get_file(dir.path().join(name)).is_some(),
            Self::Folder(folder) => folder.join(name).is_file(),
            Self::Files(files) => files.contains_key(name),
        }
    }

    /// Returns the size of a file in bytes, or 0 if it cannot be read.
    pub(crate) fn size(&self, name: &str) -> u64 {
        match self {
            Self::BuiltIn(dir) => dir.get_file(dir.path().join(name)).map_or(0, |file| file.contents().len() as u64),
            Self::Folder(folder) => size(&folder.join(name)),
            Self::Files(files) => files.get(name).map_or(0, |file| size(file)),
        }
    }

    /// Returns the contents of a file with at most `most` bytes.
    pub(crate) fn bytes(&self, name: &str, most: u64) -> Result<Vec<u8>, LoadError> {
        let unreadable = |reason: String| LoadError::Unreadable { file: self.display(name), reason };
        match self {
            Self::BuiltIn(dir) => {
                let file = dir.get_file(dir.path().join(name));
                file.map(|file| file.contents().to_owned()).ok_or_else(|| unreadable("not built in".to_owned()))
            }
            Self::Folder(folder) => read_file(&folder.join(name), most).map_err(unreadable),
            Self::Files(files) => {
                let file = files.get(name).ok_or_else(|| unreadable("no such file".to_owned()))?;
                read_file(file, most).map_err(unreadable)
            }
        }
    }

    /// Returns the contents of a text file.
    pub(crate) fn text(&self, name: &str) -> Result<String, LoadError> {
        self.text_up_to(name, MAX_TEXT)
    }

    /// Returns the contents of an XML file with at most `most` bytes, in the encoding that it says, as the strict library takes it.
    pub(crate) fn xml(&self, name: &str, most: u64) -> Result<String, LoadError> {
        Ok(xml::decode(&self.bytes(name, most)?))
    }

    /// Returns the contents of a text file with at most `most` bytes.
    pub(crate) fn text_up_to(&self, name: &str, most: u64) -> Result<String, LoadError> {
        String::from_utf8(self.bytes(name, most)?).map_err(|error| LoadError::Unreadable {
            file: self.display(name),
            reason: format!("not UTF-8 at byte {}", error.utf8_error().valid_up_to()),
        })
    }

    /// Returns the name of a file for messages.
    pub(crate) fn display(&self, name: &str) -> String {
        match self {
            Self::BuiltIn(dir) => dir.path().join(name).display().to_string(),
            Self::Folder(folder) => folder.join(name).display().to_string(),
            Self::Files(_) => name.to_owned(),
        }
    }
}

/// Returns a path without `.` and `..`, which lead nowhere above the root.
pub(crate) fn normalized(path: &Path) -> PathBuf {
    let mut whole = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => drop(whole.pop()),
            Component::CurDir => {}
            other => whole.push(other),
        }
    }
    whole
}

fn size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |found| found.len())
}

/// Reads a file of at most so many bytes. Refuses pipes and devices, as they could go on for ever.
fn read_file(path: &Path, most: u64) -> Result<Vec<u8>, String> {
    let text = |error: std::io::Error| error.to_string();
    if !std::fs::metadata(path).map_err(text)?.is_file() {
        return Err("not a regular file".to_owned());
    }
    let mut content = Vec::new();
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut content)).map_err(text)?;
    if content.len() as u64 > most {
        return Err(format!("larger than {most} bytes, the most that is read"));
    }
    Ok(content)
}
