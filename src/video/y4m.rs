//! The header of a Y4M stream: `YUV4MPEG2`, then parameters of a letter and a value each, on a line.

use super::frame::checked_size;
use super::{PixelFormat, VideoError};

/// The word that a Y4M stream begins with.
pub(super) const MAGIC: &str = "YUV4MPEG2";
/// Colour of a stream that does not tell: that of mjpegtools and ffmpeg.
const DEFAULT: PixelFormat = PixelFormat::Y4M[0];
/// The comment by which ffmpeg tells that codes go from 0 to 255.
const FULL_RANGE: &str = "XCOLORRANGE=FULL";
/// Pixels are square in every picture that a photo is unwrapped to.
const SQUARE: &str = "A1:1";

/// Size and pixels of a stream's frames.
#[derive(Debug, Clone, PartialEq)]
pub struct VideoFormat {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Planes and their samples.
    pub pixels: PixelFormat,
    /// The header's other parameters, in their order; none of raw frames, which have no header.
    parameters: Option<Vec<String>>,
}

impl VideoFormat {
    /// Frames without a header.
    ///
    /// # Errors
    /// [`VideoError::Size`].
    pub fn raw(pixels: PixelFormat, size: [usize; 2]) -> Result<Self, VideoError> {
        Ok(Self { size: checked_size(size)?, pixels, parameters: None })
    }

    /// Whether frames come with a header.
    #[must_use]
    pub fn is_y4m(&self) -> bool {
        self.parameters.is_some()
    }

    /// The format of the same stream with frames of another size and square pixels.
    #[must_use]
    pub fn resized(&self, size: [usize; 2]) -> Self {
        let square = |parameter: &String| match parameter.starts_with('A') {
            true => SQUARE.to_owned(),
            false => parameter.clone(),
        };
        let parameters = self.parameters.as_ref().map(|all| all.iter().map(square).collect());
        Self { size, parameters, ..self.clone() }
    }

    /// The header's line; empty of raw frames.
    #[must_use]
    pub fn header(&self) -> String {
        let Some(parameters) = &self.parameters else { return String::new() };
        let [width, height] = self.size;
        let rest: String = parameters.iter().map(|parameter| format!(" {parameter}")).collect();
        format!("{MAGIC} W{width} H{height}{rest}\n")
    }

    /// The format that a header's line, without its end, tells.
    ///
    /// # Errors
    /// [`VideoError`] by the parameter that cannot be taken.
    pub(super) fn parse(line: &str) -> Result<Self, VideoError> {
        let (mut size, mut pixels) = ([None; 2], DEFAULT);
        let (mut kept, mut is_full) = (Vec::new(), false);
        for parameter in line.split(' ').skip(1).filter(|parameter| !parameter.is_empty()) {
            let (letter, value) =
                parameter.split_at(parameter.chars().next().map_or(0, char::len_utf8));
            match letter {
                "W" => size[0] = Some(side(parameter, value)?),
                "H" => size[1] = Some(side(parameter, value)?),
                "C" => pixels = colour(parameter, value)?,
                "I" => progressive(parameter, value)?,
                "F" => frame_rate(parameter, value)?,
                "A" | "X" => is_full |= parameter == FULL_RANGE,
                _ => {
                    let must = "is no parameter of Y4M (W, H, F, I, A, C and X are); write the stream again";
                    return Err(VideoError::Parameter { parameter: parameter.into(), must });
                }
            }
            if !matches!(letter, "W" | "H") {
                kept.push(parameter.to_owned());
            }
        }
        let width = size[0].ok_or(VideoError::Missing("W, the width"))?;
        let height = size[1].ok_or(VideoError::Missing("H, the height"))?;
        let pixels = if is_full { pixels.full_range() } else { pixels };
        Ok(Self { size: checked_size([width, height])?, pixels, parameters: Some(kept) })
    }
}

fn side(parameter: &str, value: &str) -> Result<usize, VideoError> {
    let must = "must be a whole number of pixels; write the stream again";
    let bad = || VideoError::Parameter { parameter: parameter.into(), must };
    value.parse().map_err(|_| bad())
}

/// Refuses a frame rate that no reader of the output would take.
fn frame_rate(parameter: &str, value: &str) -> Result<(), VideoError> {
    let must = "must be a frame rate of two whole numbers, as F30:1; write the stream again";
    let is_number = |text: &str| text.parse::<u64>().is_ok();
    let fits = value.split_once(':').is_some_and(|(a, b)| is_number(a) && is_number(b));
    fits.then_some(()).ok_or_else(|| VideoError::Parameter { parameter: parameter.into(), must })
}

/// Refuses frames with lines of two moments.
fn progressive(parameter: &str, value: &str) -> Result<(), VideoError> {
    let kind = match value {
        "p" | "?" => return Ok(()),
        "t" => "interlaced, the upper field first",
        "b" => "interlaced, the lower field first",
        "m" => "interlaced and progressive ones, mixed",
        _ => {
            let must = "must be Ip, as progressive frames have it; write the stream again";
            return Err(VideoError::Parameter { parameter: parameter.into(), must });
        }
    };
    Err(VideoError::Interlaced { parameter: parameter.into(), kind })
}

fn colour(parameter: &str, value: &str) -> Result<PixelFormat, VideoError> {
    if let Some(format) = PixelFormat::Y4M.iter().find(|format| format.name == value) {
        return Ok(*format);
    }
    let is_deep = ["420p", "422p", "444p", "mono"].iter().any(|start| {
        let depth = value.strip_prefix(start);
        depth.is_some_and(|depth| depth.parse::<u8>().is_ok_and(|bits| bits > 8))
    });
    let why = match value {
        _ if is_deep => "has more than 8 bits to a value",
        "444alpha" => "has opacity",
        "411" => "has one sample of colour to four pixels of a row",
        _ => "is not known",
    };
    let known: Vec<String> =
        PixelFormat::Y4M.iter().map(|format| format!("C{}", format.name)).collect();
    Err(VideoError::Colour { parameter: parameter.into(), why, known: known.join(", ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_keeps_rate_colour_and_comments_and_gets_the_new_size() {
        let line =
            "YUV4MPEG2 W640 H480 F30000:1001 Ip A4:3 C420mpeg2 XYSCSS=420MPEG2 XCOLORRANGE=FULL";
        let format = VideoFormat::parse(line).unwrap();
        assert_eq!((format.size, format.pixels.name), ([640, 480], "420mpeg2"));
        assert_eq!(format.pixels.black, [0, 128]);
        assert_eq!(
            format.resized([320, 60]).header(),
            "YUV4MPEG2 W320 H60 F30000:1001 Ip A1:1 C420mpeg2 XYSCSS=420MPEG2 XCOLORRANGE=FULL\n"
        );
        let plain = VideoFormat::parse("YUV4MPEG2 H8 W9").unwrap();
        assert_eq!((plain.pixels.name, plain.pixels.black), ("420jpeg", [16, 128]));
        assert_eq!(plain.header(), "YUV4MPEG2 W9 H8\n");
        assert_eq!(VideoFormat::raw(PixelFormat::GRAY8, [9, 8]).unwrap().header(), "");
    }

    #[test]
    fn every_parameter_that_cannot_be_taken_is_refused_by_name() {
        for (parameters, words) in [
            ("W640", "H, the height, is missing"),
            ("H640", "W, the width, is missing"),
            ("W64x H48", "\"W64x\" must be a whole number"),
            ("W640 H480 It", "\"It\" says that the frames are interlaced, the upper field first"),
            ("W640 H480 Ib", "bwdif"),
            ("W640 H480 Im", "mixed"),
            ("W640 H480 Ix", "\"Ix\" must be Ip"),
            ("W640 H480 C420p10", "\"C420p10\" has more than 8 bits"),
            ("W640 H480 Cmono16", "\"Cmono16\" has more than 8 bits"),
            ("W640 H480 C444alpha", "opacity"),
            ("W640 H480 C411", "four pixels"),
            ("W640 H480 C999", "\"C999\" is not known"),
            ("W640 H480 F30", "\"F30\" must be a frame rate"),
            ("W640 H480 Q1", "\"Q1\" is no parameter"),
            ("W7 H480", "7 x 480 pixels"),
            ("W65536 H480", "65536 x 480"),
            ("W60000 H60000", "60000 x 60000"),
            ("W99999999999999999999 H1", "must be a whole number"),
        ] {
            let error = VideoFormat::parse(&format!("{MAGIC} {parameters}")).unwrap_err();
            assert!(error.to_string().contains(words), "{parameters}: {error}");
        }
    }
}
