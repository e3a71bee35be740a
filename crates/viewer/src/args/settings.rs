//! Settings, camera and tone as the command line wants them instead of the scene.

use glam::Vec3;
use lightbox_core::color::{ToneCurve, ToneMap};
use lightbox_core::{AccelKind, Camera, Filter, Method, SamplerKind, SceneDesc};

use super::SETTINGS;
use super::values::{depth, field_of_view, finite, named, point, seed, size};

// Headings of the help.
const CAMERA: &str = "Camera (default: the scene's)";
const PNG: &str = "PNG";

/// What to render otherwise than the scene wants.
#[derive(Debug, clap::Args)]
pub struct SettingsArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true, help_heading = SETTINGS)]
    pub size: Option<[u32; 2]>,
    /// Most segments of a path, or "unlimited"; 1 sees emitters only, 2 adds direct light
    #[arg(long, value_name = "D", value_parser = depth, allow_hyphen_values = true, help_heading = SETTINGS)]
    pub depth: Option<u32>,
    /// Pixel filter: box, tent, gaussian, mitchell, blackman-harris or lanczos, and its radius in pixels
    #[arg(long, value_name = "F[:RADIUS]", help_heading = SETTINGS)]
    pub filter: Option<Filter>,
    /// How light is found
    #[arg(long, value_name = "M", value_parser = named(Method::ALL, Method::name), help_heading = SETTINGS)]
    pub method: Option<Method>,
    /// How rays find surfaces
    #[arg(long, value_name = "A", value_parser = named(AccelKind::ALL, AccelKind::name), help_heading = SETTINGS)]
    pub accel: Option<AccelKind>,
    /// Where the random numbers come from
    #[arg(long, value_name = "S", value_parser = named(SamplerKind::ALL, SamplerKind::name), help_heading = SETTINGS)]
    pub sampler: Option<SamplerKind>,
    /// Chooses the random numbers
    #[arg(long, value_name = "K", value_parser = seed, allow_negative_numbers = true, help_heading = SETTINGS)]
    pub seed: Option<u64>,
    /// Leave out nothing, not even what the scene does not need: the same picture, later
    #[arg(long, help_heading = SETTINGS)]
    pub full_model: bool,

    /// Pinhole
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub eye: Option<Vec3>,
    /// Point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub target: Option<Vec3>,
    /// Direction that is up in the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true, help_heading = CAMERA)]
    pub up: Option<Vec3>,
    /// Vertical field of view, degrees
    #[arg(long, value_name = "DEGREES", value_parser = field_of_view, help_heading = CAMERA)]
    pub fov: Option<f32>,

    /// Brightness of a PNG in photographic stops [default: 0, or a saved picture's]
    #[arg(long, value_name = "E", value_parser = finite, allow_negative_numbers = true, help_heading = PNG)]
    pub exposure: Option<f32>,
    /// Light added to a PNG after that [default: 0, or a saved picture's]
    #[arg(long, value_name = "O", value_parser = finite, allow_negative_numbers = true, help_heading = PNG)]
    pub offset: Option<f32>,
    /// Tone curve of a PNG [default: linear, or a saved picture's]
    #[arg(long, value_name = "T", value_parser = named(&ToneCurve::ALL, ToneCurve::name), help_heading = PNG)]
    pub tone: Option<ToneCurve>,
}

impl SettingsArgs {
    /// Puts what was asked for in place of what the scene wants; the error is one line.
    pub fn apply(&self, spp: Option<u64>, desc: &mut SceneDesc) -> Result<(), String> {
        let (render, camera) = (&mut desc.render, &mut desc.camera);
        let scene_render = *render;
        [render.width, render.height] = self.size.unwrap_or([render.width, render.height]);
        render.samples = spp.unwrap_or(render.samples);
        render.depth = self.depth.unwrap_or(render.depth);
        render.filter = self.filter.unwrap_or(render.filter);
        render.method = self.method.unwrap_or(render.method);
        render.accel = self.accel.unwrap_or(render.accel);
        render.sampler = self.sampler.unwrap_or(render.sampler);
        render.seed = self.seed.unwrap_or(render.seed);
        render.full_model |= self.full_model;
        let scene_camera = *camera;
        camera.eye = self.eye.unwrap_or(camera.eye);
        camera.target = self.target.unwrap_or(camera.target);
        camera.up = self.up.unwrap_or(camera.up);
        camera.fov = self.fov.unwrap_or(camera.fov);
        // Here, because later the scene file would get the blame.
        if *render != scene_render
            && let Some(problem) = render.problem()
        {
            return Err(problem);
        }
        if *camera != scene_camera {
            Camera::new(camera, render.width, render.height)?;
        }
        Ok(())
    }

    /// Puts what was asked for in place of how the scene wants to be shown.
    pub fn tone_map(&self, scene: ToneMap) -> ToneMap {
        ToneMap {
            exposure: self.exposure.unwrap_or(scene.exposure),
            offset: self.offset.unwrap_or(scene.offset),
            curve: self.tone.unwrap_or(scene.curve),
        }
    }
}
