//! The log's messages in Rust, and their descriptors: those of `armbridge.proto` in
//! `host/log/proto`, and those of Foxglove that viewers draw.
//!
//! After a change there, or of the version of `foxglove`: `UPDATE_SNAPSHOT=1 cargo test
//! -p armbridge-tests --test sim schema`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use armbridge_log::export::column::{Column, TELEMETRY_ONLY};
use foxglove::Encode;
use foxglove::messages::{FrameTransforms, JointStates, Log, SceneUpdate};
use prost::Message;
use prost_build::{Config, Module};
use prost_types::FileDescriptorSet;

/// Folder of the log's crate.
fn log() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/log")
}

/// Compares a file of `src/proto` with what it should be, or writes it.
fn check(name: &str, expected: &[u8]) {
    let path = log().join("src/proto").join(name);
    if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
        fs::write(&path, expected).unwrap();
    } else if fs::read(&path).unwrap() != expected {
        panic!(
            "{} is not of the schema: run again with UPDATE_SNAPSHOT=1",
            path.display()
        );
    }
}

/// Rust of each package of a set, by the package's name.
fn generated(config: &mut Config, set: &FileDescriptorSet) -> Vec<(String, String)> {
    let modules = set.file.iter().map(|file| {
        let module = Module::from_protobuf_package_name(file.package());
        (module, file.clone())
    });
    let code = config.generate(modules.collect()).unwrap();
    let named = code
        .into_iter()
        .map(|(module, code)| (module.parts().collect::<Vec<_>>().join("."), code));
    named.collect()
}

#[test]
fn what_is_checked_in_is_what_the_schema_says() {
    let set = protox::compile(["armbridge.proto"], [log().join("proto")]).unwrap();
    for (package, code) in generated(&mut Config::new(), &set) {
        check(&format!("{package}.rs"), code.as_bytes());
    }
    // Descriptors travel in every log: without the comments.
    let mut bare = set;
    for file in &mut bare.file {
        file.source_code_info = None;
    }
    check("armbridge.bin", &bare.encode_to_vec());
}

#[test]
fn fields_are_the_columns_of_exported_files() {
    let set = protox::compile(["armbridge.proto"], [log().join("proto")]).unwrap();
    let fields = |message: &str| {
        let mut messages = set.file.iter().flat_map(|file| &file.message_type);
        let message = messages.find(|found| found.name() == message).unwrap();
        let names = message.field.iter().map(|field| field.name().to_owned());
        names.collect::<BTreeSet<String>>()
    };
    let names = |columns: Vec<Column>| {
        let names = columns.iter().map(|column| column.name.to_owned());
        names.collect::<BTreeSet<String>>()
    };
    let recorded = names(Column::all(false));
    let only = TELEMETRY_ONLY.map(|[name, ..]| name.to_owned());
    let telemetry: BTreeSet<String> = recorded.iter().cloned().chain(only).collect();
    assert_eq!(fields("Telemetry"), telemetry);
    let all = names(Column::all(true));
    let keys = ["time_s", "tick"].map(str::to_owned);
    let truth: BTreeSet<String> = all.difference(&recorded).cloned().chain(keys).collect();
    assert_eq!(fields("SimulationState"), truth);
}

#[test]
fn foxglove_messages_are_those_of_its_library() {
    let mut all = FileDescriptorSet::default();
    for schema in [
        FrameTransforms::get_schema(),
        JointStates::get_schema(),
        Log::get_schema(),
        SceneUpdate::get_schema(),
    ] {
        let schema = schema.unwrap();
        check(&format!("{}.bin", schema.name), &schema.data);
        for file in FileDescriptorSet::decode(&schema.data[..]).unwrap().file {
            if !all.file.contains(&file) {
                all.file.push(file);
            }
        }
    }
    // Two of Google's messages, instead of a crate that has all of them.
    let mut config = Config::new();
    config.compile_well_known_types();
    for (package, code) in generated(&mut config, &all) {
        check(&format!("{package}.rs"), code.as_bytes());
    }
}
