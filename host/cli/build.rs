//! Tells the program which commit it is built from: `ARMBRIDGE_GIT`, the hash, with
//! `-dirty` behind it if the sources differ; `unknown` where there is no repository,
//! as in an archive of the sources. `ARMBRIDGE_COMMIT` takes its place: a release has the
//! commit that it was built from.

use std::path::Path;
use std::process::Command;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    println!("cargo::rerun-if-env-changed=ARMBRIDGE_COMMIT");
    let given = std::env::var("ARMBRIDGE_COMMIT").ok();
    let hash = given.or_else(|| hash(&root));
    let hash = hash.unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=ARMBRIDGE_GIT={hash}");
    // Asked again when the sources change, and not for each commit: what was built
    // before a commit is its parent, and dirty.
    for path in [
        "src",
        "../analysis/src",
        "../client/src",
        "../log/src",
        "../sim/src",
        "../../shared",
        "../../Cargo.lock",
    ] {
        println!("cargo::rerun-if-changed={path}");
    }
}

/// The commit, if the repository is this one and not one around it.
fn hash(root: &Path) -> Option<String> {
    let top = git(root, &["rev-parse", "--show-toplevel"])?;
    let is_ours = Path::new(&top).canonicalize().ok()? == root.canonicalize().ok()?;
    let hash = git(root, &["rev-parse", "HEAD"]).filter(|_| is_ours)?;
    let tracked = "--untracked-files=no";
    let changes = git(root, &["status", "--porcelain", tracked, "host", "shared"])?;
    Some(if changes.is_empty() {
        hash
    } else {
        format!("{hash}-dirty")
    })
}

fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let output = Command::new("git")
        .arg("-C")
        .arg(root)
        .args(arguments)
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
