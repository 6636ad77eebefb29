//! The windows of every edge, in one allocation.
//!
//! In: an edge's windows in order. Out: slices. Holds: the windows of an edge are contiguous; room that an edge leaves
//! is given to others of the same size class, so that memory stays within a small multiple of the windows alive.

use crate::window::Window;
use quadloom_mesh::{EdgeId, EdgeMap};

/// Room of each size class, in windows.
const ROOM: [usize; 12] = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];

/// Where an edge's windows are.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    start: u32,
    len: u32,
    /// Size class plus 1; 0 for no room.
    class: u8,
}

/// One list of windows per edge.
#[derive(Clone, Debug)]
pub(crate) struct EdgeLists {
    span: EdgeMap<Span>,
    pool: Vec<Window>,
    /// Starts of free rooms, per class.
    free: Vec<Vec<u32>>,
}

impl EdgeLists {
    pub fn new(edges: usize) -> Self {
        Self { span: EdgeMap::filled(edges, Span::default()), pool: Vec::new(), free: Vec::new() }
    }

    /// The windows of an edge, ascending.
    #[inline]
    pub fn of(&self, e: EdgeId) -> &[Window] {
        let span = self.span[e];
        &self.pool[span.start as usize..][..span.len as usize]
    }

    #[inline]
    pub fn of_mut(&mut self, e: EdgeId) -> &mut [Window] {
        let span = self.span[e];
        &mut self.pool[span.start as usize..][..span.len as usize]
    }

    /// Forgets the windows of an edge.
    pub fn clear(&mut self, e: EdgeId) {
        let span = std::mem::take(&mut self.span[e]);
        if span.class > 0 {
            self.release(span);
        }
    }

    /// Forgets all but the first windows of an edge.
    pub fn truncate(&mut self, e: EdgeId, len: usize) {
        self.span[e].len = len as u32;
    }

    /// Replaces the windows of an edge.
    pub fn set(&mut self, e: EdgeId, windows: &[Window]) {
        let old = self.span[e];
        if windows.len() > room(old.class) {
            if old.class > 0 {
                self.release(old);
            }
            self.span[e] = self.allocate(windows.len());
        }
        let span = &mut self.span[e];
        span.len = windows.len() as u32;
        self.pool[span.start as usize..][..windows.len()].copy_from_slice(windows);
    }

    fn allocate(&mut self, len: usize) -> Span {
        let class = (1..).find(|&c| room(c) >= len).expect("rooms grow without end");
        if self.free.len() <= class as usize {
            self.free.resize(class as usize + 1, Vec::new());
        }
        let start = self.free[class as usize].pop().unwrap_or_else(|| {
            let start = self.pool.len() as u32;
            let none = Window::circular([0.0; 2], [0.0; 2], 0.0, 0);
            self.pool.resize(self.pool.len() + room(class), none);
            start
        });
        Span { start, len: len as u32, class }
    }

    fn release(&mut self, span: Span) {
        self.free[span.class as usize].push(span.start);
    }
}

/// Room of a class: as in the table, then growing by halves.
fn room(class: u8) -> usize {
    match class as usize {
        0 => 0,
        c if c <= ROOM.len() => ROOM[c - 1],
        c => {
            let step = c - ROOM.len();
            (2 + step % 2) << (5 + step / 2)
        }
    }
}
