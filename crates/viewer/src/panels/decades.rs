//! Charts whose axes are both logarithmic: the plot is given decades and labelled with numbers.

use egui_plot::{Corner, GridInput, GridMark, Legend, Plot, PlotPoints, Points};

/// Least span of an axis, decades.
const LEAST: f64 = 0.7;

/// Room beside the curves, as a share of the span: left, right, below and above.
const ROOM: [f64; 4] = [0.03, 0.13, 0.08, 0.08];

/// Least step of the marks at 1, 2 and 5.
const FEW: f64 = 0.1;

/// A chart that shows what it is told to and cannot be moved.
pub fn still<'a>(id: &str, height: f32) -> Plot<'a> {
    Plot::new(id)
        .height(height)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .allow_axis_zoom_drag(false)
        .show_crosshair(false)
        .label_formatter(|_| None)
}

/// A chart of relative errors; `x_text` writes a round number of the other axis.
pub fn plot<'a>(id: &str, height: f32, x_text: impl Fn(f64) -> String + 'a) -> Plot<'a> {
    still(id, height)
        .x_grid_spacer(grid)
        .y_grid_spacer(grid)
        .x_axis_formatter(move |mark, shown| {
            // A label in the last part would be cut off.
            let end = shown.end() - 0.06 * (shown.end() - shown.start());
            if mark.value < end {
                x_text(mantissa_exact(mark.value))
            } else {
                String::new()
            }
        })
        .y_axis_formatter(|mark, _| {
            if mark.step_size < FEW {
                return String::new(); // Their labels would run into each other.
            }
            format!("{} %", mantissa_exact(mark.value + 2.0))
        })
        .y_axis_min_width(48.0)
        .legend(Legend::default().position(Corner::RightTop))
}

/// Marks without a name under the pointer.
pub fn dots<'a>(name: &str, id: impl std::hash::Hash, at: Vec<[f64; 2]>) -> Points<'a> {
    Points::new(name, PlotPoints::from(at))
        .id(id)
        .allow_hover(false)
}

/// What the axes show: all points and some room. Left, right, bottom, top.
pub fn bounds<'a>(points: impl Iterator<Item = &'a [f64; 2]>) -> [f64; 4] {
    let mut span = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for point in points {
        for (span, x) in span.iter_mut().zip(point) {
            *span = [span[0].min(*x), span[1].max(*x)];
        }
    }
    let [x, y] = span.map(|[low, high]| {
        if low > high {
            return [-1.0, 1.0];
        }
        let lack = (LEAST - (high - low)).max(0.0);
        [low - lack / 2.0, high + lack / 2.0]
    });
    let (width, height) = (x[1] - x[0], y[1] - y[0]);
    [
        x[0] - ROOM[0] * width,
        x[1] + ROOM[1] * width,
        y[0] - ROOM[2] * height,
        y[1] + ROOM[3] * height,
    ]
}

/// Lines at 1, 2, … 9 times every power of ten; labels, where there is room, at 1, 2 and 5.
fn grid(input: GridInput) -> Vec<GridMark> {
    let (low, high) = input.bounds;
    let mut marks = Vec::new();
    for decade in low.floor() as i32..=high.ceil() as i32 {
        for k in 1..10 {
            let step_size = match k {
                1 => 1.0,
                2 | 5 => 0.3,
                _ => 0.09,
            };
            marks.push(GridMark {
                value: f64::from(decade) + f64::from(k).log10(),
                step_size,
            });
        }
    }
    marks.retain(|m| (low..=high).contains(&m.value));
    marks
}

/// 10 to the power of a grid mark, with one digit.
fn mantissa_exact(mark: f64) -> f64 {
    format!("{:.0e}", 10f64.powf(mark)).parse().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panels::format::si;

    #[test]
    fn marks_are_round_numbers() {
        let input = GridInput {
            bounds: (-1.5, 1.2),
            base_step_size: 0.01,
        };
        let marks = grid(input);
        let labelled: Vec<String> = marks
            .iter()
            .filter(|m| m.step_size >= FEW)
            .map(|m| mantissa_exact(m.value).to_string())
            .collect();
        assert_eq!(labelled, ["0.05", "0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(
            [0.0, 3.0, 6.3, 9.0].map(|m| si(mantissa_exact(m))),
            ["1", "1 k", "2 M", "1 G"]
        );
    }

    #[test]
    fn axes_hold_every_point_and_are_never_empty() {
        let [left, right, bottom, top] = bounds([[-1.0, 0.0], [2.0, -3.0]].iter());
        assert!(left < -1.0 && right > 2.0 && bottom < -3.0 && top > 0.0);
        let [left, right, bottom, top] = bounds([[1.0, 1.0]].iter());
        assert!(right - left >= LEAST && top - bottom >= LEAST);
        assert!((left..right).contains(&1.0) && (bottom..top).contains(&1.0));
        assert!(bounds([].iter())[0].is_finite());
    }
}
