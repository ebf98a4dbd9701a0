//! The needs of sections of a machine, and the way to meet each.

use std::path::Path;
use std::process::Command;

use crate::shell::{Failure, Shell};

/// Something that a section needs.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum Need {
    /// A program that a package of Debian's has.
    Program(&'static str, &'static str),
    /// A file that a package of Debian's has.
    File(&'static str, &'static str),
    /// A component of Rust.
    Component(Component),
    /// A target of Rust.
    Target(&'static str),
    /// The packages that the `package.json` of a folder names.
    NodePackages(NodeFolder),
    /// Python 3.11 or newer, with its module for environments.
    Python,
    /// Node 20 or newer, with npm.
    Node,
    /// The user root.
    Root,
    /// Registries or databases on the network.
    Network,
}

/// A component of Rust that not every installation has.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum Component {
    Clippy,
    Rustfmt,
}

impl Component {
    /// As rustup has it.
    const fn word(self) -> &'static str {
        match self {
            Self::Clippy => "clippy",
            Self::Rustfmt => "rustfmt",
        }
    }

    /// The program that it installs.
    const fn program(self) -> &'static str {
        match self {
            Self::Clippy => "clippy-driver",
            Self::Rustfmt => "rustfmt",
        }
    }
}

/// A folder with a `package.json`.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum NodeFolder {
    Tools,
    TypeScript,
    Viewer,
}

impl NodeFolder {
    /// Its path from the root.
    const fn path(self) -> &'static str {
        match self {
            Self::Tools => "xtask/tools",
            Self::TypeScript => "examples/typescript",
            Self::Viewer => "viewer",
        }
    }
}

impl Need {
    /// In a word.
    pub(crate) fn word(self) -> String {
        match self {
            Self::Program(word, _) | Self::File(_, word) | Self::Target(word) => word.to_owned(),
            Self::Component(component) => component.word().to_owned(),
            Self::NodePackages(folder) => format!("packages of {}/", folder.path()),
            Self::Python => "Python 3.11".to_owned(),
            Self::Node => "Node 20".to_owned(),
            Self::Root => "root".to_owned(),
            Self::Network => "a network".to_owned(),
        }
    }

    fn is_there(self, root: &Path) -> bool {
        match self {
            Self::Program(program, _) => on_path(program),
            Self::File(path, _) => Path::new(path).exists(),
            Self::Component(component) => succeeds(component.program(), &["--version"]),
            Self::Target(target) => targets().is_some_and(|text| text.lines().any(|line| line == target)),
            Self::NodePackages(folder) => are_installed(&root.join(folder.path())),
            Self::Python => succeeds(
                "python3",
                &["-c", "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))"],
            ),
            Self::Node => {
                succeeds("node", &["-e", "process.exit(+(process.versions.node.split('.')[0] < 20))"])
                    && on_path("npm")
            }
            Self::Root => rustix::process::geteuid().is_root(),
            // A machine without a network finds out from the section: its registries are its own.
            Self::Network => true,
        }
    }
}

/// The needs that this machine does not meet.
pub(crate) struct Missing(Vec<Need>);

impl Missing {
    /// The needs that are not met.
    pub(crate) fn of<'a>(needs: impl IntoIterator<Item = &'a Need>, root: &Path) -> Self {
        let mut needs: Vec<_> = needs.into_iter().copied().collect();
        needs.sort_unstable();
        needs.dedup();
        needs.retain(|need| !need.is_there(root));
        Self(needs)
    }

    /// Whether nothing is missing.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The missing things, in words.
    pub(crate) fn words(&self) -> String {
        self.0.iter().map(|need| need.word()).collect::<Vec<_>>().join(", ")
    }

    /// Whether commands can install all of it.
    pub(crate) fn can_be_installed(&self) -> bool {
        !self.is_empty() && self.by_hand().is_empty()
    }

    /// The missing things that no command of ours installs, in words.
    fn by_hand(&self) -> Vec<&'static str> {
        let words = self.0.iter().filter_map(|need| match need {
            Need::Python => Some(
                "python3 3.11 or newer with its module venv is needed (Debian: apt-get install python3-venv)",
            ),
            Need::Node => Some("node 20 or newer with npm is needed (https://nodejs.org)"),
            Need::Root => Some("root is needed"),
            Need::Target(_) | Need::Component(_) if !on_path("rustup") => {
                Some("rustup is needed (https://rustup.rs)")
            }
            Need::Program(..) | Need::File(..) if !on_path("apt-get") => {
                Some("what is named above is to be installed by hand: there is no apt-get")
            }
            Need::Program(..)
            | Need::File(..)
            | Need::Component(_)
            | Need::Target(_)
            | Need::NodePackages(_)
            | Need::Network => None,
        });
        let mut words: Vec<_> = words.collect();
        words.dedup();
        words
    }

    /// A line for a shell that installs what can be installed, and in words what cannot.
    pub(crate) fn remedy(&self) -> String {
        let by_hand = self.by_hand();
        if !by_hand.is_empty() {
            return by_hand.join("\n");
        }
        let commands: Vec<_> = self.commands().iter().map(|words| words.join(" ")).collect();
        format!("this installs them, as does --install:\n\n{}\n", commands.join(" && "))
    }

    /// Installs what can be installed.
    ///
    /// # Errors
    ///
    /// A command for that fails.
    pub(crate) fn install(&self, shell: &Shell) -> Result<(), Failure> {
        for words in self.commands() {
            shell.say(&words.join(" "));
            let mut command = shell.command(&words[0]);
            command.args(&words[1..]).env("DEBIAN_FRONTEND", "noninteractive");
            shell.run(command)?;
        }
        Ok(())
    }

    fn commands(&self) -> Vec<Vec<String>> {
        let mut packages = Vec::new();
        let mut targets = Vec::new();
        let mut components = Vec::new();
        let mut folders = Vec::new();
        for need in &self.0 {
            match *need {
                Need::Program(_, package) | Need::File(_, package) => packages.extend(package.split(' ')),
                Need::Component(component) => components.push(component.word()),
                Need::Target(target) => targets.push(target),
                Need::NodePackages(folder) => folders.push(folder.path()),
                Need::Python | Need::Node | Need::Root | Need::Network => {}
            }
        }
        packages.sort_unstable();
        packages.dedup();
        let sudo: &[&str] = if rustix::process::geteuid().is_root() { &[] } else { &["sudo", "-n"] };
        let command = |parts: &[&[&str]]| parts.concat().into_iter().map(str::to_owned).collect();
        let mut commands: Vec<Vec<String>> = Vec::new();
        if !packages.is_empty() {
            commands.push(command(&[sudo, &["apt-get", "update", "-qq"]]));
            commands.push(command(&[
                sudo,
                &["apt-get", "install", "-y", "-qq", "--no-install-recommends"],
                &packages,
            ]));
        }
        if !components.is_empty() {
            commands.push(command(&[&["rustup", "component", "add"], &components]));
        }
        if !targets.is_empty() {
            commands.push(command(&[&["rustup", "target", "add"], &targets]));
        }
        // Not `npm ci`: it wants programs for all other systems in the lock file, which has those for Linux.
        let options = ["--no-save", "--no-audit", "--no-fund", "--loglevel=error"];
        commands.extend(
            folders.into_iter().map(|folder| command(&[&["npm", "install", "--prefix", folder], &options])),
        );
        commands
    }
}

fn succeeds(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|printed| printed.status.success())
}

fn on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    // Programs for root lie where other users do not look.
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/sbin".into()]);
    folders.map(|folder| folder.join(program)).any(|file| file.is_file())
}

fn targets() -> Option<String> {
    let printed = Command::new("rustup").args(["target", "list", "--installed"]).output().ok()?;
    Some(String::from_utf8_lossy(&printed.stdout).into_owned())
}

/// Whether npm has installed what the lock file says: it writes a list of its own behind the packages.
fn are_installed(folder: &Path) -> bool {
    let time = |path: &str| std::fs::metadata(folder.join(path)).and_then(|data| data.modified());
    match (time("package-lock.json"), time("node_modules/.package-lock.json")) {
        (Ok(wanted), Ok(installed)) => installed >= wanted,
        (Ok(_) | Err(_), Err(_)) | (Err(_), Ok(_)) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::{Component, Missing, Need, NodeFolder};

    #[test]
    fn what_is_missing_is_one_line_for_a_shell() {
        let missing = Missing(vec![
            Need::Program("avr-gdb", "gdb-avr"),
            Need::File("/usr/include/simavr/sim_avr.h", "libsimavr-dev libelf-dev"),
            Need::Component(Component::Clippy),
            Need::Target("thumbv7em-none-eabihf"),
            Need::NodePackages(NodeFolder::Viewer),
        ]);
        let remedy = missing.remedy();
        assert_eq!(remedy.lines().count(), 3, "{remedy}");
        assert!(
            remedy.contains("apt-get install -y -qq --no-install-recommends gdb-avr libelf-dev libsimavr-dev && rustup component add clippy")
                && remedy.contains("rustup target add thumbv7em-none-eabihf && npm install --prefix viewer"),
            "{remedy}"
        );
        assert_eq!(
            missing.words(),
            "avr-gdb, libsimavr-dev libelf-dev, clippy, thumbv7em-none-eabihf, packages of viewer/"
        );
    }

    #[test]
    fn what_no_command_installs_is_told_in_words() {
        assert_eq!(
            Missing(vec![Need::Node]).remedy(),
            "node 20 or newer with npm is needed (https://nodejs.org)"
        );
        assert!(
            Missing(Vec::new()).is_empty()
                && !Missing(vec![Need::Node, Need::NodePackages(NodeFolder::Viewer)]).can_be_installed()
        );
    }
}
