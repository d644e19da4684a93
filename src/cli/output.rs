//! Results: on standard output, in files, and numbers as people read them.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use super::CliError;
use crate::node::NodeError;

/// Prints a result. A reader that closed the pipe (`toile list scenes | head -1`) has all it wants.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}

/// Prints a JSON value, a line of its own.
pub(super) fn print_json(value: &serde_json::Value) -> Result<(), CliError> {
    print(&format!("{value:#}\n"))
}

/// Prints the path of a file that was written, a line of its own.
pub(super) fn announce(path: &Path) -> Result<(), CliError> {
    print(&format!("{}\n", path.display()))
}

/// Writes a file.
pub(super) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), CliError> {
    Ok(fs::write(path, bytes).map_err(NodeError::file("write", path))?)
}

/// Writes a file and prints its path.
pub(super) fn save(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), CliError> {
    write(path, bytes)?;
    announce(path)
}

/// Rows with their columns aligned.
pub(super) fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<_> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths);
        let cells: Vec<_> = cells
            .map(|(cell, width)| format!("{cell:<width$}"))
            .collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    rows.iter().map(line).collect()
}

/// A number to so many significant digits, without exponent; what rounds to nothing is 0.
pub(super) fn significant(value: f64, digits: i32) -> String {
    let magnitude = value.abs().log10().floor();
    if !magnitude.is_finite() || magnitude < -9.0 {
        return "0".to_string();
    }
    let decimals = (digits - 1 - magnitude as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

/// A whole number with its thousands apart: 5,750.
pub(super) fn thousands(number: usize) -> String {
    let digits = number.to_string();
    let mut out = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A number to at most four decimals, without trailing zeros.
pub(super) fn trimmed(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn significant_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-1e-20, "0"),
            (0.001234, "0.00123"),
            (-41.987, "-42.0"),
            (98765.4, "98765"),
            (1.0, "1.00"),
        ] {
            assert_eq!(significant(value, 3), text);
        }
    }

    #[test]
    fn numbers_without_noise() {
        assert_eq!(
            [999, 5750, 1234567].map(thousands),
            ["999", "5,750", "1,234,567"]
        );
        assert_eq!([5.0, 0.25, 100.0].map(trimmed), ["5", "0.25", "100"]);
    }

    #[test]
    fn columns_are_aligned_and_end_without_blanks() {
        let rows = [["a", "bb", ""], ["µµµ", "b", "c"]];
        let rows = rows.map(|row| row.map(str::to_string).to_vec());
        assert_eq!(table(&rows), "a    bb\nµµµ  b   c\n");
    }
}
