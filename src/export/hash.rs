//! SHA-256 hashes, by which scripts tell pictures apart.

use sha2::{Digest, Sha256};

use super::for_each_rgb_row;
use crate::frame::Frame;

/// Collects bytes into a SHA-256.
#[derive(Clone, Debug, Default)]
pub struct Hasher(Sha256);

impl Hasher {
    /// Takes in more bytes.
    pub fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The hash of all bytes so far, 64 lower-case hexadecimal digits.
    #[must_use]
    pub fn finish(self) -> String {
        self.0
            .finalize()
            .iter()
            .map(|b| format!("{b:02x}"))
            .collect()
    }
}

/// The SHA-256 of the picture as a binary PPM file (`P6\nW H\n255\n`, then R, G, B of each pixel).
#[must_use]
pub fn picture_hash(frame: &Frame) -> String {
    let mut hasher = Hasher::default();
    hasher.update(format!("P6\n{} {}\n255\n", frame.width, frame.height).as_bytes());
    for_each_rgb_row(frame, |row| {
        hasher.update(row);
        Ok(())
    })
    .expect("hashing cannot fail");
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_ppm_file() {
        // printf 'P6\n1 1\n255\nabc' | sha256sum
        let frame = Frame {
            width: 1,
            height: 1,
            pixels: vec![0x0061_6263],
        };
        let mut file = Hasher::default();
        file.update(b"P6\n1 1\n255\nabc");
        assert_eq!(picture_hash(&frame), file.finish());
        let mut abc = Hasher::default();
        abc.update(b"abc");
        assert_eq!(
            abc.finish(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
