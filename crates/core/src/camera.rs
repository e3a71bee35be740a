//! The pinhole camera.

use glam::Vec3;

use crate::math::Ray;
use crate::scene::CameraDesc;

/// A camera ready to make rays for pictures of one size.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    eye: Vec3,
    /// Half of the picture across and down, pixels.
    middle: [f32; 2],
    /// One pixel to the right.
    right: Vec3,
    /// One pixel down.
    down: Vec3,
    forward: Vec3,
}

impl Camera {
    /// Sets up a camera; the error is one line that says what to change.
    pub fn new(desc: &CameraDesc, width: u32, height: u32) -> Result<Self, String> {
        let CameraDesc {
            eye,
            target,
            up,
            fov,
        } = *desc;
        if !(eye.is_finite() && target.is_finite() && up.is_finite()) {
            return Err("camera: eye, target and up must be finite numbers".into());
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(format!(
                "camera: fov is {fov}; use more than 0 and less than 180 degrees"
            ));
        }
        // In f64: eye and target may be close together and far from the origin.
        let axis = (target.as_dvec3() - eye.as_dvec3()).normalize_or_zero();
        if axis == glam::DVec3::ZERO {
            return Err("camera: eye and target are the same point; move one".into());
        }
        let up = up.as_dvec3().normalize_or_zero();
        if up == glam::DVec3::ZERO {
            return Err("camera: up is the zero vector; use for example [0, 1, 0]".into());
        }
        // Looking straight up or down: any other axis serves as up.
        let side = axis.cross(up);
        let side = if side.length() < 1e-6 {
            axis.cross(up.any_orthonormal_vector())
        } else {
            side
        };
        let right = side.normalize();
        let up = right.cross(axis);
        let pixel = 2.0 * libm::tan(f64::from(fov).to_radians() * 0.5) / f64::from(height);
        let (right, down) = (right * pixel, -up * pixel);
        Ok(Self {
            eye,
            middle: [0.5 * width as f32, 0.5 * height as f32],
            right: right.as_vec3(),
            down: down.as_vec3(),
            forward: axis.as_vec3(),
        })
    }

    /// The ray through the point `offset` pixels from the centre of pixel (x, y); (0, 0) is at
    /// the upper left.
    pub fn ray(&self, [x, y]: [u32; 2], offset: [f32; 2]) -> Ray {
        // From the middle outwards: from a corner, most of the digits of a wide view cancel.
        let x = (x as f32 + 0.5 - self.middle[0]) + offset[0];
        let y = (y as f32 + 0.5 - self.middle[1]) + offset[1];
        Ray::new(
            self.eye,
            (self.forward + x * self.right + y * self.down).normalize(),
        )
    }

    /// Width and height of the picture, pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.middle.map(|half| (2.0 * half) as u32)
    }

    /// Where a point is seen: its place in the picture, in pixels from the upper left, and how
    /// many pixels a surface there takes up per unit of area when it faces the camera. `None`
    /// behind the camera and beyond the border of the picture and a `margin` of pixels.
    #[inline]
    pub(crate) fn place(&self, p: Vec3, margin: f32) -> Option<([f32; 2], f32)> {
        let way = p - self.eye;
        let depth = way.dot(self.forward);
        // Both axes are as long as a pixel at distance 1.
        let pixel2 = self.right.length_squared();
        let scale = 1.0 / (depth * pixel2);
        let x = way.dot(self.right) * scale + self.middle[0];
        let y = way.dot(self.down) * scale + self.middle[1];
        let is_seen = |x: f32, middle: f32| x >= -margin && x <= 2.0 * middle + margin;
        if !(depth > 0.0 && is_seen(x, self.middle[0]) && is_seen(y, self.middle[1])) {
            return None;
        }
        let distance = way.length();
        Some(([x, y], distance / (pixel2 * depth * depth * depth)))
    }

    /// Unit vector along the optical axis.
    pub fn forward(&self) -> Vec3 {
        self.forward
    }

    /// All that decides its rays.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f32> {
        let Self {
            eye,
            middle,
            right,
            down,
            forward,
        } = *self;
        let vectors = [eye, right, down, forward].into_iter();
        vectors.flat_map(|v| v.to_array()).chain(middle)
    }

    /// The pinhole.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }
}
