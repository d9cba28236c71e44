//! Places where models of Gazebo and their meshes lie: beside the world, in the folders above, in named folders and in Gazebo's caches.

use std::path::{Path, PathBuf};

use percent_encoding::percent_decode_str;

use crate::source::{MAX_TEXT, Source, normalized};
use crate::xml;

/// Number of folders above a file in which models are looked for.
const LEVELS: usize = 5;
/// Maximum number of elements, attributes and texts of a model.config.
const MAX_NODES: u32 = 10_000;
/// Models of every Gazebo without a shape, and the plane that worlds stand on.
const WELL_KNOWN: [(&str, WellKnown); 3] =
    [("sun", WellKnown::Light), ("ground_plane", WellKnown::Ground), ("asphalt_plane", WellKnown::Ground)];

/// A model that needs no file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum WellKnown {
    /// A light, without a shape.
    Light,
    /// A plane at z = 0.
    Ground,
}

/// Places where models are looked for.
#[derive(Clone, Copy)]
pub(crate) struct Models<'a> {
    /// Folders beside those of the file itself.
    pub(crate) folders: &'a [PathBuf],
    /// Folder outside of which nothing is read, without `..` and links.
    pub(crate) within: Option<&'a Path>,
}

/// Returns the name of a model in an address: `crate` for `model://crate`, `Ground Plane` for one of Fuel.
fn name_in(uri: &str) -> String {
    let path = uri.split_once("://").map_or(uri, |(_, path)| path).trim_matches('/');
    let path = match path.split_once("/models/").filter(|_| uri.starts_with("http")) {
        // After the name there may be a version.
        Some((_, name)) => name.split('/').next().unwrap_or(name),
        None => path,
    };
    percent_decode_str(path).decode_utf8_lossy().into_owned()
}

/// Returns the well-known model at an address.
pub(crate) fn well_known(uri: &str) -> Option<WellKnown> {
    let name = name_in(uri).to_ascii_lowercase().replace(' ', "_");
    WELL_KNOWN.iter().find(|(known, _)| *known == name).map(|(_, model)| *model)
}

impl Models<'_> {
    /// Returns the folder of a model and its file; `None` if it is not there.
    pub(crate) fn find(self, beside: &Source, uri: &str) -> Option<(Source, String)> {
        let name = name_in(uri);
        if name.is_empty() {
            return None;
        }
        self.places(beside, &name).into_iter().find_map(|place| {
            if place.is_file() {
                let file = place.file_name()?.to_string_lossy().into_owned();
                return Some((Source::of_file(&place), file));
            }
            let folder = newest(&place);
            let file = file_of(&folder)?;
            self.admits(&folder.join(&file)).then_some((Source::Folder(folder), file))
        })
    }

    /// True if a file may be read.
    fn admits(self, path: &Path) -> bool {
        self.within.is_none_or(|within| normalized(path).starts_with(within))
    }

    /// Returns the folder and the name of a mesh in it; `None` if it is not there.
    pub(crate) fn mesh(self, beside: &Source, uri: &str) -> Option<(Source, String)> {
        let place = |path: &Path| {
            let file = path.file_name()?.to_string_lossy().into_owned();
            (self.admits(path) && path.is_file()).then(|| (Source::of_file(path), file))
        };
        if let Some((model, file)) = uri.strip_prefix("http").and_then(|_| uri.split_once("/files/")) {
            let (folder, _) = self.find(beside, model)?;
            let Source::Folder(folder) = folder else { return None };
            return place(&folder.join(&*percent_decode_str(file).decode_utf8_lossy()));
        }
        let (scheme, path) = uri.split_once("://").unwrap_or(("file", uri));
        // Models and packages have no root: a third slash is a slip.
        let path = if scheme == "file" { path } else { path.trim_start_matches('/') };
        let absolute = Path::new(path);
        if absolute.is_absolute() {
            return place(absolute);
        }
        self.places(beside, path).iter().find_map(|path| place(path))
    }

    /// Lists the places of a name: the nearest first.
    fn places(self, beside: &Source, name: &str) -> Vec<PathBuf> {
        let Source::Folder(beside) = beside else { return Vec::new() };
        let whole = beside.canonicalize().unwrap_or_else(|_| beside.clone());
        let near = whole.ancestors().take(LEVELS).flat_map(|folder| [folder.to_owned(), folder.join("models")]);
        let named = self.folders.iter().flat_map(|folder| [folder.clone(), folder.join("models")]);
        let names = [name.to_owned(), name.to_ascii_lowercase(), name.replace(' ', "_").to_ascii_lowercase()];
        let folders: Vec<PathBuf> = near.chain(named).collect();
        let places = folders.iter().flat_map(|folder| names.iter().map(|name| folder.join(name)));
        places.filter(|place| self.admits(place)).collect()
    }
}

/// Returns the folder of the newest version, as Fuel's cache has them; or the folder itself.
fn newest(folder: &Path) -> PathBuf {
    if file_of(folder).is_some() {
        return folder.to_owned();
    }
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().take(100);
    let version = |path: &Path| path.file_name()?.to_str()?.parse::<u32>().ok();
    let versions = entries.map(|entry| entry.path()).filter(|path| version(path).is_some());
    versions.max_by_key(|path| version(path)).unwrap_or_else(|| folder.to_owned())
}

/// Returns the SDF of a model's folder: that of its model.config with the highest version, or model.sdf.
fn file_of(folder: &Path) -> Option<String> {
    let source = Source::Folder(folder.to_owned());
    if let Ok(text) = source.xml("model.config", MAX_TEXT)
        && let Ok(document) = xml::parse(&text, MAX_NODES)
    {
        let version = |text: &str| text.split('.').map(|part| part.parse().unwrap_or(0)).collect::<Vec<u32>>();
        let files = document.root_element().children().filter(|node| node.has_tag_name("sdf"));
        let files = files.filter_map(|node| {
            Some((version(node.attribute("version").unwrap_or_default()), node.text()?.trim().to_owned()))
        });
        if let Some((_, file)) = files.filter(|(_, file)| source.has(file)).max() {
            return Some(file);
        }
    }
    source.has("model.sdf").then(|| "model.sdf".to_owned())
}
