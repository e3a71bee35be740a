//! Threads that work for the window all the time, and let it go first.

use rayon::ThreadPoolBuilder;

/// How much nicer they are than the window's thread: a frame of the window waits for none of them,
/// and neither do other programs of the desktop. Alone on the machine they are as fast.
#[cfg(target_os = "linux")]
const NICER: i32 = 10;

/// As many as trace where nobody says otherwise: on a large machine, one core in eight stays free for
/// the window and the desktop.
pub fn usual() -> usize {
    cores() - cores() / 8
}

/// How many threads the machine runs at once.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

/// A pool of such threads, as many as there are cores if it is told nothing else.
pub fn pool(name: &'static str) -> ThreadPoolBuilder {
    ThreadPoolBuilder::new()
        .thread_name(move |i| format!("lightbox-{name}-{i}"))
        .start_handler(|_| give_way())
}

/// Of the calling thread alone. Where it is refused, the thread works as others do.
fn give_way() {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::nice(NICER);
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn workers_are_nicer_than_who_starts_them() {
        let nice = || rustix::process::getpriority_process(None).expect("a priority");
        let before = nice();
        let pool = pool("test").num_threads(2).build().expect("two threads");
        // Nobody is nicer than that.
        let expected = (before + NICER).min(19);
        assert_eq!(pool.broadcast(|_| nice()), [expected; 2]);
        assert_eq!(nice(), before);
        assert!(expected > before || before == 19);
    }
}
