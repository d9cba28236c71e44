//! Mass, centre of mass and inertia of robots and their parts.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3};

use crate::{Belt, Link, MountedWheel, RobotDef, Rollers, Wheel};

/// Mass properties of a body.
#[derive(Debug, Clone, Copy)]
pub struct Mass {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the frame of the robot or of the wheel, m.
    pub centre: Vector3<f64>,
    /// Inertia about the centre, along the axes of that frame, kg m².
    pub inertia: Matrix3<f64>,
}

impl RobotDef {
    /// Returns the mass of the robot with its joints held at 0.
    pub fn total_mass(&self) -> Mass {
        let of_wheel = |wheel: MountedWheel| {
            let mass = wheel.mass_with_rollers(wheel.drive.is_some());
            Mass { centre: mass.centre + Vector3::from(wheel.position), ..mass }
        };
        let wheels = self.wheels().map(of_wheel);
        combined(self.links.iter().flat_map(part_masses).chain(wheels))
    }

    /// Returns the mass of the root link, without its wheels and child links.
    pub fn body_mass(&self) -> Mass {
        combined(self.links.iter().take(1).flat_map(part_masses))
    }
}

impl Link {
    /// Returns the mass of the link without its wheel, robot frame.
    pub fn mass(&self) -> Mass {
        combined(part_masses(self))
    }
}

fn part_masses(link: &Link) -> impl Iterator<Item = Mass> {
    link.parts.iter().map(|part| Mass { mass: part.mass, centre: part.centre, inertia: part.inertia })
}

impl Wheel {
    /// Mass without rollers, about the wheel's middle: a driven plain wheel is a solid disc, the hub of a Mecanum wheel a disc out to the
    /// roller axes, a caster a ball, a track the box around its belt.
    pub fn hub_mass(&self, driven: bool) -> Mass {
        if let Some(belt) = &self.belt {
            return self.track_mass(belt);
        }
        let radius = self.rollers.as_ref().map_or(self.radius, |rollers| rollers.axis_circle);
        let spin = self.mass * radius * radius / 2.0;
        let tilt = self.mass * (3.0 * radius * radius + self.width * self.width) / 12.0;
        let moments = if driven { [tilt, spin, tilt] } else { [0.4 * self.mass * radius * radius; 3] };
        Mass { mass: self.mass, centre: Vector3::zeros(), inertia: Matrix3::from_diagonal(&moments.into()) }
    }

    fn track_mass(&self, belt: &Belt) -> Mass {
        let [x, z] = belt.rollers.first().map_or([0.0; 2], |&[x, z, _]| [x, z]);
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [along, down] in belt.outline() {
            for (axis, value) in [along - x, down - z].into_iter().enumerate() {
                (least[axis], most[axis]) = (least[axis].min(value), most[axis].max(value));
            }
        }
        let [length, height] = [most[0] - least[0], most[1] - least[1]].map(|edge| edge * edge);
        let width = self.width * self.width;
        let moments = Vector3::new(width + height, length + height, length + width) * (self.mass / 12.0);
        let centre = Vector3::new(least[0] + most[0], 0.0, least[1] + most[1]) / 2.0;
        Mass { mass: self.mass, centre, inertia: Matrix3::from_diagonal(&moments) }
    }

    /// Returns the inertia of a driven wheel with its rollers about its axle, kg m², without the motor's rotor. Half of a track's mass is
    /// its belt, which moves; its rollers are light.
    pub fn spin_inertia(&self) -> f64 {
        match &self.belt {
            Some(_) => self.mass / 2.0 * self.radius.powi(2),
            None => self.mass_with_rollers(true).inertia[(1, 1)],
        }
    }

    /// Returns the mass with the rollers held.
    pub fn mass_with_rollers(&self, driven: bool) -> Mass {
        let hub = self.hub_mass(driven);
        let Some(rollers) = &self.rollers else { return hub };
        let own = rollers.inertia(self.radius);
        let mut inertia = hub.inertia;
        for index in 0..rollers.count {
            let pose = rollers.pose(index);
            let turn = pose.rotation.to_rotation_matrix();
            inertia += turn * own * turn.inverse() + point_inertia(rollers.mass, pose.translation.vector);
        }
        Mass { mass: hub.mass + f64::from(rollers.count) * rollers.mass, inertia, ..hub }
    }
}

impl Rollers {
    /// Returns the inertia of a roller along the x axis, as a solid of the exact profile, kg m².
    pub fn inertia(&self, wheel_radius: f64) -> Matrix3<f64> {
        let (axial, transverse) = self.inertia_per_mass(wheel_radius);
        Matrix3::from_diagonal(&Vector3::new(axial, transverse, transverse)) * self.mass
    }

    /// Returns the moments of inertia about the axis and across it for a mass of 1, m², by summing thin discs.
    fn inertia_per_mass(&self, wheel_radius: f64) -> (f64, f64) {
        const DISCS: u32 = 200;
        let (mut volume, mut axial, mut transverse) = (0.0, 0.0, 0.0);
        for edges in self.outline(wheel_radius, DISCS).windows(2) {
            let ([from, from_radius], [to, to_radius]) = (edges[0], edges[1]);
            let (thickness, along, radius) = (to - from, (to + from) / 2.0, (to_radius + from_radius) / 2.0);
            let disc_volume = PI * radius * radius * thickness;
            volume += disc_volume;
            axial += disc_volume * radius * radius / 2.0;
            transverse += disc_volume * (radius * radius / 4.0 + along * along);
        }
        (axial / volume, transverse / volume)
    }
}

/// Returns the inertia of a point mass about the origin.
fn point_inertia(mass: f64, position: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * position.norm_squared() - position * position.transpose()) * mass
}

fn combined(parts: impl Iterator<Item = Mass>) -> Mass {
    let parts: Vec<Mass> = parts.collect();
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    let centre = parts.iter().map(|part| part.centre * part.mass).sum::<Vector3<f64>>() / mass;
    let inertia = parts.iter().map(|part| part.inertia + point_inertia(part.mass, part.centre - centre)).sum();
    Mass { mass, centre, inertia }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_4;

    use super::*;
    use crate::Material;

    /// Reference roller: R = 50, a = 36 mm, six rollers at 45 degrees, computed independently (fidelity.md 3.2, 3.3).
    #[test]
    fn the_profile_has_the_known_numbers() {
        let rollers = Rollers {
            count: 6,
            axis_circle: 0.036,
            angle: FRAC_PI_4,
            first_roller: 0.0,
            last_phase: PI / 6.0,
            mass: 1.0,
            damping: 0.0,
            bearing_friction: 0.0,
            material: Material::default(),
        };
        let (end, end_radius) =
            (rollers.half_length_at(rollers.last_phase, 0.05), rollers.radius_at(rollers.last_phase, 0.05));
        assert!((2.0 * end - 0.06475).abs() < 1e-5, "length {end}");
        assert!((end_radius - 0.00789).abs() < 1e-5, "end radius {end_radius}");
        let (axial, transverse) = rollers.inertia_per_mass(0.05);
        assert!((axial - 79.1e-6).abs() < 0.2e-6, "axial {axial}");
        assert!((transverse - 300.4e-6).abs() < 0.5e-6, "transverse {transverse}");
    }
}
