//! Tests of the film. Its sums are cases of the stability lab.

use super::*;
use crate::filter::Filter;

#[test]
fn noise_needs_both_halves() {
    let film = Film::new(1, 1, &FilterSampler::new(Filter::default()));
    for (sample, noise) in [(0, None), (1, Some(0.0))] {
        let (mut batch, _) = film.batch(0);
        batch.add([0, 0], sample, 0, Vec3::ONE);
        assert!(film.merge(0, &batch, sample, sample + 1));
        assert_eq!(film.noise(), noise);
    }
}
