//! Text that fits into the room that there is, in pictures and in columns of characters.

/// The approximate width of a text, in pixels: fonts differ, and it must fit in most of them.
pub fn width(text: &str, size: f64) -> f64 {
    let of = |c: char| match c {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ' ' | '|' | '\'' => 0.36,
        'm' | 'w' | 'M' | 'W' => 0.95,
        c if c.is_ascii_uppercase() => 0.72,
        c if (c as u32) < 0x1100 => 0.61,
        _ => 1.0,
    };
    size * text.chars().map(of).sum::<f64>()
}

/// The part of a text that fits into a width, in pixels, with an ellipsis if there was more.
pub fn shortened(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let mut short = String::new();
    for c in text.chars() {
        if width(&short, size) + width("m…", size) > room {
            break;
        }
        short.push(c);
    }
    short + "…"
}

/// A name that fits into a width, in pixels. It loses its middle, which matters less than its ends.
pub fn without_middle(name: &str, size: f64, room: f64) -> String {
    if width(name, size) <= room {
        return name.to_owned();
    }
    let half = shortened(name, size, 0.5 * room);
    let end: String = name.chars().rev().collect();
    let end = shortened(&end, size, 0.5 * room);
    half.trim_end_matches('…').chars().chain(end.chars().rev()).collect()
}

/// A text in at most `most` lines that fit into a width, in pixels; the last of them may be shortened.
pub fn wrapped(text: &str, size: f64, room: f64, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if lines_fit(line, word, size, room) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    if lines.len() > most {
        let rest = lines.split_off(most).join(" ");
        if let Some(last) = lines.last_mut() {
            *last = format!("{last} {rest}");
        }
    }
    lines.iter().map(|line| shortened(line, size, room)).collect()
}

/// Rows of cells as lines: columns are as wide as their widest cells, and two spaces apart. Cells of columns that are
/// `is_left` are aligned to the left, all others to the right.
pub fn columns<R: AsRef<[String]>>(indent: &str, rows: &[R], is_left: impl Fn(usize) -> bool) -> String {
    let rows = || rows.iter().map(AsRef::as_ref);
    let mut widths: Vec<usize> = Vec::new();
    for row in rows() {
        widths.resize(widths.len().max(row.len()), 0);
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let cell = |(i, (cell, &width)): (usize, (&String, &usize))| match is_left(i) {
        true => format!("{cell:<width$}"),
        false => format!("{cell:>width$}"),
    };
    let line = |row: &[String]| row.iter().zip(&widths).enumerate().map(cell).collect::<Vec<_>>().join("  ");
    rows().map(|row| format!("{}\n", format!("{indent}{}", line(row)).trim_end())).collect()
}

fn lines_fit(line: &str, word: &str, size: f64, room: f64) -> bool {
    width(line, size) + width(" ", size) + width(word, size) <= room
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut_to_the_room_that_there_is() {
        let long = "a description that goes on and on and on and never comes to its end";
        let lines = wrapped(long, 10.0, 100.0, 2);
        assert_eq!(lines.len(), 2);
        assert!(lines.iter().all(|line| width(line, 10.0) <= 100.0) && lines[1].ends_with('…'), "{lines:?}");
        assert_eq!(shortened("short", 10.0, 100.0), "short");
        let name = without_middle("ir_sensor_of_the_left_side_number_7", 10.0, 100.0);
        assert!(name.starts_with("ir_s") && name.contains('…') && name.ends_with("r_7"), "{name}");
    }

    #[test]
    fn columns_line_up() {
        let row = |cells: [&str; 3]| cells.map(str::to_owned);
        let text = columns("> ", &[row(["µ", "1", ""]), row(["left", "100", ""])], |i| i == 0);
        assert_eq!(text, "> µ       1\n> left  100\n");
        assert_eq!(columns::<[String; 3]>("", &[], |_| true), "");
    }
}
