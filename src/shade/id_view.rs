//! A colour for each triangle's number: the report's id picture.

/// Neighbouring numbers get colours far apart, the same in every picture; none is black.
/// The mixing function is from Wellons, "Prospecting for hash functions", 2018 (lowbias32).
#[must_use]
pub fn color(id: u32) -> u32 {
    let mut h = id.wrapping_add(1);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    // Each channel from 48 to 255.
    let channel = |shift: u32| 48 + (h >> shift & 255) * 207 / 255;
    channel(16) << 16 | channel(8) << 8 | channel(0)
}

#[cfg(test)]
mod tests {
    use super::color;

    #[test]
    fn neighbours_differ_clearly_and_none_is_black() {
        for id in 0..10_000 {
            let (a, b) = (color(id).to_be_bytes(), color(id + 1).to_be_bytes());
            let apart: i32 = (1..4)
                .map(|i| (i32::from(a[i]) - i32::from(b[i])).abs())
                .sum();
            assert!(apart > 5, "{id} and its neighbour differ by {apart}");
            assert!(a[1..].iter().all(|&c| c >= 48));
        }
    }
}
