//! The seeds of the fuzz targets: `tests/fuzz/seeds/TARGET/NAME`, as they go on a wire.
//!
//! Packets are the documented and the recorded ones; messages are one of each
//! kind, as the encoder writes them. The files are written from `packets` and
//! `messages` by
//! `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test sim streams`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::messages;
use super::packets::{MASTER, MORPHEUS, PROTOCOL1, PROTOCOL2, STORE, TRANSPARENT_PORT};

/// Names and bytes.
pub type Seeds = BTreeMap<String, Vec<u8>>;

fn bytes(hex: &str) -> Vec<u8> {
    hex.split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).expect("two digits"))
        .collect()
}

fn written(table: &[(&str, &str)]) -> Seeds {
    let seed = |(name, hex): &(&str, &str)| ((*name).to_owned(), bytes(hex));
    table.iter().map(seed).collect()
}

/// Expected content of the folder of each target.
pub fn all() -> [(&'static str, Seeds); 7] {
    [
        ("transparent_port", written(&TRANSPARENT_PORT)),
        ("link", messages::seeds()),
        ("master", written(&MASTER)),
        ("morpheus", written(&MORPHEUS)),
        ("protocol1", written(&PROTOCOL1)),
        ("protocol2", written(&PROTOCOL2)),
        ("store", written(&STORE)),
    ]
}

/// The folder of a target.
pub fn folder(target: &str) -> PathBuf {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    seeds.join(target)
}

/// Actual content of the folder of a target.
pub fn files(target: &str) -> Seeds {
    let Ok(files) = std::fs::read_dir(folder(target)) else {
        return Seeds::new();
    };
    files
        .map(|file| {
            let file = file.expect("a file");
            let name = file.file_name().into_string().expect("a name");
            (name, std::fs::read(file.path()).expect("its bytes"))
        })
        .collect()
}

/// The seeds of a target.
///
/// # Panics
/// If there are none.
pub fn read(target: &str) -> Vec<Vec<u8>> {
    let seeds: Vec<_> = files(target).into_values().collect();
    assert!(!seeds.is_empty(), "no seeds of {target}");
    seeds
}
