//! Scattering.

use glam::Vec3;
use lightbox_core::bsdf::Bsdf;

use super::draw::{Draw, unit};

/// Reflectances and indices that scenes may have, with normals of unit length, flipped, or far
/// from unit, and directions down to grazing: unit directions, no gain of energy, no NaN.
pub fn bsdfs(bytes: &[u8]) {
    let mut draw = Draw::new(bytes);
    let mut color =
        || Vec3::from_array([0; 3].map(|_| draw.of(&[0.0, 1e-45, 1e-20, 0.25, 0.9, 1.0])));
    let (diffuse, mirror) = (color(), color());
    let share = draw.of(&[1e-30, 1e-7, 0.3, 0.999_999_9]);
    let bsdf = match draw.below(4) {
        0 => Bsdf::Diffuse(diffuse),
        1 => Bsdf::Mirror(mirror),
        2 => Bsdf::Blend {
            diffuse: (1.0 - share) * diffuse,
            mirror: share * mirror,
        },
        _ => Bsdf::Glass(draw.of(&[0.2, 0.75, 1.0, 1.0 + f32::EPSILON, 1.5, 5.0])),
    };
    let n = draw.direction();
    let across = n.any_orthonormal_vector();
    let grazing = draw.of(&[0.0, 1e-38, 1e-20, 1e-7, 1e-3, 0.5, 1.0]);
    // `n` is on the side of `wo`, up to rounding, or on the wrong one.
    let wo = unit(across * (1.0 - grazing) + n * grazing * draw.of(&[1.0, 1.0, -1.0]));
    let is_unit = draw.below(2) == 0;
    let n = if is_unit {
        n
    } else {
        n * draw.of(&[0.0, 1e-20, 0.9, 1.1, 1e10])
    };
    let (front, choice, u) = (draw.below(2) == 0, draw.unit(), [draw.unit(), draw.unit()]);
    let Some(sample) = bsdf.sample(wo, n, front, || choice, || u) else {
        return;
    };
    let what = || format!("{bsdf:?}, wo {wo}, n {n}, front {front}, {choice}, {u:?}: {sample:?}");
    let weight = sample.weight;
    assert!(
        weight.is_finite() && weight.cmpge(Vec3::ZERO).all(),
        "{}",
        what()
    );
    assert!(sample.pdf.is_finite() && sample.pdf >= 0.0, "{}", what());
    // A weight is divided by the probability of its lobe; together the lobes must not gain.
    let lobe = match bsdf {
        Bsdf::Blend { diffuse, mirror } => {
            let (d, m) = (diffuse.element_sum(), mirror.element_sum());
            if sample.specular {
                m / (d + m)
            } else {
                d / (d + m)
            }
        }
        _ => 1.0,
    };
    let most = match (bsdf, sample.specular) {
        (Bsdf::Glass(_), _) => Vec3::ONE,
        (Bsdf::Diffuse(d), _) | (Bsdf::Blend { diffuse: d, .. }, false) => d,
        (Bsdf::Mirror(m), _) | (Bsdf::Blend { mirror: m, .. }, true) => m,
    };
    assert!(
        (weight * lobe).cmple(most * 1.00001 + 1e-6).all(),
        "gains: {}",
        what()
    );
    if !is_unit {
        return;
    }
    assert!((sample.wi.length() - 1.0).abs() < 1e-6, "{}", what());
    let cos = sample.wi.dot(n);
    if !sample.specular {
        assert!(cos > -1e-6, "below the surface: {}", what());
        let asked = bsdf.pdf(cos.max(0.0));
        assert!(
            (asked - sample.pdf).abs() < 1e-6,
            "density {asked}: {}",
            what()
        );
    }
}
