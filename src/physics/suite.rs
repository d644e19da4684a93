//! shared derivative suite
