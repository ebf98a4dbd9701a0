//! The map of the crates: a picture of which crate needs which, for ARCHITECTURE.md.
//!
//! A crate lies one floor above the highest that it needs. A line leads to what it needs directly; one that follows from
//! others is left out. Optional dependencies count, those of tests do not.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::shell::{Failure, Shell};

/// The picture, below the root of the repository.
const PICTURE: &str = "docs/pictures/crates.svg";

/// Draws the map anew.
pub(crate) fn write(shell: &Shell, _: &[String]) -> Result<(), Failure> {
    let path = shell.place.root.join(PICTURE);
    fs::write(&path, drawing(shell)?).map_err(Failure::file(&path))?;
    shell.say(&path.display().to_string());
    Ok(())
}

/// A line for `./test structure`, if the map is not that of the crates as they are.
pub(crate) fn finding(shell: &Shell) -> Result<Option<String>, Failure> {
    let drawn = fs::read_to_string(shell.place.root.join(PICTURE)).unwrap_or_default();
    let is_current = drawn == drawing(shell)?;
    Ok((!is_current).then(|| format!("{PICTURE}: is not the map of the crates; ./test map draws it")))
}

#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Package>,
}

#[derive(Deserialize)]
struct Package {
    name: String,
    manifest_path: PathBuf,
    dependencies: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    name: String,
    /// None if it is normal; else it is for builds or for tests.
    kind: Option<String>,
}

/// A crate on the map.
struct Place {
    /// The folder from the root.
    folder: String,
    /// Neither files nor sockets, threads or clocks: it is `no_std`.
    is_pure: bool,
    needs: BTreeSet<String>,
    floor: usize,
}

type Places = BTreeMap<String, Place>;

fn drawing(shell: &Shell) -> Result<String, Failure> {
    let command = shell.cargo(["metadata", "--format-version", "1", "--no-deps", "--offline"]);
    let metadata: Metadata = serde_json::from_str(&shell.text(command)?)
        .map_err(|error| Failure::Wrong(format!("cargo metadata tells what is not understood: {error}")))?;
    Ok(svg(&places(&metadata.packages, &shell.place.root)))
}

fn places(packages: &[Package], root: &Path) -> Places {
    let is_ours = |name: &String| packages.iter().any(|package| package.name == *name);
    let place = |package: &Package| {
        let folder = package.manifest_path.parent().unwrap_or(root);
        let library = fs::read_to_string(folder.join("src/lib.rs")).unwrap_or_default();
        let normal = package.dependencies.iter().filter(|dependency| dependency.kind.is_none());
        Place {
            folder: folder.strip_prefix(root).unwrap_or(folder).display().to_string(),
            is_pure: library.lines().any(|line| line == "#![no_std]"),
            needs: normal.map(|dependency| dependency.name.clone()).filter(is_ours).collect(),
            floor: 0,
        }
    };
    let mut places: Places = packages.iter().map(|package| (package.name.clone(), place(package))).collect();
    // Cargo lets no circle through, so that no floor rises more often than there are crates.
    for _ in 0..places.len() {
        let floors: BTreeMap<_, _> = places.iter().map(|(name, place)| (name.clone(), place.floor)).collect();
        for place in places.values_mut() {
            place.floor = place.needs.iter().map(|need| floors[need] + 1).max().unwrap_or(0);
        }
    }
    places
}

/// All that a crate needs, directly or not.
fn reached<'a>(places: &'a Places, name: &str, seen: &mut BTreeSet<&'a str>) {
    for need in &places[name].needs {
        if seen.insert(need) {
            reached(places, need, seen);
        }
    }
}

/// Needs that do not follow from other needs.
fn direct<'a>(places: &'a Places, name: &str) -> Vec<&'a str> {
    let mut indirect = BTreeSet::new();
    for need in &places[name].needs {
        reached(places, need, &mut indirect);
    }
    places[name].needs.iter().map(String::as_str).filter(|need| !indirect.contains(need)).collect()
}

const WIDTH: usize = 1000;
const BOX: (usize, usize) = (126, 30);
const FLOOR: usize = 74;
const TOP: usize = 56;

fn svg(places: &Places) -> String {
    let highest = places.values().map(|place| place.floor).max().unwrap_or(0);
    let centres = centres(places, highest);
    let height = TOP + highest * FLOOR + BOX.1 + 20;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" \
         font-family=\"system-ui, Helvetica, Arial, sans-serif\" font-size=\"13\"><title>The crates and what they need</title>\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#f7f8fa\"/>\n\
         <text x=\"20\" y=\"28\" fill=\"#3c4656\">A line leads down to a crate that is needed. Green: pure (no_std), without clock, file, socket or thread.</text>\n"
    );
    for (name, &(x, y)) in &centres {
        for need in direct(places, name) {
            let (to, below) = centres[need];
            let (from, half) = (y + BOX.1, (below - y) / 2);
            let _ = writeln!(
                svg,
                "<path d=\"M{x} {from}C{x} {} {to} {} {to} {below}\" fill=\"none\" stroke=\"#8a93a3\"/>",
                y + half,
                below - half / 2
            );
        }
    }
    for (name, &(x, y)) in &centres {
        let place = &places[*name];
        let fill = if place.is_pure { "#d9efe0" } else { "#ffffff" };
        let _ = writeln!(
            svg,
            "<rect x=\"{}\" y=\"{y}\" width=\"{}\" height=\"{}\" rx=\"5\" fill=\"{fill}\" stroke=\"#3c4656\"/>\
             <text x=\"{x}\" y=\"{}\" text-anchor=\"middle\" fill=\"#1d2430\">{}</text>",
            x - BOX.0 / 2,
            BOX.0,
            BOX.1,
            y + 20,
            place.folder
        );
    }
    svg + "</svg>\n"
}

/// The middle of the upper edge of each box. The highest floor is on top, and the crates of a floor lie near those that need them.
fn centres(places: &Places, highest: usize) -> BTreeMap<&str, (usize, usize)> {
    let mut centres: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for floor in (0..=highest).rev() {
        let around = |name: &str| {
            let above: Vec<_> =
                centres.iter().filter(|(user, _)| places[**user].needs.contains(name)).collect();
            let sum: usize = above.iter().map(|(_, (x, _))| x).sum();
            sum.checked_div(above.len()).unwrap_or(WIDTH / 2)
        };
        let mut names: Vec<(usize, &str)> = places
            .iter()
            .filter(|(_, place)| place.floor == floor)
            .map(|(name, _)| (around(name), name.as_str()))
            .collect();
        names.sort_unstable();
        let count = names.len();
        for (n, (_, name)) in names.into_iter().enumerate() {
            centres.insert(name, ((2 * n + 1) * WIDTH / (2 * count), TOP + (highest - floor) * FLOOR));
        }
    }
    centres
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, needs: &[(&str, Option<&str>)]) -> Package {
        let dependency = |(name, kind): &(&str, Option<&str>)| Dependency {
            name: (*name).to_owned(),
            kind: kind.map(str::to_owned),
        };
        Package {
            name: name.to_owned(),
            manifest_path: format!("/root/{name}/Cargo.toml").into(),
            dependencies: needs.iter().map(dependency).collect(),
        }
    }

    #[test]
    fn a_crate_lies_above_all_that_it_needs_and_a_line_that_follows_from_others_is_left_out() {
        let packages = [
            package("robot", &[("arm", None), ("hand", None), ("serde", None), ("tool", Some("dev"))]),
            package("arm", &[("hand", None)]),
            package("hand", &[]),
            package("tool", &[]),
        ];
        let places = places(&packages, Path::new("/root"));
        let floors: Vec<_> = places.iter().map(|(name, place)| (name.as_str(), place.floor)).collect();
        assert_eq!(floors, [("arm", 1), ("hand", 0), ("robot", 2), ("tool", 0)]);
        assert_eq!(direct(&places, "robot"), ["arm"]);
        assert_eq!(svg(&places).matches("<path").count(), 2);
    }
}
