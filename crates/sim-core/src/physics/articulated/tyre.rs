//! The brush of a tyre (docs/kinematics.md, "Tyres"): a tread whose bristles bend before they slide, under parabolic pressure.
//!
//! The state of a contact is the deflection z of the tread along and across, m. It grows by the slip and is carried out of the patch by the
//! wheel's turning: z' = slip - V z / s, with the speed V of the rim and the relaxation length s. The force is k(z) z, whose stiffness k falls
//! to friction over deflection as the patch begins to slide. So in steady rolling a tyre has the force of the brush for its slip z / s.
//! For the solver a tyre is a compliance and a target speed of the two rows of its friction, which bound the force.

use scene::Tyre;

/// A tyre as a class of robots has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tread {
    pub(super) tyre: Tyre,
    /// Mean distance of the pressure in the patch from its middle, m.
    arm: f64,
}

/// Deflection of a tread along and across, m.
pub(super) type Deflection = [f64; 2];

/// A tyre in contact, as it is before the coming step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grip {
    deflection: Deflection,
    /// Force over deflection along and across, N/m.
    stiffness: [f64; 2],
    /// Friction along and across, as ratios to that of the pair.
    ratio: [f64; 2],
    /// Coefficient of friction of the pair.
    friction: f64,
    /// Slip over the slip at which the whole patch slides, and no more than 1.
    share: f64,
}

/// Rows of a tyre's friction along and across.
pub(super) struct Rows {
    /// Compliance for rows that are scaled by the ratios, m/s per N s.
    pub(super) compliance: [f64; 2],
    /// Target speed of rows that are not scaled, m/s.
    pub(super) target: [f64; 2],
}

/// Motion of a tyre over the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    /// Speed of the rim against the hub, m/s.
    pub(super) rim: f64,
    /// Velocity of the tread over the ground along and across, m/s.
    pub(super) slip: [f64; 2],
    /// Angular velocity about the normal, rad/s.
    pub(super) spin: f64,
}

impl Tread {
    pub(super) fn new(tyre: Tyre) -> Self {
        Self { tyre, arm: mean_arm(tyre.patch) }
    }

    /// Computes the moment about the normal by which the patch resists spin under a load, N, in N m. Three limits are exact, and the root of
    /// their squares joins them: a patch that slides by far more than it spins, one that only spins, and one that rolls and holds.
    pub(super) fn spin_moment(&self, friction: f64, load: f64, motion: Motion) -> f64 {
        let Tyre { stiffness, patch: [length, width], .. } = self.tyre;
        let Motion { rim, slip, spin } = motion;
        let most = friction * load;
        // While it holds, the patch slips by less than this.
        let elastic = rim.abs() * friction / stiffness[0];
        // Sliding turns with the part of the arm along the slip; mean squares of parabolic and of even pressure.
        let [along, across] = [length * length / 5.0, width * width / 3.0];
        let [ahead, aside] = slip.map(|slip| slip * slip);
        let total = ahead + aside + elastic * elastic;
        let square = if total > 0.0 { (along * ahead + across * (total - ahead)) / total } else { across };
        let turning = (spin * square / self.arm).powi(2);
        if spin == 0.0 { 0.0 } else { -most * spin * square / (total + turning).sqrt() }
    }
}

impl Grip {
    /// Computes the stiffness of a tyre under a load, N, at a deflection.
    pub(super) fn new(tyre: &Tyre, friction: f64, load: f64, deflection: Deflection) -> Self {
        let ratio = tyre.friction;
        let linear = [0, 1].map(|way| tyre.stiffness[way] / tyre.relaxation());
        // A contact may come to ground with less friction.
        let bent = share(tyre, friction, deflection);
        let (share, deflection) = if bent > 1.0 { (1.0, deflection.map(|it| it / bent)) } else { (bent, deflection) };
        // Bristles that hold have their own stiffness. Those that slide give friction along the deflection (Gäfvert and Svendenius 2003).
        let weighted = length([0, 1].map(|way| ratio[way] * friction * deflection[way]));
        let sliding = if weighted > 0.0 { share * share * (3.0 - 2.0 * share) / weighted } else { 0.0 };
        let holding = (1.0 - share).powi(2);
        let stiffness = [0, 1].map(|way| load * (holding * linear[way] + sliding * (friction * ratio[way]).powi(2)));
        Self { deflection, stiffness, ratio, friction, share }
    }

    /// Returns a tyre that just came to the ground. It is rigid for a step, as its load is not known yet.
    pub(super) fn rigid(tyre: &Tyre, friction: f64) -> Self {
        let infinite = [f64::INFINITY; 2];
        Self { deflection: [0.0; 2], stiffness: infinite, ratio: tyre.friction, friction, share: 0.0 }
    }

    /// Returns the rows for a step in which the rim runs at a speed, m/s.
    pub(super) fn rows(&self, tyre: &Tyre, rim: f64, time_step: f64) -> Rows {
        let carried = 1.0 + time_step * rim.abs() / tyre.relaxation();
        let compliance = |way: usize| self.ratio[way].powi(2) * carried / (time_step * time_step * self.stiffness[way]);
        Rows { compliance: [0, 1].map(compliance), target: self.deflection.map(|deflection| -deflection / time_step) }
    }

    /// Returns the deflection after a step that ended with a force along and across and a load, N.
    pub(super) fn after(&self, tyre: &Tyre, force: [f64; 2], load: f64) -> Deflection {
        let most = self.friction * load;
        let used = length([0, 1].map(|way| force[way] / self.ratio[way]));
        if most > 0.0 && used < most * (1.0 - 1e-9) {
            return [0, 1].map(|way| -force[way] / self.stiffness[way]);
        }
        // The patch slides. It is bent as far as it can be, along its slip.
        let slip = [0, 1].map(|way| -force[way] / self.ratio[way].powi(2));
        let share = share(tyre, self.friction, slip);
        if share > 0.0 { slip.map(|slip| slip / share) } else { [0.0; 2] }
    }

    /// Returns the distance behind the wheel's middle at which the force across acts while it rolls, m: the moment mu N a x (1 - x)^3 of the
    /// brush, at a share x of full sliding, over its force.
    pub(super) fn trail(&self, tyre: &Tyre) -> f64 {
        let share = self.share;
        tyre.patch[0] * (1.0 - share).powi(3) / (3.0 - 3.0 * share + share * share)
    }
}

/// Computes the slip over that at which the whole patch slides, for the deflection that it has in steady rolling. It is not limited here.
fn share(tyre: &Tyre, friction: f64, deflection: Deflection) -> f64 {
    let part = |way: usize| tyre.stiffness[way] * deflection[way] / (tyre.relaxation() * tyre.friction[way]);
    length([part(0), part(1)]) / (3.0 * friction)
}

fn length([one, other]: [f64; 2]) -> f64 {
    (one * one + other * other).sqrt()
}

/// Computes the mean distance from the middle of a patch, with a half length and width, over its pressure: parabolic along, even across.
fn mean_arm([length, width]: [f64; 2]) -> f64 {
    const PIECES: usize = 64;
    let middles = || (0..PIECES).map(|piece| (piece as f64 + 0.5) / PIECES as f64);
    let of_row = |y: f64| {
        middles().map(|x| 1.5 * (1.0 - x * x) * self::length([x * length, y * width])).sum::<f64>() / PIECES as f64
    };
    middles().map(of_row).sum::<f64>() / PIECES as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOAD: f64 = 50.0;
    const FRICTION: f64 = 0.6;
    const STEP: f64 = 0.001;
    const TYRE: Tyre =
        Tyre { stiffness: [6.0, 5.0], patch: [0.03, 0.02], relaxation: Some(0.04), friction: scene::isotropic() };

    /// Returns the forces along and across, step by step, of a tyre whose rim runs at 1 m/s, for a slip from rest. Each row is solved by hand.
    fn forces(tyre: &Tyre, slip: [f64; 2], steps: usize) -> Vec<([f64; 2], Grip)> {
        let mut deflection = [0.0; 2];
        let most = FRICTION * LOAD * STEP;
        let step = |_| {
            let grip = Grip::new(tyre, FRICTION, LOAD, deflection);
            let Rows { compliance, target } = grip.rows(tyre, 1.0, STEP);
            let row = |way: usize| tyre.friction[way] * (target[way] - slip[way]) / compliance[way];
            let impulse = [row(0), row(1)];
            let over = (length(impulse) / most).max(1.0);
            // A contact that slides gives its force against the slip of the scaled rows.
            let scaled = [0, 1]
                .map(|way| tyre.friction[way] * slip[way] / length([0, 1].map(|way| tyre.friction[way] * slip[way])));
            let impulse = if over > 1.0 { scaled.map(|slip| -slip * most) } else { impulse };
            let force = [0, 1].map(|way| impulse[way] * tyre.friction[way] / STEP);
            deflection = grip.after(tyre, force, LOAD);
            (force, grip)
        };
        (0..steps).map(step).collect()
    }

    fn steady(tyre: &Tyre, slip: [f64; 2]) -> ([f64; 2], Grip) {
        forces(tyre, slip, 2000).pop().expect("steps")
    }

    #[track_caller]
    fn check(what: &str, found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected}");
    }

    /// F = mu N (3 x - 3 x^2 + x^3), all of the friction from x = 1, and the moment mu N a x (1 - x)^3.
    #[test]
    fn a_brush_under_parabolic_pressure_has_its_force_and_moment() {
        for x in [0.02, 0.2, 0.5, 0.8, 0.99, 1.0, 1.5, 4.0] {
            for (way, sign) in [(0, 1.0), (1, -1.0)] {
                let mut slip = [0.0; 2];
                slip[way] = sign * 3.0 * FRICTION * x / TYRE.stiffness[way];
                let (force, grip) = steady(&TYRE, slip);
                let within = f64::min(x, 1.0);
                let expected = 3.0 * within - 3.0 * within.powi(2) + within.powi(3);
                check(&format!("force at {x}"), -sign * force[way] / (FRICTION * LOAD), expected, 1e-6);
                let moment = grip.trail(&TYRE) * force[way].abs() / (FRICTION * LOAD * TYRE.patch[0]);
                check(&format!("moment at {x}"), moment, within * (1.0 - within).powi(3), 1e-6);
            }
        }
    }

    /// With unequal stiffness the part that holds pulls along stiffness times slip, and the part that slides along the slip.
    #[test]
    fn combined_slip_is_that_of_gaefvert_and_svendenius() {
        for [ahead, aside] in [[0.05, 0.05], [0.1, -0.2], [0.3, 0.02], [-0.5, 0.4], [2.0, 2.0]] {
            let (force, _) = steady(&TYRE, [ahead, aside]);
            let elastic = [ahead * TYRE.stiffness[0], aside * TYRE.stiffness[1]];
            let x = (length(elastic) / (3.0 * FRICTION)).min(1.0);
            let slip = length([ahead, aside]);
            for (way, part) in [ahead, aside].into_iter().enumerate() {
                let holding = if x < 1.0 { (1.0 - x).powi(2) * elastic[way] } else { 0.0 };
                let sliding = FRICTION * x * x * (3.0 - 2.0 * x) * part / slip;
                check(&format!("{ahead}, {aside}"), -force[way] / LOAD, holding + sliding, 1e-6);
            }
        }
    }

    /// A tyre that slides with unequal friction has its force on an ellipse: along mu_x^2 and mu_y^2 times the slip.
    #[test]
    fn friction_is_an_ellipse() {
        let tyre = Tyre { friction: [1.0, 0.7], ..TYRE };
        for slip in [[1.0, 1.0], [3.0, -0.5], [0.1, 2.0]] {
            let (force, _) = steady(&tyre, slip);
            let weighted = [slip[0], 0.7 * slip[1]];
            let expected = [slip[0], 0.49 * slip[1]].map(|part| -part / length(weighted) * FRICTION * LOAD);
            check("ahead", force[0], expected[0], 1e-6 * LOAD);
            check("aside", force[1], expected[1], 1e-6 * LOAD);
        }
    }

    /// After a step of slip the force rises by 1 - exp(-way / relaxation length).
    #[test]
    fn the_force_follows_a_step_within_the_relaxation_length() {
        let slip = 1e-4;
        let found = forces(&TYRE, [0.0, slip], 200);
        for way in [0.01, 0.04, 0.1] {
            let at = (way / STEP) as usize - 1;
            let share = -found[at].0[1] / (TYRE.stiffness[1] * slip * LOAD);
            check(&format!("after {way} m"), share, 1.0 - (-way / TYRE.relaxation()).exp(), 0.006);
        }
    }

    /// Spin: 3/8 mu N a of a line, mu N w <r^2> / v where it slides by more than it spins, and C w b^2 / (3 V) where it rolls and holds.
    #[test]
    fn a_patch_resists_spin_in_each_of_the_three_limits() {
        let motion = |rim: f64, slip: [f64; 2], spin: f64| Motion { rim, slip, spin };
        let line = Tread::new(Tyre { patch: [0.03, 1e-6], ..TYRE });
        let patch = Tread::new(TYRE);
        let most = FRICTION * LOAD;
        check(
            "line",
            line.spin_moment(FRICTION, LOAD, motion(0.0, [0.0; 2], 2.0)),
            -most * 0.375 * 0.03,
            1e-3 * most * 0.03,
        );
        let sliding = |slip| patch.spin_moment(FRICTION, LOAD, motion(0.0, slip, 1.0));
        check("slides ahead", sliding([5.0, 0.0]), -most * 0.03_f64.powi(2) / 5.0 / 5.0, 1e-8 * most);
        check("slides aside", sliding([0.0, 5.0]), -most * 0.02_f64.powi(2) / 3.0 / 5.0, 1e-8 * most);
        let rolling = patch.spin_moment(FRICTION, LOAD, motion(1.0, [0.0; 2], 0.1));
        check("rolls", rolling, -TYRE.stiffness[0] * LOAD * 0.02_f64.powi(2) / 3.0 * 0.1, 1e-6);
    }
}
