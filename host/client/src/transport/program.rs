//! The name under which this program joins a served link.

use std::path::Path;

use armbridge_link::server::Program;

/// This program, as "armbridge run": its file, and its first argument unless that is an option.
pub(super) fn this() -> Program {
    let mut args = std::env::args_os();
    let file = args.next().map(|path| file_name(Path::new(&path)));
    let first = args.next().map(|arg| file_name(Path::new(&arg)));
    let first = first.filter(|arg| !arg.is_empty() && !arg.starts_with('-'));
    let name: Vec<String> = file.into_iter().chain(first).collect();
    Program::new(&name.join(" "), std::process::id())
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}
