//! Undo and redo of whatever changes the description of the scene: materials, shapes, settings,
//! camera. One step for each gesture.

use lightbox_core::SceneDesc;

/// Most steps that are kept.
const STEPS: usize = 200;

/// Earlier and later descriptions.
#[derive(Default)]
pub struct Undo {
    /// As of the last step.
    present: SceneDesc,
    past: Vec<SceneDesc>,
    future: Vec<SceneDesc>,
    /// As of the last frame.
    seen: SceneDesc,
}

impl Undo {
    /// Begins with the description of another file.
    pub fn open(&mut self, desc: &SceneDesc) {
        *self = Self {
            present: desc.clone(),
            seen: desc.clone(),
            ..Self::default()
        };
    }

    /// Takes down an edit once it is over: nothing has changed for a frame, and no button is held.
    pub fn watch(&mut self, desc: &SceneDesc, is_held: bool) {
        if !same(desc, &self.seen) {
            self.seen = desc.clone();
        } else if !is_held {
            self.step(desc);
        }
    }

    /// The description before the last edit, if there was one.
    pub fn undo(&mut self, desc: &mut SceneDesc) {
        self.step(desc);
        go(&mut self.past, &mut self.future, &mut self.present, desc);
        self.seen = desc.clone();
    }

    /// What was undone last, if nothing was edited since.
    pub fn redo(&mut self, desc: &mut SceneDesc) {
        self.step(desc);
        go(&mut self.future, &mut self.past, &mut self.present, desc);
        self.seen = desc.clone();
    }

    /// Whether there is something to undo, and to redo.
    pub fn can(&self) -> [bool; 2] {
        let is_edited = !same(&self.seen, &self.present);
        [is_edited || !self.past.is_empty(), !self.future.is_empty()]
    }

    fn step(&mut self, desc: &SceneDesc) {
        if !same(desc, &self.present) {
            self.past
                .push(std::mem::replace(&mut self.present, desc.clone()));
            self.future.clear();
            if self.past.len() > STEPS {
                self.past.remove(0);
            }
        }
    }
}

fn go(
    from: &mut Vec<SceneDesc>,
    to: &mut Vec<SceneDesc>,
    present: &mut SceneDesc,
    desc: &mut SceneDesc,
) {
    if let Some(mut next) = from.pop() {
        // The size of the picture is the window's business.
        (next.render.width, next.render.height) = (desc.render.width, desc.render.height);
        to.push(std::mem::replace(present, next.clone()));
        *desc = next;
    }
}

/// Whether two descriptions differ in nothing but the size of the picture.
fn same(a: &SceneDesc, b: &SceneDesc) -> bool {
    let size = |d: &SceneDesc| (d.render.width, d.render.height);
    if size(a) == size(b) {
        return a == b;
    }
    let mut b = b.clone();
    (b.render.width, b.render.height) = size(a);
    *a == b
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
    fn the_size_of_the_window_is_no_edit() {
        let mut undo = Undo::default();
        undo.open(&desc(0));
        undo.watch(&desc(1), false);
        undo.watch(&desc(1), false);
        let mut larger = desc(1);
        larger.render.width += 1;
        undo.watch(&larger, false);
        undo.watch(&larger, false);
        undo.undo(&mut larger);
        let mut expected = desc(0);
        expected.render.width += 1;
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
