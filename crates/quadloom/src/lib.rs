//! quadloom
