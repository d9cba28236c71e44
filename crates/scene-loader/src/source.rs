//! Where files come from: a folder on disk, or one built into the program.

use std::path::{Path, PathBuf};

use include_dir::Dir;

use crate::LoadError;

/// A folder that the files of a robot or map lie in.
pub(crate) enum Source {
    BuiltIn(&'static Dir<'static>),
    Folder(PathBuf),
}

impl Source {
    /// The folder of a file.
    pub(crate) fn of_file(path: &Path) -> Self {
        Self::Folder(path.parent().map(Path::to_owned).unwrap_or_default())
    }

    /// The content of a file of the folder.
    pub(crate) fn bytes(&self, name: &str) -> Result<Vec<u8>, LoadError> {
        let unreadable = |reason: String| LoadError::Unreadable { file: self.display(name), reason };
        match self {
            Self::BuiltIn(dir) => {
                let file = dir.get_file(dir.path().join(name));
                file.map(|file| file.contents().to_owned()).ok_or_else(|| unreadable("not built in".to_owned()))
            }
            Self::Folder(folder) => std::fs::read(folder.join(name)).map_err(|error| unreadable(error.to_string())),
        }
    }

    /// The content of a text file.
    pub(crate) fn text(&self, name: &str) -> Result<String, LoadError> {
        String::from_utf8(self.bytes(name)?).map_err(|error| LoadError::Unreadable {
            file: self.display(name),
            reason: format!("not UTF-8 at byte {}", error.utf8_error().valid_up_to()),
        })
    }

    /// How to name a file of the folder in a message.
    pub(crate) fn display(&self, name: &str) -> String {
        match self {
            Self::BuiltIn(dir) => dir.path().join(name).display().to_string(),
            Self::Folder(folder) => folder.join(name).display().to_string(),
        }
    }
}
