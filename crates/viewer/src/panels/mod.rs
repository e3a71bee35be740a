//! The parts of the window around the picture, one file each. A panel reads the engine's status,
//! edits the [`Model`](crate::model::Model) and asks for [`Action`](crate::keys::Action)s.

mod banner;
mod budget;
mod camera;
mod chart;
mod color;
pub mod decades;
mod display;
pub mod format;
mod help;
mod lab;
mod material;
mod object;
mod plan;
mod quit;
mod race;
mod render;
mod scene;
mod status_bar;
mod widgets;
mod window;

pub use banner::Banners;
pub use budget::budget_ui;
pub use camera::camera_ui;
pub use chart::ChartPanel;
pub use display::display_ui;
pub use help::help_ui;
pub use lab::LabPanel;
pub use material::material_ui;
pub use object::object_ui;
pub use plan::plan_ui;
pub use quit::quit_ui;
pub use race::RacePanel;
pub use render::render_ui;
pub use scene::scene_ui;
pub use status_bar::status_bar_ui;
pub use widgets::{RESTARTS, follow_focus, may_be_reset, slider, slider_row};
pub use window::window_ui;
