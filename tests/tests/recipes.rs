//! The recipes of the contributors' manual are true of their examples: what they name is there, and they name all that the example took.
//! Source files that the other documents name are there, too.

use std::fs;
use std::path::Path;

const RECIPES: &str = include_str!("../../docs/architecture/recipes.md");

/// Files that mention an example without being named one by one: what is written about it, what tests it, and what is
/// generated.
const BESIDE: [&str; 7] =
    ["docs/", "tests/", "/tests/", "proto/src/generated/", "viewer/src/gen/", "viewer/dist/", ".md"];

struct Recipe {
    title: &'static str,
    /// The example's name as it may stand in a file: `optical_flow`, `optical-flow`, `OpticalFlow`, `opticalFlow`, `OPTICAL_FLOW`.
    forms: [String; 5],
    /// The paths that it names; folders end in `/`.
    paths: Vec<&'static str>,
    /// Whether it names every file that mentions the example.
    is_complete: bool,
}

fn recipes() -> Vec<Recipe> {
    RECIPES.split("\n## ").filter(|section| section.starts_with("How to add ")).map(Recipe::read).collect()
}

impl Recipe {
    fn read(section: &'static str) -> Self {
        let title = section.lines().next().unwrap();
        let quoted: Vec<_> = section.split('`').skip(1).step_by(2).collect();
        let example = section.split_once("The example is `").and_then(|(_, rest)| rest.split_once('`'));
        let (example, _) = example.unwrap_or_else(|| panic!("{title}: say `The example is …`"));
        let is_path = |word: &&str| word.contains('/') && !word.contains(' ');
        let paths = quoted.into_iter().filter(is_path).collect();
        let is_complete = !section.contains("this list is not checked for completeness");
        Self { title, forms: forms(example), paths, is_complete }
    }

    /// The path, of the example.
    fn of_example(&self, path: &str) -> Vec<String> {
        self.forms.iter().map(|form| path.replace("NAME", form)).collect()
    }

    fn names(&self, file: &str) -> bool {
        let is_it = |path: String| file == path || (path.ends_with('/') && file.starts_with(&path));
        self.paths.iter().any(|path| self.of_example(path).into_iter().any(is_it))
    }
}

/// A name in snake or camel case, in all cases.
fn forms(name: &str) -> [String; 5] {
    let mut words: Vec<String> = Vec::new();
    for letter in name.chars() {
        if letter == '_' || letter.is_uppercase() || words.is_empty() {
            words.push(String::new());
        }
        words.last_mut().unwrap().extend(letter.to_lowercase().filter(|&c| c != '_'));
    }
    let camel: String = words.iter().map(|word| word[..1].to_uppercase() + &word[1..]).collect();
    let lower = camel[..1].to_lowercase() + &camel[1..];
    let upper = words.join("_").to_uppercase();
    [words.join("_"), words.join("-"), camel, lower, upper]
}

/// The files below a folder with their text, by their paths from the root; what is hidden, built or fetched is left out.
fn texts(root: &Path, folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy();
        // An example in Go that was built has a link back to its own folder.
        let is_built = name == "build" && path.starts_with(root.join("examples"));
        if name.starts_with('.') || ["target", "node_modules"].contains(&&*name) || is_built {
            continue;
        }
        if path.is_dir() {
            texts(root, &path, found);
        } else if let Ok(text) = fs::read_to_string(&path) {
            found.push((path.strip_prefix(root).unwrap().to_str().unwrap().to_owned(), text));
        }
    }
}

#[test]
fn what_a_recipe_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let recipes = recipes();
    assert!(recipes.len() >= 3, "found only {} recipes", recipes.len());
    for recipe in recipes {
        assert!(recipe.paths.len() > 4, "{} names only {:?}", recipe.title, recipe.paths);
        for path in &recipe.paths {
            let is_there = recipe.of_example(path).iter().any(|path| root.join(path).exists());
            assert!(is_there, "{} names `{path}`, which is not there", recipe.title);
        }
    }
}

#[test]
fn a_recipe_names_all_that_its_example_took() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    texts(&root, &root, &mut files);
    for recipe in recipes().into_iter().filter(|recipe| recipe.is_complete) {
        let takes = |&(path, text): &(&str, &str)| {
            recipe.forms.iter().any(|form| path.contains(&**form) || text.contains(&**form))
        };
        let is_beside = |path: &str| {
            BESIDE.iter().any(|part| {
                if part.starts_with('/') {
                    path.contains(part)
                } else {
                    path.starts_with(part) || path.ends_with(part)
                }
            })
        };
        let all = files.iter().map(|(path, text)| (path.as_str(), text.as_str())).filter(takes);
        let took: Vec<_> = all.map(|(path, _)| path).filter(|path| !is_beside(path)).collect();
        assert!(took.len() > 1, "{}: only {took:?} mention {:?}", recipe.title, recipe.forms);
        let missing: Vec<_> = took.into_iter().filter(|path| !recipe.names(path)).collect();
        assert!(
            missing.is_empty(),
            "{} does not name {missing:?}, which mention {:?}",
            recipe.title,
            recipe.forms
        );
    }
}

#[test]
fn a_name_has_its_forms() {
    let expected = ["optical_flow", "optical-flow", "OpticalFlow", "opticalFlow", "OPTICAL_FLOW"];
    assert_eq!(forms("optical_flow"), expected);
    assert_eq!(forms("OpticalFlow"), expected);
}

#[test]
fn source_files_that_documents_name_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = Vec::new();
    texts(&root, &root, &mut found);
    let is_document = |path: &str| {
        path == "ARCHITECTURE.md"
            || path == "README.md"
            || (path.starts_with("docs/") && path.ends_with(".md"))
    };
    // `NAME` stands for a thing's own name.
    let is_source =
        |name: &str| name.ends_with(".rs") && !name.contains(char::is_whitespace) && !name.contains("NAME");
    let mut named = 0;
    for (document, text) in found.iter().filter(|(path, _)| is_document(path)) {
        let quoted = text.split('`').skip(1).step_by(2);
        for name in quoted.filter(|quoted| is_source(quoted)) {
            named += 1;
            let below = format!("/{name}");
            let is_there = found.iter().any(|(path, _)| path == name || path.ends_with(&below));
            assert!(is_there, "{document} names {name}, and there is no such file");
        }
    }
    assert!(named > 200, "{named}");
}
