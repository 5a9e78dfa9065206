//! Plain tables and text for a terminal.

/// Columns of a terminal.
pub const WIDTH: usize = 80;

/// Rows as text, the first being the heads; each column is as wide as its longest cell.
pub fn columns(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or_default();
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().zip(&widths);
        let line: Vec<String> = cells
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        text.push_str(line.join("  ").trim_end());
        text.push('\n');
    }
    text
}

/// Lines of items with `between` between them, broken between items at `width`; lines
/// after the first begin with `indent`.
pub fn wrap<T: AsRef<str>>(
    items: impl IntoIterator<Item = T>,
    between: &str,
    width: usize,
    indent: &str,
) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        let item = item.as_ref();
        match lines.last_mut() {
            Some(line) if line.chars().count() + between.len() + item.chars().count() <= width => {
                line.push_str(between);
                line.push_str(item);
            }
            Some(line) => {
                line.push_str(between.trim_end());
                lines.push(format!("{indent}{item}"));
            }
            None => lines.push(item.to_owned()),
        }
    }
    lines
}

/// Text with its lines broken at spaces where they are wider than a terminal; what follows
/// a break begins with `indent`.
pub fn fold(text: &str, indent: &str) -> String {
    let lines = text
        .lines()
        .flat_map(|line| wrap(line.split(' '), " ", WIDTH, indent));
    lines.map(|line| line + "\n").collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_broken_between_items() {
        assert_eq!(wrap(["ab", "c", "d"], ", ", 6, ""), ["ab, c,", "d"]);
        assert_eq!(wrap(["ab", "c", "d"], " ", 4, "  "), ["ab c", "  d"]);
    }

    #[test]
    fn only_wide_lines_are_folded() {
        let line = "word ".repeat(20);
        let folded = fold(&format!("  a   b\n\n{line}"), "  ");
        let lines: Vec<&str> = folded.lines().collect();
        assert_eq!(lines[..2], ["  a   b", ""]);
        assert_eq!(lines.len(), 4, "{folded}");
        assert!(lines[2].len() <= WIDTH && lines[3].starts_with("  word"));
    }

    #[test]
    fn columns_line_up() {
        let rows = [["id", "name"], ["253", "x"]].map(|row| row.map(str::to_owned).to_vec());
        assert_eq!(columns(&rows), "id   name\n253  x\n");
        assert_eq!(columns(&[]), "");
    }
}
