//! Stop plan: stops at every speed at which servos may run, before any other packet.
//!
//! Where servos may run at any of several speeds, a full sequence at each would delay
//! the last one: 7 ms at 1 Mbaud, 52 ms at 57600. So the brief stop is sent at
//! each of them first, the likeliest first, and full sequences follow where servos are
//! likely to be. A search sends them at the other speeds.

use armbridge_servo::master::Transaction;
use heapless::Vec;

/// Capacity for speeds: those of the servos, a client's last, and those of discovery.
const SPEEDS_MAX: usize = 12;

/// Speeds in bits per second, without repetition.
pub(super) type Speeds = Vec<u32, SPEEDS_MAX>;

/// Adds a speed; if there is no room, it replaces the oldest after the first.
pub(super) fn add_speed(speeds: &mut Speeds, baud: u32) {
    if speeds.contains(&baud) {
        return;
    }
    if speeds.is_full() {
        speeds.remove(1);
    }
    // There is room.
    let _ = speeds.push(baud);
}

/// Planned stops, and the progress through them.
#[derive(Clone, Debug, Default)]
pub(super) struct StopPlan {
    /// Speeds at which servos may be.
    possible: Speeds,
    /// Number of likely speeds among them, which come first.
    likely: usize,
    next: usize,
}

impl StopPlan {
    /// A plan of brief stops at `likely` speeds and at `others`, then full sequences at the likely
    /// ones.
    pub(super) fn new(likely: Speeds, others: &[u32]) -> Self {
        let count = likely.len();
        let mut possible = likely;
        for baud in others {
            if !possible.contains(baud) {
                // Speeds that do not fit are left to the search.
                let _ = possible.push(*baud);
            }
        }
        Self {
            possible,
            likely: count,
            next: 0,
        }
    }

    /// Number of brief stops: none for a single speed, because the sequence begins with it.
    fn briefs(&self) -> usize {
        match self.possible.len() {
            1 => 0,
            count => count,
        }
    }

    /// Whether all stops have been taken.
    pub(super) fn is_done(&self) -> bool {
        self.next >= self.briefs() + self.likely
    }

    /// Takes the next stop, with its speed.
    pub(super) fn take(&mut self) -> Option<(Transaction, u32)> {
        if self.is_done() {
            return None;
        }
        let (transaction, index) = match self.next.checked_sub(self.briefs()) {
            None => (Transaction::BriefStop, self.next),
            Some(index) => (Transaction::Stop, index),
        };
        let baud = *self.possible.get(index)?;
        self.next += 1;
        Some((transaction, baud))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(speeds: &[u32]) -> StopPlan {
        let mut all = Speeds::new();
        for baud in speeds {
            add_speed(&mut all, *baud);
        }
        StopPlan::new(all, &[])
    }

    #[test]
    fn brief_stops_at_all_speeds_come_first() {
        use Transaction::{BriefStop, Stop};
        let mut one = plan(&[1_000_000, 1_000_000]);
        assert_eq!(one.take(), Some((Stop, 1_000_000)));
        assert_eq!(one.take(), None);
        let mut two = plan(&[57_142, 1_000_000]);
        let sent = [(); 5].map(|()| two.take());
        let expected = [
            Some((BriefStop, 57_142)),
            Some((BriefStop, 1_000_000)),
            Some((Stop, 57_142)),
            Some((Stop, 1_000_000)),
            None,
        ];
        assert_eq!(sent, expected);
        assert_eq!(StopPlan::default().take(), None);
        let mut wide = StopPlan::new(Speeds::from_slice(&[500_000]).unwrap(), &[500_000, 57_142]);
        let sent = [(); 4].map(|()| wide.take());
        let expected = [
            Some((BriefStop, 500_000)),
            Some((BriefStop, 57_142)),
            Some((Stop, 500_000)),
            None,
        ];
        assert_eq!(sent, expected);
    }

    #[test]
    fn the_first_speed_and_the_latest_are_remembered() {
        let mut speeds = Speeds::new();
        for baud in 1..=20 {
            add_speed(&mut speeds, baud);
        }
        assert_eq!(speeds, [1, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20]);
    }
}
