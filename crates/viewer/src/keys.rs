//! What keys and buttons do: one table for the keyboard and for the window that lists it.

use std::path::PathBuf;

use egui::{Context, Event, InputState, Key, KeyboardShortcut, Modifiers};

use crate::aov::Aov;
use crate::compare::Mode;
use crate::unsaved::Answer;

/// Something the user asks for, by key or by button.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Choose a file and open it.
    Open,
    /// Open this file or built-in scene.
    OpenPath(PathBuf),
    /// Keep the present file after all.
    CancelOpening,
    /// What becomes of edits before another file is opened.
    Leave(Answer),
    /// Read the present file again.
    Reload,
    /// Save the picture as shown.
    SavePng,
    /// Save linear light.
    SaveExr,
    /// Rest, or go on.
    Pause,
    /// Rest after one more pass.
    Pass,
    /// See all of the selected object, or of the scene.
    Frame,
    /// The camera of the file.
    Home,
    /// The camera where it was before its last move.
    CameraBack,
    /// The camera where it was before that was taken back.
    CameraOn,
    /// The view from this direction.
    ViewFrom([i8; 3]),
    /// Begin or end to fly.
    Fly,
    /// Orbits over the poles, or not.
    FreeOrbit,
    /// The camera as text to the clipboard.
    CopyCamera,
    /// The picture as shown to the clipboard.
    CopyPicture,
    /// Half a stop brighter.
    Brighter,
    /// Half a stop darker.
    Darker,
    /// A tenth of white more.
    Raise,
    /// A tenth of white less.
    Lower,
    /// Exposure and offset that fit the picture.
    FitTone,
    /// Light as it is.
    ResetTone,
    /// A copy of the selected object.
    Duplicate,
    /// The scene without the selected object.
    Delete,
    /// Choose a mesh file and add it.
    AddMesh,
    /// Show or hide the list of keys.
    Help,
    /// Show or hide the stability lab.
    Lab,
    /// Show or hide the error chart.
    Chart,
    /// Show or hide the race.
    Race,
    /// Choose a folder for the files of a race.
    SaveRace,
    /// Show or hide the plan.
    Plan,
    /// Choose a reference for the error chart.
    Reference,
    /// Have pixels show this.
    Show(Aov),
    /// Show where samples were no numbers, and go to the first.
    Invalid,
    /// Look into the samples of the pixel under the pointer.
    Autopsy,
    /// Keep the picture, and compare with it.
    Keep,
    /// Show or hide the strip of kept pictures.
    Strip,
    /// Compare in this way, or no longer.
    Compare(Mode),
    /// Look at the kept picture while the key is held.
    Glance,
    /// Look closer at the pixels, or less so, by halves.
    Zoom(bool),
    /// See all of the picture.
    ZoomAll,
    /// Take back the last edit.
    Undo,
    /// Do again what was taken back.
    Redo,
    /// Save the scene with every edit.
    SaveScene,
    /// Keep the samples in a file.
    SaveSamples,
    /// Close a window over the picture, or select nothing.
    Escape,
    /// Close the window.
    Quit,
}

const PLAIN: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const COMMAND: Modifiers = Modifiers::COMMAND;
const ALT: Modifiers = Modifiers::ALT;

/// Keys that fly while one flies, and mean what else they do otherwise.
pub const FLIGHT: [Key; 6] = [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E];

/// Keys, actions and their description. Where modifiers overlap, the longer one comes first: a
/// shortcut without Shift also matches with it.
const KEYS: &[(Modifiers, Key, Action, &str)] = &[
    (
        COMMAND,
        Key::O,
        Action::Open,
        "open a scene, a mesh or a saved picture",
    ),
    (COMMAND, Key::R, Action::Reload, "read the file again"),
    (
        COMMAND.plus(SHIFT),
        Key::S,
        Action::SaveExr,
        "save linear light (EXR)",
    ),
    (
        COMMAND,
        Key::S,
        Action::SavePng,
        "save the picture as shown (PNG)",
    ),
    (
        COMMAND.plus(SHIFT),
        Key::T,
        Action::SaveScene,
        "save the scene with every edit (TOML)",
    ),
    (
        COMMAND.plus(SHIFT),
        Key::P,
        Action::SaveSamples,
        "keep the samples in a file that the render can go on from (.part)",
    ),
    (
        PLAIN,
        Key::Space,
        Action::Pause,
        "pause or go on; samples are kept",
    ),
    (
        PLAIN,
        Key::Period,
        Action::Pass,
        "render one more pass, and pause",
    ),
    (
        SHIFT,
        Key::F,
        Action::Fly,
        "fly without holding the right button, or end it",
    ),
    (
        PLAIN,
        Key::F,
        Action::Frame,
        "frame the selected object, or the scene",
    ),
    (PLAIN, Key::Home, Action::Home, "back to the file's camera"),
    (
        COMMAND.plus(SHIFT),
        Key::Z,
        Action::Redo,
        "do again what was undone",
    ),
    (COMMAND, Key::Z, Action::Undo, "undo the last edit"),
    (COMMAND, Key::Y, Action::Redo, ""),
    (
        ALT,
        Key::ArrowLeft,
        Action::CameraBack,
        "the camera's last place",
    ),
    (
        ALT,
        Key::ArrowRight,
        Action::CameraOn,
        "the camera's next place",
    ),
    (
        SHIFT,
        Key::X,
        Action::ViewFrom([-1, 0, 0]),
        "view from the left (-x)",
    ),
    (
        PLAIN,
        Key::X,
        Action::ViewFrom([1, 0, 0]),
        "view from the right (+x)",
    ),
    (
        SHIFT,
        Key::Y,
        Action::ViewFrom([0, -1, 0]),
        "view from below (-y)",
    ),
    (
        PLAIN,
        Key::Y,
        Action::ViewFrom([0, 1, 0]),
        "view from above (+y)",
    ),
    (
        SHIFT,
        Key::Z,
        Action::ViewFrom([0, 0, -1]),
        "view from behind (-z)",
    ),
    (
        PLAIN,
        Key::Z,
        Action::ViewFrom([0, 0, 1]),
        "view from the front (+z)",
    ),
    (
        PLAIN,
        Key::T,
        Action::FreeOrbit,
        "orbit freely, over the poles, or with the horizon level",
    ),
    (
        COMMAND.plus(SHIFT),
        Key::C,
        Action::CopyCamera,
        "copy the camera as text, as a scene file has it",
    ),
    (
        COMMAND,
        Key::C,
        Action::CopyPicture,
        "copy the picture as shown",
    ),
    (SHIFT, Key::E, Action::Darker, "half a stop darker"),
    (PLAIN, Key::E, Action::Brighter, "half a stop brighter"),
    (SHIFT, Key::O, Action::Lower, "take away a tenth of white"),
    (PLAIN, Key::O, Action::Raise, "add a tenth of white"),
    (
        PLAIN,
        Key::N,
        Action::FitTone,
        "fit exposure and offset to the picture",
    ),
    (
        PLAIN,
        Key::R,
        Action::ResetTone,
        "exposure and offset back to zero",
    ),
    (
        SHIFT,
        Key::K,
        Action::Strip,
        "show or hide the strip of kept pictures",
    ),
    (
        PLAIN,
        Key::K,
        Action::Keep,
        "keep the picture in a strip, and compare with it",
    ),
    (
        SHIFT,
        Key::B,
        Action::Compare(Mode::Beside),
        "show the kept picture and the present one side by side",
    ),
    (
        PLAIN,
        Key::B,
        Action::Compare(Mode::Wipe),
        "wipe between the kept picture and the present one",
    ),
    (
        PLAIN,
        Key::V,
        Action::Glance,
        "see the kept picture in place of the present one while held",
    ),
    (
        PLAIN,
        Key::Plus,
        Action::Zoom(true),
        "look closer at the pixels under the pointer",
    ),
    (PLAIN, Key::Equals, Action::Zoom(true), ""),
    (
        PLAIN,
        Key::Minus,
        Action::Zoom(false),
        "look less closely at the pixels",
    ),
    (
        PLAIN,
        Key::Num0,
        Action::ZoomAll,
        "see all of the picture again",
    ),
    (
        PLAIN,
        Key::P,
        Action::Autopsy,
        "look into the samples of the pixel under the pointer",
    ),
    (
        PLAIN,
        Key::Escape,
        Action::Escape,
        "close the topmost window, or select nothing",
    ),
    (
        COMMAND,
        Key::D,
        Action::Duplicate,
        "duplicate the selected object",
    ),
    (
        PLAIN,
        Key::Delete,
        Action::Delete,
        "delete the selected object",
    ),
    (PLAIN, Key::F1, Action::Help, "show or hide this list"),
    (PLAIN, Key::Questionmark, Action::Help, ""),
    (
        PLAIN,
        Key::F2,
        Action::Lab,
        "show or hide the stability lab",
    ),
    (
        PLAIN,
        Key::F3,
        Action::Chart,
        "show or hide the error chart",
    ),
    (
        PLAIN,
        Key::F4,
        Action::Race,
        "race methods against each other",
    ),
    (
        PLAIN,
        Key::F5,
        Action::Plan,
        "show or hide the plan and where the time goes",
    ),
    (COMMAND, Key::Q, Action::Quit, "quit"),
];

/// `KEYS` and the keys of what pixels can show.
pub fn all() -> impl Iterator<Item = (Modifiers, Key, Action, &'static str)> {
    let aovs = |shift: bool| {
        let rows = Aov::all().filter(move |aov| aov.keys().0.shift == shift);
        rows.map(|aov| (aov.keys().0, aov.keys().1, Action::Show(aov), aov.tip()))
    };
    KEYS.iter().cloned().chain(aovs(true)).chain(aovs(false))
}

/// Gestures over the picture, keys that go with them, and their description.
pub const GESTURES: &[(&str, &str)] = &[
    ("left drag, or Alt+left drag", "orbit"),
    (
        "right or middle drag",
        "pan: the camera, or closer than all of the picture its pixels",
    ),
    ("wheel or pinch", "move towards the point under the cursor"),
    (
        "click",
        "select an object; drag its knobs to move, turn or scale it",
    ),
    (
        "Ctrl+click",
        "look into the samples of a pixel: paths, noise, one step by step",
    ),
    ("double-click", "orbit around this point"),
    (
        "right button with W A S D, Q E",
        "look around and fly; Shift fast, Alt slow",
    ),
    (
        "Shift+left drag",
        "render a region first; Shift+click: all alike again",
    ),
    (
        "double-click a slider",
        "back to what the file says, or to what is usual",
    ),
    ("1 to 9", "go to a bookmark of the camera"),
    ("Ctrl+1 to Ctrl+9", "set a bookmark"),
    ("Ctrl+V", "paste a camera"),
    ("drop a file", "open it"),
];

/// The actions whose keys were pressed; those of [`FLIGHT`] have none while one `flies`. None while
/// text is being typed.
pub fn pressed(ctx: &Context, flies: bool) -> Vec<Action> {
    if ctx.text_edit_focused() {
        return Vec::new();
    }
    // A focused button takes Space for a click, an open list takes Escape.
    let (focused, listing) = (
        ctx.egui_wants_keyboard_input(),
        egui::Popup::is_any_open(ctx),
    );
    let mut actions = Vec::new();
    for (modifiers, key, action, _) in all() {
        let taken = (key == Key::Space && focused)
            || (key == Key::Escape && listing)
            || (flies && FLIGHT.contains(&key) && !modifiers.command);
        if !taken && ctx.input_mut(|i| i.consume_key(modifiers, key)) {
            actions.push(action);
        }
    }
    // What window systems tell in place of the key.
    if ctx.input(|i| i.events.contains(&Event::Copy)) {
        actions.push(Action::CopyPicture);
    }
    actions
}

/// Whether the key of [`Action::Glance`] is held.
pub fn is_glancing(ctx: &Context) -> bool {
    let is_held = |i: &InputState| {
        let mut keys = KEYS
            .iter()
            .filter(|(.., action, _)| *action == Action::Glance);
        keys.any(|(modifiers, key, ..)| i.key_down(*key) && i.modifiers == *modifiers)
    };
    !ctx.text_edit_focused() && ctx.input(is_held)
}

/// The key of an action, as shown on buttons.
pub fn text(ctx: &Context, action: &Action) -> String {
    let key = all().find(|(_, _, a, _)| a == action);
    key.map_or_else(String::new, |(modifiers, key, _, _)| {
        ctx.format_shortcut(&KeyboardShortcut::new(modifiers, key))
    })
}
