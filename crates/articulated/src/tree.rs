//! The structure of a tree, which does not change while it moves.

use nalgebra::{Matrix3, Vector3};

/// Links, parents before their children. The first is the root.
#[derive(Debug, Clone)]
pub struct Tree {
    pub(crate) links: Vec<Link>,
    pub(crate) dofs: Vec<Dof>,
    /// First degree of freedom of every link, and the number of them.
    pub(crate) dofs_of: Vec<(usize, usize)>,
    /// For every degree of freedom, those above it and itself, from the root down. `Dof::chain` is the start of its part.
    chains: Vec<usize>,
    /// Length of the common prefix of the chains of two degrees of freedom, by their numbers.
    common: Vec<u16>,
    /// Links that are not rotors, each with the mass of its rotors; then the rotors.
    pub(crate) carriers: Vec<(usize, Mass)>,
    pub(crate) rotors: Vec<Rotor>,
    /// Number of entries of a lower triangle that has only those of the chains.
    pub(crate) entries: usize,
}

/// A rigid body, and the joint to its parent. Its frame has its origin at the joint, and the axes of the parent's frame when the joint is
/// at 0.
#[derive(Debug, Clone)]
pub struct Link {
    /// Number of the parent, less than the link's own. Unused for the root.
    pub parent: usize,
    /// Joint to the parent, or of the root to the world.
    pub joint: Joint,
    /// Origin in the parent's frame when the joint is at 0, m.
    pub anchor: Vector3<f64>,
    /// Mass properties.
    pub mass: Mass,
    /// True if the mass distribution is the same at any angle about the joint's axis, as a wheel's. Then the frame does not turn.
    pub is_round: bool,
    /// Viscous friction of every degree of freedom, N m s/rad or N s/m. For a free root, that of its angular velocity.
    pub damping: f64,
    /// Viscous friction of a free root's velocity, N s/m.
    pub linear_damping: f64,
    /// Inertia of the motor's rotor at every degree of freedom, kg m² or kg. A belt needs some, as its link does not move.
    pub armature: f64,
}

/// The degrees of freedom of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// Free motion, for a root only.
    Free,
    /// No motion, for a root only: elsewhere such a link is merged with its parent.
    Fixed,
    /// Rotation about an axis, a unit vector in the frame of the parent.
    Revolute(Vector3<f64>),
    /// Translation along an axis, a unit vector in the frame of the parent.
    Prismatic(Vector3<f64>),
    /// Rotation about every axis, with speeds along world axes.
    Ball,
    /// A belt that runs around the link. The link does not move; the surface at its contacts does.
    Belt {
        /// Axle of the sprocket, a unit vector in the frame of the parent.
        axis: Vector3<f64>,
        /// Travel of the belt for each rad of the sprocket, m.
        radius: f64,
    },
}

/// Mass and its distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the frame of the link, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre of mass, kg m².
    pub inertia: Matrix3<f64>,
}

/// A link that turns about its axis of symmetry and has no children. Its mass acts on the parent alike at every angle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rotor {
    pub(crate) parent: usize,
    pub(crate) dof: usize,
    /// Inertia about its axis, kg m².
    pub(crate) inertia: f64,
}

/// A degree of freedom.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dof {
    /// Number of degrees of freedom above it.
    pub(crate) depth: usize,
    /// Start of its chain in `chains`.
    chain: usize,
    /// Start of its row among the entries.
    pub(crate) row: usize,
    pub(crate) damping: f64,
    pub(crate) armature: f64,
}

impl Tree {
    /// Builds a tree of links.
    ///
    /// # Panics
    /// If a link comes before its parent, or if the root's joint is neither `Free` nor `Fixed`, or another link's is.
    pub fn new(links: Vec<Link>) -> Self {
        let (mut dofs, mut dofs_of, mut chains, mut entries) = (Vec::<Dof>::new(), Vec::new(), Vec::new(), 0);
        let mut tips: Vec<Option<usize>> = Vec::new();
        for (number, link) in links.iter().enumerate() {
            let is_root = number == 0;
            assert!(is_root || link.parent < number, "link {number} comes before its parent {}", link.parent);
            assert_eq!(is_root, matches!(link.joint, Joint::Free | Joint::Fixed), "the joint of link {number}");
            let count = link.joint.dofs();
            dofs_of.push((dofs.len(), count));
            let mut above = if is_root { None } else { tips[link.parent] };
            for own in 0..count {
                let mut chain: Vec<usize> =
                    above.map_or_else(Vec::new, |above: usize| chain_of(&chains, &dofs[above]).to_vec());
                let depth = chain.len();
                chain.push(dofs.len());
                let damping = if link.joint == Joint::Free && own >= 3 { link.linear_damping } else { link.damping };
                above = Some(dofs.len());
                dofs.push(Dof { depth, chain: chains.len(), row: entries, damping, armature: link.armature });
                chains.extend(chain);
                entries += depth + 1;
            }
            tips.push(above);
        }
        let of = |dof: usize| chain_of(&chains, &dofs[dof]);
        let shared = |a: usize, b: usize| of(a).iter().zip(of(b)).take_while(|(a, b)| a == b).count() as u16;
        let common =
            (0..dofs.len()).flat_map(|a| (0..dofs.len()).map(move |b| (a, b))).map(|(a, b)| shared(a, b)).collect();
        let is_rotor =
            |number: usize| links[number].is_rotor() && !links[number + 1..].iter().any(|it| it.parent == number);
        let (mut carriers, mut rotors) = (Vec::new(), Vec::new());
        for (number, link) in links.iter().enumerate() {
            if is_rotor(number) {
                rotors.push(Rotor { parent: link.parent, dof: dofs_of[number].0, inertia: link.axial_inertia() });
                continue;
            }
            let own = (number + 1..links.len()).filter(|&it| links[it].parent == number && is_rotor(it));
            let mass = own.fold(link.mass, |mass, rotor| mass.with(&links[rotor].mass, links[rotor].anchor));
            carriers.push((number, mass));
        }
        Self { links, dofs, dofs_of, chains, common, carriers, rotors, entries }
    }

    /// Returns the links.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the number of degrees of freedom.
    pub fn dof_count(&self) -> usize {
        self.dofs.len()
    }

    /// Returns the first degree of freedom of a link's joint. A joint with one value has no others.
    pub fn dof_of(&self, link: usize) -> usize {
        self.dofs_of[link].0
    }

    /// Returns the degrees of freedom above one, and itself, from the root down.
    pub(crate) fn chain(&self, dof: usize) -> &[usize] {
        chain_of(&self.chains, &self.dofs[dof])
    }

    /// Returns the number of degrees of freedom that are in both chains.
    pub(crate) fn common(&self, a: usize, b: usize) -> usize {
        usize::from(self.common[a * self.dofs.len() + b])
    }

    /// Returns the number of degrees of freedom of a free root, the first of every chain; 0 for a fixed root.
    pub(crate) fn dofs_of_free_root(&self) -> usize {
        self.dofs_of[0].1
    }

    /// Returns the last degree of freedom that moves a link, or `None` if nothing does.
    pub(crate) fn tip(&self, mut link: usize) -> Option<usize> {
        loop {
            let (first, count) = self.dofs_of[link];
            if count > 0 {
                return Some(first + count - 1);
            }
            if link == 0 {
                return None;
            }
            link = self.links[link].parent;
        }
    }
}

fn chain_of<'a>(chains: &'a [usize], dof: &Dof) -> &'a [usize] {
    &chains[dof.chain..=dof.chain + dof.depth]
}

impl Joint {
    fn dofs(self) -> usize {
        match self {
            Self::Free => 6,
            Self::Fixed => 0,
            Self::Revolute(_) | Self::Prismatic(_) | Self::Belt { .. } => 1,
            Self::Ball => 3,
        }
    }
}

impl Mass {
    /// Returns the sum of this mass and another, whose frame has its origin at an offset.
    #[must_use]
    pub fn with(&self, other: &Self, offset: Vector3<f64>) -> Self {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return *self;
        }
        let at = other.centre + offset;
        let centre = (self.centre * self.mass + at * other.mass) / mass;
        let about = |own: &Self, at: Vector3<f64>| {
            let arm = at - centre;
            own.inertia + (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose()) * own.mass
        };
        Self { mass, centre, inertia: about(self, self.centre) + about(other, at) }
    }
}

impl Link {
    /// True if the link turns about its axis of symmetry, through its centre of mass.
    fn is_rotor(&self) -> bool {
        let Joint::Revolute(axis) = self.joint else { return false };
        let off = self.mass.inertia * axis - axis * self.axial_inertia();
        self.is_round && self.mass.centre == Vector3::zeros() && off.norm() <= 1e-9 * self.mass.inertia.trace()
    }

    /// Returns the inertia about the joint's axis, kg m².
    fn axial_inertia(&self) -> f64 {
        if let Joint::Revolute(axis) = self.joint { axis.dot(&(self.mass.inertia * axis)) } else { 0.0 }
    }

    /// Creates a link without damping or armature.
    pub fn new(parent: usize, joint: Joint, anchor: Vector3<f64>, mass: Mass) -> Self {
        Self { parent, joint, anchor, mass, is_round: false, damping: 0.0, linear_damping: 0.0, armature: 0.0 }
    }
}
