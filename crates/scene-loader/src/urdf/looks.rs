//! Visuals of a URDF's links. A robot is never rejected because of its looks. Heavy meshes lose triangles, and a link whose meshes
//! cannot be drawn is drawn as its collision shapes.

use nalgebra::{Isometry3, UnitQuaternion};
use scene::check::MAX_PARTS;
use scene::{Link, Pose, Shape, Solid, Visual};
use urdf_rs::Geometry;

use super::{isometry, mesh_file, primitive, z_down};
use crate::mesh::{self, Piece};
use crate::source::Source;

/// Maximum number of triangles, or corners, of all meshes of a URDF: two thirds of the limit of a robot, as its robot.toml may add
/// some.
pub(super) const MAX_TRIANGLES: usize = 200_000;
/// Fewest triangles that simplification leaves of a mesh.
const LEAST_TRIANGLES: usize = 24;
/// Maximum number of bytes of mesh files read for the looks of one URDF.
const MAX_BYTES: u64 = 256 << 20;
/// Maximum number of pieces of one mesh; more are joined into one piece.
const MAX_PIECES: usize = 64;

/// Visuals read so far.
#[derive(Default)]
pub(super) struct Looks {
    bytes: u64,
    /// Sizes of meshes as read, and as kept.
    read: usize,
    kept: usize,
    visuals: usize,
}

/// Reason for which a visual is not drawn.
struct Undrawn(String);

impl Looks {
    /// Returns the visuals of a link and its assumptions. If no visual can be drawn, its collision solids are drawn instead.
    pub(super) fn of_link(
        &mut self,
        source: &Source,
        link: &urdf_rs::Link,
        pose: &Pose,
        robot: &urdf_rs::Robot,
        solids: &[Solid],
    ) -> (Vec<Visual>, Vec<String>) {
        let (mut drawn, mut reasons) = (Vec::new(), Vec::new());
        for visual in &link.visual {
            match self.visuals(source, visual, pose, robot) {
                Ok(visuals) => {
                    for visual in visuals {
                        match scene::check::visual(&visual).first() {
                            Some(wrong) => reasons.push(wrong.clone()),
                            None => drawn.push(visual),
                        }
                    }
                }
                Err(Undrawn(reason)) => reasons.push(reason),
            }
        }
        let mut how = "not drawn";
        if drawn.is_empty() && !reasons.is_empty() && !solids.is_empty() {
            let of_solid = |it: &Solid| Visual {
                shape: it.shape.clone(),
                position: it.position,
                rotation: it.rotation,
                colour: mesh::COLOUR,
                spin: 0.0,
            };
            drawn = solids.iter().map(of_solid).collect();
            how = "drawn as its collision shape";
        }
        let room = MAX_PARTS.saturating_sub(self.visuals);
        if drawn.len() > room {
            drawn.truncate(room);
            reasons.push(format!("expected at most {MAX_PARTS} visuals of a robot: some are left out"));
        }
        self.visuals += drawn.len();
        let size: usize = drawn.iter().map(|visual| mesh::size(&visual.shape)).sum();
        (self.read, self.kept) = (self.read + size, self.kept + size);
        (drawn, reasons.iter().map(|reason| format!("link {}: {reason}: {how}", link.name)).collect())
    }

    /// Simplifies meshes while the links have too many triangles. This bounds memory for any number of meshes.
    pub(super) fn bound(&mut self, links: &mut [Link]) {
        if self.kept > 2 * MAX_TRIANGLES {
            self.simplify(links);
        }
    }

    /// Simplifies meshes to the limit of a URDF, and returns a message if any triangles were removed.
    pub(super) fn finish(mut self, links: &mut [Link]) -> Option<String> {
        if self.kept > MAX_TRIANGLES {
            self.simplify(links);
        }
        let Self { read, kept, .. } = self;
        (kept < read)
            .then(|| format!("visuals have {read} triangles: drawn with {kept}, as {MAX_TRIANGLES} are enough"))
    }

    fn simplify(&mut self, links: &mut [Link]) {
        let part = MAX_TRIANGLES as f64 / self.kept as f64;
        let mut kept = 0;
        for visual in links.iter_mut().flat_map(|link| &mut link.visuals) {
            let size = mesh::size(&visual.shape);
            let most = ((size as f64 * part) as usize).max(LEAST_TRIANGLES);
            if size > most {
                let shape = std::mem::replace(&mut visual.shape, Shape::HalfSpace);
                visual.shape = mesh::simplified(shape, most);
            }
            kept += mesh::size(&visual.shape);
        }
        // A mesh of tiny pieces may have lost its surface.
        links.iter_mut().for_each(|link| link.visuals.retain(|visual| scene::check::visual(visual).is_empty()));
        self.kept = kept;
    }

    /// Returns visuals of a link in the robot frame: a mesh in one piece per colour.
    fn visuals(
        &mut self,
        source: &Source,
        visual: &urdf_rs::Visual,
        pose: &Pose,
        robot: &urdf_rs::Robot,
    ) -> Result<Vec<Visual>, Undrawn> {
        let named = |name: &str| robot.materials.iter().find(|it| it.name == name)?.color.clone();
        let colour = visual.material.as_ref().and_then(|it| it.color.clone().or_else(|| named(&it.name)));
        let colour = colour.map(|colour| [0, 1, 2].map(|part| colour.rgba[part].clamp(0.0, 1.0)));
        let place = Isometry3::from_parts(Default::default(), z_down()) * pose * isometry(&visual.origin);
        let (shapes, turn) = match &visual.geometry {
            Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or([1.0; 3], |scale| *scale);
                let pieces = self.pieces(source, &mesh_file(source, filename))?;
                let piece = |it: Piece| (it.colour, it.scaled(scale));
                (pieces.into_iter().map(piece).collect(), z_down())
            }
            geometry => (vec![(None, primitive(geometry).map_err(Undrawn)?)], UnitQuaternion::identity()),
        };
        let (position, rotation) = scene::position_and_rotation(&(place * turn));
        let drawn = |(own, shape): (Option<[f64; 3]>, Shape)| Visual {
            shape,
            position,
            rotation,
            colour: colour.or(own).unwrap_or(mesh::COLOUR),
            spin: 0.0,
        };
        Ok(shapes.into_iter().map(drawn).collect())
    }

    fn pieces(&mut self, source: &Source, file: &str) -> Result<Vec<Piece>, Undrawn> {
        self.bytes = self.bytes.saturating_add(source.size(file));
        if self.bytes > MAX_BYTES {
            let most = MAX_BYTES >> 20;
            return Err(Undrawn(format!("mesh `{file}`: expected at most {most} MB of meshes in all")));
        }
        let pieces = mesh::pieces(source, file).map_err(Undrawn)?;
        Ok(if pieces.len() > MAX_PIECES { vec![mesh::joined(pieces)] } else { pieces })
    }
}
