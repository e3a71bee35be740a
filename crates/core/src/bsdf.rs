//! How surfaces scatter light: perfect diffuse, perfect mirror, a blend of the two, or glass.

use glam::Vec3;

use crate::math::{Frame, warp};

/// Scattering at one point. Two-sided except for glass, whose inside is the back.
#[derive(Clone, Copy, Debug)]
pub enum Bsdf {
    /// Lambertian with this reflectance.
    Diffuse(Vec3),
    /// Perfect mirror with this reflectance.
    Mirror(Vec3),
    /// Both at once; each reflectance already carries its share of the blend.
    Blend {
        /// Diffuse reflectance.
        diffuse: Vec3,
        /// Mirror reflectance.
        mirror: Vec3,
    },
    /// Clear glass of this index of refraction, in air.
    Glass(f32),
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample {
    /// Unit direction in which the path goes on.
    pub wi: Vec3,
    /// f·|cos θ|/pdf, per channel.
    pub weight: Vec3,
    /// Density of `wi` per solid angle; meaningless if `specular`.
    pub pdf: f32,
    /// Whether the direction was the only one possible (a delta lobe).
    pub specular: bool,
}

impl Bsdf {
    /// Diffuse reflectance: what light sampling can use. Zero for mirror and glass.
    pub(crate) fn diffuse(&self) -> Vec3 {
        match *self {
            Self::Diffuse(diffuse) | Self::Blend { diffuse, .. } => diffuse,
            Self::Mirror(_) | Self::Glass(_) => Vec3::ZERO,
        }
    }

    /// Reflectance of the mirror; zero for glass.
    pub(crate) fn mirror(&self) -> Vec3 {
        match *self {
            Self::Mirror(mirror) | Self::Blend { mirror, .. } => mirror,
            Self::Diffuse(_) | Self::Glass(_) => Vec3::ZERO,
        }
    }

    /// Probability that [`Bsdf::sample`] takes the diffuse lobe.
    pub(crate) fn diffuse_share(&self) -> f32 {
        match self {
            Self::Diffuse(_) => 1.0,
            Self::Blend { diffuse, mirror } => {
                let (d, m) = (diffuse.element_sum(), mirror.element_sum());
                d / (d + m)
            }
            Self::Mirror(_) | Self::Glass(_) => 0.0,
        }
    }

    /// Density per solid angle with which [`Bsdf::sample`] gives a direction at `cos` > 0 from
    /// the normal by its diffuse lobe.
    pub fn pdf(&self, cos: f32) -> f32 {
        self.diffuse_share() * cos * std::f32::consts::FRAC_1_PI
    }

    /// Draws a direction. `n` is the unit normal on the side of `wo`, `front` tells whether that
    /// is the front, `wo` points away from the surface. `lobe` and `u` give numbers in [0, 1);
    /// what is not needed is not drawn. `None` where nothing is scattered.
    #[inline]
    pub fn sample(
        &self,
        wo: Vec3,
        n: Vec3,
        front: bool,
        lobe: impl FnOnce() -> f32,
        u: impl FnOnce() -> [f32; 2],
    ) -> Option<BsdfSample> {
        let diffuse = |reflectance: Vec3, share: f32| {
            let (wi, pdf) = diffuse_direction(n, u());
            (pdf > 0.0).then(|| BsdfSample {
                wi,
                weight: reflectance / share,
                pdf: share * pdf,
                specular: false,
            })
        };
        let specular = |wi: Vec3, weight: Vec3| {
            Some(BsdfSample {
                wi: wi.normalize(),
                weight,
                pdf: 0.0,
                specular: true,
            })
        };
        match *self {
            Self::Diffuse(reflectance) => {
                if reflectance == Vec3::ZERO {
                    None
                } else {
                    diffuse(reflectance, 1.0)
                }
            }
            Self::Mirror(reflectance) => {
                if reflectance == Vec3::ZERO {
                    None
                } else {
                    specular(reflect(wo, n), reflectance)
                }
            }
            Self::Blend {
                diffuse: d,
                mirror: m,
            } => {
                let share = self.diffuse_share();
                if !(share >= 0.0) {
                    None // Both reflectances are zero.
                } else if lobe() < share {
                    diffuse(d, share)
                } else {
                    specular(reflect(wo, n), m / (1.0 - share))
                }
            }
            Self::Glass(ior) => {
                let [(reflected, share), (refracted, _)] = through_glass(ior, wo, n, front);
                // Chosen in proportion, so the weight is 1.
                let is_reflected = lobe() < share;
                specular(if is_reflected { reflected } else { refracted }, Vec3::ONE)
            }
        }
    }
}

/// A direction off a diffuse surface with unit normal `n`, and its density per solid angle, cos/π.
#[inline(always)]
pub(crate) fn diffuse_direction(n: Vec3, u: [f32; 2]) -> (Vec3, f32) {
    let local = warp::cosine_hemisphere(u);
    let wi = Frame::around(n).world_from_local(local).normalize();
    (wi, local.z * std::f32::consts::FRAC_1_PI)
}

/// The two ways on from glass of some index of refraction, by reflection and by refraction, and the
/// share of the light that goes each; for the arguments see [`Bsdf::sample`]. Paths carry basic
/// radiance L/n² (Veach 1997), which refraction does not change; camera and lights are in air.
#[inline]
pub(crate) fn through_glass(ior: f32, wo: Vec3, n: Vec3, front: bool) -> [(Vec3, f32); 2] {
    let eta = if front { 1.0 / ior } else { ior };
    let cos = wo.dot(n).clamp(0.0, 1.0);
    let (reflectance, cos_t) = fresnel(cos, eta);
    let refracted = eta * -wo + (eta * cos - cos_t) * n;
    [
        (reflect(wo, n), reflectance),
        (refracted, 1.0 - reflectance),
    ]
}

/// `wo` mirrored about `n`.
fn reflect(wo: Vec3, n: Vec3) -> Vec3 {
    2.0 * wo.dot(n) * n - wo
}

/// Unpolarised Fresnel reflectance of a dielectric at `cos` from the normal, and the cosine of the
/// refracted direction; `eta` is the ratio of indices, incident over transmitted. Total
/// reflection gives (1, 0).
pub(crate) fn fresnel(cos: f32, eta: f32) -> (f32, f32) {
    // 1 − eta² sin², so that a boundary between equal indices reflects nothing at any angle.
    let cos2_t = (1.0 - eta) * (1.0 + eta) + eta * eta * cos * cos;
    if cos2_t <= 0.0 {
        return (1.0, 0.0);
    }
    let cos_t = cos2_t.sqrt();
    let parallel = (cos - eta * cos_t) / (cos + eta * cos_t);
    let perpendicular = (eta * cos - cos_t) / (eta * cos + cos_t);
    (
        0.5 * (parallel * parallel + perpendicular * perpendicular),
        cos_t,
    )
}
