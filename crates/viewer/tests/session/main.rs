//! The session against headless renders, for a moment; fuzzing does it for longer.

mod property;

#[test]
fn any_edits_end_in_the_picture_of_a_headless_render() {
    lightbox_tests::properties::check("session", 6, property::session);
}
