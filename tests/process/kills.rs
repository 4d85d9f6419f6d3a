//! Builds that are killed.

use crate::builds::{assert_same, files, lasting};
use crate::draws::Draws;
use crate::thorough::times;
use crate::whole::{Home, temporary};
use std::os::unix::fs::MetadataExt;
use std::time::{Duration, Instant};

/// The next build succeeds, makes what it would have made without the one that was killed, and
/// leaves nothing of that one.
#[track_caller]
fn next_build_mends(home: &Home) {
    let output = home.start().wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_same(&lasting(files(&home.made())), &lasting(home.new.clone()), "after a kill");
}

#[test]
fn a_build_killed_at_any_moment_leaves_whole_files_and_the_next_one_mends() {
    let home = Home::new();
    let made = home.made();
    let begun = Instant::now();
    assert!(home.start().wait().unwrap().success());
    let whole_run = begun.elapsed();

    let mut random = Draws::new(20);
    let (mut counts, mut left) = (Vec::new(), 0);
    let moments = times(20, 200);
    for moment in 0..moments {
        home.put_back();
        let mut child = home.start();
        // The first one at once; some after the end.
        let share = if moment == 0 { 0.0 } else { random.inside([0.0, 1.1]) };
        std::thread::sleep(whole_run.mul_f64(share));
        child.kill().unwrap();
        child.wait().unwrap();
        counts.push(home.all_whole());
        left += usize::from(temporary(&made) > 0);
        next_build_mends(&home);
    }
    // And as soon as each of the files has got its name.
    for name in home.old.keys() {
        home.put_back();
        // Between the old one and the new one there may be none.
        let inode = || std::fs::metadata(made.join(name)).ok().map(|found| found.ino());
        let (before, mut child, deadline) =
            (inode(), home.start(), Instant::now() + Duration::from_secs(60));
        while inode().is_none_or(|found| Some(found) == before) {
            assert!(Instant::now() < deadline, "{name} never changes");
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let count = home.all_whole();
        assert!(count > 0, "{name}");
        counts.push(count);
        next_build_mends(&home);
    }
    println!("{moments} moments: {left} left temporary files; files renewed: {counts:?}");
    assert!(counts.contains(&0) && counts.contains(&home.old.len()), "{counts:?}");
    assert!(left > 0, "no build was killed while it wrote");
}
