//! 8-bit colours and the packing of a frame's pixels.

/// A colour with 8 bits a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Rgb {
    /// Red, 0..=255.
    pub r: u8,
    /// Green, 0..=255.
    pub g: u8,
    /// Blue, 0..=255.
    pub b: u8,
}

impl Rgb {
    /// Black, the background.
    pub const BLACK: Rgb = Rgb::new(0, 0, 0);

    /// A colour from its channels.
    #[must_use]
    pub const fn new(r: u8, g: u8, b: u8) -> Rgb {
        Rgb { r, g, b }
    }

    /// `0x00RRGGBB`, a pixel of a frame.
    #[must_use]
    pub const fn packed(self) -> u32 {
        (self.r as u32) << 16 | (self.g as u32) << 8 | self.b as u32
    }

    /// The colour of a frame's pixel; the top byte is ignored.
    #[must_use]
    pub const fn from_packed(pixel: u32) -> Rgb {
        let [_, r, g, b] = pixel.to_be_bytes();
        Rgb { r, g, b }
    }
}
