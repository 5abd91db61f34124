//! The original report's method as printed.
