//! The critical values that the lab holds as constants, against a library of distributions.

use lightbox_core::lab::stats::{BIAS_31, CHI_SQUARE_63, REPLICATES, SPREAD_31, T_31, alpha};
use statrs::distribution::{ChiSquared, Continuous as _, ContinuousCDF as _, Normal, StudentsT};

#[test]
fn critical_values_are_those_of_the_family() {
    let degrees = REPLICATES as f64 - 1.0;
    let t = StudentsT::new(0.0, 1.0, degrees).unwrap();
    let critical = t.inverse_cdf(1.0 - alpha() / 2.0);
    assert!((T_31 / critical - 1.0).abs() < 1e-5, "{critical}");
    // The noncentral t: a normal mean over a spread that is a χ² of its own, by midpoints.
    let (spread, mean) = (ChiSquared::new(degrees).unwrap(), Normal::standard());
    let step = 0.01;
    let power: f64 = (0..20_000)
        .map(|i| (f64::from(i) + 0.5) * step)
        .map(|x| mean.cdf(BIAS_31 - T_31 * (x / degrees).sqrt()) * spread.pdf(x) * step)
        .sum();
    assert!((power - 0.9).abs() < 1e-6, "{power}");
    let above = spread.cdf(degrees / SPREAD_31.powi(2));
    assert!((above - 0.01).abs() < 1e-6, "{above}");
    // By the tail at the constant: the inverse is iterative and less exact.
    let tail = ChiSquared::new(63.0).unwrap().sf(CHI_SQUARE_63);
    assert!(
        (tail / alpha() - 1.0).abs() < 1e-3,
        "{tail} instead of {}",
        alpha()
    );
}
