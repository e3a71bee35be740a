//! The viewer and the command line, both thin over `lightbox-core`.

pub mod aov;
pub mod app;
pub mod args;
pub mod autopsy;
pub mod commands;
pub mod dialogs;
pub mod gestures;
pub mod keys;
pub mod lab;
pub mod legend;
pub mod model;
pub mod orbit;
pub mod overlay;
pub mod pace;
pub mod panels;
pub mod race;
pub mod replay;
pub mod saved;
pub mod savings;
pub mod session;
pub mod spent;
pub mod undo;
pub mod viewport;
