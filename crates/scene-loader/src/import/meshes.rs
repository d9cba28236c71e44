//! Meshes of an imported robot.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use urdf_rs::Geometry;

use super::{MESHES, Packages};
use crate::mesh;
use crate::source::{MAX_MESH, Source};

/// Maximum number of meshes.
const MAX_MESHES: usize = 1000;
/// Maximum number of bytes of all meshes.
const MAX_BYTES: u64 = 256 << 20;
/// Maximum number of meshes that a message lists.
const MAX_LISTED: usize = 5;
/// Longest name of a mesh, characters.
const MAX_NAME: usize = 100;

/// Meshes that have a place in the robot's folder.
pub(super) struct Meshes<'a> {
    packages: &'a Packages,
    /// Names in the robot's folder, by the meshes' files; or reasons for which a mesh has none.
    places: BTreeMap<PathBuf, Result<String, String>>,
    /// Names in lower case.
    names: BTreeSet<String>,
    bytes: u64,
}

impl<'a> Meshes<'a> {
    pub(super) fn new(packages: &'a Packages) -> Self {
        Self { packages, places: BTreeMap::new(), names: BTreeSet::new(), bytes: 0 }
    }

    /// Gives a place to every mesh of a robot, and removes the shapes whose meshes cannot be read. Removes textures, too.
    pub(super) fn place_all(&mut self, robot: &mut urdf_rs::Robot, left_out: &mut Vec<String>) {
        let mut reasons = BTreeMap::<String, BTreeSet<String>>::new();
        for link in &mut robot.links {
            let mut keep = |geometry: &mut Geometry| {
                let Geometry::Mesh { filename, .. } = geometry else { return true };
                match self.place(filename) {
                    Ok(place) => *filename = place,
                    Err(reason) => {
                        reasons.entry(reason).or_default().insert(format!("`{filename}`"));
                        return false;
                    }
                }
                true
            };
            link.visual.retain_mut(|visual| keep(&mut visual.geometry));
            link.collision.retain_mut(|collision| keep(&mut collision.geometry));
        }
        for (reason, files) in reasons {
            let files: Vec<&str> = files.iter().map(String::as_str).collect();
            let more = files.len().saturating_sub(MAX_LISTED);
            let more = if more == 0 { String::new() } else { format!(" and {more} more") };
            let listed = files[..files.len().min(MAX_LISTED)].join(", ");
            let meshes = if files.len() == 1 { "mesh" } else { "meshes" };
            left_out.push(format!("{meshes} {listed}{more}: {reason}"));
        }
        let of_links = robot.links.iter_mut().flat_map(|link| &mut link.visual).filter_map(|it| it.material.as_mut());
        of_links.chain(&mut robot.materials).for_each(|material| material.texture = None);
    }

    /// Returns a mesh's name in the robot's folder.
    fn place(&mut self, reference: &str) -> Result<String, String> {
        let path = self.packages.resolve(reference)?;
        if let Some(place) = self.places.get(&path) {
            return place.clone();
        }
        let place = self.new_place(&path);
        self.places.insert(path, place.clone());
        place
    }

    fn new_place(&mut self, path: &Path) -> Result<String, String> {
        if self.places.len() >= MAX_MESHES {
            return Err(format!("expected at most {MAX_MESHES} meshes"));
        }
        let size = std::fs::metadata(path).map_err(|error| error.to_string())?.len();
        if size > MAX_MESH || self.bytes + size > MAX_BYTES {
            let [each, all] = [MAX_MESH, MAX_BYTES].map(|bytes| bytes >> 20);
            return Err(format!("it has {size} bytes: expected at most {each} MB, and {all} MB of all meshes"));
        }
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let (stem, ending) = name.rsplit_once('.').unwrap_or((&name, ""));
        if ending.eq_ignore_ascii_case("gltf") {
            return Err("its buffers are files of their own: expected a .glb".to_owned());
        }
        mesh::pieces(&Source::of_file(path), &name)
            .map_err(|reason| reason.strip_prefix(&format!("mesh `{name}`: ")).map_or(reason.clone(), str::to_owned))?;
        self.bytes += size;
        let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
        let stem: String = stem.chars().take(MAX_NAME).map(plain).collect();
        let ending = ending.to_ascii_lowercase();
        let numbered = |number: u32| {
            let number = if number == 1 { String::new() } else { format!("_{number}") };
            format!("{MESHES}/{stem}{number}.{ending}")
        };
        let mut names = (1..).map(numbered);
        let place = names.find(|name| self.names.insert(name.to_ascii_lowercase())).unwrap_or_default();
        Ok(place)
    }

    /// Returns the robot's folder as it will be.
    pub(super) fn source(&self) -> Source {
        let placed = self.places.iter().filter_map(|(path, place)| Some((place.clone().ok()?, path.clone())));
        Source::Files(placed.collect())
    }

    /// Returns the meshes that a robot still uses, by their names in its folder.
    pub(super) fn used_by(&self, robot: &urdf_rs::Robot) -> Vec<(String, PathBuf)> {
        let shapes = robot.links.iter().flat_map(|link| {
            link.visual.iter().map(|it| &it.geometry).chain(link.collision.iter().map(|it| &it.geometry))
        });
        let used: BTreeSet<&String> = shapes
            .filter_map(|shape| match shape {
                Geometry::Mesh { filename, .. } => Some(filename),
                _ => None,
            })
            .collect();
        let placed = self.places.iter().filter_map(|(path, place)| Some((place.clone().ok()?, path.clone())));
        let mut meshes: Vec<(String, PathBuf)> = placed.filter(|(name, _)| used.contains(name)).collect();
        meshes.sort();
        meshes
    }
}
