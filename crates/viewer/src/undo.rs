//! Undo and redo: of whatever changes the description of the scene, and apart from that of where
//! the camera has been. One step for each gesture.

use lightbox_core::SceneDesc;
use lightbox_core::scene::CameraDesc;

/// Most steps that are kept.
const STEPS: usize = 200;

/// What has a history.
pub trait State: Clone + Default {
    /// Whether going from one to the other is no step.
    fn same(&self, other: &Self) -> bool;

    /// This state as it comes back when `present` is left.
    fn coming_after(self, present: &Self) -> Self;
}

impl State for SceneDesc {
    /// The size of the picture is the window's business, and the camera has its own history.
    fn same(&self, other: &Self) -> bool {
        let apart = |d: &Self| (d.render.width, d.render.height, d.camera);
        if apart(self) == apart(other) {
            return self == other;
        }
        *self == other.clone().coming_after(self)
    }

    fn coming_after(mut self, present: &Self) -> Self {
        (self.render.width, self.render.height) = (present.render.width, present.render.height);
        self.camera = present.camera;
        self
    }
}

impl State for CameraDesc {
    fn same(&self, other: &Self) -> bool {
        self == other
    }

    fn coming_after(self, _: &Self) -> Self {
        self
    }
}

/// Earlier and later states.
#[derive(Default)]
pub struct Undo<T> {
    /// As of the last step.
    present: T,
    past: Vec<T>,
    future: Vec<T>,
    /// As of the last frame.
    seen: T,
}

impl<T: State> Undo<T> {
    /// Begins with that of another file.
    pub fn open(&mut self, state: &T) {
        *self = Self {
            present: state.clone(),
            seen: state.clone(),
            ..Self::default()
        };
    }

    /// Takes down an edit once it is over: nothing has changed for a frame, and no button is held.
    pub fn watch(&mut self, state: &T, is_held: bool) {
        if !state.same(&self.seen) {
            self.seen = state.clone();
        } else if !is_held {
            self.step(state);
        }
    }

    /// The state before the last edit, if there was one.
    pub fn undo(&mut self, state: &mut T) {
        self.step(state);
        go(&mut self.past, &mut self.future, &mut self.present, state);
        self.seen = state.clone();
    }

    /// What was undone last, if nothing was edited since.
    pub fn redo(&mut self, state: &mut T) {
        self.step(state);
        go(&mut self.future, &mut self.past, &mut self.present, state);
        self.seen = state.clone();
    }

    /// Whether there is something to undo, and to redo.
    pub fn can(&self) -> [bool; 2] {
        let is_edited = !self.seen.same(&self.present);
        [is_edited || !self.past.is_empty(), !self.future.is_empty()]
    }

    fn step(&mut self, state: &T) {
        if !state.same(&self.present) {
            self.past
                .push(std::mem::replace(&mut self.present, state.clone()));
            self.future.clear();
            if self.past.len() > STEPS {
                self.past.remove(0);
            }
        }
    }
}

fn go<T: State>(from: &mut Vec<T>, to: &mut Vec<T>, present: &mut T, state: &mut T) {
    if let Some(next) = from.pop() {
        let next = next.coming_after(state);
        to.push(std::mem::replace(present, next.clone()));
        *state = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desc(seed: u64) -> SceneDesc {
        let mut desc = SceneDesc::default();
        desc.render.seed = seed;
        desc
    }

    #[test]
    fn a_gesture_is_one_step() {
        let mut undo = Undo::default();
        undo.open(&desc(0));
        assert_eq!(undo.can(), [false, false]);
        // A drag: a new value in each frame, then one at rest, the button still held.
        for seed in [1, 2, 3, 3, 3] {
            undo.watch(&desc(seed), true);
        }
        // Let go.
        undo.watch(&desc(3), false);
        undo.watch(&desc(7), false);
        undo.watch(&desc(7), false);
        let mut present = desc(7);
        for expected in [3, 0, 0] {
            undo.undo(&mut present);
            assert_eq!(present, desc(expected));
            undo.watch(&present, false);
            undo.watch(&present, false);
        }
        assert_eq!(undo.can(), [false, true]);
        for expected in [3, 7, 7] {
            undo.redo(&mut present);
            assert_eq!(present, desc(expected));
        }
        assert_eq!(undo.can(), [true, false]);
    }

    #[test]
    fn an_edit_in_the_making_is_undone_and_an_edit_forgets_what_was() {
        let mut undo = Undo::default();
        undo.open(&desc(0));
        undo.watch(&desc(1), false);
        let mut present = desc(1);
        undo.undo(&mut present);
        assert_eq!(present, desc(0));
        undo.redo(&mut present);
        assert_eq!(present, desc(1));
        undo.undo(&mut present);
        undo.watch(&desc(5), false);
        undo.watch(&desc(5), false);
        assert_eq!(undo.can(), [true, false]);
    }

    #[test]
    fn the_size_of_the_window_and_the_camera_are_no_edits() {
        let mut undo = Undo::default();
        undo.open(&desc(0));
        undo.watch(&desc(1), false);
        undo.watch(&desc(1), false);
        let mut larger = desc(1);
        larger.render.width += 1;
        larger.camera.eye.x += 1.0;
        undo.watch(&larger, false);
        undo.watch(&larger, false);
        undo.undo(&mut larger);
        let mut expected = desc(0);
        expected.render.width += 1;
        expected.camera.eye.x += 1.0;
        assert_eq!(larger, expected);
        assert_eq!(undo.can(), [false, true]);
    }

    #[test]
    fn the_oldest_steps_go_first() {
        let mut undo = Undo::default();
        undo.open(&desc(0));
        for seed in 1..=300 {
            undo.watch(&desc(seed), false);
            undo.watch(&desc(seed), false);
        }
        let mut present = desc(300);
        for _ in 0..400 {
            undo.undo(&mut present);
        }
        assert_eq!(present, desc(100));
    }
}
