//! Builds and checks the bounding volume hierarchy.
