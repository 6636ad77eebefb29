//! Entering a window into the list of an edge.
//!
//! In: a list of disjoint windows in ascending order, and a candidate. Out: the list of the pointwise shorter ones.
//! Holds: a candidate enters only where it is shorter by more than rounding, so that equal ones never alternate and
//! every entry lowers the distance somewhere; pieces too narrow to matter go to their neighbours, so that no gap
//! opens. Source: [Bommes2012] §9, window intersection; a window may end in three pieces.

use crate::trim::{Outcome, compare};
use crate::window::{NARROW_REL, Window};

/// Which window a piece belongs to.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    New,
    Old(usize),
}

/// Pieces on their way into a list.
#[derive(Default)]
pub(crate) struct Pieces {
    windows: Vec<Window>,
    last: Option<Owner>,
    /// Least distance of the pieces of the new window.
    least: f64,
}

impl Pieces {
    fn start(&mut self) {
        self.windows.clear();
        self.last = None;
        self.least = f64::INFINITY;
    }

    fn add(&mut self, owner: Owner, window: &Window, b0: f64, b1: f64) {
        if b1 <= b0 {
            return;
        }
        match self.windows.last_mut() {
            Some(last) if self.last == Some(owner) => last.b1 = b1,
            _ => self.windows.push(window.over(b0, b1)),
        }
        self.last = Some(owner);
        if owner == Owner::New {
            let piece = window.over(b0, b1);
            self.least = self.least.min(piece.least());
        }
    }
}

/// Enters a candidate; returns the least distance over what it won, infinity if nothing.
pub(crate) fn insert(list: &mut Vec<Window>, pieces: &mut Pieces, length: f64, mut new: Window) -> f64 {
    let narrow = NARROW_REL * length;
    if new.b0 <= narrow {
        new.b0 = 0.0;
    }
    if new.b1 >= length - narrow {
        new.b1 = length;
    }
    // 1. The windows that it overlaps.
    let from = list.partition_point(|o| o.b1 <= new.b0 + narrow);
    let mut to = from;
    pieces.start();
    if let Some(first) = list.get(from)
        && (new.b0 - first.b0).abs() <= narrow
    {
        new.b0 = first.b0;
    }
    // Most come in order and find nothing there.
    if from == list.len() {
        let b0 = list.last().map_or(new.b0, |last| new.b0.max(last.b1));
        if new.b1 <= b0 {
            return f64::INFINITY;
        }
        new.b0 = b0;
        list.push(new);
        return new.least();
    }
    let mut cursor = from.checked_sub(1).map_or(new.b0, |k| new.b0.max(list[k].b1));
    // 2. One after the other, with the holes before them.
    while let Some(old) = list.get(to).filter(|o| o.b0 < new.b1 - narrow) {
        let owner = Owner::Old(to);
        if old.b0 > cursor {
            pieces.add(Owner::New, &new, cursor, old.b0);
            cursor = old.b0;
        }
        pieces.add(owner, old, old.b0, cursor);
        let hi = if new.b1 >= old.b1 - narrow { old.b1 } else { new.b1 };
        overlap(pieces, &new, (owner, old), cursor, hi, narrow);
        pieces.add(owner, old, hi, old.b1);
        cursor = hi;
        to += 1;
    }
    // 3. The hole behind them.
    if new.b1 > cursor + narrow || to == from {
        let end = list.get(to).map_or(new.b1, |next| new.b1.min(next.b0));
        pieces.add(Owner::New, &new, cursor, end);
    }
    if pieces.least < f64::INFINITY {
        list.splice(from..to, pieces.windows.iter().copied());
    }
    pieces.least
}

/// Shares `lo..=hi` between the new window and an old one.
fn overlap(pieces: &mut Pieces, new: &Window, (owner, old): (Owner, &Window), lo: f64, hi: f64, narrow: f64) {
    let snap = |x: f64| {
        if x - lo <= narrow {
            lo
        } else if hi - x <= narrow {
            hi
        } else {
            x
        }
    };
    let mut share = |cuts: [f64; 2], inside: Owner, outside: Owner| {
        let [x, y] = cuts.map(snap);
        let of = |o: Owner| if o == Owner::New { new } else { old };
        pieces.add(outside, of(outside), lo, x);
        pieces.add(inside, of(inside), x, y);
        pieces.add(outside, of(outside), y, hi);
    };
    // Equal windows from two sides are cut so that their rays do not part: at the end where the slope falls more. One is
    // only the other's extension there, which cuts the corner behind which the other begins.
    let cut = |left: &Window, right: &Window| {
        let falls = |x: f64| left.at_with_slope(x).1 - right.at_with_slope(x).1;
        if falls(lo) > falls(hi) { lo } else { hi }
    };
    match compare(new, old, lo, hi, narrow) {
        Outcome::Equal if new.b0 < old.b0 && new.b1 < old.b1 => share([lo, cut(new, old)], Owner::New, owner),
        Outcome::Equal if new.b0 > old.b0 && new.b1 > old.b1 => share([cut(old, new), hi], Owner::New, owner),
        Outcome::Old | Outcome::Equal => share([lo, hi], owner, Owner::New),
        Outcome::New => share([lo, hi], Owner::New, owner),
        Outcome::NewThenOld(x) => share([lo, x], Owner::New, owner),
        Outcome::OldThenNew(x) => share([x, hi], Owner::New, owner),
        Outcome::NewInside(x, y) => share([x, y], Owner::New, owner),
        Outcome::OldInside(x, y) => share([x, y], owner, Owner::New),
    }
}
