//! Packages of ROS on disk.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::LoadError;
use crate::source::{MAX_TEXT, Source, normalized};
use crate::xml;

/// Maximum number of folders between a file and the folder of its package.
const MAX_LEVELS: usize = 8;
/// Number of folders above a package in which others are searched.
const SEARCHED_ABOVE: usize = 2;
/// Depth to which packages are searched.
const MAX_DEPTH: usize = 3;
/// Maximum number of files and folders that are looked at.
const MAX_ENTRIES: usize = 20_000;
/// Maximum number of elements, attributes and texts of a manifest.
const MAX_NODES: u32 = 10_000;
/// Folders that have only URDFs.
const URDF_FOLDERS: [&str; 3] = ["urdf", "robots", "xacro"];
/// File that makes a folder a package.
const MANIFEST: &str = "package.xml";

/// Packages of ROS, by name.
pub struct Packages {
    folders: BTreeMap<String, PathBuf>,
    /// Folder of the robot's file.
    beside: PathBuf,
    /// Folder that relative paths cannot leave: the file's package, or else the folder of the file, or of its `urdf`.
    own: PathBuf,
    /// Folders from which files with whole paths may come, too.
    allowed: Vec<PathBuf>,
    /// Files of a closed folder by their names in lower case, for references whose folders are not there; none if two have the name.
    loose: Option<BTreeMap<String, Option<PathBuf>>>,
}

impl Packages {
    /// Finds the package of a file and the packages near it. `named` are packages with their folders, which come first. `searched`
    /// are folders in which more are searched, as those of `ROS_PACKAGE_PATH`.
    ///
    /// # Errors
    /// Reports a file without a folder, and a named folder that is none.
    pub fn around(file: &Path, named: &[(String, PathBuf)], searched: &[PathBuf]) -> Result<Self, LoadError> {
        let unreadable =
            |path: &Path, reason: String| LoadError::Unreadable { file: path.display().to_string(), reason };
        let canonical = file.canonicalize().map_err(|error| unreadable(file, error.to_string()))?;
        let beside = canonical.parent().map(Path::to_owned).unwrap_or_default();
        let mut folders = BTreeMap::new();
        for (name, folder) in named {
            let found = folder.canonicalize().map_err(|error| unreadable(folder, error.to_string()))?;
            if !found.is_dir() {
                return Err(unreadable(folder, "not a folder".to_owned()));
            }
            folders.insert(name.clone(), found);
        }
        let own = beside.ancestors().take(MAX_LEVELS).find(|folder| folder.join(MANIFEST).is_file());
        let above = own.into_iter().flat_map(|own| own.ancestors().skip(1).take(SEARCHED_ABOVE));
        let mut search = Search { folders, left: MAX_ENTRIES };
        own.into_iter().for_each(|own| search.add(own, 0));
        for folder in above.chain(searched.iter().map(PathBuf::as_path)) {
            search.add(folder, MAX_DEPTH);
        }
        // Without a package, a URDF in a folder of its own has its meshes in the one beside it.
        let is_of_urdfs = beside.file_name().is_some_and(|name| URDF_FOLDERS.iter().any(|known| name == *known));
        let above = beside.parent().filter(|_| is_of_urdfs).unwrap_or(&beside);
        let own = own.unwrap_or(above).to_owned();
        Ok(Self { folders: search.folders, beside, own, allowed: Vec::new(), loose: None })
    }

    /// Finds the packages in a folder, and looks at nothing outside of it. The folders in it are packages, too, and a file whose folder is not
    /// there is found by its name.
    ///
    /// # Errors
    /// Reports a file that is not there.
    pub fn inside(root: &Path, file: &Path) -> Result<Self, LoadError> {
        let whole = |path: &Path| {
            let unreadable = |error: std::io::Error| LoadError::Unreadable {
                file: path.display().to_string(),
                reason: error.to_string(),
            };
            path.canonicalize().map_err(unreadable)
        };
        let (root, file) = (whole(root)?, whole(file)?);
        let mut search = Search { folders: BTreeMap::new(), left: MAX_ENTRIES };
        search.add(&root, MAX_DEPTH);
        let (mut loose, mut open, mut left) =
            (BTreeMap::<String, Option<PathBuf>>::new(), vec![root.clone()], MAX_ENTRIES);
        while let Some(folder) = open.pop() {
            let entries: Vec<_> = std::fs::read_dir(&folder).into_iter().flatten().flatten().take(left).collect();
            left -= entries.len();
            for path in entries.iter().map(std::fs::DirEntry::path) {
                let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
                if path.is_dir() {
                    search.folders.entry(name).or_insert_with(|| path.clone());
                    open.push(path);
                } else {
                    let found = Some(path);
                    loose.entry(name.to_lowercase()).and_modify(|known| *known = None).or_insert(found);
                }
            }
        }
        let beside = file.parent().map(Path::to_owned).unwrap_or_default();
        Ok(Self { folders: search.folders, beside, own: root, allowed: Vec::new(), loose: Some(loose) })
    }

    /// Allows the files of a folder.
    pub fn allow(&mut self, folder: &Path) {
        self.allowed.push(normalized(folder));
    }

    /// Returns the packages with their folders.
    pub fn folders(&self) -> &BTreeMap<String, PathBuf> {
        &self.folders
    }

    /// Returns the file that a URDF refers to: `package://NAME/..`, `file:///..`, or a path from the URDF's folder.
    pub(super) fn resolve(&self, reference: &str) -> Result<PathBuf, String> {
        self.at(reference).or_else(|reason| {
            let name = reference.rsplit(['/', '\\']).next().unwrap_or_default().to_lowercase();
            self.loose.as_ref().and_then(|loose| loose.get(&name).cloned().flatten()).ok_or(reason)
        })
    }

    /// Returns the file at the place that a reference names.
    fn at(&self, reference: &str) -> Result<PathBuf, String> {
        let in_package = ["package://", "model://"].iter().find_map(|scheme| reference.strip_prefix(scheme));
        let (bases, path): (Vec<&PathBuf>, PathBuf) = if let Some(path) = in_package {
            let (name, path) = path.split_once('/').unwrap_or((path, ""));
            let hint = || match self.loose {
                None => format!("package `{name}` is not found: name its folder by --package {name}=FOLDER"),
                Some(_) => format!("package `{name}` is not here: bring its folder, too"),
            };
            let folder = self.folders.get(name).ok_or_else(hint)?;
            (vec![folder], folder.join(path.trim_start_matches('/')))
        } else {
            let path = reference.strip_prefix("file://").unwrap_or(reference);
            (self.folders.values().chain([&self.own]).chain(&self.allowed).collect(), self.beside.join(path))
        };
        let path = normalized(&path);
        if !bases.iter().any(|base| path.starts_with(base)) {
            return Err(match self.loose {
                None => "it is outside of every package: expected a file in one, see --package".to_owned(),
                Some(_) => "it is not here: bring it, too".to_owned(),
            });
        }
        if path.is_file() { Ok(path) } else { Err("no such file".to_owned()) }
    }
}

/// A search for packages.
struct Search {
    folders: BTreeMap<String, PathBuf>,
    /// Number of files and folders that may still be looked at.
    left: usize,
}

impl Search {
    /// Adds a folder if it is a package, or else those in it. The first package of a name counts.
    fn add(&mut self, folder: &Path, depth: usize) {
        if folder.join(MANIFEST).is_file() {
            let by_folder = || folder.file_name().map(|name| name.to_string_lossy().into_owned());
            if let Some(name) = name_of(folder).or_else(by_folder) {
                self.folders.entry(name).or_insert_with(|| folder.to_owned());
            }
            return;
        }
        if depth == 0 {
            return;
        }
        let entries: Vec<_> = std::fs::read_dir(folder).into_iter().flatten().flatten().take(self.left).collect();
        self.left -= entries.len();
        let is_hidden = |path: &Path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        let folders = entries.iter().map(std::fs::DirEntry::path).filter(|path| path.is_dir() && !is_hidden(path));
        let mut folders: Vec<PathBuf> = folders.collect();
        folders.sort();
        folders.iter().for_each(|folder| self.add(folder, depth - 1));
    }
}

/// Returns the name in a package's manifest.
fn name_of(folder: &Path) -> Option<String> {
    let text = Source::Folder(folder.to_owned()).xml(MANIFEST, MAX_TEXT).ok()?;
    let document = xml::parse(&text, MAX_NODES).ok()?;
    let name = document.root_element().children().find(|node| node.has_tag_name("name"))?;
    name.text().map(|name| name.trim().to_owned()).filter(|name| !name.is_empty())
}
