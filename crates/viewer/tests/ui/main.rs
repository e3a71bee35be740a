//! The window, driven as a user drives it: by the names of its controls, the pointer and the keys.
//! The engine runs behind it for real; a test waits for results, never for a span of time.

mod autopsy;
mod budget;
mod camera;
mod chart;
mod compare;
mod conveniences;
mod disk;
mod editing;
mod files;
mod habits;
mod handles;
mod lab;
mod layout;
mod navigation;
mod objects;
mod plan;
mod race;
mod settings;
mod undo;
mod views;
mod window;
