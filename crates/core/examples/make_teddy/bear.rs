//! The bear: seated, arms half open, soles towards the viewer. +y is up and it looks along +z.

use super::implicit::{Part, Solid};

/// The bear as a solid about one unit tall.
pub fn bear() -> Solid {
    let mut solid = Solid::default();
    // Body, belly and tail.
    solid.join(
        Part::ellipsoid([0.0, 0.29, -0.01], [0.18, 0.28, 0.165]),
        0.01,
    );
    solid.join(
        Part::ellipsoid([0.0, 0.235, 0.045], [0.2, 0.185, 0.185]),
        0.1,
    );
    solid.join(
        Part::ellipsoid([0.0, 0.11, -0.19], [0.06, 0.06, 0.06]),
        0.05,
    );
    // Head, muzzle and nose.
    solid.join(
        Part::ellipsoid([0.0, 0.72, 0.03], [0.235, 0.195, 0.19]),
        0.08,
    );
    solid.join(
        Part::ellipsoid([0.0, 0.664, 0.195], [0.115, 0.085, 0.1]),
        0.02,
    );
    solid.join(
        Part::ellipsoid([0.0, 0.708, 0.283], [0.053, 0.038, 0.036]),
        0.012,
    );
    for side in [-1.0, 1.0] {
        let at = |x: f64, y: f64, z: f64| [side * x, y, z];
        // Cheeks and eyes.
        solid.join(
            Part::ellipsoid(at(0.12, 0.675, 0.04), [0.12, 0.10, 0.12]),
            0.1,
        );
        solid.join(
            Part::ellipsoid(at(0.09, 0.782, 0.198), [0.034, 0.038, 0.032]),
            0.014,
        );
        // Ears, hollowed in front.
        let ear = at(0.25, 0.1, 1.0);
        solid.join(
            Part::facing(at(0.18, 0.888, 0.01), [0.095, 0.095, 0.05], ear),
            0.05,
        );
        solid.carve(
            Part::facing(at(0.196, 0.898, 0.068), [0.06, 0.06, 0.036], ear),
            0.03,
        );
        // Arms, reaching a little forward.
        solid.join(
            Part::limb(at(0.14, 0.46, 0.02), 0.07, at(0.31, 0.335, 0.13), 0.074),
            0.1,
        );
        solid.join(
            Part::ellipsoid(at(0.325, 0.322, 0.145), [0.08, 0.08, 0.08]),
            0.04,
        );
        // Legs, spread, and feet with a pad on each sole.
        let sole = at(0.22, 0.12, 1.0);
        solid.join(
            Part::limb(at(0.11, 0.105, 0.05), 0.1, at(0.23, 0.088, 0.33), 0.085),
            0.1,
        );
        solid.join(
            Part::facing(at(0.25, 0.118, 0.36), [0.1, 0.125, 0.066], sole),
            0.06,
        );
        solid.join(
            Part::facing(at(0.26, 0.114, 0.412), [0.06, 0.072, 0.046], sole),
            0.01,
        );
    }
    solid
}
