//! The limit on memory holds for a whole process, so that this test has one for itself.

use fuzz::MEMORY;

#[test]
fn a_target_has_so_much_memory_and_no_more() {
    fn reserve(_: &[u8]) {
        let reserve = |bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok();
        assert!(reserve(MEMORY / 2) && !reserve(MEMORY + 1));
    }
    fuzz::run(reserve, &[]);
    assert!(Vec::<u8>::new().try_reserve_exact(MEMORY + 1).is_ok());
}
