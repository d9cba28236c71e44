//! Thousands of random problems without initial impulses. Every answer is checked row by row.

use friction::{Constraint, Outcome, Problem, TOLERANCE, Workspace, solve};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

mod support;

use support::{Kind, random};

/// Problems of each kind.
const COUNT: usize = 1000;

/// Solves a problem without initial impulses.
fn cold(problem: &Problem) -> (Vec<f64>, Outcome) {
    let mut impulses = vec![0.0; problem.right_side.len()];
    let outcome = solve(problem, &mut impulses, &mut Workspace::default());
    (impulses, outcome)
}

#[test]
fn what_settles_is_right_and_nearly_all_does() {
    let mut all_unsettled = 0;
    for kind in Kind::ALL {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let (mut unsettled, mut steps, mut sweeps, mut worst) = (0, 0, 0, 0.0_f64);
        for _ in 0..COUNT {
            let problem = random(kind, &mut rng);
            let (impulses, outcome) = cold(&problem);
            let residual = problem.residual(&impulses).worst();
            assert!(impulses.iter().all(|it| it.is_finite()), "{kind:?}: {problem:?}");
            assert_eq!(outcome.is_settled, residual <= TOLERANCE, "{kind:?}: misses by {residual:e}");
            unsettled += usize::from(!outcome.is_settled);
            (steps, sweeps, worst) = (steps + outcome.newton_steps, sweeps + outcome.sweeps, worst.max(residual));
        }
        let mean = |total: usize| total as f64 / COUNT as f64;
        println!(
            "{kind:?}: {unsettled} of {COUNT} not settled, at worst {worst:.1e}; {:.1} sweeps and {:.1} steps in the mean",
            mean(sweeps),
            mean(steps)
        );
        all_unsettled += unsettled;
    }
    // Two in a thousand.
    assert!(all_unsettled * 500 <= COUNT * Kind::ALL.len(), "{all_unsettled} not settled");
}

/// In steady motion the last step's impulses are exact, and those of a similar problem are close.
#[test]
fn a_problem_that_comes_again_takes_no_sweep() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let (mut same, mut near) = (0, 0);
    for _ in 0..COUNT {
        let mut problem = random(Kind::Wheels, &mut rng);
        let (first, outcome) = cold(&problem);
        if !outcome.is_settled {
            continue;
        }
        let mut impulses = first.clone();
        let again = solve(&problem, &mut impulses, &mut Workspace::default());
        assert_eq!((again.sweeps, again.newton_steps, &impulses), (0, 0, &first));
        same += 1;
        problem.right_side.iter_mut().for_each(|right_side| *right_side *= 1.0 + 1e-4);
        near += usize::from(solve(&problem, &mut impulses, &mut Workspace::default()).sweeps == 0);
    }
    assert!(same > 990 && near * 100 >= same * 99, "{near} of {same}");
}

/// Cases that can be solved by hand: a body of 2 kg on one contact, and a joint with dry friction.
#[test]
fn one_contact_holds_slides_or_lets_go() {
    let contact = |tangents| Constraint::Contact { friction: 0.5, tangents };
    for (constraint, right_side, expected) in [
        // The body moves down at 1 m/s and aside at 0.3, which half the normal impulse can stop.
        (contact(2), vec![1.0, 0.3, 0.0], vec![2.0, 0.6, 0.0]),
        // It moves aside at 1.0 along a diagonal, which friction cannot stop.
        (contact(2), vec![1.0, 0.8, 0.6], vec![2.0, 0.8, 0.6]),
        // The body moves up.
        (contact(2), vec![-1.0, 0.8, 0.6], vec![0.0, 0.0, 0.0]),
        // A roller has friction along its axis alone.
        (contact(1), vec![1.0, 0.3], vec![2.0, 0.6]),
        (contact(1), vec![1.0, -0.8], vec![2.0, -1.0]),
        // The end of a joint only pushes.
        (contact(0), vec![1.0], vec![2.0]),
        (contact(0), vec![-1.0], vec![0.0]),
        // Dry friction holds, or slides at its limit.
        (Constraint::Within(1.0), vec![0.4], vec![0.8]),
        (Constraint::Within(1.0), vec![-0.8], vec![-1.0]),
        (Constraint::Within(f64::INFINITY), vec![-0.8], vec![-1.6]),
    ] {
        let count = right_side.len();
        let delassus = (0..count * count).map(|entry| if entry % (count + 1) == 0 { 0.5 } else { 0.0 }).collect();
        let problem = Problem { delassus, right_side: right_side.clone(), constraints: vec![constraint] };
        let (impulses, outcome) = cold(&problem);
        let off = impulses.iter().zip(&expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max);
        assert!(outcome.is_settled && off < 1e-9, "{constraint:?} {right_side:?}: {impulses:?}, expected {expected:?}");
    }
}
