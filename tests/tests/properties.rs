//! The properties that fuzzing tries for hours, for a moment: on the corpus, on what is close to
//! it, and on random bytes, always the same.

use lightbox_tests::properties::{self, check};

#[test]
fn accelerators() {
    check("accelerators", 100, properties::accelerators);
}

#[test]
fn bsdfs() {
    check("bsdfs", 1000, properties::bsdfs);
}

#[test]
fn camera() {
    check("camera", 1000, properties::camera);
}

#[test]
fn film() {
    check("film", 30, properties::film);
}

#[test]
fn images() {
    check("images", 30, properties::images);
}

#[test]
fn intersectors() {
    check("intersectors", 1000, properties::intersectors);
}

#[test]
fn lights() {
    check("lights", 300, properties::lights);
}

#[test]
fn obj() {
    check("obj", 30, properties::obj);
}

#[test]
fn scene() {
    check("scene", 30, properties::scene);
}
