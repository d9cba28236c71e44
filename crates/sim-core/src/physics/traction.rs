//! Contact forces of a body with spinning wheels, found together with the speeds that follow from them.
//!
//! The unknowns are the velocity of the body and the speed of each wheel relative to it; motors are implicit in their
//! speeds, so a stiff servo is stable at any step. Every contact is a row: its velocity along a direction, and the
//! impulse along it within its limit. The impulses are found by elimination, with rows moved to their limits and back until
//! each is where it belongs; should that not settle, projected Gauss-Seidel goes on from there. World axes,
//! SI units.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Most changes of the active set.
const MAX_CHANGES: u32 = 40;
/// Most sweeps of Gauss-Seidel.
const MAX_SWEEPS: u32 = 200;
/// Sweeps end when no impulse changes the velocity at its row by more than this, m/s.
const TOLERANCE: f64 = 1e-9;
/// Part of a row's own inverse mass that is added to it, so that contacts which say the same have an answer.
const SOFTNESS: f64 = 1e-6;

/// A body with wheels, at one moment.
pub(super) struct Base<'a> {
    /// Mass of everything, kg.
    pub(super) mass: f64,
    /// Centre of mass.
    pub(super) centre: Vector3<f64>,
    /// Inertia about the centre of mass with the wheels held, world axes, kg m².
    pub(super) inertia: Matrix3<f64>,
    /// The wheels.
    pub(super) wheels: &'a [SpinningWheel],
}

/// A wheel for one step.
#[derive(Debug, Clone, Copy)]
pub(super) struct SpinningWheel {
    /// Axis of a positive speed, world axes.
    pub(super) axle: Vector3<f64>,
    /// Inertia about the axle, kg m².
    pub(super) inertia: f64,
    /// Inertia of the rotor as felt at the wheel, relative to the body, kg m².
    pub(super) armature: f64,
    /// Torque of the motor at speed 0, N m.
    pub(super) stall_torque: f64,
    /// How it falls with the speed, N m s/rad.
    pub(super) gain: f64,
    /// Most torque either way, N m.
    pub(super) max_torque: f64,
}

/// Velocity of a body and of its wheels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    /// Velocity of the centre of mass.
    pub(super) linear: Vector3<f64>,
    /// Angular velocity.
    pub(super) angular: Vector3<f64>,
    /// Speeds of the wheels relative to the body.
    pub(super) spins: Vec<f64>,
}

/// Velocities of a body: linear of its centre of mass, and angular.
pub(super) type Velocity = (Vector3<f64>, Vector3<f64>);

/// Momentum belonging to a [`Motion`]: along, about the centre of mass, and of each wheel about its axle.
#[derive(Debug, Clone, Default)]
pub(super) struct Momentum {
    /// Mass times velocity.
    pub(super) linear: Vector3<f64>,
    /// About the centre of mass, wheels included.
    pub(super) angular: Vector3<f64>,
    /// What turns with each axle.
    pub(super) spins: Vec<f64>,
}

/// A body that is touched, as far as its contacts need it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Other {
    /// Velocity, linear and angular about the centre, by an impulse and a turning impulse there.
    pub(super) inverse_inertia: Matrix6<f64>,
    pub(super) centre: Vector3<f64>,
    pub(super) linear: Vector3<f64>,
    pub(super) angular: Vector3<f64>,
}

/// What an impulse may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Limit {
    /// At most so much, either way, N s.
    Within(f64),
    /// Zero or more.
    Push,
    /// At most so much of the impulse of another row, either way.
    Friction { normal: usize, coefficient: f64 },
}

/// A contact along one direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Direction of the impulse on the body.
    pub(super) direction: Vector3<f64>,
    /// Where it acts; `None` makes it a turning impulse about the direction.
    pub(super) point: Option<Vector3<f64>>,
    /// The wheel that it acts on and its hub, if it is not the body itself.
    pub(super) wheel: Option<(usize, Vector3<f64>)>,
    /// Index of the other body; `None` is the ground.
    pub(super) other: Option<usize>,
    /// Relative velocity to be reached, m/s.
    pub(super) target: f64,
    /// How much it gives way, m/s per N s.
    pub(super) compliance: f64,
    /// Limit of the impulse.
    pub(super) limit: Limit,
    /// Coefficient of rolling resistance that goes with it.
    pub(super) rolling_resistance: f64,
}

impl Base<'_> {
    /// The momentum of a motion.
    pub(super) fn momentum(&self, motion: &Motion) -> Momentum {
        let mut angular = self.inertia * motion.angular;
        let spins = self.wheels.iter().zip(&motion.spins);
        let spins = spins.map(|(wheel, &spin)| {
            angular += wheel.axle * (wheel.inertia * spin);
            wheel.inertia * (wheel.axle.dot(&motion.angular) + spin) + wheel.armature * spin
        });
        let spins = spins.collect();
        Momentum { linear: motion.linear * self.mass, angular, spins }
    }

    /// Adds an impulse at a point of a wheel.
    pub(super) fn push(
        &self,
        momentum: &mut Momentum,
        wheel: usize,
        hub: Vector3<f64>,
        point: Vector3<f64>,
        impulse: Vector3<f64>,
    ) {
        momentum.linear += impulse;
        momentum.angular += (point - self.centre).cross(&impulse);
        momentum.spins[wheel] += self.wheels[wheel].axle.dot(&(point - hub).cross(&impulse));
    }

    /// The motion at the end of a step and the impulse of every row. `momentum` is what the body would have then without
    /// contacts and motors; `expected` is a change of its velocity by others that is foreseen but not part of the answer.
    pub(super) fn solve(
        &self,
        momentum: &Momentum,
        expected: Velocity,
        rows: &[Row],
        others: &[Other],
        time_step: f64,
    ) -> (Motion, Vec<f64>) {
        let mut torques: Vec<(f64, f64)> = self.wheels.iter().map(|wheel| (wheel.stall_torque, wheel.gain)).collect();
        loop {
            let system = System::new(self, &torques, momentum, time_step);
            let jacobians: Vec<Jacobian> = rows.iter().map(|row| system.jacobian(row)).collect();
            let impulses = system.equations(expected, rows, &jacobians, others).solve(rows);
            let motion = system.motion(&jacobians, &impulses);
            // A motor at its limit gives that, whatever its speed.
            let mut limited = false;
            for ((wheel, torque), spin) in self.wheels.iter().zip(&mut torques).zip(&motion.spins) {
                let wanted = torque.0 - torque.1 * spin;
                if torque.1 > 0.0 && wanted.abs() > wheel.max_torque {
                    *torque = (wheel.max_torque.copysign(wanted), 0.0);
                    limited = true;
                }
            }
            if !limited {
                return (motion, impulses);
            }
        }
    }
}

/// The equations of one step, its wheels eliminated.
struct System<'a> {
    base: &'a Base<'a>,
    /// Inertia of a wheel and its motor against a change of its speed in this step.
    spin_inertias: Vec<f64>,
    /// Inverse inertia of the body with wheels that give way.
    inverse_inertia: Matrix3<f64>,
    free: Motion,
}

/// The directions of a row in the unknowns.
struct Jacobian {
    linear: Vector3<f64>,
    angular: Vector3<f64>,
    wheel: usize,
    spin: f64,
    /// `angular` less what the wheel takes up.
    reduced: Vector3<f64>,
    /// `inverse_inertia * reduced`.
    turning: Vector3<f64>,
}

impl<'a> System<'a> {
    fn new(base: &'a Base<'a>, torques: &[(f64, f64)], momentum: &Momentum, time_step: f64) -> Self {
        let (mut inertia, mut turning) = (base.inertia, momentum.angular);
        let mut spin_inertias = Vec::with_capacity(base.wheels.len());
        let mut spins = Vec::with_capacity(base.wheels.len());
        for ((wheel, &(stall_torque, gain)), &own) in base.wheels.iter().zip(torques).zip(&momentum.spins) {
            let spin_inertia = wheel.inertia + wheel.armature + gain * time_step;
            let spin = own + stall_torque * time_step;
            let share = wheel.axle * (wheel.inertia / spin_inertia);
            inertia -= share * wheel.axle.transpose() * wheel.inertia;
            turning -= share * spin;
            spin_inertias.push(spin_inertia);
            spins.push(spin);
        }
        let inverse_inertia = inertia.try_inverse().unwrap_or_default();
        let angular = inverse_inertia * turning;
        for ((spin, wheel), inertia) in spins.iter_mut().zip(base.wheels).zip(&spin_inertias) {
            *spin = (*spin - wheel.inertia * wheel.axle.dot(&angular)) / inertia;
        }
        let free = Motion { linear: momentum.linear / base.mass, angular, spins };
        Self { base, spin_inertias, inverse_inertia, free }
    }

    fn jacobian(&self, row: &Row) -> Jacobian {
        let linear = if row.point.is_some() { row.direction } else { Vector3::zeros() };
        let angular = row.point.map_or(row.direction, |point| (point - self.base.centre).cross(&row.direction));
        let (mut wheel, mut spin, mut reduced) = (0, 0.0, angular);
        if let (Some((index, hub)), Some(point)) = (row.wheel, row.point) {
            let axle = self.base.wheels[index].axle;
            (wheel, spin) = (index, axle.dot(&(point - hub).cross(&row.direction)));
            reduced -= axle * (self.base.wheels[index].inertia / self.spin_inertias[index] * spin);
        }
        Jacobian { linear, angular, wheel, spin, reduced, turning: self.inverse_inertia * reduced }
    }

    fn equations(&self, expected: Velocity, rows: &[Row], jacobians: &[Jacobian], others: &[Other]) -> Equations {
        let count = rows.len();
        let (mut matrix, mut wanted) = (vec![0.0; count * count], Vec::with_capacity(count));
        let (linear, angular) = (self.free.linear + expected.0, self.free.angular + expected.1);
        let inverse_mass = 1.0 / self.base.mass;
        for (i, (row, own)) in rows.iter().zip(jacobians).enumerate() {
            for (j, peer) in jacobians[..=i].iter().enumerate() {
                let mut entry = own.linear.dot(&peer.linear) * inverse_mass + own.reduced.dot(&peer.turning);
                if own.wheel == peer.wheel {
                    entry += own.spin * peer.spin / self.spin_inertias[own.wheel];
                }
                if let Some(other) = row.other.filter(|_| row.other == rows[j].other) {
                    entry += others[other].response(row, &rows[j]);
                }
                matrix[i * count + j] = entry;
                matrix[j * count + i] = entry;
            }
            matrix[i * count + i] = matrix[i * count + i] * (1.0 + SOFTNESS) + row.compliance;
            let velocity = own.linear.dot(&linear) + own.angular.dot(&angular) + own.spin * self.free.spins[own.wheel];
            let other = row.other.map_or(0.0, |other| others[other].velocity(row));
            wanted.push(row.target - velocity + other);
        }
        Equations { matrix, wanted }
    }

    fn motion(&self, jacobians: &[Jacobian], impulses: &[f64]) -> Motion {
        let mut motion = self.free.clone();
        let mut turning = Vector3::zeros();
        for (own, &impulse) in jacobians.iter().zip(impulses) {
            motion.linear += own.linear * (impulse / self.base.mass);
            turning += own.turning * impulse;
            motion.spins[own.wheel] += own.spin * impulse / self.spin_inertias[own.wheel];
        }
        motion.angular += turning;
        for ((spin, wheel), inertia) in motion.spins.iter_mut().zip(self.base.wheels).zip(&self.spin_inertias) {
            *spin -= wheel.inertia * wheel.axle.dot(&turning) / inertia;
        }
        motion
    }
}

impl Other {
    /// The impulse of a row and the turning impulse about the centre.
    fn wrench(&self, row: &Row) -> Vector6<f64> {
        let turning = row.point.map_or_else(Vector3::zeros, |point| (point - self.centre).cross(&row.direction));
        stacked(row.direction, turning)
    }

    fn velocity(&self, row: &Row) -> f64 {
        self.wrench(row).dot(&stacked(self.linear, self.angular))
    }

    /// The change of its velocity by the impulses of rows on what touches it.
    pub(super) fn change<'a>(&self, rows: impl Iterator<Item = (&'a Row, &'a f64)>) -> Velocity {
        let wrench = rows.map(|(row, impulse)| self.wrench(row) * -impulse).sum::<Vector6<f64>>();
        let change = self.inverse_inertia * wrench;
        (change.fixed_rows::<3>(0).into(), change.fixed_rows::<3>(3).into())
    }

    /// Velocity along one row by an impulse along another.
    fn response(&self, row: &Row, peer: &Row) -> f64 {
        self.wrench(row).dot(&(self.inverse_inertia * self.wrench(peer)))
    }
}

fn stacked(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// What the impulses have to do: `matrix * impulses = wanted` for the rows that hold.
struct Equations {
    /// Velocity at a row by an impulse at another, row by row.
    matrix: Vec<f64>,
    wanted: Vec<f64>,
}

impl Equations {
    /// The impulses within their limits, by active sets: rows either hold their velocity or stand at a limit. Where that
    /// does not settle, projected Gauss-Seidel goes on from there.
    fn solve(&self, rows: &[Row]) -> Vec<f64> {
        let mut impulses = vec![0.0; rows.len()];
        let mut at_limit = vec![false; rows.len()];
        let mut scratch = Scratch::default();
        for _ in 0..MAX_CHANGES {
            self.hold(&at_limit, &mut impulses, &mut scratch);
            if !self.change(rows, &mut at_limit, &mut impulses) {
                return impulses;
            }
        }
        self.sweep(rows, &mut impulses);
        impulses
    }

    fn row(&self, index: usize) -> &[f64] {
        let count = self.wanted.len();
        &self.matrix[index * count..][..count]
    }

    /// What is missing at a row, m/s.
    fn missing(&self, index: usize, impulses: &[f64]) -> f64 {
        self.wanted[index] - self.row(index).iter().zip(impulses).map(|(a, b)| a * b).sum::<f64>()
    }

    /// Solves for the rows that hold, the others as they are, by Cholesky's method.
    fn hold(&self, at_limit: &[bool], impulses: &mut [f64], scratch: &mut Scratch) {
        let Scratch { active, factor, values } = scratch;
        active.clear();
        active.extend((0..at_limit.len()).filter(|&row| !at_limit[row]));
        active.iter().for_each(|&row| impulses[row] = 0.0);
        values.clear();
        values.extend(active.iter().map(|&row| self.missing(row, impulses)));
        let count = active.len();
        factor.clear();
        factor.resize(count * count, 0.0);
        for i in 0..count {
            let source = self.row(active[i]);
            let (done, rest) = factor.split_at_mut(i * count);
            let own = &mut rest[..=i];
            for j in 0..i {
                let peer = &done[j * count..][..=j];
                let known: f64 = own[..j].iter().zip(&peer[..j]).map(|(a, b)| a * b).sum();
                own[j] = (source[active[j]] - known) / peer[j];
            }
            let known: f64 = own[..i].iter().map(|a| a * a).sum();
            own[i] = (source[active[i]] - known).max(f64::MIN_POSITIVE).sqrt();
            let known: f64 = own[..i].iter().zip(&values[..i]).map(|(a, b)| a * b).sum();
            values[i] = (values[i] - known) / own[i];
        }
        for i in (0..count).rev() {
            values[i] /= factor[i * count + i];
            let value = values[i];
            let own = &factor[i * count..][..i];
            values[..i].iter_mut().zip(own).for_each(|(value_before, a)| *value_before -= a * value);
        }
        active.iter().zip(&*values).for_each(|(&row, &impulse)| impulses[row] = impulse);
    }

    /// Moves rows to their limits and back: of the contacts only the one that is worst, friction at once. False when
    /// every row is where it belongs.
    fn change(&self, rows: &[Row], at_limit: &mut [bool], impulses: &mut [f64]) -> bool {
        let mut worst = (TOLERANCE, None);
        let mut changed = false;
        for index in 0..rows.len() {
            let own = self.row(index)[index];
            let held = impulses[index];
            let next = if at_limit[index] { held + self.missing(index, impulses) / own } else { held };
            let limited = limited(next, rows[index].limit, impulses);
            let off = (limited - held).abs() * own;
            if off < TOLERANCE {
                continue;
            }
            match rows[index].limit {
                Limit::Friction { .. } | Limit::Within(_) => {
                    at_limit[index] = next != limited;
                    impulses[index] = limited;
                    changed = true;
                }
                Limit::Push if off > worst.0 => worst = (off, Some(index)),
                Limit::Push => {}
            }
        }
        if let (_, Some(index)) = worst {
            at_limit[index] = !at_limit[index];
            impulses[index] = 0.0;
            changed = true;
        }
        changed
    }

    /// Projected Gauss-Seidel.
    fn sweep(&self, rows: &[Row], impulses: &mut [f64]) {
        for _ in 0..MAX_SWEEPS {
            let mut change = 0.0f64;
            for (index, row) in rows.iter().enumerate() {
                let own = self.row(index)[index];
                let next = limited(impulses[index] + self.missing(index, impulses) / own, row.limit, impulses);
                change = change.max((next - impulses[index]).abs() * own);
                impulses[index] = next;
            }
            if change < TOLERANCE {
                return;
            }
        }
    }
}

/// Memory of a factorisation.
#[derive(Default)]
struct Scratch {
    active: Vec<usize>,
    /// Lower triangle, row by row.
    factor: Vec<f64>,
    values: Vec<f64>,
}

fn limited(impulse: f64, limit: Limit, impulses: &[f64]) -> f64 {
    match limit {
        Limit::Within(most) => impulse.clamp(-most, most),
        Limit::Push => impulse.max(0.0),
        Limit::Friction { normal, coefficient } => {
            let most = coefficient * impulses[normal].max(0.0);
            impulse.clamp(-most, most)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.01;

    fn wheel(stall_torque: f64, gain: f64, max_torque: f64) -> SpinningWheel {
        // A positive speed rolls along +x over ground below at +z.
        let axle = -Vector3::y();
        SpinningWheel { axle, inertia: 0.01, armature: 0.002, stall_torque, gain, max_torque }
    }

    fn base(wheels: &[SpinningWheel]) -> Base<'_> {
        let inertia = Matrix3::from_diagonal(&Vector3::new(0.2, 0.4, 0.5));
        Base { mass: 10.0, centre: Vector3::zeros(), inertia, wheels }
    }

    fn moving(linear: Vector3<f64>, angular: Vector3<f64>, spins: Vec<f64>) -> Motion {
        Motion { linear, angular, spins }
    }

    /// A push from the ground under the middle, and friction along x on a wheel whose hub is 0.1 m above it.
    fn ground(coefficient: f64) -> [Row; 2] {
        let point = Vector3::new(0.0, 0.0, 0.1);
        let push = Row {
            direction: -Vector3::z(),
            point: Some(point),
            wheel: Some((0, Vector3::zeros())),
            other: None,
            target: 0.0,
            compliance: 0.0,
            limit: Limit::Push,
            rolling_resistance: 0.0,
        };
        [push, Row { direction: Vector3::x(), limit: Limit::Friction { normal: 0, coefficient }, ..push }]
    }

    fn solve(base: &Base, start: &Motion, rows: &[Row]) -> (Motion, Vec<f64>) {
        base.solve(&base.momentum(start), Default::default(), rows, &[], STEP)
    }

    #[test]
    fn without_forces_nothing_changes() {
        let wheels = [wheel(0.0, 0.0, 1.0)];
        let start = moving(Vector3::new(1.0, -2.0, 0.5), Vector3::new(0.3, 0.7, -0.2), vec![4.0]);
        let (end, _) = solve(&base(&wheels), &start, &[]);
        assert!((end.linear - start.linear).norm() < 1e-12 && (end.angular - start.angular).norm() < 1e-12, "{end:?}");
        assert!((end.spins[0] - 4.0).abs() < 1e-12);
    }

    /// What turns the wheel turns the body back: their momentum stays.
    #[test]
    fn a_motor_in_flight_keeps_the_momentum() {
        let wheels = [wheel(5.0, 1.0, 100.0)];
        let base = base(&wheels);
        let start = moving(Vector3::x(), Vector3::zeros(), vec![0.0]);
        let (end, _) = solve(&base, &start, &[]);
        let (before, after) = (base.momentum(&start), base.momentum(&end));
        assert!(end.spins[0] > 0.5 && end.angular.y > 0.0, "{end:?}");
        assert!((before.angular - after.angular).norm() < 1e-12 && (before.linear - after.linear).norm() < 1e-12);
    }

    #[test]
    fn a_servo_drives_the_body_without_slip_within_the_grip() {
        let wheels = [wheel(10.0, 10.0, 100.0)];
        let start = moving(Vector3::z() * 0.0981, Vector3::zeros(), vec![0.0]);
        let (end, impulses) = solve(&base(&wheels), &start, &ground(1e3));
        let at_ground = end.linear.x - 0.1 * end.angular.y.mul_add(-1.0, end.spins[0]);
        assert!(end.linear.z.abs() < 1e-6 && end.linear.x > 0.0, "{end:?}");
        assert!(at_ground.abs() < 1e-5, "slips by {at_ground}");
        assert!((impulses[0] - 0.981).abs() < 1e-5, "carries {} N s", impulses[0]);
    }

    #[test]
    fn beyond_the_grip_friction_is_what_it_can_be() {
        let wheels = [wheel(1000.0, 10.0, 1000.0)];
        let start = moving(Vector3::z() * 0.0981, Vector3::zeros(), vec![0.0]);
        let (end, impulses) = solve(&base(&wheels), &start, &ground(0.5));
        assert!((impulses[1] - 0.5 * impulses[0]).abs() < 1e-9, "{impulses:?}");
        assert!((end.linear.x - impulses[1] / 10.0).abs() < 1e-9, "{end:?}");
    }

    #[test]
    fn the_ground_does_not_pull() {
        let wheels = [wheel(0.0, 0.0, 1.0)];
        let start = moving(-Vector3::z(), Vector3::zeros(), vec![0.0]);
        let (end, impulses) = solve(&base(&wheels), &start, &ground(0.5));
        assert_eq!((impulses, end.linear.z), (vec![0.0, 0.0], -1.0));
    }

    #[test]
    fn a_motor_gives_no_more_than_its_limit() {
        let wheels = [wheel(1000.0, 10.0, 2.0)];
        let (end, _) = solve(&base(&wheels), &moving(Vector3::zeros(), Vector3::zeros(), vec![0.0]), &[]);
        // 2 N m for 0.01 s on the wheel and its rotor; the body gives way to the wheel's own part.
        let expected = 0.02 / (0.012 - 0.01 * 0.01 / 0.4);
        assert!((end.spins[0] - expected).abs() < 1e-9, "{} of {expected}", end.spins[0]);
    }
}
