//! The texts of `./test --help` and `./test --list`.

use crate::ladder::in_words;
use crate::place::Place;
use crate::records::{self, Error};
use crate::sections::{self, Rung, SECTIONS};

/// The usage.
pub(crate) const HELP: &str = "\
usage: ./test                     what a contributor runs
       ./test all                 everything that a change must pass, as continuous integration runs it
       ./test release-checks      what is checked before a release
       ./test SECTION…            some sections, by their names
       ./test SECTION ARGUMENT…   a section that takes arguments
       ./test house [--rev COMMIT] [--check]   the structure of the code, in figures

  --list            all sections, with what they protect, what they need, and how long they take
  --install         install the tools that are missing (apt, rustup, npm); without it they are named before anything runs
  --from SECTION    begin with this section
  --resume          pass over what has passed on this state of the tree
  --keep-going      go on after a section that fails
  --repeat N        run each section N times; the results are kept in target/test/repeats
  --load            keep all processors busy meanwhile
  --write-times     keep how long the sections took as what is expected (xtask/times.toml)

The output of a section is also in target/test/SECTION.log.
";

/// Prints the table of sections.
///
/// # Errors
///
/// Records cannot be read.
pub(crate) fn print() -> Result<(), Error> {
    let root = Place::new().root;
    let (times, greens) = (records::times(&root)?, records::greens(&root)?);
    for rung in [Rung::Test, Rung::All, Rung::Release, Rung::Asked] {
        let sections = || SECTIONS.iter().filter(|section| section.rung == rung);
        let sum: u64 = sections().filter_map(|section| times.get(section.name)).map(|time| time.wall_s).sum();
        let added = if rung == Rung::All { ", in addition" } else { "" };
        println!("{}, {}{added}", rung.title(), in_words(sum));
        for section in sections() {
            let time =
                times.get(section.name).map_or_else(|| "?".to_owned(), |time| format!("{} s", time.wall_s));
            let name = [section.name, section.arguments].join(" ");
            println!("  {name:26} {time:>7}  {}", section.protects);
            let needs: Vec<_> = section.needs.iter().map(|need| need.word()).collect();
            if !needs.is_empty() {
                println!("{:37} needs {}", "", needs.join(", "));
            }
            if rung == Rung::Release {
                let green = greens.get(section.name).map_or_else(
                    || "never seen green".to_owned(),
                    |green| format!("last green on {} at {}", green.date, green.commit),
                );
                println!("{:37} {green}", "");
            }
        }
        println!();
    }
    println!(
        "./test all takes {} s in sum; its limit is {} s",
        sections::sum_of_all(&times),
        sections::LONGEST_S
    );
    Ok(())
}
