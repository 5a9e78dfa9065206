//! Streams of bytes, random and damaged seeds of the fuzz targets, into each parser and
//! the store. The campaign has ten million.

use armbridge_tests::streams::seeds;

armbridge_tests::stream_tests!(200_000);

#[test]
fn the_files_are_what_stands_here() {
    for (target, expected) in seeds::all() {
        if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
            let folder = seeds::folder(target);
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).unwrap();
            for (name, bytes) in &expected {
                std::fs::write(folder.join(name), bytes).unwrap();
            }
        }
        assert_eq!(
            seeds::files(target),
            expected,
            "meant? UPDATE_SNAPSHOT=1 rewrites seeds/{target}"
        );
    }
}

/// Each seed gets to where its target is interesting.
#[test]
fn every_seed_is_understood() {
    let checks = [
        checks::transparent_port::check,
        checks::link::check,
        checks::master::check,
        checks::morpheus::check,
        checks::protocol1::check,
        checks::protocol2::check,
        checks::store::check,
    ];
    for ((target, all), check) in seeds::all().into_iter().zip(checks) {
        for (name, bytes) in all {
            // A stop is not answered, and half a packet is none.
            let is_nothing = target == "master" && name.starts_with("stop");
            let is_answered = !is_nothing && name != "morpheus-too-long";
            assert_eq!(check(&bytes) > 0, is_answered, "{target}/{name}");
        }
    }
}
