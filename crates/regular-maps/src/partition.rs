//! Disjoint sets over dense indices.
//!
//! In: a number of elements and pairs to join. Out: the sets, numbered by their smallest element.
//! Holds: numbers do not depend on the order of the joins. Source: Tarjan's path halving.

/// Disjoint sets; each is named by its smallest element.
#[derive(Clone, Debug)]
pub(crate) struct Partition {
    parent: Vec<u32>,
}

impl Partition {
    pub(crate) fn new(len: usize) -> Self {
        Self { parent: (0..len as u32).collect() }
    }

    pub(crate) fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] as usize != i {
            let grandparent = self.parent[self.parent[i] as usize];
            self.parent[i] = grandparent;
            i = grandparent as usize;
        }
        i
    }

    /// Joins two sets; false if they were one already.
    pub(crate) fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b)] = a.min(b) as u32;
        a != b
    }

    /// The number of each element's set, and how many sets there are.
    pub(crate) fn numbered(mut self) -> (Vec<u32>, usize) {
        let mut number = vec![0; self.parent.len()];
        let mut count = 0;
        for i in 0..number.len() {
            let root = self.root(i);
            if root == i {
                number[i] = count;
                count += 1;
            } else {
                number[i] = number[root];
            }
        }
        (number, count as usize)
    }
}
