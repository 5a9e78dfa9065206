//! Curve in a plane, such as speed over angle, in bounded memory.
//!
//! The curve is not kept again where it has already been: the plane is divided into cells,
//! and a cell is entered once. If too many cells are filled, they double in size.

use std::collections::HashSet;

/// Largest number of cells: more than a figure shows apart.
const CELLS_MAX: usize = 50_000;

/// A curve, point by point; a point that is not finite makes a gap.
#[derive(Clone, Debug)]
pub(super) struct Trace {
    /// Width and height of a cell.
    cell: [f64; 2],
    seen: HashSet<[i32; 2]>,
    pieces: Vec<Vec<(f64, f64)>>,
    piece: Vec<(f64, f64)>,
    before: Option<([i32; 2], (f64, f64))>,
}

impl Trace {
    /// Empty curve, with cells of this size.
    pub(super) fn new(cell: [f64; 2]) -> Self {
        Self {
            cell,
            seen: HashSet::new(),
            pieces: Vec::new(),
            piece: Vec::new(),
            before: None,
        }
    }

    pub(super) fn add(&mut self, (x, y): (f64, f64)) {
        if !(x.is_finite() && y.is_finite()) {
            self.end_piece();
            self.before = None;
            return;
        }
        // Far outside, all points share the outermost cells.
        let cell = [
            (x / self.cell[0]).round() as i32,
            (y / self.cell[1]).round() as i32,
        ];
        if self.before.is_some_and(|(last, _)| last == cell) {
            return;
        }
        if self.seen.insert(cell) {
            // Where the curve leaves the cells that it has been in, it is joined to them.
            if let (true, Some((_, last))) = (self.piece.is_empty(), self.before) {
                self.piece.push(last);
            }
            self.piece.push((x, y));
        } else if !self.piece.is_empty() {
            self.piece.push((x, y));
            self.end_piece();
        }
        self.before = Some((cell, (x, y)));
        if self.seen.len() > CELLS_MAX {
            self.coarsen();
        }
    }

    fn end_piece(&mut self) {
        if !self.piece.is_empty() {
            self.pieces.push(std::mem::take(&mut self.piece));
        }
    }

    /// Doubles the cells.
    fn coarsen(&mut self) {
        let last = self.before.map(|(_, last)| last);
        let mut coarse = Self::new(self.cell.map(|side| 2.0 * side));
        for point in std::mem::replace(self, Self::new([1.0; 2])).points() {
            coarse.add(point);
        }
        // A curve that goes on is joined to its last point.
        if let Some(last) = last {
            coarse.end_piece();
            coarse.before = None;
            coarse.add(last);
        }
        *self = coarse;
    }

    /// Pieces of the curve.
    pub(super) fn into_pieces(mut self) -> Vec<Vec<(f64, f64)>> {
        self.end_piece();
        self.pieces
    }

    /// Points, with a gap after each piece.
    pub(super) fn points(self) -> impl Iterator<Item = (f64, f64)> {
        let gap = (f64::NAN, f64::NAN);
        self.into_pieces()
            .into_iter()
            .flat_map(move |piece| piece.into_iter().chain([gap]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_closed_curve_is_traced_once() {
        let around = |turns: u32| {
            let mut trace = Trace::new([1.0; 2]);
            for i in 0..turns * 1000 {
                let turn = f64::from(i) / 1000.0 * std::f64::consts::TAU;
                trace.add((100.0 * turn.cos(), 100.0 * turn.sin()));
            }
            trace.into_pieces()
        };
        let length = |pieces: &[Vec<(f64, f64)>]| pieces.iter().map(Vec::len).sum::<usize>();
        let (once, often) = (around(1), around(50));
        assert!(length(&once) > 500, "{}", length(&once));
        assert!(length(&often) <= length(&once) + 20, "{}", length(&often));
    }

    #[test]
    fn a_curve_that_fills_the_plane_is_bounded() {
        let mut trace = Trace::new([1e-4; 2]);
        let mut state = 1_u64;
        for _ in 0..400_000 {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            trace.add((
                (state >> 44) as f64 * 1e-6,
                (state >> 24 & 0xf_ffff) as f64 * 1e-6,
            ));
        }
        assert!(trace.seen.len() <= CELLS_MAX);
        assert!(trace.seen.len() > CELLS_MAX / 8, "{}", trace.seen.len());
    }
}
