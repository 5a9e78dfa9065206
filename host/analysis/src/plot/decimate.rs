//! Decimation of curves without visible change.
//!
//! A run has more ticks than a figure has columns. Of all points in one column only
//! the first, lowest, highest and last are visible; the others are omitted. No peak is
//! lost.

/// Width of a column in px: that of a pixel of the PNG.
const COLUMN_PX: f64 = 0.5;

/// Largest difference in px of points on a level line: less than the resolution of the
/// file.
const LEVEL_PX: f64 = 0.05;

/// Omits invisible points. Points are in order of x; one that is not finite makes a gap.
pub(super) fn decimate(points: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<(f64, f64)>> {
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    let mut column: Vec<(f64, f64)> = Vec::new();
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            keep_visible(&mut column, &mut piece);
            if !piece.is_empty() {
                pieces.push(std::mem::take(&mut piece));
            }
            continue;
        }
        if column.first().is_some_and(|first| x - first.0 >= COLUMN_PX) {
            keep_visible(&mut column, &mut piece);
        }
        column.push((x, y));
    }
    keep_visible(&mut column, &mut piece);
    if !piece.is_empty() {
        pieces.push(piece);
    }
    pieces
}

/// Moves the first, lowest, highest and last point of a column to the piece,
/// then drops points in the middle of level lines.
fn keep_visible(column: &mut Vec<(f64, f64)>, piece: &mut Vec<(f64, f64)>) {
    let by_y = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
    let (lowest, highest) = (
        (0..column.len()).min_by(by_y),
        (0..column.len()).max_by(by_y),
    );
    if let (Some(lowest), Some(highest)) = (lowest, highest) {
        let mut kept = [0, lowest, highest, column.len() - 1];
        kept.sort_unstable();
        for (i, &at) in kept.iter().enumerate() {
            if i > 0 && kept[i - 1] == at {
                continue;
            }
            let point = column[at];
            if let [.., before, last] = piece.as_mut_slice()
                && [*last, point]
                    .iter()
                    .all(|(_, y)| (y - before.1).abs() < LEVEL_PX)
            {
                *last = point;
            } else {
                piece.push(point);
            }
        }
    }
    column.clear();
}

/// Reduces overlapping dots to one.
pub(super) fn distinct(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut seen = std::collections::HashSet::new();
    points
        .filter(|(x, y)| seen.insert(((x / 1.5).round() as i64, (y / 1.5).round() as i64)))
        .collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp, reason = "points are passed through, not computed")]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_and_points_do_not() {
        // 100 points per column, one spike each way.
        let y = |i: usize| match i {
            4_321 => 50.0,
            7_777 => -50.0,
            _ => (i as f64 * 0.7).sin(),
        };
        let pieces = decimate((0..10_000).map(|i| (i as f64 * 0.005, y(i))));
        assert_eq!(pieces.len(), 1);
        let kept = &pieces[0];
        assert!(kept.len() <= 4 * 101, "{}", kept.len());
        assert!(kept.contains(&(4_321.0 * 0.005, 50.0)));
        assert!(kept.contains(&(7_777.0 * 0.005, -50.0)));
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0));
    }

    #[test]
    fn a_gap_stays_a_gap_and_a_level_line_has_two_ends() {
        let y = |i: i32| if i == 50 { f64::NAN } else { 1.0 };
        let pieces = decimate((0..100).map(|i| (f64::from(i), y(i))));
        let expected = [
            vec![(0.0, 1.0), (49.0, 1.0)],
            vec![(51.0, 1.0), (99.0, 1.0)],
        ];
        assert_eq!(pieces, expected);
    }
}
