//! The table of all sections of the tests.

mod chips;
mod pages;
mod parts;
mod projects;
mod python;
mod release;
mod rust;
mod servers;

use crate::needs::Need::{self, File, Network, Node, NodePackages, Program, Python, Root, Target};
use crate::needs::{Component, NodeFolder};
use crate::records::{Duration, Green, Table};
use crate::shell::{Failure, Shell};

/// When a section runs.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum Rung {
    /// By `./test`, and by what is above.
    Test,
    /// By `./test all`.
    All,
    /// By `./test release-checks`, and by turns under continuous integration.
    Release,
    /// By its name only.
    Asked,
}

impl Rung {
    /// The heading of its list.
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Test => "./test",
            Self::All => "./test all",
            Self::Release => "./test release-checks",
            Self::Asked => "by name only",
        }
    }
}

/// Something that is checked, with a name.
pub(crate) struct Section {
    /// The word by which it is asked for.
    pub(crate) name: &'static str,
    /// When it runs.
    pub(crate) rung: Rung,
    /// The protected property, in a few words.
    pub(crate) protects: &'static str,
    /// The arguments that it takes, as the list shows them; none if empty.
    pub(crate) arguments: &'static str,
    /// The needs of the machine.
    pub(crate) needs: &'static [Need],
    /// Whether `./test` without words passes over it where its tools are missing, and says so.
    pub(crate) is_optional: bool,
    /// The check itself, with its arguments.
    pub(crate) check: fn(&Shell, &[String]) -> Result<(), Failure>,
}

impl Section {
    /// Its place in the table.
    pub(crate) fn place(&self) -> usize {
        SECTIONS.iter().position(|section| section.name == self.name).unwrap_or(SECTIONS.len())
    }
}

/// `./test all` may never take longer.
pub(crate) const LONGEST_S: u64 = 3600;
/// A release check must have been green within so many commits.
pub(crate) const OLDEST: u64 = 300;
/// A release check that takes longer is not run under continuous integration.
pub(crate) const LONGEST_TURN_S: u64 = 480;
/// The parent of the commit with which release checks began to be recorded: one that has not been green since is as old as this.
const FIRST: &str = "0ed0eda3";

const PLAIN: Section = Section {
    name: "",
    rung: Rung::All,
    protects: "",
    arguments: "",
    needs: &[],
    is_optional: false,
    check: |_, _| Ok(()),
};

const NGINX: Need = Program("nginx", "nginx-light");
const OPENSSL: Need = Program("openssl", "openssl");
const CURL: Need = Program("curl", "curl");
const CHROMIUM: Need = Program("chromium", "chromium");
const AVR_GCC: Need = Program("avr-g++", "gcc-avr binutils-avr");
const AVR_LIBC: Need = File("/usr/lib/avr/include/avr/io.h", "avr-libc");
const ARDUINO_CORE: Need = File("/usr/share/arduino/hardware/arduino/avr", "arduino-core-avr");
const MAKE: Need = Program("make", "make");
const DEBOOTSTRAP: Need = Program("debootstrap", "debootstrap");
const TOOLS: Need = NodePackages(NodeFolder::Tools);
const VIEWER: Need = NodePackages(NodeFolder::Viewer);
const CLIPPY: Need = Need::Component(Component::Clippy);
const RUSTFMT: Need = Need::Component(Component::Rustfmt);
const WASI: Need = Target("wasm32-wasip1");

/// What brains in other languages are built with, in the words of their READMEs.
#[rustfmt::skip]
const LANGUAGES: &[Need] = &[
    Python, Node, MAKE,
    Program("g++", "g++"), Program("pkg-config", "pkg-config"), Program("protoc", "protobuf-compiler"),
    Program("grpc_cpp_plugin", "protobuf-compiler-grpc"), File("/usr/include/grpcpp/grpcpp.h", "libgrpc++-dev"), File("/usr/include/gtest/gtest.h", "libgtest-dev"),
    Program("go", "golang-go"), Program("protoc-gen-go", "protoc-gen-go"), Program("protoc-gen-go-grpc", "protoc-gen-go-grpc"),
    File("/usr/share/gocode/src/google.golang.org/grpc/version.go", "golang-google-grpc-dev golang-github-golang-protobuf-1-5-dev"),
    Program("javac", "default-jdk-headless"), Program("grpc_java_plugin", "protobuf-compiler-grpc-java-plugin"), File("/usr/share/java/grpc-netty.jar", "libgrpc-java"),
    File("/usr/share/java/netty-codec-http2.jar", "libnetty-java"), File("/usr/share/java/protobuf.jar", "libprotobuf-java"), File("/usr/share/java/guava.jar", "libguava-java"),
    File("/usr/share/java/perfmark-api.jar", "libperfmark-java"), File("/usr/share/java/geronimo-annotation-1.3-spec.jar", "libgeronimo-annotation-1.3-spec-java"),
    File("/usr/share/java/junit-platform-console-standalone.jar", "junit5"),
    Program("ruby", "ruby"), Program("grpc_tools_ruby_protoc", "ruby-grpc ruby-grpc-tools"), Program("rspec", "ruby-rspec"),
];

/// All sections, in the order in which they run.
#[rustfmt::skip]
pub(crate) static SECTIONS: &[Section] = &[
    Section { name: "formatting", rung: Rung::Test, protects: "the layout of the Rust code", needs: &[RUSTFMT], check: |shell, _| rust::formatting(shell), ..PLAIN },
    Section { name: "structure", rung: Rung::Test, protects: "sizes, errors and borders of the code; the ladder's own tables", check: |shell, _| rust::structure(shell), ..PLAIN },
    Section { name: "tests", rung: Rung::Test, protects: "all tests but those in xtask/slow-tests.toml: units, whole systems over real sockets", check: |shell, _| rust::tests(shell), ..PLAIN },
    Section { name: "main-job", rung: Rung::Test, protects: "README's first run, with its hash", check: |shell, _| rust::main_job(shell), ..PLAIN },
    Section { name: "python-client", rung: Rung::Test, protects: "the client in Python beside a real server", needs: &[Python, OPENSSL], is_optional: true, check: |shell, _| python::client(shell), ..PLAIN },

    Section { name: "lints", protects: "clippy's and the compiler's lints, in all code and with all features", needs: &[CLIPPY], check: |shell, _| rust::lints(shell), ..PLAIN },
    Section { name: "slow-tests", protects: "the tests that `./test` has no time for", check: |shell, _| rust::slow_tests(shell), ..PLAIN },
    Section { name: "fuzz-briefly", protects: "everything that reads bytes from outside, a second a target", check: |shell, _| rust::fuzz_briefly(shell), ..PLAIN },
    Section { name: "bare-metal", protects: "the pure crates on a Cortex-M4 and in a browser", needs: &[Target("thumbv7em-none-eabihf"), Target("wasm32-unknown-unknown")], check: |shell, _| rust::bare_metal(shell), ..PLAIN },
    Section { name: "supply-chain", protects: "licences, sources and bans of what is built in", check: |shell, _| rust::supply_chain(shell), ..PLAIN },
    Section { name: "contract", protects: "the contract's style, and that it only grows", needs: &[Node, TOOLS], check: |shell, _| pages::contract(shell), ..PLAIN },
    Section { name: "editors", protects: "the schema of scenarios, by what editors use", needs: &[Python, Node, TOOLS], check: |shell, _| pages::editors(shell), ..PLAIN },
    Section { name: "viewer", protects: "the page's sources, and that viewer/dist is made of them", needs: &[Node, TOOLS, VIEWER], check: |shell, _| pages::viewer(shell), ..PLAIN },
    Section { name: "viewer-browser", protects: "a server's page in Chromium", needs: &[Node, TOOLS, VIEWER, CHROMIUM, OPENSSL, Program("certutil", "libnss3-tools")], check: |shell, _| pages::viewer_in_a_browser(shell), ..PLAIN },
    Section { name: "page", protects: "the stand-alone page in Chromium: its size, hashes, brains", needs: &[Node, TOOLS, VIEWER, CHROMIUM, WASI, Python], check: |shell, _| pages::page(shell), ..PLAIN },
    Section { name: "manual", protects: "the manual as a site, without broken links", needs: &[Python], check: |shell, _| python::manual(shell), ..PLAIN },
    Section { name: "manual-commands", protects: "the commands of tutorials and how-tos; generated pages of the manual", needs: &[Python, AVR_GCC, AVR_LIBC, ARDUINO_CORE, MAKE, CHROMIUM], check: |shell, _| python::manual_commands(shell), ..PLAIN },
    Section { name: "brains-in-python", protects: "the client's types, stubs and examples", needs: &[Python], check: |shell, _| python::brains(shell), ..PLAIN },
    Section { name: "worlds-in-python", protects: "the Python package: types, ABI, environments, notebooks", needs: &[Python], check: |shell, _| python::worlds(shell), ..PLAIN },
    Section { name: "recordings", protects: "recordings, by the readers of MCAP and ROS", needs: &[Python], check: |shell, _| python::recordings(shell), ..PLAIN },
    Section { name: "traces", protects: "traces, by Perfetto's own schema", needs: &[Python], check: |shell, _| python::traces(shell), ..PLAIN },
    Section { name: "shards", protects: "a sweep in shards, by Kubernetes' schemas", needs: &[Python], check: |shell, _| python::shards(shell), ..PLAIN },
    Section { name: "requirements", protects: "the robustness of requirements, by rtamt; response times in budgets, by PROSA's analysis", needs: &[Python], check: |shell, _| python::requirements(shell), ..PLAIN },
    Section { name: "strangers", protects: "servers with TLS and tokens, before clients of others", needs: &[Python, Node, TOOLS, OPENSSL, CURL], check: |shell, _| servers::strangers(shell), ..PLAIN },
    Section { name: "deployment", protects: "units, manifests, and servers behind a proxy", needs: &[Python, OPENSSL, CURL, NGINX, Program("systemd-analyze", "systemd")], check: |shell, _| servers::deployment(shell), ..PLAIN },
    Section { name: "ports", protects: "programs of others at serial ports", needs: &[Python, Program("gpsd", "gpsd")], check: |shell, _| chips::ports(shell), ..PLAIN },
    Section { name: "microcontroller", protects: "each instruction of the chip beside simavr", needs: &[File("/usr/include/simavr/sim_avr.h", "libsimavr-dev libelf-dev")], check: |shell, _| chips::microcontroller(shell), ..PLAIN },
    Section { name: "firmware", protects: "sketches and firmware of others on a robot's chip", needs: &[Python, Node, AVR_GCC, AVR_LIBC, ARDUINO_CORE, MAKE, Program("gpsd", "gpsd")], check: |shell, _| chips::firmware(shell), ..PLAIN },
    Section { name: "simulated-programs", protects: "programs of others in simulated time: one hash, the instants of the wire, refusals by name", needs: &[Python, AVR_GCC, AVR_LIBC, ARDUINO_CORE, Program("go", "golang-go"), Program("gpsd", "gpsd"), Program("socat", "socat")], check: |shell, _| chips::simulated_programs(shell), ..PLAIN },
    Section { name: "debugging", protects: "a robot's program under avr-gdb", needs: &[Python, AVR_GCC, AVR_LIBC, Program("avr-gdb", "gdb-avr")], check: |shell, _| chips::debugging(shell), ..PLAIN },
    Section { name: "new-brains", protects: "the projects of `baudbot new brain`", needs: &[Python], check: |shell, _| projects::new_brains(shell), ..PLAIN },
    Section { name: "examples", protects: "the brains in examples/, which drive one path to the last bit", needs: &[Python, Node, TOOLS, VIEWER, NodePackages(NodeFolder::TypeScript)], check: |shell, _| projects::examples(shell), ..PLAIN },
    Section { name: "languages", protects: "brains in C++, Go, Java, Ruby and for Node: built, tested, on that path, and true to the contract", needs: LANGUAGES, check: |shell, _| projects::languages(shell), ..PLAIN },

    Section { name: "longest-tests", rung: Rung::Release, protects: "the tests that take longest, of whole drives and of budgets", check: |shell, _| rust::longest_tests(shell), ..PLAIN },
    Section { name: "exercises", rung: Rung::Release, protects: "each exercise's solution, and the word for each mistake", needs: &[Python], check: |shell, _| python::exercises(shell), ..PLAIN },
    Section { name: "documentation", rung: Rung::Release, protects: "the crates' documentation", check: |shell, _| rust::documentation(shell), ..PLAIN },
    Section { name: "program", rung: Rung::Release, protects: "the program as README builds it: its first run, and what it says without features", check: |shell, _| rust::program(shell), ..PLAIN },
    Section { name: "instructions", rung: Rung::Release, protects: "what workloads cost, in instructions", needs: &[Program("valgrind", "valgrind")], check: |shell, _| rust::instructions(shell), ..PLAIN },
    Section { name: "gallery", rung: Rung::Release, protects: "the gallery's pictures", needs: &[Python], check: |shell, _| python::gallery(shell), ..PLAIN },
    Section { name: "optimised", rung: Rung::Release, protects: "the tests of numbers and of order in a release build", check: |shell, _| release::optimised(shell), ..PLAIN },
    Section { name: "aarch64", rung: Rung::Release, protects: "the same bits on another processor", needs: &[Target("aarch64-unknown-linux-gnu"), Program("aarch64-linux-gnu-gcc", "gcc-aarch64-linux-gnu"), File("/usr/aarch64-linux-gnu/lib/crt1.o", "libc6-dev-arm64-cross"), Program("qemu-aarch64", "qemu-user")], check: |shell, _| release::aarch64(shell), ..PLAIN },
    Section { name: "firefox", rung: Rung::Release, protects: "both pages in Firefox", needs: &[Node, TOOLS, VIEWER, WASI, Program("firefox-esr", "firefox-esr")], check: |shell, _| pages::firefox(shell), ..PLAIN },
    Section { name: "kills", rung: Rung::Release, protects: "what was told before a kill -9 is there after it", arguments: "[ROUNDS]", check: release::kills, ..PLAIN },
    Section { name: "network", rung: Rung::Release, protects: "servers and clients over a network that breaks in all ways", arguments: "[SEEDS | --seed SEED]", check: release::network, ..PLAIN },
    Section { name: "faults", rung: Rung::Release, protects: "what operators were told, over kills, power cuts, full disks and a broken network", arguments: "[SEEDS | --seed SEED]", check: release::faults, ..PLAIN },
    Section { name: "fuzz", rung: Rung::Release, protects: "all that reads bytes from outside, by counts of inputs", arguments: "[SECONDS | wanted]", check: release::fuzz, ..PLAIN },
    Section { name: "soak", rung: Rung::Release, protects: "a server with all that clients do at once: nothing grows", arguments: "[HOURS]", check: release::soak, ..PLAIN },
    Section { name: "cluster", rung: Rung::Release, protects: "sweeps on a cluster by Ray, a node of which is killed", needs: &[Python, Network], check: |shell, _| python::cluster(shell), ..PLAIN },
    Section { name: "container", rung: Rung::Release, protects: "the container's static program, in an empty root", needs: &[Root, Network], check: |shell, _| release::script(shell, "deploy/container/try", &[]), ..PLAIN },
    Section { name: "wheel", rung: Rung::Release, protects: "the wheel of a release, for old systems, too", needs: &[Python, Network], check: |shell, _| python::wheel(shell), ..PLAIN },
    Section { name: "release", rung: Rung::Release, protects: "a release, each file of it tried in a clean Debian", arguments: "[x86_64 | aarch64]…", needs: &[Root, Network, DEBOOTSTRAP], check: |shell, arguments| release::script(shell, "deploy/release/try", arguments) , ..PLAIN },
    Section { name: "ports-idle", rung: Rung::Release, protects: "programs of others at serial ports, in time by the wall clock", needs: &[Python, Program("gpsd", "gpsd")], check: |shell, _| chips::ports_in_time(shell), ..PLAIN },
    Section { name: "advisories", rung: Rung::Release, protects: "known vulnerabilities, by the RustSec database", needs: &[Network], check: |shell, _| rust::cargo_deny(shell, &["check", "advisories"]), ..PLAIN },

    Section { name: "quick", rung: Rung::Asked, protects: "formatting, lints and tests of some crates", arguments: "CRATE…", needs: &[RUSTFMT, CLIPPY], check: rust::quick, ..PLAIN },
    Section { name: "learn", rung: Rung::Asked, protects: "policies that learn at fast and slow cables, for an hour", needs: &[Python], check: |shell, _| python::learn(shell), ..PLAIN },
    Section { name: "map", rung: Rung::Asked, protects: "the picture of the crates in ARCHITECTURE.md; it is drawn anew", check: crate::map::write, ..PLAIN },
    Section { name: "notices", rung: Rung::Asked, protects: "the notices of others' work that builds of releases put into them", arguments: "[FOLDER]", check: crate::notices::write, ..PLAIN },
    Section { name: "licences", rung: Rung::Asked, protects: "a list of the licences of all that is built in", check: |shell, _| rust::cargo_deny(shell, &["list"]), ..PLAIN },
];

/// The sections of a rung, with those below it if it is of the ladder.
pub(crate) fn up_to(rung: Rung) -> impl Iterator<Item = &'static Section> {
    SECTIONS
        .iter()
        .filter(move |section| section.rung == rung || (rung == Rung::All && section.rung == Rung::Test))
}

/// The section of a name.
pub(crate) fn named(name: &str) -> Option<&'static Section> {
    SECTIONS.iter().find(|section| section.name == name)
}

/// A hint at the section that somebody may have meant.
pub(crate) fn similar(word: &str) -> String {
    let shared = |name: &str| name.chars().zip(word.chars()).take_while(|(one, other)| one == other).count();
    let best = SECTIONS.iter().max_by_key(|section| (shared(section.name), usize::MAX - section.name.len()));
    match best {
        Some(section) if shared(section.name) >= 3 => format!("; did you mean `{}`?", section.name),
        Some(_) | None => "; ./test --list has them all".to_owned(),
    }
}

/// The expected seconds of `./test all`.
pub(crate) fn sum_of_all(times: &Table<Duration>) -> u64 {
    up_to(Rung::All).filter_map(|section| times.get(section.name)).map(|time| time.wall_s).sum()
}

/// The release checks that have not been green within [`OLDEST`] commits, with their ages.
pub(crate) fn overdue(greens: &Table<Green>, age: impl Fn(&str) -> Option<u64>) -> Vec<(&'static str, u64)> {
    let aged = up_to(Rung::Release).map(|section| (section.name, age_of(section, greens, &age)));
    aged.filter(|(_, age)| *age > OLDEST).collect()
}

/// The release check whose turn it is: of those that are short, the one that was green longest ago. Several that were green at
/// the same commit take turns, by a number that grows with each commit.
pub(crate) fn next_release_check(
    greens: &Table<Green>,
    times: &Table<Duration>,
    turn: u64,
    age: impl Fn(&str) -> Option<u64>,
) -> Option<&'static Section> {
    let is_short =
        |section: &&Section| times.get(section.name).is_some_and(|time| time.wall_s <= LONGEST_TURN_S);
    let aged: Vec<_> = up_to(Rung::Release)
        .filter(is_short)
        .map(|section| (age_of(section, greens, &age), section))
        .collect();
    let oldest = aged.iter().map(|(age, _)| *age).max()?;
    let oldest: Vec<_> = aged.into_iter().filter(|(age, _)| *age == oldest).collect();
    let place = usize::try_from(turn).unwrap_or(0) % oldest.len();
    oldest.get(place).map(|(_, section)| *section)
}

/// The number of commits since a check was green. A commit that is not known here, as in a clone without its past,
/// counts as none.
fn age_of(section: &Section, greens: &Table<Green>, age: impl Fn(&str) -> Option<u64>) -> u64 {
    age(greens.get(section.name).map_or(FIRST, |green| &green.commit)).unwrap_or(0)
}

/// The faults of the tables of the ladder: each section of it has a time, and all of them together are short enough.
pub(crate) fn faults(times: &Table<Duration>, greens: &Table<Green>) -> Vec<String> {
    let mut faults = Vec::new();
    for section in up_to(Rung::All).filter(|section| !times.contains_key(section.name)) {
        faults.push(format!(
            "xtask/times.toml: there is no line for `{0}`; ./test {0} --write-times writes it",
            section.name
        ));
    }
    for name in times.keys().filter(|name| named(name).is_none()) {
        faults.push(format!("xtask/times.toml: there is no section `{name}`; remove the line"));
    }
    for name in greens.keys().filter(|name| named(name).is_none_or(|section| section.rung != Rung::Release)) {
        faults
            .push(format!("xtask/release-checks.toml: there is no release check `{name}`; remove the line"));
    }
    let sum = sum_of_all(times);
    if sum > LONGEST_S {
        faults.push(format!("xtask/times.toml: ./test all takes {sum} s, more than {LONGEST_S} s; move a section to the release checks"));
    }
    faults
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{FIRST, Rung, SECTIONS, faults, next_release_check, overdue, up_to};
    use crate::place::Place;
    use crate::records::{self, Duration, Green, Table};

    fn time(wall_s: u64) -> Duration {
        Duration { wall_s, processor_s: wall_s, commit: String::new(), machine: String::new() }
    }

    fn green(commit: &str) -> Green {
        Green { commit: commit.to_owned(), date: String::new(), log: String::new(), wall_s: 1 }
    }

    #[test]
    fn names_are_different_and_each_section_says_what_it_protects() {
        let names: BTreeSet<_> = SECTIONS.iter().map(|section| section.name).collect();
        assert_eq!(names.len(), SECTIONS.len());
        for section in SECTIONS {
            assert!(
                !section.name.is_empty()
                    && section.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
            );
            assert!(section.protects.len() > 10, "{}", section.name);
        }
        assert!(SECTIONS.is_sorted_by_key(|section| section.rung));
    }

    #[test]
    fn the_committed_tables_are_whole() {
        let root = Place::new().root;
        assert_eq!(
            faults(&records::times(&root).unwrap(), &records::greens(&root).unwrap()),
            Vec::<String>::new()
        );
    }

    #[test]
    fn a_section_without_a_time_a_ladder_that_is_too_long_and_lines_of_nothing_are_faults() {
        let mut times: Table<_> =
            up_to(Rung::All).map(|section| (section.name.to_owned(), time(10))).collect();
        assert!(faults(&times, &Table::new()).is_empty());
        times.insert("lints".to_owned(), time(4000));
        assert!(faults(&times, &Table::new())[0].contains("move a section to the release checks"));
        times.remove("lints");
        times.insert("lint".to_owned(), time(1));
        let greens = Table::from([("formatting".to_owned(), green("a"))]);
        let found = faults(&times, &greens).join("\n");
        assert!(
            found.contains("no line for `lints`")
                && found.contains("no section `lint`")
                && found.contains("no release check `formatting`"),
            "{found}"
        );
    }

    #[test]
    fn the_release_check_of_the_longest_past_comes_next_and_is_overdue_in_the_end() {
        let age = |commit: &str| {
            Some(match commit {
                "new" => 1,
                "old" => 301,
                FIRST => 20,
                _ => 0,
            })
        };
        let mut greens: Table<_> =
            up_to(Rung::Release).map(|section| (section.name.to_owned(), green("new"))).collect();
        let times: Table<_> = up_to(Rung::Release)
            .map(|section| (section.name.to_owned(), time(if section.name == "soak" { 700 } else { 60 })))
            .collect();
        assert!(overdue(&greens, age).is_empty());
        greens.remove("aarch64");
        assert_eq!(next_release_check(&greens, &times, 7, age).unwrap().name, "aarch64");
        greens.insert("kills".to_owned(), green("old"));
        greens.insert("soak".to_owned(), green("old"));
        assert_eq!(next_release_check(&greens, &times, 7, age).unwrap().name, "kills");
        let turns: BTreeSet<_> =
            (0..50).map(|turn| next_release_check(&Table::new(), &times, turn, age).unwrap().name).collect();
        assert_eq!(turns.len(), up_to(Rung::Release).count() - 1, "all but the soak, which is long");
        assert_eq!(overdue(&greens, age), [("kills", 301), ("soak", 301)]);
    }
}
