//! Maps of disk-shaped tiles to the plane.
