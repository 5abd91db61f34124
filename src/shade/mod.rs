//! From hits to colours.
