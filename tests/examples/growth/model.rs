//! What a render costs, as a sum of a few terms fitted to what was measured.

use crate::measure::{Cost, Runs};
use crate::sizes::Size;

/// Steps of a fit of squares, which then stands still to all digits that are printed.
const STEPS: usize = 30_000;

/// Such fits, each with other weights, for one of relative errors; and errors below which there is
/// no difference.
const ROUNDS: usize = 15;
const CLOSE: f64 = 0.02;

/// A number that a cost is a multiple of.
pub struct Term {
    /// What is counted, and the unit that its coefficient is printed in.
    pub name: &'static str,
    pub unit: (&'static str, f64),
    pub value: fn(&Size) -> f64,
}

/// Terms and their coefficients, none of them negative.
pub struct Sum {
    pub terms: &'static [Term],
    pub coefficients: Vec<f64>,
}

impl Sum {
    pub fn of(&self, size: &Size) -> f64 {
        let terms = self.terms.iter().zip(&self.coefficients);
        terms.map(|(term, c)| c * (term.value)(size)).sum()
    }

    fn fit<'a>(terms: &'static [Term], runs: impl Iterator<Item = (&'a Size, f64)>) -> Self {
        let rows = runs.map(|(size, cost)| {
            let values = terms.iter().map(|term| (term.value)(size) / cost);
            values.collect()
        });
        Self {
            terms,
            coefficients: fit(&rows.collect::<Vec<_>>()),
        }
    }
}

/// Coefficients, none of them negative, with which each row adds up to 1 as nearly as can be: rows
/// are divided by what they cost, and the sum of relative errors is least. Squares would follow
/// the runs that other programs have made longer.
fn fit(rows: &[Vec<f64>]) -> Vec<f64> {
    let mut weights = vec![1.0; rows.len()];
    let mut coefficients = Vec::new();
    for _ in 0..ROUNDS {
        coefficients = least_squares(rows, &weights);
        for (weight, row) in weights.iter_mut().zip(rows) {
            let sum: f64 = row.iter().zip(&coefficients).map(|(x, c)| x * c).sum();
            *weight = 1.0 / (sum - 1.0).abs().max(CLOSE);
        }
    }
    coefficients
}

/// The same with the least sum of weighted squares, term by term.
fn least_squares(rows: &[Vec<f64>], weights: &[f64]) -> Vec<f64> {
    let terms = rows.first().map_or(0, Vec::len);
    let column = |i: usize| rows.iter().map(move |row| row[i]).zip(weights);
    let scales: Vec<f64> = (0..terms)
        .map(|i| column(i).map(|(x, weight)| weight * x * x).sum())
        .collect();
    let mut coefficients = vec![0.0; terms];
    let mut left = vec![1.0; rows.len()];
    for i in (0..STEPS).map(|step| step % terms) {
        if scales[i] == 0.0 {
            continue;
        }
        let slope: f64 = column(i)
            .zip(&left)
            .map(|((x, weight), left)| weight * x * left)
            .sum();
        let to = (coefficients[i] + slope / scales[i]).max(0.0);
        let by = to - coefficients[i];
        coefficients[i] = to;
        for (left, row) in left.iter_mut().zip(rows) {
            *left -= by * row[i];
        }
    }
    coefficients
}

/// Paths times the levels of the tree that each of their rays goes down.
fn descended(size: &Size) -> f64 {
    size.paths() * size.triangles().log2()
}

/// A tree of more triangles than this does not fit the caches next to a core (the fit to the known sizes
/// is best with it, of 50,000, 100,000, 200,000 and 400,000).
const CACHED: f64 = 2e5;

/// Paths times the levels that have to be fetched from farther away: in a small picture the paths that go
/// together see more of the scene (of the powers 0 to 1/4 the known sizes are fitted best by 1/10 to 1/7).
fn fetched(size: &Size) -> f64 {
    let spread = (512.0 * 512.0 / size.pixels()).powf(0.125);
    size.paths() * (size.triangles() / CACHED).log2().max(0.0) * spread
}

const NANOSECONDS: (&str, f64) = ("ns", 1e9);

macro_rules! terms {
    ($($name:literal, $unit:expr, $value:expr;)+) => {
        &[$(Term { name: $name, unit: $unit, value: $value }),+]
    };
}

/// Seconds of the processors.
const CPU: &[Term] = terms! {
    "pixel", NANOSECONDS, Size::pixels;
    "triangle", NANOSECONDS, Size::triangles;
    "path", NANOSECONDS, Size::paths;
    "path and level", NANOSECONDS, descended;
    "path and level beyond the caches", NANOSECONDS, fetched;
};

/// Seconds on the clock.
const WALL: &[Term] = terms! {
    "pixel", NANOSECONDS, Size::pixels;
    "triangle", NANOSECONDS, Size::triangles;
    "triangle / threads", NANOSECONDS, |s| s.triangles() / s.threads();
    "path / threads", NANOSECONDS, |s| s.paths() / s.threads();
    "path and level / threads", NANOSECONDS, |s| descended(s) / s.threads();
    "path and level beyond the caches / threads", NANOSECONDS, |s| fetched(s) / s.threads();
};

/// Bytes, those of triangles while the scene is built, or those of triangles and pixels while it is
/// rendered and written, whichever are more.
pub struct Memory {
    pub program: f64,
    pub building: f64,
    pub rendering: f64,
    pub pixel: f64,
}

impl Memory {
    fn fit(runs: &Runs) -> Self {
        // Which of the two are more follows from the fit, and the fit from it. It begins with a guess.
        let mut memory = Self {
            program: 0.0,
            building: 1.2,
            rendering: 1.0,
            pixel: 1.0,
        };
        for _ in 0..8 {
            let rows = runs.iter().map(|(size, cost)| {
                let row = match memory.builds(size) {
                    true => [1.0, size.triangles(), 0.0, 0.0],
                    false => [1.0, 0.0, size.triangles(), size.pixels()],
                };
                row.map(|x| x / cost.memory).to_vec()
            });
            if let [program, building, rendering, pixel] = *fit(&rows.collect::<Vec<_>>()) {
                memory = Self {
                    program,
                    building,
                    rendering,
                    pixel,
                };
            }
        }
        memory
    }

    /// Whether it is while the scene is built that most is needed.
    fn builds(&self, size: &Size) -> bool {
        let (triangles, pixels) = (size.triangles(), size.pixels());
        self.building * triangles > self.rendering * triangles + self.pixel * pixels
    }

    fn of(&self, size: &Size) -> f64 {
        let (triangles, pixels) = (size.triangles(), size.pixels());
        let rendering = self.rendering * triangles + self.pixel * pixels;
        self.program + rendering.max(self.building * triangles)
    }
}

/// What a render of some size costs.
pub struct Model {
    pub wall: Sum,
    pub cpu: Sum,
    pub memory: Memory,
}

impl Model {
    /// Fitted to some runs.
    pub fn fit(runs: &Runs) -> Self {
        let costs = |cost: fn(&Cost) -> f64| runs.iter().map(move |(size, c)| (size, cost(c)));
        Self {
            wall: Sum::fit(WALL, costs(|c| c.wall)),
            cpu: Sum::fit(CPU, costs(|c| c.cpu)),
            memory: Memory::fit(runs),
        }
    }

    /// What it says of a size.
    pub fn of(&self, size: &Size) -> Cost {
        Cost {
            wall: self.wall.of(size),
            cpu: self.cpu.of(size),
            memory: self.memory.of(size),
        }
    }
}
