//! Frames of a video and folders of pictures: against the cubic in closed form, against still pictures, and as streams.

use super::files::{home, npy, picture, read, unwrapped};
use crate::support::builds::{command, files, morion, told};
use crate::support::refused;
use std::io::Write;
use std::path::Path;
use std::process::{Output, Stdio};

/// Runs `morion unwrap -` on a stream.
fn streamed(home: &Path, arguments: &str, stream: &[u8]) -> Output {
    let mut program = command(home);
    program.args(["unwrap", "-", "-q"]).args(arguments.split(' '));
    program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut program = program.spawn().unwrap();
    let mut input = program.stdin.take().unwrap();
    let stream = stream.to_vec();
    // (It may end before it has read all.)
    let writing = std::thread::spawn(move || drop(input.write_all(&stream)));
    let output = program.wait_with_output().unwrap();
    writing.join().unwrap();
    output
}

/// The frames that come out.
#[track_caller]
fn frames(home: &Path, arguments: &str, stream: &[u8]) -> Vec<u8> {
    let output = streamed(home, arguments, stream);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    output.stdout
}

/// A Y4M stream of frames.
fn y4m(header: &str, frames: &[Vec<u8>]) -> Vec<u8> {
    let mut stream = format!("YUV4MPEG2 {header}\n").into_bytes();
    for frame in frames {
        stream.extend(b"FRAME\n");
        stream.extend(frame);
    }
    stream
}

/// Grey that grows to the right and downwards.
fn ramp() -> Vec<u8> {
    (0..120 * 160).map(|k| (k % 160 / 2 + k / 160) as u8).collect()
}

/// Between samples of a ramp of one code value the cubic of Keys with a = -3/4 is off by t/2 - 3/2 t^2 + t^3.
#[test]
fn a_ramp_is_resampled_as_the_cubic_has_it_in_closed_form() {
    let home = home();
    let home = home.path();
    unwrapped(home, "photo.png --profile folded.toml --map npy");
    let ([rows, columns, _], places) = npy(&read(home, "photo-map.npy"));
    let across: Vec<u8> = (0..120 * 160).map(|k| (k % 160) as u8).collect();
    let down: Vec<u8> = (0..120 * 160).map(|k| (k / 160) as u8).collect();
    let arguments = "--raw gray8 --profile folded.toml";
    let found = frames(home, arguments, &[across, down].concat());
    assert_eq!(found.len(), 2 * rows * columns);
    let wanted = |place: f32| {
        let place = (f64::from(place) * 32.0).round() / 32.0;
        let t = place - place.floor();
        place + t * (0.5 + t * (t - 1.5))
    };
    let mut compared = 0;
    for (k, place) in places.iter().enumerate() {
        if *place == [-1.0; 2] {
            assert_eq!([found[k], found[rows * columns + k]], [0, 0]);
            continue;
        }
        // Away from edges of the frame and of the panels, beyond which their samples repeat.
        let is_inside = (2.0..157.0).contains(&place[0]);
        let is_on_a_panel = (2.0..57.0).contains(&place[1]) || (62.0..117.0).contains(&place[1]);
        if is_inside && is_on_a_panel {
            let off = [0, 1]
                .map(|axis| f64::from(found[axis * rows * columns + k]) - wanted(place[axis]));
            // Half a code value, and a step of 1/32 by a place half-way between two.
            assert!(off.iter().all(|off| off.abs() <= 0.5 + 1.0 / 16.0), "{place:?} {off:?}");
            compared += 1;
        }
    }
    assert!(10 * compared > 8 * rows * columns, "{compared}");
}

#[test]
fn a_smooth_frame_is_nearly_the_still_picture() {
    let home = home();
    let home = home.path();
    let photo = picture(160, 120);
    unwrapped(home, "photo.png --profile folded.toml");
    let still =
        morion::internals::raster::Raster::decode(&read(home, "photo-unwrapped.png")).unwrap();
    let codes = |raster: &morion::internals::raster::Raster| -> Vec<u8> {
        let code = morion::internals::raster::srgb::encode;
        raster.rgb.iter().flatten().map(|light| code(*light)).collect()
    };
    let found = frames(home, "--raw rgb24 --profile folded.toml", &codes(&photo));
    let still = codes(&still);
    assert_eq!(found.len(), still.len());
    let off = found.iter().zip(&still).map(|(a, b)| a.abs_diff(*b));
    let near = off.filter(|off| *off <= 2).count();
    // All but what lies at edges of what is seen.
    assert!(near as f64 > 0.98 * still.len() as f64, "{near} of {}", still.len());
}

#[test]
fn a_stream_keeps_its_header_and_each_of_its_frames() {
    let home = home();
    let home = home.path();
    for (tag, chroma) in [
        ("420jpeg", 2 * 80 * 60),
        ("420mpeg2", 2 * 80 * 60),
        ("420paldv", 2 * 80 * 60),
        ("422", 2 * 80 * 120),
        ("444", 2 * 160 * 120),
        ("mono", 0),
    ] {
        let frame = |colour: u8| {
            let mut frame = ramp();
            frame.extend(vec![colour; chroma]);
            frame
        };
        let header = format!("W160 H120 F30000:1001 Ip A4:3 C{tag} XYSCSS=ANY");
        let stream = y4m(&header, &[frame(90), frame(91), frame(90)]);
        let found = frames(home, "--profile folded.toml --width 320", &stream);
        let end = found.iter().position(|byte| *byte == b'\n').unwrap();
        assert_eq!(
            String::from_utf8_lossy(&found[..end]),
            format!("YUV4MPEG2 W320 H60 F30000:1001 Ip A1:1 C{tag} XYSCSS=ANY")
        );
        let size = 320 * 60 + chroma * 320 * 60 / (160 * 120);
        let each: Vec<&[u8]> = found[end + 1..].chunks(6 + size).collect();
        assert_eq!((each.len(), each[2].len()), (3, 6 + size), "{tag}");
        assert!(each.iter().all(|frame| frame.starts_with(b"FRAME\n")));
        // The same frame is the same again; an even colour stays, but for black where nothing is seen.
        assert!(each[0] == each[2] && (chroma == 0 || each[0] != each[1]), "{tag}");
        let is_even = each[1][6 + 320 * 60..].iter().all(|code| [91, 128].contains(code));
        assert!(is_even, "{tag}");
    }
}

#[test]
fn the_number_of_threads_does_not_show_in_frames() {
    let home = home();
    let home = home.path();
    let stream = y4m("W160 H120 F25:1 Cmono", &[ramp(), ramp()]);
    let found = |threads: usize| {
        frames(home, &format!("--profile folded.toml --threads {threads}"), &stream)
    };
    assert!(found(1) == found(3));
}

#[test]
fn the_report_of_a_stream_goes_to_stderr() {
    let home = home();
    let stream = y4m("W160 H120 F25:1 Cmono", &[ramp(), ramp()]);
    let output = streamed(home.path(), "--profile folded.toml --format json", &stream);
    let report: serde_json::Value = serde_json::from_slice(&output.stderr).unwrap();
    assert_eq!(report["frames"], serde_json::json!({ "format": "mono", "count": 2 }));
    assert_eq!(report["photo"]["name"], "-");
    assert_eq!(report["files"], serde_json::json!([]));
    assert!(!home.path().join("out").exists());
}

#[test]
fn pictures_of_a_folder_are_those_of_each_alone() {
    let home = home();
    let home = home.path();
    std::fs::create_dir(home.join("drive")).unwrap();
    let save =
        |name: &str, bytes: &[u8]| std::fs::write(home.join("drive").join(name), bytes).unwrap();
    save("b.png", &picture(160, 120).to_png().unwrap());
    let mut other = picture(160, 120);
    other.rgb.reverse();
    save("a.png", &other.to_png().unwrap());
    save("notes.txt", b"none");
    let report = unwrapped(home, "drive --profile folded.toml --map npy");
    assert_eq!(report["frames"], serde_json::json!({ "format": "pictures", "count": 2 }));
    let made = files(&home.join("out/folded/drive-unwrapped"));
    assert_eq!(made.keys().collect::<Vec<_>>(), ["a.png", "b.png", "map.npy"]);
    for name in ["a", "b"] {
        unwrapped(home, &format!("drive/{name}.png --profile folded.toml --map npy"));
        assert!(made[&format!("{name}.png")] == read(home, &format!("{name}-unwrapped.png")));
        assert!(made["map.npy"] == read(home, &format!("{name}-map.npy")));
    }
    // One picture that cannot be taken: nothing is written.
    save("c.png", &picture(80, 60).to_png().unwrap());
    std::fs::remove_dir_all(home.join("out")).unwrap();
    let refusal = ["unwrap", "-q", "drive", "--profile", "folded.toml"];
    refused(home, &refusal, &["c.png has 80 x 60 pixels", "160 x 120"]);
    assert!(files(&home.join("out/folded/drive-unwrapped")).is_empty());
    std::fs::create_dir(home.join("empty")).unwrap();
    let refusal = ["unwrap", "-q", "empty", "--profile", "folded.toml"];
    refused(home, &refusal, &["empty: there is no PNG, JPEG or EXR"]);
}

#[test]
fn a_stream_that_cannot_be_read_on_leaves_whole_frames_and_one_error() {
    let home = home();
    let home = home.path();
    let whole = y4m("W160 H120 F25:1 Cmono", &[ramp(), ramp()]);
    let output = streamed(home, "--profile folded.toml", &whole[..whole.len() - 5]);
    let (code, said) = (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned());
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("standard input: frame 2 ends after 19195 of its 19200 bytes"), "{said}");
    let first = frames(home, "--profile folded.toml", &y4m("W160 H120 F25:1 Cmono", &[ramp()]));
    assert!(output.stdout == first);
    for (arguments, stream, words) in [
        ("--profile folded.toml", &b""[..], "nothing comes in"),
        ("--profile folded.toml", b"\x89PNG\r\n\x1a\n", "is not the YUV4MPEG2"),
        ("--profile folded.toml", b"YUV4MPEG2 W160 H120 It\n", "deinterlace them first"),
        ("--profile folded.toml", b"YUV4MPEG2 W160 H120 C420p10\n", "more than 8 bits"),
        ("--profile folded.toml", b"YUV4MPEG2 W160 H100\n", "160 x 100"),
        ("--profile given.toml", b"YUV4MPEG2 W160 H120\n", "given has no [projection]"),
        ("--profile folded.toml --map npy", b"", "--map writes a file"),
        ("--profile folded.toml --out there", b"", "--out is a folder"),
        ("--profile folded.toml --raw rgb24 --pixels 160", b"", "as in 1280x720"),
    ] {
        let (code, out, said) = told(&streamed(home, arguments, stream));
        assert_eq!((code, &*out), (2, ""), "{said}");
        assert!(said.contains(words) && said.matches("error: ").count() == 1, "{said}");
    }
    let (code, _, said) =
        told(&morion(home, &["unwrap", "photo.png", "--profile", "folded.toml", "--raw", "gray8"]));
    assert!(code == 2 && said.contains("write - in the place of the photo"), "{said}");
}

/// Who reads the frames may go away.
#[test]
#[cfg(unix)]
fn a_reader_that_goes_away_is_no_error() {
    let home = home();
    let stream = y4m("W160 H120 F25:1 Cmono", &vec![ramp(); 40]);
    let mut program = command(home.path());
    program.args(["unwrap", "-", "-q", "--profile", "folded.toml"]);
    program.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut program = program.spawn().unwrap();
    drop(program.stdout.take());
    let mut input = program.stdin.take().unwrap();
    let _ = input.write_all(&stream);
    drop(input);
    let output = program.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
