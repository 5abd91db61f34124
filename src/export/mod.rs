//! Writes pictures to any `io::Write`.
