//! Work shared among threads. This module alone uses rayon, and hides every caller's types from it:
//! the compiler translates rayon's code once and not for each caller.
//!
//! No result depends on the number of threads: values come in the order of their indices, whichever
//! thread makes them.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Bytes of each thread's stack: what Linux gives the first thread of a program.
const STACK: usize = 8 << 20;
/// Pieces per thread into which work is cut: enough for threads to finish at about the same time.
const PIECES: usize = 16;

/// Calls `work` in a pool of `threads` threads, or one a core. Where one is enough, or so many cannot be
/// started, `work` and all that it shares out is done on this thread alone.
#[cfg(feature = "cli")]
pub(crate) fn within<T: Send>(threads: Option<usize>, work: impl FnOnce() -> T + Send) -> T {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK);
    if threads != Some(1)
        && let Ok(pool) = pool(threads.unwrap_or(0)).build()
    {
        return pool.install(work);
    }
    // It starts no thread. On a thread of a pool it fails, and work goes to that pool.
    let _alone = pool(1).use_current_thread().build();
    work()
}

/// Calls both functions, on two threads if one is idle; `a` on this one, if it is of the pool.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    let (mut a, mut b) = (Some(a), Some(b));
    let (mut of_a, mut of_b) = (None, None);
    both(&mut || of_a = a.take().map(|a| a()), &mut || of_b = b.take().map(|b| b()));
    (of_a.expect("called once"), of_b.expect("called once"))
}

fn both(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Calls `f` for `0..count` on as many threads as there are; what a call shares out itself is done on its thread
/// alone. Calls are begun in the order of their indices.
pub(crate) fn each_alone(count: usize, f: &(dyn Fn(usize) + Sync)) {
    if threads() == 1 {
        return (0..count).for_each(f);
    }
    let next = AtomicUsize::new(0);
    let work = || {
        // On a thread of its own it is a pool of one.
        let _alone = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= count {
                break;
            }
            f(k);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads().min(count) {
            // One that cannot be started leaves the work to the others, and all of them to this thread.
            let _ = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        }
    });
    (next.into_inner()..count).for_each(f);
}

/// Threads among which work is shared out.
pub(crate) fn threads() -> usize {
    rayon::current_num_threads()
}

/// How many of `count` items are handled by one thread in one go: `min` or more.
fn grain(count: usize, min: usize) -> usize {
    match threads() {
        1 => usize::MAX,
        threads => (count / (PIECES * threads)).max(min).max(1),
    }
}

/// Calls `f` for every item with its index; on one thread for fewer than `min` of them.
pub(crate) fn for_each_mut<T: Send>(items: &mut [T], min: usize, f: impl Fn(usize, &mut T) + Sync) {
    let grain = grain(items.len(), min);
    halve(items, 0, grain, &|first, piece| {
        for (k, item) in piece.iter_mut().enumerate() {
            f(first + k, item);
        }
    });
}

/// Calls `f` for pieces of at most `grain` items, with the index of the first of each.
fn halve<T: Send>(
    items: &mut [T],
    first: usize,
    grain: usize,
    f: &(dyn Fn(usize, &mut [T]) + Sync),
) {
    if items.len() <= grain {
        return f(first, items);
    }
    let half = items.len() / 2;
    let (a, b) = items.split_at_mut(half);
    both(&mut || halve(a, first, grain, f), &mut || halve(b, first + half, grain, f));
}

/// What `f` makes of each chunk of `size` items and its number.
pub(crate) fn map_chunks_mut<A: Send, T: Send>(
    items: &mut [A],
    size: usize,
    f: impl Fn(usize, &mut [A]) -> T + Sync,
) -> Vec<T> {
    let mut chunks: Vec<_> = items.chunks_mut(size).map(|chunk| (chunk, None)).collect();
    for_each_mut(&mut chunks, 1, |k, (chunk, made)| *made = Some(f(k, chunk)));
    chunks.into_iter().filter_map(|(_, made)| made).collect()
}

/// What `f` makes of the pieces of `0..count`, as one list. The sizes of the pieces, `min` or more
/// but for the last, depend on the number of threads: the list must not depend on them.
pub(crate) fn gather<T: Send>(
    count: usize,
    min: usize,
    f: impl Fn(Range<usize>) -> Vec<T> + Sync,
) -> Vec<T> {
    gathered(count, grain(count, min), &f)
}

fn gathered<T: Send>(
    count: usize,
    grain: usize,
    f: &(dyn Fn(Range<usize>) -> Vec<T> + Sync),
) -> Vec<T> {
    if count <= grain {
        return f(0..count);
    }
    let mut pieces: Vec<Vec<T>> = Vec::new();
    pieces.resize_with(count.div_ceil(grain), Vec::new);
    halve(&mut pieces, 0, 1, &|k, piece| {
        piece[0] = f(k * grain..count.min((k + 1) * grain));
    });
    let mut all = Vec::with_capacity(pieces.iter().map(Vec::len).sum());
    for mut piece in pieces {
        all.append(&mut piece);
    }
    all
}

/// The values of `f` for `0..count`; on one thread for fewer than `min` of them.
pub(crate) fn map<T: Send>(count: usize, min: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    gather(count, min, |piece| piece.map(&f).collect())
}

/// The same for every item.
pub(crate) fn map_slice<A: Sync, T: Send>(
    items: &[A],
    min: usize,
    f: impl Fn(&A) -> T + Sync,
) -> Vec<T> {
    gather(items.len(), min, |piece| items[piece].iter().map(&f).collect())
}

/// The same for every chunk of `size` items.
pub(crate) fn map_chunks<A: Sync, T: Send>(
    items: &[A],
    size: usize,
    f: impl Fn(&[A]) -> T + Sync,
) -> Vec<T> {
    map(items.len().div_ceil(size), 1, |k| f(&items[k * size..items.len().min((k + 1) * size)]))
}

/// The values of `f` for `0..count` if all are some; few more are asked for once one is none.
pub(crate) fn try_map<T: Send>(
    count: usize,
    min: usize,
    f: impl Fn(usize) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    let failed = AtomicBool::new(false);
    let all = gather(count, min, |piece| {
        let mut made = Vec::with_capacity(piece.len());
        for k in piece {
            if failed.load(Ordering::Relaxed) {
                break;
            }
            match f(k) {
                Some(value) => made.push(value),
                None => failed.store(true, Ordering::Relaxed),
            }
        }
        made
    });
    (!failed.into_inner()).then_some(all)
}

/// Sorts; the order of what `compare` calls equal is not kept.
pub(crate) fn sort_unstable_by<T: Send>(
    items: &mut [T],
    compare: impl Fn(&T, &T) -> std::cmp::Ordering + Sync,
) {
    rayon::slice::ParallelSliceMut::par_sort_unstable_by(items, compare);
}

/// Pool of working memory that tasks reuse.
#[derive(Default)]
pub(crate) struct ScratchPool<S>(Mutex<Vec<S>>);

impl<S: Default> ScratchPool<S> {
    /// What `f` makes with some of it, in which an earlier call may have left anything.
    pub(crate) fn with<T>(&self, f: impl FnOnce(&mut S) -> T) -> T {
        // Never held while `f` runs, so a panic there does not poison it.
        let idle = || self.0.lock().expect("not poisoned");
        let taken = idle().pop();
        let mut scratch = taken.unwrap_or_default();
        let made = f(&mut scratch);
        idle().push(scratch);
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `run` on pools of several sizes.
    fn on_pools(run: impl Fn() + Sync) {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(&run);
        }
    }

    #[test]
    fn values_come_in_the_order_of_their_indices() {
        on_pools(|| {
            for count in (0..70).chain([1000]) {
                let expected: Vec<usize> = (0..count).map(|k| 3 * k).collect();
                for min in [1, 2, 7, 50] {
                    assert_eq!(map(count, min, |k| 3 * k), expected);
                    assert_eq!(map_slice(&expected, min, |x| *x), expected);
                    let sums = expected.chunks(min).map(|chunk| chunk.iter().sum());
                    let sums: Vec<usize> = sums.collect();
                    let sum = |chunk: &[usize]| chunk.iter().sum::<usize>();
                    assert_eq!(map_chunks(&expected, min, sum), sums);
                    let mut items = expected.clone();
                    let found = map_chunks_mut(&mut items, min, |k, chunk| {
                        chunk.iter_mut().for_each(|x| *x += k);
                        k
                    });
                    assert_eq!(found, (0..count.div_ceil(min)).collect::<Vec<_>>());
                    assert!(items.iter().enumerate().all(|(k, x)| *x == 3 * k + k / min));
                    let mut items = vec![0; count];
                    for_each_mut(&mut items, min, |k, item| *item = 3 * k);
                    assert_eq!(items, expected);
                }
            }
        });
    }

    #[test]
    fn work_inside_of_work_ends() {
        on_pools(|| {
            let sums = map(40, 1, |k| map(k, 1, |j| j).into_iter().sum::<usize>());
            assert!(sums.into_iter().enumerate().all(|(k, sum)| 2 * sum == k * k.max(1) - k));
            assert_eq!(join(|| join(|| 1, || 2), || 3), ((1, 2), 3));
        });
    }

    #[test]
    fn each_call_alone_is_made_once_and_shares_nothing_out() {
        on_pools(|| {
            for count in [0, 1, 2, 100] {
                let calls: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
                each_alone(count, &|k| {
                    assert_eq!(threads(), 1);
                    let own = std::thread::current().id();
                    assert!(
                        map(50, 1, |_| std::thread::current().id()).iter().all(|id| *id == own)
                    );
                    calls[k].fetch_add(1, Ordering::Relaxed);
                });
                assert!(calls.iter().all(|calls| calls.load(Ordering::Relaxed) == 1));
            }
        });
    }

    #[test]
    fn one_that_is_none_makes_all_none() {
        on_pools(|| {
            assert_eq!(try_map(90, 1, Some), Some((0..90).collect()));
            assert_eq!(try_map(90, 1, |k| (k != 61).then_some(k)), None);
        });
    }

    #[test]
    fn a_panic_comes_out_where_the_work_was_asked_for() {
        on_pools(|| {
            let caught = std::panic::catch_unwind(|| map(90, 1, |k| assert!(k != 77)));
            assert!(caught.is_err());
        });
    }
}
