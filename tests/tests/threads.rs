//! The motion of robots does not depend on the number of threads.

use std::sync::Arc;

use system_tests::{busy_scene, busy_world};
use thread_pool::ThreadPool;

/// Returns the digest after every tenth of a second, and every report with all digits.
fn play(threads: &ThreadPool) -> (Vec<u64>, Vec<String>) {
    let mut world = busy_world(busy_scene()).on_threads(Arc::new(threads.clone()));
    let (mut digests, mut reports) = (Vec::new(), Vec::new());
    for step in 0..1000 {
        reports.extend(world.step().into_iter().map(|report| format!("{report:?}")));
        if step % 50 == 0 {
            digests.push(world.digest());
        }
    }
    (digests, reports)
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_lines() {
    let one = play(&ThreadPool::one());
    assert!(one.1.iter().any(|line| line.contains("RangeScanner")), "no laser measures");
    for threads in [2, 8] {
        let pool = ThreadPool::new(threads).expect("threads");
        assert_eq!(pool.threads(), threads);
        for (how, many) in [("from outside", play(&pool)), ("inside", pool.run(|| play(&pool)))] {
            assert_eq!(many.0, one.0, "{threads} threads, {how}");
            assert!(many.1 == one.1, "{threads} threads, {how}: lines differ");
        }
    }
    let pool = ThreadPool::new(3).expect("threads");
    assert_eq!(pool.run_in_a_hurry(|| play(&pool)).0, one.0, "in a hurry");
}

/// A panic on a thread reaches the caller that steps the world, and no thread waits for ever.
#[test]
fn a_panic_on_a_thread_ends_what_it_was_part_of() {
    let pool = ThreadPool::new(2).expect("threads");
    for how in [ThreadPool::run::<()>, ThreadPool::run_in_a_hurry::<()>] as [fn(&ThreadPool, fn()); 2] {
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| how(&pool, || panic!("as asked"))));
        assert!(result.is_err());
    }
}
