//! The stability lab behind the window: measures and draws cases on a thread of its own, one after
//! another, so that the window never waits.

use std::collections::{HashMap, VecDeque};
use std::panic::catch_unwind;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use lightbox_core::Image;
use lightbox_core::lab::{Case, Check, Figure, Side, Verdict};

/// How far a case is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stand {
    /// It was not measured yet.
    Unknown,
    /// It waits for its turn.
    Waiting,
    /// It is being measured.
    Running,
    /// There is a verdict.
    Settled(Verdict),
}

/// The picture of a case by the naive method and by lightbox.
pub type Pair = [Image; 2];

#[derive(Clone, Copy, PartialEq)]
enum Task {
    Measure,
    Draw,
}

#[derive(Default)]
struct State {
    queue: VecDeque<(&'static Case, Task)>,
    running: Option<(&'static str, Task)>,
    /// By id.
    figures: HashMap<&'static str, Arc<[Figure]>>,
    pictures: HashMap<&'static str, Option<Arc<Pair>>>,
    /// Whether a thread is at work.
    is_busy: bool,
    /// Measured and wanted since the thread began.
    progress: [usize; 2],
}

/// Handle to the lab; dropping it leaves at most the case in work to be done.
pub struct Lab {
    state: Arc<Mutex<State>>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Lab {
    /// A lab in which nothing was measured. `wake` is called from another thread when there is
    /// something new.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self {
            state: Arc::default(),
            wake: Arc::new(wake),
        }
    }

    /// Has cases measured, again if they were before.
    pub fn measure(&self, cases: impl IntoIterator<Item = &'static Case>) {
        let probes = cases
            .into_iter()
            .filter(|case| matches!(case.check, Check::Probe(_)));
        self.add(probes, Task::Measure);
    }

    /// The pictures of a case, or `Some(None)` if drawing them broke. They are drawn for the first
    /// who asks.
    pub fn pictures(&self, case: &'static Case) -> Option<Option<Arc<Pair>>> {
        let known = lock(&self.state).pictures.get(case.id).cloned();
        if known.is_none() {
            self.add([case], Task::Draw);
        }
        known
    }

    /// Drops what waits; the case in work is finished.
    pub fn cancel(&self) {
        let mut state = lock(&self.state);
        state.queue.clear();
        state.progress[1] = state.progress[0] + usize::from(state.running.is_some());
    }

    /// How many cases have been measured and how many are wanted, while any are.
    pub fn progress(&self) -> Option<[usize; 2]> {
        let state = lock(&self.state);
        let [done, wanted] = state.progress;
        (state.is_busy && done < wanted).then_some([done, wanted])
    }

    /// How far a case is.
    pub fn stand(&self, case: &Case) -> Stand {
        if !matches!(case.check, Check::Probe(_)) {
            return Stand::Settled(case.verdict(&[]));
        }
        let state = lock(&self.state);
        let waits = |(other, task): &(&Case, Task)| (other.id, *task) == (case.id, Task::Measure);
        if state.running == Some((case.id, Task::Measure)) {
            Stand::Running
        } else if state.queue.iter().any(waits) {
            Stand::Waiting
        } else if let Some(figures) = state.figures.get(case.id) {
            Stand::Settled(case.verdict(figures))
        } else {
            Stand::Unknown
        }
    }

    /// The figures of a case, once it is measured.
    pub fn figures(&self, case: &Case) -> Option<Arc<[Figure]>> {
        lock(&self.state).figures.get(case.id).cloned()
    }

    fn add(&self, cases: impl IntoIterator<Item = &'static Case>, task: Task) {
        let mut state = lock(&self.state);
        for case in cases {
            let is_there = state.running == Some((case.id, task))
                || state
                    .queue
                    .iter()
                    .any(|(c, t)| (c.id, *t) == (case.id, task));
            if is_there {
                continue;
            }
            match task {
                Task::Measure => {
                    state.progress[1] += 1;
                    state.queue.push_back((case, task));
                }
                // Somebody looks at it.
                Task::Draw => state.queue.push_front((case, task)),
            }
        }
        if state.is_busy || state.queue.is_empty() {
            return;
        }
        let (shared, wake) = (self.state.clone(), self.wake.clone());
        let thread = std::thread::Builder::new().name("lightbox-lab".into());
        state.is_busy = thread.spawn(move || work(&shared, &*wake)).is_ok();
        if !state.is_busy {
            state.queue.clear();
        }
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// Does what is in the queue.
fn work(shared: &Mutex<State>, wake: &(dyn Fn() + Send + Sync)) {
    loop {
        let (case, task) = {
            let mut state = lock(shared);
            let Some((case, task)) = state.queue.pop_front() else {
                state.is_busy = false;
                state.progress = [0; 2];
                drop(state);
                return wake();
            };
            state.running = Some((case.id, task));
            (case, task)
        };
        wake();
        match task {
            Task::Measure => {
                let figures = case.measure();
                let mut state = lock(shared);
                state.figures.insert(case.id, figures.into());
                state.progress[0] += 1;
                state.running = None;
            }
            Task::Draw => {
                // A panic must not end the others.
                let draw = |draw| catch_unwind(|| [Side::Naive, Side::Lightbox].map(draw)).ok();
                let pair = case.picture.and_then(draw).map(Arc::new);
                let mut state = lock(shared);
                state.pictures.insert(case.id, pair);
                state.running = None;
            }
        }
    }
}

/// Every state of the lab is valid, even if a holder of the lock has panicked.
fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::{Duration, Instant};

    use glam::Vec3;
    use lightbox_core::lab::Bound;

    use super::*;

    static GATE: AtomicBool = AtomicBool::new(false);

    const fn case(id: &'static str, check: Check) -> Case {
        Case {
            id,
            title: "",
            failure: "",
            cure: "",
            check,
            scene: None,
            picture: Some(draw),
        }
    }

    static CASES: [Case; 6] = [
        case("T0", Check::Probe(waits)),
        case("T1", Check::Probe(|| figure(1.0))),
        case("T2", Check::Probe(|| figure(2.0))),
        case("T3", Check::Probe(|| panic!("a defect"))),
        case("T4", Check::Test("tests/a.rs")),
        case("T5", Check::Absent("nothing")),
    ];

    fn waits() -> Vec<Figure> {
        while !GATE.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        figure(1.0)
    }

    fn figure(lightbox: f64) -> Vec<Figure> {
        vec![Figure {
            what: "",
            naive: None,
            lightbox,
            bound: Bound::AtMost(1.0),
        }]
    }

    fn draw(side: Side) -> Image {
        let shade = if side == Side::Naive { 0.0 } else { 1.0 };
        Image {
            width: 1,
            height: 1,
            pixels: vec![Vec3::splat(shade)],
        }
    }

    fn wait(what: &str, holds: impl Fn() -> bool) {
        let start = Instant::now();
        while !holds() {
            assert!(start.elapsed() < Duration::from_secs(60), "{what}");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn cases_are_measured_in_order_and_cancelled_in_between() {
        let lab = Lab::new(|| ());
        let stands = || CASES.each_ref().map(|case| lab.stand(case));
        let settled = |verdicts: &[Verdict]| -> Vec<Stand> {
            verdicts.iter().map(|v| Stand::Settled(*v)).collect()
        };
        assert_eq!(stands()[..4], [Stand::Unknown; 4]);
        assert_eq!(stands()[4..], settled(&[Verdict::ByTest, Verdict::Absent]));

        // The first one holds up the others, which are then dropped.
        lab.measure(&CASES);
        lab.measure(&CASES);
        wait("the first case", || stands()[0] == Stand::Running);
        assert_eq!(stands()[1..4], [Stand::Waiting; 3]);
        assert_eq!(lab.progress(), Some([0, 4]));
        lab.cancel();
        assert_eq!(stands()[1..4], [Stand::Unknown; 3]);
        assert_eq!(lab.progress(), Some([0, 1]));
        GATE.store(true, Ordering::Relaxed);
        wait("the end", || lab.progress().is_none());
        assert_eq!(stands()[..1], settled(&[Verdict::Holds]));
        assert_eq!(stands()[1..4], [Stand::Unknown; 3]);

        lab.measure(&CASES);
        wait("the end", || lab.progress().is_none());
        let (good, bad) = (Verdict::Holds, Verdict::Fails);
        assert_eq!(stands()[..4], settled(&[good, good, bad, bad]));
        assert_eq!(lab.figures(&CASES[2]).as_deref(), Some(&*figure(2.0)));

        wait("the pictures", || lab.pictures(&CASES[1]).is_some());
        let pair = lab.pictures(&CASES[1]).flatten().expect("two pictures");
        assert_eq!(*pair, [Side::Naive, Side::Lightbox].map(draw));
    }
}
