//! Which triangle each pixel's ray hits.
