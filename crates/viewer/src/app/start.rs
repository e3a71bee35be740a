//! Opening the window, or saying why there is none.

use std::path::PathBuf;

use super::App;
use crate::commands::INTERRUPTED;
use crate::settings::Settings;
use crate::workers;

/// The window's icon: `dist/lightbox.svg` at 128×128 (`rsvg-convert -w 128`).
const ICON: &[u8] = include_bytes!("../icon.png");

/// What to do where no window can be opened.
const WITHOUT_WINDOW: &str = "use `lightbox render SCENE -o OUT.png` instead";

/// Opens the window on a scene or mesh, or on the first built-in scene, until the user closes it.
/// The error is one line that names what to use where there is no display.
pub fn run(path: Option<PathBuf>) -> Result<(), String> {
    if !has_display() {
        return Err(format!(
            "there is no display to open a window on; {WITHOUT_WINDOW}"
        ));
    }
    // Trees are built there, and samples looked into. Fails where there is one already.
    let _ = workers::pool("work").build_global();
    let icon = eframe::icon_data::from_png_bytes(ICON).expect("the icon is a PNG");
    let viewport = egui::ViewportBuilder::default()
        .with_title("lightbox")
        .with_app_id("lightbox")
        .with_icon(icon)
        .with_inner_size([1280.0, 720.0])
        .with_min_inner_size([640.0, 400.0])
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions {
        viewport,
        ..Default::default()
    };
    let create: eframe::AppCreator<'_> = Box::new(|context| {
        let settings = Settings::load(context.storage);
        let app = App::new(&context.egui_ctx, path)?.remembering(settings);
        let end = app.session.ender();
        ctrlc::set_handler(move || {
            end();
            #[expect(
                clippy::disallowed_methods,
                reason = "a window out of sight draws nothing, and never comes back to main"
            )]
            std::process::exit(INTERRUPTED.into());
        })?;
        Ok(Box::new(app))
    });
    eframe::run_native("lightbox", options, create).map_err(|e| {
        // What comes before the last colon names places in somebody's source code.
        let text = e.to_string();
        let reason = text.lines().last().unwrap_or_default();
        let reason = reason
            .rsplit(": ")
            .next()
            .unwrap_or_default()
            .trim_end_matches(')');
        format!("cannot open a window ({reason}); {WITHOUT_WINDOW}")
    })
}

/// Whether a display server is named; only where there may be none.
fn has_display() -> bool {
    let named = |name| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    cfg!(not(all(unix, not(target_vendor = "apple"))))
        || named("DISPLAY")
        || named("WAYLAND_DISPLAY")
}
