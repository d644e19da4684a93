//! Integration tests, one binary.

mod pictures;
