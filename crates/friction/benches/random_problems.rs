//! Time of 100 000 random problems without initial impulses: `cargo bench -p friction`.

use friction::{Problem, Workspace, solve};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

#[path = "../tests/support/mod.rs"]
mod support;

use support::{Kind, random};

/// Problems of each kind.
const COUNT: usize = 25_000;

fn main() {
    divan::main();
}

/// Solves all problems of a kind in sequence. The time of one problem is that of divan's items.
#[divan::bench(args = Kind::ALL, sample_count = 3, sample_size = 1)]
fn cold(bencher: divan::Bencher, kind: Kind) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let problems: Vec<Problem> = (0..COUNT).map(|_| random(kind, &mut rng)).collect();
    bencher.counter(divan::counter::ItemsCount::new(COUNT)).bench_local(|| {
        let mut workspace = Workspace::default();
        let unsettled =
            |problem: &&Problem| !solve(problem, &mut vec![0.0; problem.right_side.len()], &mut workspace).is_settled;
        problems.iter().filter(unsettled).count()
    });
}
