//! What can go wrong with groups and maps.

use quadloom_mesh::Cancelled;

/// Why there is no map, match or surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MapError {
    /// A word or presentation cannot be read.
    #[error("{text:?}, character {at}: {what}; words are made of R, S, T (or r0, r1, r2), as in (R*S^-1)^2*T")]
    Syntax {
        /// What was to be read.
        text: String,
        /// Position of the offending character, from 1.
        at: usize,
        /// What is wrong there.
        what: String,
    },
    /// A presentation without R^p or S^q.
    #[error("the presentation has no relator {0}^n with n of at least 2, so the type {{p,q}} is unknown; add it")]
    NoType(char),
    /// A presentation with two powers of one rotation.
    #[error(
        "the presentation has both {0}^{1} and {0}^{2}; give the one that counts the {side}",
        side = if *.0 == 'R' { "corners of a face" } else { "corners at a vertex" }
    )]
    TwoTypes(char, usize, usize),
    /// The relators make a rotation shorter than they say.
    #[error(
        "the presentation says {letter}^{said}, but its other relators make the order of {letter} {found}: \
         no map of this type has this group"
    )]
    WrongOrder {
        /// R or S, or a reflection.
        letter: String,
        /// Order that was asked for.
        said: usize,
        /// Order that follows.
        found: usize,
    },
    /// More cosets than allowed.
    #[error("more than {0} cosets: the group is infinite or too large; add relators")]
    TooLarge(usize),
    /// A table that is no regular map.
    #[error("this is no regular map: {0}")]
    NotRegular(String),
    /// A map on a surface that is not orientable.
    #[error("{0} lies on a surface that is not orientable; only orientable maps can be drawn on a solid")]
    NotOrientable(String),
    /// Stopped from outside.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
