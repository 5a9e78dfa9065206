//! Code shared by the programs of this package: the boards, and how cargo builds the image of one.

#[path = "../../../firmware/boards.rs"]
pub mod boards;

use boards::{BOARDS, BoardRow};

/// Target of all images.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// Arguments of cargo for this command on a board's program.
pub fn image_arguments(command: &str, board: &BoardRow) -> String {
    let name = board.name;
    format!(
        "{command} --profile firmware --package armbridge-firmware --target {TARGET} \
         --features {name} --bin {name}"
    )
}

/// The board with this name; the first without one.
///
/// # Errors
/// If there is none; it names those that there are.
pub fn board_named(name: Option<&str>) -> Result<&'static BoardRow, String> {
    let name = name.unwrap_or(BOARDS[0].name);
    BOARDS
        .iter()
        .find(|board| board.name == name)
        .ok_or_else(|| {
            let names: Vec<&str> = BOARDS.iter().map(|board| board.name).collect();
            format!("no board `{name}`; there are {}", names.join(", "))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_found_by_its_name() {
        assert_eq!(
            board_named(None).map(|board| board.name),
            Ok("feather-f405")
        );
        let nucleo = board_named(Some("nucleo-f446ze"));
        assert_eq!(nucleo.map(|board| board.program_kib), Ok(256));
        let error = board_named(Some("feather")).err();
        assert!(error.is_some_and(|error| error.contains("there are feather-f405, nucleo")));
    }
}
