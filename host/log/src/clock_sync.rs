//! Mapping of the board's clock to the host's.
//!
//! A frame reaches the host after its tick with a variable, occasionally long delay. So
//! the relation of the two clocks is the lower envelope of `host - board`, and the
//! distance above it is delay.
//!
//! * [`Mapping`] maps a tick to the host's clock while the log is written, from the
//!   frames so far; ticks are spaced evenly, whatever the delays of the link.
//! * [`Envelope`] keeps the minimum of each second, in bounded memory, and [`Line`] is
//!   the line below all of them: offset, drift, and delays of frames.

/// Window in ns whose minimum is stored.
const WINDOW_NS: u64 = 1_000_000_000;

/// Limit of the windows, beyond which neighbours are merged: over an hour of seconds.
const WINDOWS_MAX: usize = 4_096;

/// Fraction of the offset error that is corrected per window.
const CORRECTION: f64 = 0.2;

/// Largest correction per window: the mapped rate is off by at most 1 %.
const CORRECTION_MAX_NS: f64 = 10e6;

/// Online mapping of the board's times to the host's clock.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mapping {
    /// `host - board` in ns at the start of the window, and its change per ns
    /// of the board within.
    offset_ns: f64,
    slope: f64,
    window_from_ns: u64,
    least_ns: f64,
    has_offset: bool,
}

impl Mapping {
    /// Restarts after a reset of the board: its clock restarted too.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    /// Host time of a board time that was received at `host_ns`.
    pub(crate) fn host_ns(&mut self, host_ns: u64, board_us: u64) -> u64 {
        let board_ns = board_us.saturating_mul(1_000);
        // Times since 1970 in ns need 61 bits: the difference is exact only as an
        // integer.
        let ahead_ns = (i128::from(host_ns) - i128::from(board_ns)) as f64;
        if !self.has_offset || board_ns < self.window_from_ns {
            *self = Self {
                offset_ns: ahead_ns,
                slope: 0.0,
                window_from_ns: board_ns,
                least_ns: ahead_ns,
                has_offset: true,
            };
        }
        let within_ns = (board_ns - self.window_from_ns) as f64;
        let offset_ns = self.offset_ns + self.slope * within_ns.min(WINDOW_NS as f64);
        if within_ns >= WINDOW_NS as f64 {
            let correction_ns = (self.least_ns - offset_ns) * CORRECTION;
            self.slope =
                correction_ns.clamp(-CORRECTION_MAX_NS, CORRECTION_MAX_NS) / WINDOW_NS as f64;
            self.offset_ns = offset_ns;
            self.window_from_ns = board_ns;
            self.least_ns = ahead_ns;
        }
        self.least_ns = self.least_ns.min(ahead_ns);
        let mapped = i128::from(board_ns) + offset_ns as i128;
        mapped.clamp(0, u64::MAX.into()) as u64
    }
}

/// A tick: its start, and the host's clock ahead of the board's at its reception.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    board_ns: f64,
    ahead_ns: f64,
}

/// Minimum of each window, for a board without a reset in between.
#[derive(Clone, Debug)]
pub struct Envelope {
    base: Option<(u64, u64)>,
    window_ns: f64,
    points: Vec<Point>,
}

impl Default for Envelope {
    fn default() -> Self {
        Self {
            base: None,
            window_ns: WINDOW_NS as f64,
            points: Vec::new(),
        }
    }
}

impl Envelope {
    /// Adds a tick of this board's time that was received at this host's time.
    pub fn add(&mut self, host_ns: u64, board_us: u64) {
        let (host_base, board_base) = *self.base.get_or_insert((host_ns, board_us));
        let point = Point {
            board_ns: (board_us as f64 - board_base as f64) * 1e3,
            ahead_ns: (i128::from(host_ns)
                - i128::from(host_base)
                - (i128::from(board_us) - i128::from(board_base)) * 1_000)
                as f64,
        };
        let window = |point: &Point| (point.board_ns / self.window_ns).floor();
        match self.points.last_mut() {
            Some(last) if window(last) >= window(&point) => {
                if point.ahead_ns < last.ahead_ns {
                    *last = point;
                }
            }
            Some(_) | None => self.points.push(point),
        }
        if self.points.len() > WINDOWS_MAX {
            self.window_ns *= 2.0;
            let lower = |pair: &[Point]| {
                let least = pair.iter().min_by(|a, b| a.ahead_ns.total_cmp(&b.ahead_ns));
                least.copied()
            };
            self.points = self.points.chunks(2).filter_map(lower).collect();
        }
    }

    /// The line below all minima; `None` before the second window.
    pub fn line(&self) -> Option<Line> {
        let (host_base, board_base) = self.base?;
        let (slope, at_base_ns) = lower_tangent(&self.points)?;
        let last = self.points.last()?;
        let above = |point: &Point| point.ahead_ns - at_base_ns - slope * point.board_ns;
        let mut above: Vec<f64> = self.points.iter().map(above).collect();
        above.sort_by(f64::total_cmp);
        let base_ns = i128::from(host_base) - i128::from(board_base) * 1_000;
        Some(Line {
            offset_ns: (base_ns + (at_base_ns + slope * last.board_ns) as i128) as i64,
            at_board_us: board_base.saturating_add((last.board_ns / 1e3) as u64),
            drift_ppm: slope * 1e6,
            residual_us: above[above.len() / 2] / 1e3,
            residual_most_us: above[above.len() - 1] / 1e3,
        })
    }
}

/// Relation of the two clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// The host's clock minus the board's in ns, including the shortest delay of a
    /// frame,
    pub offset_ns: i64,
    /// at this time of the board in µs.
    pub at_board_us: u64,
    /// Drift of the host's clock relative to the board's, in ppm.
    pub drift_ppm: f64,
    /// Distance of a second's minimum above the line in µs: median,
    pub residual_us: f64,
    /// and maximum.
    pub residual_most_us: f64,
}

/// Slope and intercept of the highest line below all points: the edge of their lower
/// hull at their mean time. Late frames are far above the hull.
fn lower_tangent(points: &[Point]) -> Option<(f64, f64)> {
    if points.len() < 2 {
        return None;
    }
    let mut hull: Vec<Point> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..] {
            // `b` is on or above the line from `a` to `point`: no corner.
            let cross = (b.board_ns - a.board_ns) * (point.ahead_ns - a.ahead_ns)
                - (b.ahead_ns - a.ahead_ns) * (point.board_ns - a.board_ns);
            if cross > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(*point);
    }
    let middle = points.iter().map(|point| point.board_ns).sum::<f64>() / points.len() as f64;
    let mut edges = hull.windows(2);
    let edge = edges.rfind(|edge| edge[0].board_ns <= middle)?;
    let run = edge[1].board_ns - edge[0].board_ns;
    if run <= 0.0 {
        return None;
    }
    let slope = (edge[1].ahead_ns - edge[0].ahead_ns) / run;
    Some((slope, edge[0].ahead_ns - slope * edge[0].board_ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2026, in ns since 1970: where a double has a resolution of 256 ns.
    const EPOCH_NS: u64 = 1_795_000_000_000_000_000;

    /// Ticks of 1 ms whose frames take 200 µs, mostly up to 1 ms more, occasionally
    /// 80 ms; the host's clock drifts.
    fn received(ticks: u64, ppm: f64) -> impl Iterator<Item = (u64, u64)> {
        let mut seed = 1u64;
        (0..ticks).map(move |tick| {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            let random = (seed >> 40) as f64 / (1u64 << 24) as f64;
            let delay_us = 200.0 + 1_000.0 * random + if tick % 97 == 0 { 80_000.0 } else { 0.0 };
            let board_us = 5_000_000 + tick * 1_000;
            let host_ns = (tick * 1_000_000) as f64 * (1.0 + ppm * 1e-6) + delay_us * 1e3;
            (EPOCH_NS + host_ns as u64, board_us)
        })
    }

    #[test]
    fn offset_and_drift_are_found_among_delays() {
        for ppm in [-120.0, 0.0, 45.0] {
            let mut envelope = Envelope::default();
            for (host_ns, board_us) in received(600_000, ppm) {
                envelope.add(host_ns, board_us);
            }
            let line = envelope.line().unwrap();
            assert!((line.drift_ppm - ppm).abs() < 0.05, "{line:?}");
            let gained_ns = (line.at_board_us - 5_000_000) as f64 * ppm * 1e-3;
            let true_ns = EPOCH_NS as i64 - 5_000_000_000 + gained_ns as i64 + 200_000;
            assert!((line.offset_ns - true_ns).abs() < 20_000, "{line:?}");
            assert!(line.residual_us < 10.0, "{line:?}");
        }
    }

    #[test]
    fn an_hour_and_a_day_take_the_same_memory() {
        let mut envelope = Envelope::default();
        for second in 0..86_400 {
            envelope.add(EPOCH_NS + second * 1_000_000_000, second * 1_000_000);
        }
        assert!(envelope.points.len() <= WINDOWS_MAX);
        assert!(envelope.line().unwrap().drift_ppm.abs() < 1e-9);
    }

    #[test]
    fn ticks_are_evenly_spaced_on_the_hosts_clock() {
        let mut mapping = Mapping::default();
        let mut before = 0;
        for (i, (host_ns, board_us)) in received(40_000, 50.0).enumerate() {
            let at = mapping.host_ns(host_ns, board_us);
            if i > 0 {
                let step_us = (at - before) as f64 / 1e3;
                assert!((step_us - 1_000.0).abs() <= 11.0, "{step_us} µs");
            }
            // The first frame was 80 ms late: the error is corrected in time.
            if i > 35_000 {
                let late_us = (host_ns as f64 - at as f64) / 1e3;
                assert!((-500.0..90_000.0).contains(&late_us), "{late_us} µs");
            }
            before = at;
        }
    }

    #[test]
    fn a_reset_of_the_board_resets_the_mapping() {
        let mut mapping = Mapping::default();
        assert_eq!(mapping.host_ns(10_000_000_000, 5_000_000), 10_000_000_000);
        assert_eq!(mapping.host_ns(11_000_000_000, 20), 11_000_000_000);
        mapping.reset();
        assert_eq!(mapping.host_ns(12_000_000_000, 6_000_000), 12_000_000_000);
    }
}
