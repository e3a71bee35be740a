//! Rectangular lights, sampled uniformly in solid angle (Ureña, Fajardo & King 2013).

use glam::{DVec3, Vec3};

use super::area_pdf;
use crate::geometry::SurfacePoint;
use crate::math::trig;
use crate::shape::Quad;

/// Solid angle, sr, below which rectangles are sampled by area.
const SMALL: f32 = 0.01;

/// A rectangle prepared for being seen from many points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangle {
    quad: Quad,
    /// First corner.
    corner: DVec3,
    /// Unit vectors along the first and the last edge, and of the front. In f64, as the height of a
    /// point over a large rectangle is a small difference, and decides whether it is behind.
    axes: [DVec3; 2],
    n: DVec3,
    /// Lengths of these edges.
    size: [f64; 2],
    /// From the first corner to the centre.
    to_center: DVec3,
    /// Width + height: the distance from which on it may count as small.
    extent: f32,
    area: f32,
}

/// A rectangle seen from a point. The inner angles are kept as complex numbers
/// e^{iγ} up to a positive factor: their product has the argument that the sum of the angles
/// would have, without arc cosines. In f64, because close to the rectangle all cosines crowd
/// at 1.
struct View {
    /// Whether it is better sampled by area.
    is_small: bool,
    /// Left and right bound in the rectangle's frame, from the foot of the point.
    x: [f64; 2],
    /// Lower and upper bound.
    y: [f64; 2],
    /// Distance of the point from the plane; not positive behind it, where nothing else holds.
    z: f64,
    solid_angle: f64,
    /// A positive multiple of e^{i(γ₂+γ₃)}.
    corner: [f64; 2],
}

impl Rectangle {
    /// `None` if the quad is not a rectangle.
    pub fn new(quad: Quad) -> Option<Self> {
        let [a, b, c, d] = quad.corners();
        let (ex, ey) = (b - a, d - a);
        let (width, height) = (ex.length(), ey.length());
        let is_right = ex.dot(ey).abs() <= 1e-5 * width * height;
        is_right.then(|| {
            let [a, b, c, d] = [a, b, c, d].map(|p| p.as_dvec3());
            let (ex, ey) = (b - a, d - a);
            Self {
                quad,
                corner: a,
                axes: [ex, ey].map(|e| e.normalize()),
                // That of the whole: rounding of the corners tilts the halves of thin ones.
                n: (c - a).cross(d - b).normalize(),
                size: [width, height].map(f64::from),
                to_center: 0.5 * (ex + ey),
                extent: width + height,
                area: width * height,
            }
        })
    }

    /// The rectangle itself.
    pub fn quad(&self) -> &Quad {
        &self.quad
    }

    /// A point that may shine on `p`, drawn uniformly in solid angle or by area, and the density
    /// of its direction; 0 where the rectangle does not face `p`.
    #[inline(always)]
    pub fn sample(&self, p: Vec3, u: [f32; 2]) -> (SurfacePoint, f32) {
        let view = self.seen_from(p);
        let [s, t] = if view.is_small { u } else { view.sample(u) };
        let point = SurfacePoint::of_quad(&self.quad, s, t);
        (point, self.pdf_in(&view, p, point.p))
    }

    /// Density with which [`Self::sample`] draws the direction from `p` to `q`.
    pub fn pdf(&self, p: Vec3, q: Vec3) -> f32 {
        self.pdf_in(&self.seen_from(p), p, q)
    }

    #[inline(always)]
    fn pdf_in(&self, view: &View, p: Vec3, q: Vec3) -> f32 {
        let by_area = area_pdf(p, q, self.quad.normal(), self.area);
        let pdf = if view.is_small {
            by_area
        } else {
            (1.0 / view.solid_angle) as f32
        };
        if view.z > 0.0 { pdf } else { 0.0 }
    }

    #[inline(always)]
    fn seen_from(&self, p: Vec3) -> View {
        let to_a = self.corner - p.as_dvec3();
        let z = -to_a.dot(self.n);
        let distance = (to_a + self.to_center).as_vec3().length();
        // From further than its size, the solid angle is close to area·cos/distance².
        let is_small = (distance > self.extent)
            & (self.area * z as f32 <= SMALL * distance * distance * distance);
        let [x0, y0] = self.axes.map(|axis| to_a.dot(axis));
        let [width, height] = self.size;
        let (x, y) = ([x0, x0 + width], [y0, y0 + height]);
        // For each corner, e^{iγ} ∝ ∓xy + i·z·|corner|. Coordinates below 2⁶⁰ leave the product
        // of the four, of the eighth power of a length, within the range of f64.
        let (x2, y2) = (x.map(|x| x * x + z * z), y.map(|y| y * y));
        let angle =
            |i: usize, j: usize, sign: f64| [sign * x[i] * y[j], z * (x2[i] + y2[j]).sqrt()];
        let corner = times(angle(0, 1, 1.0), angle(0, 0, -1.0));
        let [re, im] = times(times(angle(1, 0, 1.0), angle(1, 1, -1.0)), corner);
        // The sum of the angles is 2π more than the solid angle, which is within (0, 2π).
        let angle = trig::atan2(im, re);
        let solid_angle = if angle < 0.0 {
            angle + std::f64::consts::TAU
        } else {
            angle
        };
        View {
            is_small,
            x,
            y,
            z,
            solid_angle,
            corner,
        }
    }
}

impl View {
    /// Maps the unit square to coordinates (u, v) in [0, 1]² of the rectangle, uniformly in solid
    /// angle.
    #[inline(always)]
    fn sample(&self, u: [f32; 2]) -> [f32; 2] {
        let ([x0, x1], [y0, y1], z) = (self.x, self.y, self.z);
        let [sin, cos] = trig::sin_cos(f64::from(u[0]) * self.solid_angle);
        // The angle uΩ − (γ₂ + γ₃).
        let [re, im] = self.corner;
        let length = (re * re + im * im).sqrt();
        let [sin, cos] = [sin * re - cos * im, cos * re + sin * im];
        let b0 = y0 / (z * z + y0 * y0).sqrt();
        let b1 = y1 / (z * z + y1 * y1).sqrt();
        let fu = -(cos * b0 + length * b1) / sin;
        // cu/√(1−cu²) with cu = ±1/√(fu² + b0²).
        let tangent = (fu * fu + b0 * b0 - 1.0).max(0.0).sqrt();
        // NaN becomes `x0`.
        let xu = (z.copysign(fu) / tangent).max(x0).min(x1);
        let d2 = xu * xu + z * z;
        let (h0, h1) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
        let hv = h0 + f64::from(u[1]) * (h1 - h0);
        let rest = 1.0 - hv * hv;
        let yv = if rest > 0.0 {
            (hv * (d2 / rest).sqrt()).max(y0).min(y1)
        } else {
            y1
        };
        [(xu - x0) / (x1 - x0), (yv - y0) / (y1 - y0)].map(|x| (x as f32).clamp(0.0, 1.0))
    }
}

/// Product of two complex numbers.
#[inline(always)]
fn times([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}
