//! A table as a header of C: whole numbers of 16 bits, and functions that read them.

use super::BilinearField;
use std::fmt::Write;

/// Most steps of a number in a table.
pub const MOST_STEPS: f64 = 32_767.0;
/// Numbers to a line.
const TO_A_LINE: usize = 16;
/// The least number stands for none.
const NONE: i16 = i16::MIN;

/// The header of a profile's tables: directions projected with the sign `pole`, and places of the floor, if there is one; and how many
/// bytes its tables take.
#[must_use]
pub fn c_header(
    comments: &[String],
    (directions, pole): (&BilinearField, f64),
    floor: Option<&BilinearField>,
) -> (String, usize) {
    let grid = directions.grid;
    let [[columns, rows], [width, height]] = [grid.nodes(), grid.frame];
    let mut text = String::new();
    for comment in comments {
        // (No comment ends another.)
        let _ = writeln!(text, "/* {} */", comment.replace("*/", "* /"));
    }
    text += GUARD;
    for (name, value) in [
        ("WIDTH", width),
        ("HEIGHT", height),
        ("EVERY", grid.every),
        ("COLUMNS", columns),
        ("ROWS", rows),
    ] {
        let _ = writeln!(text, "#define MORION_{name} {value}");
    }
    let _ = writeln!(text, "#define MORION_POLE {pole:?}f");
    let mut bytes = 0;
    let mut tables = vec![("direction", directions)];
    tables.extend(floor.map(|floor| ("floor", floor)));
    for (name, table) in tables {
        let _ = writeln!(text, "#define MORION_{}_STEP {:e}f", name.to_uppercase(), table.step);
        bytes += write_table(&mut text, name, table);
    }
    text += READ;
    text += LOOK;
    if floor.is_some() {
        text += FLOOR;
    }
    text += "\n#endif\n";
    (text, bytes)
}

fn write_table(text: &mut String, name: &str, field: &BilinearField) -> usize {
    let number = |x: f64| (x / field.step).round() as i16;
    let values = field.values.iter().flat_map(|value| value.map_or([NONE; 2], |v| v.map(number)));
    let values: Vec<String> = values.map(|value| value.to_string()).collect();
    write_list(text, ("int16_t", name), &values);
    // A bit for each cell that is told, the lowest first.
    let of = |cells: &[bool]| {
        let bits = cells.iter().enumerate().filter(|(_, told)| **told).map(|(k, _)| 1u8 << k);
        bits.fold(0, |all, bit| all | bit)
    };
    let cells: Vec<String> = field.told.chunks(8).map(|cells| of(cells).to_string()).collect();
    write_list(text, ("uint8_t", &format!("{name}_told")), &cells);
    2 * values.len() + cells.len()
}

fn write_list(text: &mut String, (kind, name): (&str, &str), values: &[String]) {
    let _ = writeln!(text, "static const {kind} morion_{name}_table[{}] = {{", values.len());
    for line in values.chunks(TO_A_LINE) {
        let _ = writeln!(text, "{},", line.join(","));
    }
    text.push_str("};\n");
}

const GUARD: &str = "\
#ifndef MORION_TABLE_H
#define MORION_TABLE_H
#include <math.h>
#include <stdint.h>

/* Places of the frame are in pixels from its upper left corner, to the right and down: the first pixel's middle is (0.5, 0.5). */
";

const READ: &str = "
/* Two numbers of a table, between its nodes; 0 where it tells nothing. */
static inline int morion_read(const int16_t *table, const uint8_t *told, float x, float y, float *a, float *b) {
    if (!(x >= 0.0f && x <= MORION_WIDTH && y >= 0.0f && y <= MORION_HEIGHT)) return 0;
    float u = x / MORION_EVERY - 0.5f, v = y / MORION_EVERY - 0.5f;
    int column = u > 0.0f ? (int)u : 0, row = v > 0.0f ? (int)v : 0;
    if (column > MORION_COLUMNS - 2) column = MORION_COLUMNS - 2;
    if (row > MORION_ROWS - 2) row = MORION_ROWS - 2;
    int cell = row * (MORION_COLUMNS - 1) + column;
    if (!(told[cell / 8] >> (cell % 8) & 1)) return 0;
    u -= column;
    v -= row;
    const int16_t *at = table + 2 * (row * MORION_COLUMNS + column), *below = at + 2 * MORION_COLUMNS;
    *a = (1 - v) * ((1 - u) * at[0] + u * at[2]) + v * ((1 - u) * below[0] + u * below[2]);
    *b = (1 - v) * ((1 - u) * at[1] + u * at[3]) + v * ((1 - u) * below[1] + u * below[3]);
    return 1;
}
";

const LOOK: &str = "
/* Azimuth, from Y towards X, and elevation, towards Z, of what a place of the frame shows, rad; 0 where it shows nothing. */
static inline int morion_look(float x, float y, float *azimuth, float *elevation) {
    float u, v;
    if (!morion_read(morion_direction_table, morion_direction_told_table, x, y, &u, &v)) return 0;
    u *= MORION_DIRECTION_STEP;
    v *= MORION_DIRECTION_STEP;
    float square = u * u + v * v;
    *azimuth = atan2f(u, v);
    *elevation = asinf(MORION_POLE * (1 - square) / (1 + square));
    return 1;
}
";

const FLOOR: &str = "
/* X and Y of the floor that a place of the frame shows, mm; 0 where it shows none. */
static inline int morion_floor(float x, float y, float *x_mm, float *y_mm) {
    if (!morion_read(morion_floor_table, morion_floor_told_table, x, y, x_mm, y_mm)) return 0;
    *x_mm *= MORION_FLOOR_STEP;
    *y_mm *= MORION_FLOOR_STEP;
    return 1;
}
";
