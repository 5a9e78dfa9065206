//! Completions and manual pages.

use std::fs;
use std::process::Command;

use super::{Program, text};

#[test]
fn every_shell_has_completions() {
    let program = Program::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = program.says(&["completions", shell]);
        for word in ["design", "explain", "dry-run"] {
            assert!(script.contains(word), "no {word} for {shell}");
        }
    }
    program.fails(&["completions", "sh"], &["bash", "zsh", "fish"]);
}

/// Completions of bash for an incomplete command line.
#[cfg(unix)]
#[test]
fn bash_completes_commands_and_options() {
    let program = Program::new();
    let path = program.path("armbridge.bash");
    fs::write(&path, program.says(&["completions", "bash"])).unwrap();
    let bash = |script: &str| {
        let mut command = Command::new("bash");
        let command = command.args(["-c", script]);
        let output = command.current_dir(program.0.path()).output();
        output.map(|output| {
            assert!(output.status.success(), "{}", text(&output.stderr));
            text(&output.stdout).trim().to_owned()
        })
    };
    if bash("true").is_err() {
        eprintln!("no bash here: not looked at");
        return;
    }
    bash("bash -n armbridge.bash").unwrap();
    let completed = |words: &str| {
        let last = words.split(' ').count() - 1;
        let script = format!(
            "source ./armbridge.bash; COMP_WORDS=({words}); COMP_CWORD={last}; \
             _armbridge armbridge \"${{COMP_WORDS[{last}]}}\" \"${{COMP_WORDS[{last}-1]}}\"; \
             echo \"${{COMPREPLY[@]}}\""
        );
        bash(&script).unwrap()
    };
    assert_eq!(completed("armbridge des"), "design");
    assert_eq!(completed("armbridge params --dr"), "--dry-run");
    assert!(completed("armbridge completions z").contains("zsh"));
    assert_eq!(completed("armbridge run upri"), "upright");
    assert_eq!(completed("armbridge sweep pus"), "push");
    assert_eq!(completed("armbridge run --plant hea"), "heavy");
    assert_eq!(
        completed("armbridge run --set controller.q"),
        "controller.q="
    );
    assert_eq!(completed("armbridge params controller.q"), "controller.q");
}

/// Names of scenarios and virtual arms, beside files; parameters.
#[test]
fn other_shells_complete_names_as_well() {
    let program = Program::new();
    for (shell, words) in [
        (
            "zsh",
            [
                "{_alternative \"names:name:(demo upright",
                "{_alternative \"names:name:(default dead-zone heavy",
                "limits.hold_ms=",
            ],
        ),
        (
            "fish",
            [
                "using_subcommand sweep\" -a \"demo upright",
                "-l plant -d",
                "limits.hold_ms=",
            ],
        ),
    ] {
        let script = program.says(&["completions", shell]);
        for word in words {
            assert!(script.contains(word), "no {word} for {shell}");
        }
        assert!(!script.contains("-f -a \"demo"), "{shell}");
    }
}

#[test]
fn every_command_has_a_manual_page() {
    let program = Program::new();
    let page = program.says(&["man"]);
    assert!(page.contains(".TH armbridge 1"), "{page}");
    program.says(&["man", "--out", "pages"]);
    let help = program.says(&["--help"]);
    let commands = help.lines().filter_map(|line| {
        // Two columns of space, a name, and what it does.
        let name = line.strip_prefix("  ")?.split_whitespace().next()?;
        let is_command = line.len() > 15 && !line.starts_with("   ") && !name.starts_with('-');
        (is_command && name != "help").then_some(name)
    });
    let mut count = 0;
    for name in commands {
        let page = program.path(&format!("pages/armbridge-{name}.1"));
        let page = fs::read_to_string(&page).unwrap_or_else(|error| panic!("{page:?}: {error}"));
        assert!(page.contains(&format!(".TH armbridge-{name} 1")), "{name}");
        assert!(
            page.contains(".SH SYNOPSIS") && page.contains("Examples:"),
            "{name}"
        );
        count += 1;
    }
    assert!(count >= 14, "{count}");
}
