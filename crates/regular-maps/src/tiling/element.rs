//! Elements of the tiling's own group, told apart without rounding.
//!
//! In: p and q. Out: [`ElementGroup`], which multiplies [`Element`]s by reflections.
//! Holds: equal elements are always equal here, so elements that differ here do differ. Not proved: the converse; an
//! element other than 1 would have to be 1 modulo a prime of 61 bits in all its nine entries.
//! Source: Tits' representation of the Coxeter group ⟨r₀, r₁, r₂ | r₀², r₁², r₂², (r₀r₁)^p, (r₁r₂)^q, (r₀r₂)²⟩, which is
//! faithful: rᵢ takes eᵢ to −eᵢ and eⱼ to eⱼ + 2 cos(π/mᵢⱼ) eᵢ. Here 2 cos(π/m) is z + 1/z, z of order 2m modulo the prime.

use crate::map::Reflection;

/// An element of the group: the columns of its matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Element([[u64; 3]; 3]);

impl Element {
    pub(super) const ONE: Self = Self([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
}

/// The group of the tiling {p, q}.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementGroup {
    prime: u64,
    /// 2 cos(π/mᵢⱼ).
    cosines: [[u64; 3]; 3],
}

impl ElementGroup {
    pub(super) fn of_type(p: usize, q: usize) -> Self {
        let (p, q) = (p as u64, q as u64);
        let prime = prime_that_splits(2 * p / gcd(p, q) * q);
        let [a, b] = [p, q].map(|m| double_cosine(m, prime));
        Self { prime, cosines: [[0, a, 0], [a, 0, b], [0, b, 0]] }
    }

    /// The product of an element and a reflection.
    pub(super) fn times(&self, element: Element, by: Reflection) -> Element {
        let i = by as usize;
        let axis = element.0[i];
        let mut columns = element.0;
        for (j, column) in columns.iter_mut().enumerate() {
            for (entry, &a) in column.iter_mut().zip(&axis) {
                *entry = if j == i {
                    (self.prime - a) % self.prime
                } else {
                    (*entry + times(self.cosines[i][j], a, self.prime)) % self.prime
                };
            }
        }
        Element(columns)
    }
}

/// The largest prime below 2⁶¹ that is 1 modulo n: there the n-th roots of unity are numbers.
fn prime_that_splits(n: u64) -> u64 {
    let mut candidate = ((1 << 61) - 2) / n * n + 1;
    while !is_prime(candidate) {
        candidate -= n;
    }
    candidate
}

/// z + 1/z for the first z of order 2m.
fn double_cosine(m: u64, prime: u64) -> u64 {
    let order = 2 * m;
    let is_exact = |z: u64| prime_factors(order).all(|l| power(z, order / l, prime) != 1);
    let root = (2..).map(|a| power(a, (prime - 1) / order, prime)).find(|&z| is_exact(z)).unwrap_or(1);
    (root + power(root, order - 1, prime)) % prime
}

fn prime_factors(mut n: u64) -> impl Iterator<Item = u64> {
    (2..=n).filter(move |&l| {
        let divides = n.is_multiple_of(l);
        while n.is_multiple_of(l) {
            n /= l;
        }
        divides
    })
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn times(a: u64, b: u64, prime: u64) -> u64 {
    (u128::from(a) * u128::from(b) % u128::from(prime)) as u64
}

fn power(base: u64, mut exponent: u64, prime: u64) -> u64 {
    let (mut square, mut result) = (base % prime, 1);
    while exponent > 0 {
        if exponent & 1 == 1 {
            result = times(result, square, prime);
        }
        square = times(square, square, prime);
        exponent >>= 1;
    }
    result
}

/// Miller and Rabin's test to the first twelve primes, which is no chance below 2⁶⁴ (Sorenson and Webster).
fn is_prime(n: u64) -> bool {
    const BASES: [u64; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    if n < 2 || BASES.iter().any(|&b| n.is_multiple_of(b)) {
        return BASES.contains(&n);
    }
    let twos = (n - 1).trailing_zeros();
    BASES.iter().all(|&base| {
        let mut x = power(base, (n - 1) >> twos, n);
        let mut passes = x == 1 || x == n - 1;
        for _ in 1..twos {
            x = times(x, x, n);
            passes |= x == n - 1;
        }
        passes
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use Reflection::{R0, R1, R2};

    #[test]
    fn products_have_their_orders() {
        for (p, q) in [(2, 7), (3, 7), (4, 4), (5, 10), (84, 84), (9, 2)] {
            let group = ElementGroup::of_type(p, q);
            for (pair, order) in [([R0, R1], p), ([R1, R2], q), ([R0, R2], 2), ([R0, R0], 1)] {
                let mut at = Element::ONE;
                for n in 1..=order {
                    at = pair.iter().fold(at, |g, &by| group.times(g, by));
                    assert_eq!(at == Element::ONE, n == order, "{{{p},{q}}} {pair:?} {n}");
                }
            }
        }
    }

    #[test]
    fn primes_are_known() {
        let small: Vec<u64> = (0..60).filter(|&n| is_prime(n)).collect();
        assert_eq!(small, [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59]);
        assert!(is_prime((1 << 61) - 1) && !is_prime(3_215_031_751));
        assert_eq!(prime_factors(360).collect::<Vec<_>>(), [2, 3, 5]);
    }
}
