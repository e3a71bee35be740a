//! Cameras under digits, and the camera as text.

use egui::{Context, Event, Key, Modifiers};
use lightbox_core::Camera;
use lightbox_core::scene::CameraDesc;
use serde::{Deserialize, Serialize};

/// Cameras under the digits 1 to 9.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bookmarks([Option<CameraDesc>; 9]);

/// What a digit asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// Move there.
    Go(CameraDesc),
    /// Taken down: which digit.
    Set(usize),
    /// There is none under this digit.
    Missing(usize),
}

const DIGITS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

impl Bookmarks {
    /// Takes down a camera under a digit from 1 to 9.
    pub fn set(&mut self, digit: usize, camera: &CameraDesc) {
        if let Some(place) = self.0.get_mut(digit.wrapping_sub(1)) {
            *place = Some(*camera);
        }
    }

    /// Takes down a camera or finds one, as the digits that were pressed ask for. None while text is
    /// being typed.
    pub fn pressed(&mut self, ctx: &Context, camera: &CameraDesc) -> Option<Wish> {
        if ctx.text_edit_focused() {
            return None;
        }
        let pressed = |modifiers| {
            let is = |key: &Key| ctx.input_mut(|i| i.consume_key(modifiers, *key));
            DIGITS.iter().position(is)
        };
        if let Some(digit) = pressed(Modifiers::COMMAND) {
            self.set(digit + 1, camera);
            return Some(Wish::Set(digit + 1));
        }
        let digit = pressed(Modifiers::NONE)?;
        let wish = self.0[digit].map_or(Wish::Missing(digit + 1), Wish::Go);
        Some(wish)
    }
}

/// A camera in a scene file, as [`text`] writes it.
#[derive(Serialize, Deserialize)]
struct Scene {
    camera: CameraDesc,
}

/// The camera as a scene file has it.
pub fn text(camera: &CameraDesc) -> String {
    // Numbers can always be written.
    toml::to_string(&Scene { camera: *camera }).unwrap_or_default()
}

/// The camera in a pasted text, if anything was pasted and no text is being typed; the error is one
/// line.
pub fn pasted(ctx: &Context) -> Option<Result<CameraDesc, String>> {
    if ctx.text_edit_focused() {
        return None;
    }
    ctx.input(|i| {
        i.events.iter().rev().find_map(|event| match event {
            Event::Paste(text) => Some(read(text)),
            _ => None,
        })
    })
}

fn read(text: &str) -> Result<CameraDesc, String> {
    let cannot = |why: &str| {
        format!("the clipboard holds no camera ({why}); paste the [camera] of a scene file")
    };
    let camera = match toml::from_str::<Scene>(text) {
        Ok(Scene { camera }) => camera,
        Err(e) => return Err(cannot(e.message().lines().next().unwrap_or_default())),
    };
    Camera::new(&camera, 1, 1).map_err(|e| cannot(&e))?;
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_comes_back_from_its_text() {
        let mut camera = CameraDesc::default();
        camera.eye.x = 0.1 + 0.2;
        camera.fov = 33.3;
        assert!(text(&camera).starts_with("[camera]\n"), "{}", text(&camera));
        assert_eq!(read(&text(&camera)), Ok(camera));
        // A whole scene has one too.
        let scene = format!(
            "background = [1, 1, 1]\n{}[render]\nwidth = 3\n",
            text(&camera)
        );
        assert_eq!(read(&scene), Ok(camera));
        for bad in ["", "hello", "[camera]\neye = 3\n", "[camera]\nfov = 400\n"] {
            let error = read(bad).unwrap_err();
            assert!(error.contains("paste the [camera]"), "{error}");
            assert_eq!(error.lines().count(), 1);
        }
    }
}
