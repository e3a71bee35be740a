//! Solids as implicit functions: negative inside, zero on the surface, about the distance to it
//! nearby. Rounded parts are joined one after another with blends of a given width.

use glam::{DMat3, DVec3};

/// Half the distance over which curvature is measured, for a bear about 1 tall: near the length
/// of a triangle's edge, so that bends too tight for a triangle to follow are not chased.
const CURVATURE_STEP: f64 = 0.01;

/// An implicit function at a point.
#[derive(Clone, Copy)]
pub struct Sample {
    pub value: f64,
    /// The gradient: outward, and of length near 1 at the surface.
    pub gradient: DVec3,
}

/// A building block.
pub enum Part {
    /// An ellipsoid about `center`; `axes` holds the unit vectors of its half-axes in columns.
    Ellipsoid {
        center: DVec3,
        axes: DMat3,
        radii: DVec3,
    },
    /// A capsule from one ball (centre, radius) to another, tapered between them.
    Limb { ends: [DVec3; 2], radii: [f64; 2] },
}

impl Part {
    /// An ellipsoid whose half-axes lie along x, y and z.
    pub fn ellipsoid(center: [f64; 3], radii: [f64; 3]) -> Self {
        Self::facing(center, radii, [0.0, 0.0, 1.0])
    }

    /// An ellipsoid whose third half-axis looks along `facing` and whose second points as far
    /// upwards as that allows.
    pub fn facing(center: [f64; 3], radii: [f64; 3], facing: [f64; 3]) -> Self {
        let z = DVec3::from(facing).normalize();
        let x = DVec3::Y.cross(z).normalize();
        Self::Ellipsoid {
            center: center.into(),
            axes: DMat3::from_cols(x, z.cross(x), z),
            radii: radii.into(),
        }
    }

    /// A tapered capsule between two balls.
    pub fn limb(from: [f64; 3], from_radius: f64, to: [f64; 3], to_radius: f64) -> Self {
        Self::Limb {
            ends: [from.into(), to.into()],
            radii: [from_radius, to_radius],
        }
    }

    fn sample(&self, p: DVec3) -> Sample {
        match self {
            Self::Ellipsoid {
                center,
                axes,
                radii,
            } => {
                // With q = |local/radii|, the function q − 1 is divided by the length of its
                // gradient, s/q with s = |local/radii²|: a distance to first order (Quilez 2008).
                let local = axes.transpose() * (p - *center);
                let (by_q, by_s) = (local / *radii, local / *radii / *radii);
                let (q, s) = (by_q.length(), by_s.length());
                if s == 0.0 {
                    return Sample {
                        value: -radii.min_element(),
                        gradient: DVec3::ZERO,
                    };
                }
                let value = q * (q - 1.0) / s;
                let (q_slope, s_slope) = (by_s / q, by_s / *radii / *radii / s);
                Sample {
                    value,
                    gradient: *axes * (((2.0 * q - 1.0) * q_slope - value * s_slope) / s),
                }
            }
            Self::Limb {
                ends: [a, b],
                radii: [from, to],
            } => {
                let axis = *b - *a;
                let t = (p - *a).dot(axis) / axis.length_squared();
                let (t, taper) = if (0.0..=1.0).contains(&t) {
                    (t, axis * ((to - from) / axis.length_squared()))
                } else {
                    (t.clamp(0.0, 1.0), DVec3::ZERO)
                };
                let offset = p - a.lerp(*b, t);
                Sample {
                    value: offset.length() - (from + (to - from) * t),
                    gradient: offset.normalize_or_zero() - taper,
                }
            }
        }
    }
}

/// What a part does to the solid built before it.
enum Action {
    Join,
    Carve,
}

/// A solid: parts joined or carved in order, each with the width of its blend.
#[derive(Default)]
pub struct Solid {
    steps: Vec<(Action, Part, f64)>,
}

impl Solid {
    /// Adds a part, filling the crease where it meets the rest over the width `blend`.
    pub fn join(&mut self, part: Part, blend: f64) {
        self.steps.push((Action::Join, part, blend));
    }

    /// Takes a part away, rounding the rim that this leaves over the width `blend`.
    pub fn carve(&mut self, part: Part, blend: f64) {
        self.steps.push((Action::Carve, part, blend));
    }

    /// The implicit function at `p`; its gradient points outward.
    pub fn sample(&self, p: DVec3) -> Sample {
        let nothing = Sample {
            value: f64::MAX,
            gradient: DVec3::ZERO,
        };
        self.steps
            .iter()
            .fold(nothing, |solid, (action, part, blend)| {
                let part = part.sample(p);
                match action {
                    Action::Join => smooth_min(solid, part, *blend),
                    Action::Carve => negated(smooth_min(negated(solid), part, *blend)),
                }
            })
    }

    /// The unit outward normal at a point near the surface.
    pub fn normal(&self, p: DVec3) -> DVec3 {
        self.sample(p).gradient.normalize()
    }

    /// Moves a point near the surface onto it, by Newton steps along the gradient.
    pub fn project(&self, mut p: DVec3) -> DVec3 {
        for _ in 0..4 {
            let Sample { value, gradient } = self.sample(p);
            p -= gradient * (value / gradient.length_squared());
        }
        p
    }

    /// √(κ₁² + κ₂²) of the principal curvatures at a surface point, 1/length.
    pub fn curvature(&self, p: DVec3) -> f64 {
        let (s, t) = self.normal(p).any_orthonormal_pair();
        let bend = |along: DVec3| {
            let step = along * CURVATURE_STEP;
            (self.normal(p + step) - self.normal(p - step)) / (2.0 * CURVATURE_STEP)
        };
        (bend(s).length_squared() + bend(t).length_squared()).sqrt()
    }
}

fn negated(sample: Sample) -> Sample {
    Sample {
        value: -sample.value,
        gradient: -sample.gradient,
    }
}

/// The smaller of two functions, rounded off where they differ by less than `width` (the quadratic
/// polynomial blend of Quilez 2013).
fn smooth_min(a: Sample, b: Sample, width: f64) -> Sample {
    let (low, high) = if a.value < b.value { (a, b) } else { (b, a) };
    let overlap = (width - (high.value - low.value)).max(0.0);
    let share = overlap / (2.0 * width);
    Sample {
        value: low.value - 0.5 * overlap * share,
        gradient: low.gradient.lerp(high.gradient, share),
    }
}
