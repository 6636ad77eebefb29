//! Polygonal schemas as words.
