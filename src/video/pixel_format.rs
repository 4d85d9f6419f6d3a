//! How the samples of a frame lie: which planes there are, and where the samples of each are.

/// Least pixels of a side: a plane of colour with half of them is as wide as the kernel.
pub(super) const LEAST_SIDE: usize = 8;

/// Places of a plane's samples, in pixels from the left and the upper edge of the frame: sample k of an axis is at `first + k * step`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneGrid {
    /// Pixels from sample to sample, across and down.
    pub step: [usize; 2],
    /// Place of the first sample, px.
    pub first: [f64; 2],
}

impl PlaneGrid {
    /// A sample in the middle of each pixel.
    pub const PIXELS: Self = Self { step: [1; 2], first: [0.5; 2] };

    /// Samples across and down in a frame of `size` pixels.
    #[must_use]
    pub fn count(&self, size: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|k| size[k].div_ceil(self.step[k]))
    }

    /// The pixels of a row (axis 0) or a column (axis 1) of `count` between whose centres sample `k` is: the same one twice where it is at a
    /// centre.
    #[must_use]
    pub fn pixels(&self, axis: usize, k: usize, count: usize) -> [usize; 2] {
        let at = (k * self.step[axis]) as f64 + self.first[axis] - 0.5;
        [at.floor(), at.ceil()].map(|pixel| (pixel as usize).min(count - 1))
    }

    /// Place on the plane, in samples from the first one's centre, of a place of the frame, px.
    #[must_use]
    pub fn sample(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (place[k] - self.first[k]) / self.step[k] as f64)
    }
}

/// Arrangement of the code values of a frame in a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelFormat {
    /// Name: of Y4M that of its colour tag, of raw frames ffmpeg's.
    pub name: &'static str,
    /// Planes of colour after the first, and where their samples are.
    pub others: Option<PlaneGrid>,
    /// Whether the values of a pixel follow each other, in the place of planes.
    pub interleaved: bool,
    /// Code of the first plane, and of the others, that is black.
    pub black: [u8; 2],
}

/// Black in BT.601's and BT.709's limited range, which is that of Y4M unless the header tells another.
const LIMITED: [u8; 2] = [16, 128];
/// Centred between the pixels, as in JPEG and MPEG-1.
const CENTRED: [f64; 2] = [1.0, 1.0];
/// At the left pixels' centres, between the rows, as in MPEG-2 and H.264.
const LEFT: [f64; 2] = [0.5, 1.0];
/// At the upper left pixel's centre. (ffmpeg reads 420paldv so.)
const UPPER_LEFT: [f64; 2] = [0.5, 0.5];

impl PixelFormat {
    /// The colour tags of Y4M that are read: C and the name. (Siting as of mjpegtools' yuv4mpeg(5) and ffmpeg's yuv4mpegdec.c.)
    pub const Y4M: [Self; 7] = [
        Self::y4m("420jpeg", [2, 2], CENTRED),
        Self::y4m("420mpeg2", [2, 2], LEFT),
        Self::y4m("420paldv", [2, 2], UPPER_LEFT),
        Self::y4m("420", [2, 2], CENTRED),
        Self::y4m("422", [2, 1], UPPER_LEFT),
        Self::y4m("444", [1, 1], UPPER_LEFT),
        Self { name: "mono", others: None, interleaved: false, black: LIMITED },
    ];
    /// Red, green and blue of each pixel.
    pub const RGB24: Self =
        Self { name: "rgb24", others: Some(PlaneGrid::PIXELS), interleaved: true, black: [0; 2] };
    /// Grey.
    pub const GRAY8: Self = Self { name: "gray8", others: None, interleaved: false, black: [0; 2] };

    const fn y4m(name: &'static str, step: [usize; 2], first: [f64; 2]) -> Self {
        let others = Some(PlaneGrid { step, first });
        Self { name, others, interleaved: false, black: LIMITED }
    }

    /// The same with black at 0, as in full range.
    pub(super) fn full_range(self) -> Self {
        Self { black: [0, self.black[1]], ..self }
    }

    /// Where the samples of each plane are.
    pub fn grids(&self) -> impl Iterator<Item = PlaneGrid> {
        std::iter::once(PlaneGrid::PIXELS).chain(self.others).chain(self.others)
    }

    /// Black of plane `k`.
    #[must_use]
    pub fn black_of(&self, k: usize) -> u8 {
        self.black[k.min(1)]
    }

    /// Bytes of a frame of `size` pixels.
    #[must_use]
    pub fn bytes(&self, size: [usize; 2]) -> usize {
        self.grids().map(|grid| grid.count(size).iter().product::<usize>()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_colour_are_where_the_tag_puts_them() {
        let grid = |name: &str| {
            PixelFormat::Y4M.iter().find(|format| format.name == name).unwrap().others.unwrap()
        };
        for (name, second, pixels) in [
            ("420jpeg", [3.0, 3.0], [[2, 3], [2, 3]]),
            ("420mpeg2", [2.5, 3.0], [[2, 2], [2, 3]]),
            ("420paldv", [2.5, 2.5], [[2, 2], [2, 2]]),
            ("422", [2.5, 1.5], [[2, 2], [1, 1]]),
            ("444", [1.5, 1.5], [[1, 1], [1, 1]]),
        ] {
            let grid = grid(name);
            assert_eq!(grid.sample(second), [1.0; 2], "{name}");
            assert_eq!([0, 1].map(|axis| grid.pixels(axis, 1, 9)), pixels, "{name}");
        }
        assert_eq!(grid("420jpeg").count([5, 4]), [3, 2]);
        assert_eq!(grid("420jpeg").pixels(0, 2, 5), [4, 4]);
        assert_eq!(PixelFormat::Y4M[0].bytes([5, 3]), 15 + 2 * 6);
        assert_eq!(PixelFormat::RGB24.bytes([5, 3]), 45);
    }
}
