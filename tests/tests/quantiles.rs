//! The critical values that the lab holds as constants, against a library of distributions.

use lightbox_core::lab::stats::{CHI_SQUARE_63, REPLICATES, T_31, T_31_POWER, alpha};
use statrs::distribution::{ChiSquared, ContinuousCDF as _, StudentsT};

#[test]
fn critical_values_are_those_of_the_family() {
    let t = StudentsT::new(0.0, 1.0, REPLICATES as f64 - 1.0).unwrap();
    let critical = t.inverse_cdf(1.0 - alpha() / 2.0);
    assert!((T_31 / critical - 1.0).abs() < 1e-5, "{critical}");
    let power = t.inverse_cdf(0.9);
    assert!((T_31_POWER / power - 1.0).abs() < 1e-3, "{power}");
    // By the tail at the constant: the inverse is iterative and less exact.
    let tail = ChiSquared::new(63.0).unwrap().sf(CHI_SQUARE_63);
    assert!(
        (tail / alpha() - 1.0).abs() < 1e-3,
        "{tail} instead of {}",
        alpha()
    );
}
