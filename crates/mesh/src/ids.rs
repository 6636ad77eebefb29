//! Typed 32-bit ids and the id-typed maps that go with them.
//!
//! In: an element count. Out: ids that cannot be mixed up, and dense maps indexed by them.
//! Holds: an id is four bytes; a map has one entry per element, in id order.

use serde::{Deserialize, Serialize};
use std::marker::PhantomData;
use std::ops::{Index, IndexMut};

/// A dense 32-bit element id.
pub trait Id: Copy + Eq + Ord + std::hash::Hash + std::fmt::Debug + Send + Sync + 'static {
    /// The id of element number `index`.
    fn new(index: usize) -> Self;
    /// The element's number, from 0.
    fn index(self) -> usize;
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub u32);

        impl Id for $name {
            #[inline]
            fn new(index: usize) -> Self {
                debug_assert!(index < u32::MAX as usize);
                Self(index as u32)
            }
            #[inline]
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl $name {
            /// The id of element number `index`.
            #[inline]
            pub fn new(index: usize) -> Self {
                <Self as Id>::new(index)
            }
            /// The element's number, from 0.
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl std::fmt::Debug for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                write!(f, "{}", self.0)
            }
        }
    };
}

id!(
    /// A vertex.
    VertexId, "v"
);
id!(
    /// A half-edge: side `k` of a face, from the face's corner `k` to the next. It names that corner too.
    HalfEdgeId, "h"
);
id!(
    /// An undirected edge; its canonical half-edge is the one with the smallest id.
    EdgeId, "e"
);
id!(
    /// A face.
    FaceId, "f"
);

/// A corner of a face is named by the half-edge that leaves it inside the face.
pub type CornerId = HalfEdgeId;

/// One value per element, indexed by a typed id.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct IdMap<I, T> {
    values: Vec<T>,
    #[serde(skip)]
    id: PhantomData<fn(I) -> I>,
}

/// One value per vertex.
pub type VertexMap<T> = IdMap<VertexId, T>;
/// One value per half-edge.
pub type HalfEdgeMap<T> = IdMap<HalfEdgeId, T>;
/// One value per corner.
pub type CornerMap<T> = IdMap<CornerId, T>;
/// One value per edge.
pub type EdgeMap<T> = IdMap<EdgeId, T>;
/// One value per face.
pub type FaceMap<T> = IdMap<FaceId, T>;

impl<I: Id, T> IdMap<I, T> {
    /// A map of `len` copies of `value`.
    pub fn filled(len: usize, value: T) -> Self
    where
        T: Clone,
    {
        Self::from_vec(vec![value; len])
    }

    /// A map whose entry `i` is `values[i]`.
    pub fn from_vec(values: Vec<T>) -> Self {
        Self { values, id: PhantomData }
    }

    /// A map of `len` entries computed from their ids, in id order.
    pub fn from_fn(len: usize, mut value: impl FnMut(I) -> T) -> Self {
        Self::from_vec((0..len).map(|i| value(I::new(i))).collect())
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no entry.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// All ids, ascending.
    pub fn ids(&self) -> impl DoubleEndedIterator<Item = I> + ExactSizeIterator + use<I, T> {
        (0..self.values.len()).map(I::new)
    }

    /// All entries with their ids, ascending.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (I, &T)> + ExactSizeIterator {
        self.values.iter().enumerate().map(|(i, v)| (I::new(i), v))
    }

    /// All values in id order.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values in id order, mutable.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The values alone.
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// Appends an entry and returns its id.
    pub fn push(&mut self, value: T) -> I {
        self.values.push(value);
        I::new(self.values.len() - 1)
    }

    /// The entry of `id`, if there is one.
    pub fn get(&self, id: I) -> Option<&T> {
        self.values.get(id.index())
    }

    /// A map of the same length with every value replaced.
    pub fn map<U>(&self, value: impl FnMut(&T) -> U) -> IdMap<I, U> {
        IdMap::from_vec(self.values.iter().map(value).collect())
    }
}

impl<I: Id, T> Index<I> for IdMap<I, T> {
    type Output = T;
    #[inline]
    fn index(&self, id: I) -> &T {
        &self.values[id.index()]
    }
}

impl<I: Id, T> IndexMut<I> for IdMap<I, T> {
    #[inline]
    fn index_mut(&mut self, id: I) -> &mut T {
        &mut self.values[id.index()]
    }
}

impl<I, T: std::fmt::Debug> std::fmt::Debug for IdMap<I, T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.values.fmt(f)
    }
}

impl<I: Id, T> FromIterator<T> for IdMap<I, T> {
    fn from_iter<S: IntoIterator<Item = T>>(iter: S) -> Self {
        Self::from_vec(iter.into_iter().collect())
    }
}
