//! What a tree is made of: what does not change while it moves.

use nalgebra::{Matrix3, Vector3};

/// Links, parents before their children; the first is the root.
#[derive(Debug, Clone)]
pub struct Tree {
    pub(crate) links: Vec<Link>,
    pub(crate) dofs: Vec<Dof>,
    /// The first degree of freedom of every link, and how many it has.
    pub(crate) dofs_of: Vec<(usize, usize)>,
    /// For every degree of freedom those above it and itself, from the root down: where its part of the list begins is `Dof::chain`.
    chains: Vec<usize>,
    /// How many degrees of freedom two have above or at both, by their numbers.
    common: Vec<u16>,
    /// Links with what their rotors weigh, and the rotors.
    pub(crate) carriers: Vec<(usize, Mass)>,
    pub(crate) rotors: Vec<Rotor>,
    /// Entries of a triangle that has those of the chains alone.
    pub(crate) entries: usize,
}

/// A rigid piece, and the joint by which it hangs on its parent. Its frame has its origin at the joint, and the axes of its parent's when
/// the joint is at 0.
#[derive(Debug, Clone)]
pub struct Link {
    /// The parent's number, less than its own; of no use for the root.
    pub parent: usize,
    /// How it moves against its parent, or the root against the world.
    pub joint: Joint,
    /// Its origin in the parent's frame where the joint is at 0, m.
    pub anchor: Vector3<f64>,
    /// What it weighs.
    pub mass: Mass,
    /// Whether its mass is the same about its axis however far it has turned, so that its frame need not turn: a wheel.
    pub is_round: bool,
    /// Viscous friction of every degree of freedom, N m s/rad or N s/m. Of a free root that of its angular velocity.
    pub damping: f64,
    /// Of a free root, viscous friction of its velocity, N s/m.
    pub linear_damping: f64,
    /// Inertia of a rotor as felt at every degree of freedom, kg m² or kg.
    pub armature: f64,
}

/// What a joint lets a link do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// Move as it will: of a root alone.
    Free,
    /// Nothing: of a root alone, as elsewhere link and parent are one.
    Fixed,
    /// Turn about an axis, a unit vector in the frame of the parent.
    Revolute(Vector3<f64>),
    /// Slide along one.
    Prismatic(Vector3<f64>),
    /// Turn about every axis; its speeds are along world axes.
    Ball,
}

/// Mass, and how it is spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the frame of the link, m.
    pub centre: Vector3<f64>,
    /// About the centre, kg m².
    pub inertia: Matrix3<f64>,
}

/// A link that turns about the axis in which it is round, with nothing that hangs on it: it weighs on its parent, however far it has turned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rotor {
    pub(crate) parent: usize,
    pub(crate) dof: usize,
    /// About its axis, kg m².
    pub(crate) inertia: f64,
}

/// A degree of freedom.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dof {
    /// How many are above it.
    pub(crate) depth: usize,
    /// Where its chain begins among the chains.
    chain: usize,
    /// Where its row begins among the entries.
    pub(crate) row: usize,
    pub(crate) damping: f64,
    pub(crate) armature: f64,
}

impl Tree {
    /// A tree of links.
    ///
    /// # Panics
    /// Where a link comes before its parent, or one that is not the root is `Free` or `Fixed`.
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

    /// Its links.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// How many degrees of freedom it has.
    pub fn dof_count(&self) -> usize {
        self.dofs.len()
    }

    /// The first degree of freedom of a link's joint; that of a joint with one value.
    pub fn dof_of(&self, link: usize) -> usize {
        self.dofs_of[link].0
    }

    /// The degrees of freedom above one and itself, from the root down.
    pub(crate) fn chain(&self, dof: usize) -> &[usize] {
        chain_of(&self.chains, &self.dofs[dof])
    }

    /// How many degrees of freedom move both of two.
    pub(crate) fn common(&self, a: usize, b: usize) -> usize {
        usize::from(self.common[a * self.dofs.len() + b])
    }

    /// The last degree of freedom that moves a link; `None` where nothing does.
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
            Self::Revolute(_) | Self::Prismatic(_) => 1,
            Self::Ball => 3,
        }
    }
}

impl Mass {
    /// With another, whose frame has its origin at an offset.
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
    /// Whether it is round about the axis through its centre that it turns about.
    fn is_rotor(&self) -> bool {
        let Joint::Revolute(axis) = self.joint else { return false };
        let off = self.mass.inertia * axis - axis * self.axial_inertia();
        self.is_round && self.mass.centre == Vector3::zeros() && off.norm() <= 1e-9 * self.mass.inertia.trace()
    }

    /// About the axis that it turns about, kg m².
    fn axial_inertia(&self) -> f64 {
        if let Joint::Revolute(axis) = self.joint { axis.dot(&(self.mass.inertia * axis)) } else { 0.0 }
    }

    /// A link that nothing brakes.
    pub fn new(parent: usize, joint: Joint, anchor: Vector3<f64>, mass: Mass) -> Self {
        Self { parent, joint, anchor, mass, is_round: false, damping: 0.0, linear_damping: 0.0, armature: 0.0 }
    }
}
