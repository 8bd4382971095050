//! Functions that must not allocate memory, tested with a counting allocator.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;

use standfast::modes::{ContactProblem, Method, ProblemFields, contact_modes};

struct Counting;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(mut run: impl FnMut()) -> usize {
    let before = COUNT.with(Cell::get);
    run();
    COUNT.with(Cell::get) - before
}

#[test]
fn modes_of_a_pair_allocate_nothing() {
    for (sliding, bias) in [(Some(0), 0.0), (Some(0), 0.2), (Some(1), 0.2)] {
        let problem = ContactProblem::new(ProblemFields {
            mass: 1.0,
            gyration_radius: 0.5,
            arms: vec![[-1.0, -1.0], [1.0, -0.9]],
            tangents: vec![[1.0, 0.0], [0.8, 0.6]],
            friction: vec![0.5, 0.7],
            sliding: vec![sliding; 2],
            bias: vec![[bias, 0.5 * bias]; 2],
            free_acceleration: [0.1, -1.0, 0.2],
            ..ProblemFields::default()
        })
        .unwrap();
        let closed = allocations(|| assert!(black_box(&problem).pair_modes().is_some()));
        assert_eq!(closed, 0);
        // Check of the counter itself.
        assert!(allocations(|| drop(black_box(contact_modes(&problem, Method::Enumerate)))) > 0);
    }
}
