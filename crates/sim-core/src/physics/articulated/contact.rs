//! Contacts of a robot as the solver takes them, and their effects on the robot.

use articulated::{Contact, JointRow, Side};
use nalgebra::Vector3;

use super::super::identity::BodyId;
use super::super::rolling::Load;
use super::ArticulatedRobot;
use super::compile::Ring;
use super::finding::{CandidateContact, Counterpart, Key, MARGIN};
use super::form::{Form, Surface};
use super::tyre::{Grip, Motion, Tread};
use super::wheel::{RollerTouch, SIDE, Touch};

/// Stiffness of a contact, N/m. It shares the load between contacts.
const STIFFNESS: f64 = 1e8;
/// Stiffness of contacts in heaps, N/m: 30 kg sink in by 0.1 mm, or 1 mm. The first is that of a contact with the ground of an object, or
/// of a robot that touches another body. The second is that of a contact between two moving bodies. Stiffer contacts in heaps take Newton's
/// method several times as many steps.
const STIFFNESS_TOGETHER: [f64; 2] = [1e6, 1e5];
/// Time in which an overlap is pushed out, s.
const RECOVERY_TIME: f64 = 0.02;
/// Largest speed at which an overlap is pushed out, m/s: of roots, wheels and tracks, and of other links. These are light, and far from
/// their joints they would be thrown.
const MAX_RECOVERY: [f64; 2] = [1.0, 0.25];
/// Age at which a contact remembers all of its last impulse, s. Friction that an impact locks in is gone before: a robot that ran into a tower
/// would lean there on its bumper for ever. Until then a load creeps by up to a tenth of the velocity that friction stops in a step.
const MEMORY_TIME: f64 = 0.1;
/// Approach speed below which nothing bounces, m/s.
const LEAST_BOUNCE: f64 = 0.2;
/// Speed of a rim below which a tyre stands, m/s: then its force acts in the middle of its patch.
const LEAST_RIM: f64 = 1e-4;
/// Ratio of a bearing's compliance to the robot's (one over its mass) above which the bearing hardly brakes.
const WEAK: f64 = 1e4;

impl Surface {
    /// Returns the largest speed at which an overlap is pushed out, m/s.
    pub(super) fn recovery(&self) -> f64 {
        MAX_RECOVERY[usize::from(self.link != 0 && self.form == Form::Solid)]
    }
}

impl ArticulatedRobot {
    /// Returns a contact as the solver takes it. `body` is the robot's number among the bodies solved together. `moves` is the velocity of
    /// the other body at the contact.
    pub(super) fn contact(
        &mut self,
        found: &CandidateContact,
        body: usize,
        second: Option<Side>,
        moves: Vector3<f64>,
        is_alone: bool,
        time_step: f64,
    ) -> Contact {
        let [of_ground, between] = STIFFNESS_TOGETHER;
        let is_object = matches!(self.id, BodyId::Object(_));
        let stiffness = match found.counterpart {
            Counterpart::Fixed if is_alone && !is_object => STIFFNESS,
            Counterpart::Fixed => of_ground,
            Counterpart::Itself(_) | Counterpart::Robot(..) | Counterpart::OfEngine(..) => between,
        };
        let first = Side { body, link: self.link_of(found) };
        let Touch { point, normal, gap, share, .. } = found.touch;
        let stiffness = stiffness * share;
        let velocity = self.body.velocity_at(first.link, point) - moves;
        let speed = normal.dot(&velocity);
        let push = if gap > 0.0 { -gap / time_step } else { (-gap / (time_step + RECOVERY_TIME)).min(found.recovery) };
        let bounces = gap <= 0.0 && speed < -LEAST_BOUNCE;
        let mut contact = Contact {
            point,
            normal,
            tangents: self.tangents(found),
            friction: found.friction,
            target: if bounces { push.max(-speed * found.restitution) } else { push },
            compliance: [1.0 / (time_step * stiffness * (time_step + RECOVERY_TIME)), 0.0, 0.0],
            first,
            second,
            drift: if second.is_some() { Vector3::zeros() } else { found.drift },
            impulse: found.start,
            memory: found.start * (found.age / MEMORY_TIME).min(1.0),
        };
        self.free_roller(found, &mut contact, velocity, time_step);
        if let Some(tread) = self.compiled.surfaces[found.key.surface].tread {
            self.bend_tread(&tread, found, &mut contact, velocity, time_step);
        }
        contact
    }

    /// Returns the link that a contact pushes.
    pub(super) fn link_of(&self, found: &CandidateContact) -> usize {
        let surface = &self.compiled.surfaces[found.key.surface];
        let (Form::Rollers(ring), Some(roller)) = (surface.form, found.touch.roller) else { return surface.link };
        self.compiled.rings[ring].first_link.map_or(surface.link, |first| first + roller.index)
    }

    /// Returns the directions of friction: the way that a wheel rolls, or a roller's axis, and the direction across.
    fn tangents(&self, found: &CandidateContact) -> [Option<Vector3<f64>>; 2] {
        let normal = found.touch.normal;
        let surface = &self.compiled.surfaces[found.key.surface];
        let along = match (found.touch.roller, surface.form) {
            (Some(RollerTouch { axis, .. }), _) => (axis - normal * axis.dot(&normal)).try_normalize(1e-6),
            (None, Form::Wheel { .. } | Form::Track(_)) => {
                normal.cross(&(self.body.frames()[surface.link].rotation * Vector3::y())).try_normalize(0.1)
            }
            (None, _) => None,
        };
        let along = along.unwrap_or_else(|| {
            let aside = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
            normal.cross(&aside).normalize()
        });
        [Some(along), Some(normal.cross(&along))]
    }

    /// Lets a roller without inertia turn: it carries force along its axis only, but for its bearing friction. A base that follows its
    /// commands gets no friction, as its wheels may slide.
    fn free_roller(&mut self, found: &CandidateContact, contact: &mut Contact, velocity: Vector3<f64>, time_step: f64) {
        let compiled = &self.compiled;
        let (Some(RollerTouch { index, radius, .. }), Form::Rollers(ring)) =
            (found.touch.roller, compiled.surfaces[found.key.surface].form)
        else {
            return;
        };
        let ring_of = &compiled.rings[ring];
        let Some(across) = contact.tangents[1].filter(|_| ring_of.first_link.is_none()) else { return };
        let passing = across.dot(&velocity);
        // The roller's surface moves as fast as the ground passes.
        if found.touch.gap < MARGIN {
            self.roller_angles[ring][index] -= passing / radius * time_step;
        }
        if compiled.following.is_some() {
            contact.tangents = [None; 2];
            return;
        }
        let axle = self.body.frames()[ring_of.wheel].rotation * Vector3::y();
        if contact.normal.dot(&axle).abs() > SIDE {
            return;
        }
        // Torque d w of the bearing at the roller's speed w = v / rho is a force d v / rho².
        let free = radius.powi(2) / (ring_of.damping * time_step);
        if free * compiled.mass < WEAK {
            contact.compliance[2] = free;
        } else {
            // A weak bearing is applied as a force, which saves a row of the solver.
            contact.tangents[1] = None;
            self.body.push(ring_of.wheel, contact.point, across * (-passing / (free * time_step)));
        }
    }

    /// Lets a tyre bend: the rows of its friction give way, and the patch resists spin and turns its force behind its middle. The load is that
    /// of the last step; without one the tyre is a rigid disc. `velocity` is that of the tread over the other body.
    fn bend_tread(
        &mut self,
        tread: &Tread,
        found: &CandidateContact,
        contact: &mut Contact,
        velocity: Vector3<f64>,
        time_step: f64,
    ) {
        let ([Some(along), Some(across)], Contact { point, normal, first, friction, .. }) =
            (contact.tangents, *contact)
        else {
            return;
        };
        let frame = &self.body.frames()[first.link];
        if normal.dot(&(frame.rotation * Vector3::y())).abs() > SIDE || friction <= 0.0 {
            return;
        }
        // A contact that came takes over from another of its tyre.
        let is_own = |key: &Key| *key == found.key;
        let is_near = |key: &Key| key.surface == found.key.surface;
        let of_last = |is: &dyn Fn(&Key) -> bool| {
            let bent = self.deflections.iter().find(|(key, _)| is(key))?;
            let known = self.known.iter().find(|known| known.key == bent.0)?;
            Some((bent.1, known.impulse))
        };
        let Some((deflection, impulse)) = of_last(&is_own).or_else(|| of_last(&is_near)) else {
            return self.grips.push((found.key, Grip::rigid(&tread.tyre, friction)));
        };
        let load = impulse.dot(&normal) / time_step;
        if load <= 0.0 {
            return;
        }
        let carrier = self.body.tree().links()[first.link].parent;
        let rim = self.body.velocity_at(first.link, point) - self.body.velocity_at(carrier, point);
        let motion = Motion {
            rim: rim.norm(),
            slip: [along.dot(&velocity), across.dot(&velocity)],
            spin: frame.angular.dot(&normal),
        };
        let grip = Grip::new(&tread.tyre, friction, load, deflection);
        let rows = grip.rows(&tread.tyre, motion.rim, time_step);
        let ratio = tread.tyre.friction;
        contact.compliance = [contact.compliance[0], rows.compliance[0], rows.compliance[1]];
        contact.drift += along * rows.target[0] + across * rows.target[1];
        if ratio != scene::isotropic() {
            contact.tangents = [Some(along * ratio[0]), Some(across * ratio[1])];
            // The solver takes the guess along scaled rows.
            let guess = contact.impulse;
            let scaled = |way: Vector3<f64>, ratio: f64| way * (way.dot(&guess) * (1.0 / (ratio * ratio) - 1.0));
            contact.impulse += scaled(along, ratio[0]) + scaled(across, ratio[1]);
        }
        let aside = across * (across.dot(&impulse) / time_step);
        let behind = rim.try_normalize(LEAST_RIM).map_or_else(Vector3::zeros, |back| back * grip.trail(&tread.tyre));
        let lever = (point - self.body.centre()).norm_squared().max(tread.tyre.patch[1].powi(2));
        // It stops the spin at most.
        let stop = self.compiled.mass / self.compiled.wheels.len() as f64 * lever * motion.spin.abs() / time_step;
        let moment = tread.spin_moment(friction, load, motion).clamp(-stop, stop);
        self.body.twist(first.link, behind.cross(&aside) + normal * moment);
        self.grips.push((found.key, grip));
    }

    /// Stores the deflections of the tyres after a step, from the contacts and what they gave.
    pub(super) fn note_treads(&mut self, found: &[CandidateContact], contacts: &[Contact], time_step: f64) {
        let mut grips = std::mem::take(&mut self.grips);
        for (key, grip) in grips.drain(..) {
            let Some((it, contact)) = found.iter().zip(contacts).find(|(it, _)| it.key == key) else { continue };
            let (Some(tread), [Some(along), Some(across)]) =
                (self.compiled.surfaces[it.key.surface].tread, contact.tangents)
            else {
                continue;
            };
            let force = contact.impulse / time_step;
            let sides = [along, across].map(|way| way.normalize().dot(&force));
            let load = force.dot(&contact.normal);
            if load > 0.0 {
                self.deflections.push((key, grip.after(&tread.tyre, sides, load)));
            }
        }
        self.grips = grips;
    }

    /// Brakes the rollers that carry by the dry friction of their bearings, under the loads of the last step: a moment between roller and
    /// wheel, or, without links, a force along the way that the roller turns. It is no more than stops the robot's motion along that way.
    pub(super) fn brake_rollers(&mut self, gravity: Vector3<f64>, time_step: f64) {
        let has_friction = |ring: &Ring| ring.bearing_friction > 0.0;
        if self.compiled.following.is_some() || !self.compiled.rings.iter().any(has_friction) {
            return;
        }
        let compiled = self.compiled.clone();
        for (number, surface) in compiled.surfaces.iter().enumerate() {
            let (Form::Rollers(ring), Some(wheel)) = (surface.form, surface.wheel) else { continue };
            let ring = &compiled.rings[ring];
            let Load { normal, .. } = self.loads[wheel];
            if !has_friction(ring) || normal == Vector3::zeros() {
                continue;
            }
            let touching = self.found.iter().filter(|it| it.key.surface == number);
            let nearest = touching.min_by(|one, other| one.touch.gap.total_cmp(&other.touch.gap));
            let Some((touch, roller)) = nearest.and_then(|it| Some((it.touch, it.touch.roller?))) else { continue };
            let load = Load { normal, resistance: ring.bearing_friction * normal.norm() };
            let share = compiled.mass / compiled.rings.len() as f64;
            let Some(across) = touch.normal.cross(&roller.axis).try_normalize(1e-6) else { continue };
            let passing = across.dot(&(self.body.velocity_at(ring.wheel, touch.point) + gravity * time_step));
            if let Some(first) = ring.first_link {
                // A roller that just landed turns a step later.
                let moment = load.moment(roller.radius, -passing, share, time_step);
                self.body.load(self.body.tree().dof_of(first + roller.index), moment);
            } else {
                self.body.push(ring.wheel, touch.point, load.force(across * passing, share, time_step));
            }
        }
    }

    /// Drops the contacts, impulses and loads of the last step.
    pub(super) fn forget(&mut self) {
        self.contacts.clear();
        self.known.clear();
        self.deflections.clear();
        self.loads.fill(Load::default());
    }

    /// Stores the impulses of the joints' rows after a step.
    pub(super) fn note_joints(&mut self, rows: &[JointRow], time_step: f64) {
        self.joint_impulses.clear();
        self.joint_impulses.extend(rows.iter().map(|row| row.impulse));
        if self.compiled.following.is_some() {
            // The rows of a base that follows its commands stand for ground forces on its wheels.
            let linear = |row: &JointRow| Vector3::from_column_slice(&row.root[3..]) * row.impulse;
            let force = rows.iter().map(linear).sum::<Vector3<f64>>();
            let share = force / (time_step * self.resistances.len().max(1) as f64);
            self.resistances.iter_mut().for_each(|resistance| *resistance += share);
        }
    }

    /// Records the impulse of a contact on one of the surfaces. `sign` is 1 for the first body and -1 for the second. `slip` is that of the
    /// first body's surface over the second's, m/s.
    pub(super) fn note(
        &mut self,
        surface: usize,
        found: &CandidateContact,
        contact: &Contact,
        slip: Vector3<f64>,
        sign: f64,
        time_step: f64,
    ) {
        let push = contact.impulse.dot(&contact.normal);
        if push <= 0.0 {
            return;
        }
        let wheel = self.compiled.surfaces[surface].wheel;
        self.contacts.push(scene::Contact {
            point: contact.point,
            force: contact.impulse * (sign / time_step),
            wheel,
            slip: slip * sign,
            friction_share: friction_share(contact, push),
        });
        if let Some(load) = wheel.map(|wheel| &mut self.loads[wheel]) {
            load.normal += contact.normal * (sign * push);
            load.resistance += found.resistance * push;
        }
    }

    /// Returns the part of the velocity of one of its contacts that is slip: along the surface, and for a roller without a link along its
    /// axis.
    pub(super) fn slip(&self, found: &CandidateContact, contact: &Contact, velocity: Vector3<f64>) -> Vector3<f64> {
        let along = velocity - contact.normal * contact.normal.dot(&velocity);
        let has_no_link = contact.first.link == self.compiled.surfaces[found.key.surface].link;
        match found.touch.roller.filter(|_| has_no_link) {
            Some(RollerTouch { axis, .. }) => {
                let axis = axis - contact.normal * contact.normal.dot(&axis);
                axis.try_normalize(1e-6).map_or(along, |axis| axis * axis.dot(&velocity))
            }
            None => along,
        }
    }
}

/// Returns the friction of a contact over the most that it can give under its normal impulse, N s.
fn friction_share(contact: &Contact, push: f64) -> f64 {
    let most = contact.friction * push;
    // The impulse of a row that is scaled by a ratio lies along its scaled tangent.
    let row = |tangent: &Vector3<f64>| tangent.dot(&contact.impulse) / tangent.norm_squared();
    let used = contact.tangents.iter().flatten().map(|tangent| row(tangent).powi(2)).sum::<f64>().sqrt();
    if most > 0.0 { (used / most).min(1.0) } else { 0.0 }
}
