//! Room in memory for threads: where it is short, one thread does the work.

/// Address space that one more thread takes for a while: its stack of 8 MiB at most, 128 MiB of which the C library
/// keeps an aligned half, and the same of the allocator, which keeps 32 of 64 MiB. Where it is refused something, it
/// ends the program.
const THREAD: usize = 200 << 20;

/// Address space for the next segment of the thread that goes on.
const NEXT_SEGMENT: usize = 64 << 20;

/// Whether memory would give room for so many more threads; what is asked for is not touched.
pub(super) fn has_room_for(threads: usize) -> bool {
    let mut room: Vec<u8> = Vec::new();
    let wanted = threads.saturating_mul(THREAD).saturating_add(NEXT_SEGMENT);
    let found = room.try_reserve_exact(wanted).is_ok();
    // Asked for, although nothing is done with it.
    std::hint::black_box(&mut room);
    found
}

/// The number of threads asked for, or one where there is no room for them.
pub(super) fn threads_with_room(asked: Option<usize>) -> Option<usize> {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = asked.unwrap_or_else(cores);
    if threads == 1 || has_room_for(threads) { asked } else { Some(1) }
}
