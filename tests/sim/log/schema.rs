//! The log's messages in Rust, and their descriptors, are made of
//! `host/log/proto/armbridge.proto`.
//!
//! After a change there: `UPDATE_SNAPSHOT=1 cargo test -p armbridge-tests --test sim
//! schema`.

use std::fs;
use std::path::Path;

use prost::Message;

#[test]
fn what_is_checked_in_is_what_the_schema_says() {
    let host = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/log");
    let set = protox::compile(["armbridge.proto"], [host.join("proto")]).unwrap();
    let modules = set.file.iter().map(|file| {
        let module = prost_build::Module::from_protobuf_package_name(file.package());
        (module, file.clone())
    });
    let made = prost_build::Config::new()
        .generate(modules.collect())
        .unwrap();
    let code = made.into_values().next().unwrap();
    // Descriptors travel in every log: without the comments.
    let mut bare = set;
    for file in &mut bare.file {
        file.source_code_info = None;
    }
    let folder = host.join("src/proto");
    for (name, is) in [
        ("armbridge.rs", code.into_bytes()),
        ("armbridge.bin", bare.encode_to_vec()),
    ] {
        let path = folder.join(name);
        if std::env::var_os("UPDATE_SNAPSHOT").is_some() {
            fs::write(&path, is).unwrap();
        } else if fs::read(&path).unwrap() != is {
            panic!(
                "{} is not of the schema: run again with UPDATE_SNAPSHOT=1",
                path.display()
            );
        }
    }
}
