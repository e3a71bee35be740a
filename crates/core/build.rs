//! Finds the scenes that are built in: a published crate holds them, a checkout has them at the top.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let here = std::env::var("CARGO_MANIFEST_DIR").expect("cargo names the folder of the crate");
    // In a checkout `scenes` is a link, for `cargo package` to follow; where git makes no links,
    // it is a file.
    let scenes = ["scenes", "../../scenes"].map(|folder| Path::new(&here).join(folder));
    let scenes = scenes.iter().find(|folder| folder.is_dir());
    let scenes = scenes.expect("the scenes are part of the checkout and of the crate");
    println!("cargo::rustc-env=LIGHTBOX_SCENES={}", scenes.display());
}
