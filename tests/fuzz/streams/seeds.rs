//! The seeds of the fuzz targets: `../seeds/TARGET/NAME`, as they go on a wire.
//!
//! Packets are the documented and the recorded ones; messages are one of each
//! kind, as the encoder writes them. The files are written from `packets` and
//! `messages` by
//! `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test fuzz_streams`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::packets::{GATEWAY, MASTER, MORPHEUS, PROTOCOL1, STORE};
use super::{checks, messages};

/// Names and bytes.
pub(crate) type Seeds = BTreeMap<String, Vec<u8>>;

fn bytes(hex: &str) -> Vec<u8> {
    hex.split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).expect("two digits"))
        .collect()
}

fn written(table: &[(&str, &str)]) -> Seeds {
    let seed = |(name, hex): &(&str, &str)| ((*name).to_owned(), bytes(hex));
    table.iter().map(seed).collect()
}

/// What the folder of each target holds.
fn all() -> [(&'static str, Seeds); 6] {
    [
        ("gateway", written(&GATEWAY)),
        ("link", messages::seeds()),
        ("master", written(&MASTER)),
        ("morpheus", written(&MORPHEUS)),
        ("protocol1", written(&PROTOCOL1)),
        ("store", written(&STORE)),
    ]
}

fn folder(target: &str) -> PathBuf {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    seeds.join(target)
}

fn files(target: &str) -> Seeds {
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
pub(crate) fn read(target: &str) -> Vec<Vec<u8>> {
    let seeds: Vec<_> = files(target).into_values().collect();
    assert!(!seeds.is_empty(), "no seeds of {target}");
    seeds
}

#[test]
fn the_files_are_what_stands_here() {
    for (target, seeds) in all() {
        if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
            let folder = folder(target);
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).unwrap();
            for (name, bytes) in &seeds {
                std::fs::write(folder.join(name), bytes).unwrap();
            }
        }
        assert_eq!(
            files(target),
            seeds,
            "meant? UPDATE_SNAPSHOT=1 rewrites seeds/{target}"
        );
    }
}

/// Each seed gets to where its target is interesting.
#[test]
fn every_seed_is_understood() {
    let checks = [
        checks::gateway::check,
        checks::link::check,
        checks::master::check,
        checks::morpheus::check,
        checks::protocol1::check,
        checks::store::check,
    ];
    for ((target, seeds), check) in all().into_iter().zip(checks) {
        for (name, bytes) in seeds {
            // A stop is not answered, and half a packet is none.
            let is_nothing = target == "master" && name.starts_with("stop");
            let is_answered = !is_nothing && name != "morpheus-too-long";
            assert_eq!(check(&bytes) > 0, is_answered, "{target}/{name}");
        }
    }
}
