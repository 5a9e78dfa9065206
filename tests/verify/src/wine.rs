//! The program for Windows, run under Wine: a simulated run, and ctrl-c while a simulated arm
//! is armed. Wine is no Windows: USB, serial ports and consoles are not tested by this.

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use crate::output::Output;
use crate::{paths, release, setup};

/// Library with the random numbers of Rust's hash maps, which Wine lacks before version 9.
const RANDOM: &str = "\
#include <windows.h>
BOOLEAN NTAPI SystemFunction036(PVOID bytes, ULONG length);
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T length) {
    return SystemFunction036(bytes, (ULONG)length);
}
";

/// Longest time from ctrl-c to the end.
const PATIENCE: Duration = Duration::from_secs(10);

/// Fewest lines of a run's summary.
const SUMMARY_MIN: usize = 15;

/// Builds the program, and runs it.
pub(crate) fn run(out: &Output) -> Result<(), String> {
    setup::wine(out)?;
    let downloads = release::build(out)?;
    let wine = Wine::new(&downloads, out)?;
    same_results(&wine, &downloads.join("armbridge-linux-x86_64"), out)?;
    ctrl_c(&wine, out)
}

/// The program in a folder of its own, and Wine's.
struct Wine {
    folder: PathBuf,
}

impl Wine {
    fn new(downloads: &Path, out: &Output) -> Result<Self, String> {
        let folder = paths::target().join("wine");
        let program = downloads.join("armbridge-windows-x86_64.exe");
        fs::create_dir_all(&folder)
            .and_then(|()| fs::copy(program, folder.join("armbridge.exe")))
            .and_then(|_| fs::write(folder.join("random.c"), RANDOM))
            .map_err(|e| format!("cannot write to {}: {e}", folder.display()))?;
        let mut compile = Command::new("x86_64-w64-mingw32-gcc");
        compile.args(["-shared", "-o"]);
        compile.arg(folder.join("bcryptprimitives.dll"));
        out.run(compile.arg(folder.join("random.c")).arg("-ladvapi32"))?;
        Ok(Self { folder })
    }

    /// The program with these arguments.
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new("wine");
        command
            .arg(self.folder.join("armbridge.exe"))
            .args(arguments)
            .current_dir(&self.folder)
            .env("WINEPREFIX", self.folder.join("prefix"))
            .env("WINEDEBUG", "-all")
            .stdin(Stdio::null());
        command
    }

    /// Standard output of the program, which must succeed.
    fn printed(&self, arguments: &[&str]) -> Result<String, String> {
        printed(self.command(arguments))
    }
}

/// Standard output of a program that must succeed.
fn printed(mut command: Command) -> Result<String, String> {
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!("{command:?}: {}\n{errors}", output.status));
    }
    Ok(String::from_utf8_lossy(&output.stdout).replace('\r', ""))
}

/// `run demo` prints the numbers that it prints on Linux.
fn same_results(wine: &Wine, linux: &Path, out: &Output) -> Result<(), String> {
    let arguments = ["run", "demo", "--out", "runs"];
    let there = summary(&wine.printed(&arguments)?);
    let mut here = Command::new(linux);
    here.args(arguments).current_dir(&wine.folder);
    let here = summary(&printed(here)?);
    out.line(&there);
    if there == here && there.lines().count() >= SUMMARY_MIN {
        Ok(())
    } else {
        Err(format!("`run demo` differs: on Linux it prints\n{here}"))
    }
}

/// Output of a run, without its first line, which has its duration, and the lines with its
/// folder.
fn summary(text: &str) -> String {
    let lines = text.lines().skip(1);
    let lines = lines.filter(|line| !line.contains("-demo"));
    lines.collect::<Vec<_>>().join("\n")
}

/// Ctrl-c while a served arm is armed: the program ends by itself, and the motors are off.
fn ctrl_c(wine: &Wine, out: &Output) -> Result<(), String> {
    let link = format!("tcp://127.0.0.1:{}", free_port()?);
    // Upright, where friction holds an arm without torque.
    let serve = ["serve", "board", "--initial", "0,0", "--listen", &link];
    let mut serve = Running::start(wine.command(&serve))?;
    serve.until("end with ctrl-c")?;
    let mut arm = Running::start(wine.command(&["arm", "--link", &link]))?;
    arm.until("armed for")?;
    out.command(&format!("kill -INT {}", arm.child.id()))?;
    let code = arm.end()?;
    let status = wine.printed(&["status", "--json", "--link", &link])?;
    if code != Some(0) || !status.contains("\"mode\":\"idle\"") {
        return Err(format!("after ctrl-c `arm` ends with {code:?}: {status}"));
    }
    out.line("    ctrl-c: armed, then idle, exit code 0");
    Ok(())
}

fn free_port() -> Result<u16, String> {
    let listener = TcpListener::bind("127.0.0.1:0").and_then(|it| it.local_addr());
    listener
        .map(|address| address.port())
        .map_err(|e| format!("no free port: {e}"))
}

/// A program that runs, and is killed if it still does at the end.
struct Running {
    child: Child,
    errors: BufReader<ChildStderr>,
}

impl Running {
    fn start(mut command: Command) -> Result<Self, String> {
        let started = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut child = started.map_err(|e| format!("{command:?}: {e}"))?;
        let errors = child.stderr.take().ok_or("no standard error")?;
        Ok(Self {
            child,
            errors: BufReader::new(errors),
        })
    }

    /// Waits for a line with these words on standard error.
    fn until(&mut self, words: &str) -> Result<(), String> {
        let mut text = String::new();
        while !text.contains(words) {
            match self.errors.read_line(&mut text) {
                Ok(0) => return Err(format!("no `{words}`: {text}")),
                Ok(_) => {}
                Err(error) => return Err(error.to_string()),
            }
        }
        Ok(())
    }

    /// Exit code, once it has ended.
    fn end(&mut self) -> Result<Option<i32>, String> {
        let begin = Instant::now();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return Ok(status.code()),
                Ok(None) if begin.elapsed() < PATIENCE => {
                    std::thread::sleep(Duration::from_millis(20));
                }
                Ok(None) => return Err("the program does not end".to_owned()),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
