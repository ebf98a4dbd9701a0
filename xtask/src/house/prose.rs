//! Comments as prose: how many there are, and how many begin with a clause in place of a sentence.

use super::text::{Comment, comments};

/// The words with which a clause-comment begins.
const CLAUSES: [&str; 6] = ["What", "How", "Where", "Which", "Who", "Why"];

/// The number of comments in files, and of clause-comments among them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Prose {
    /// Paragraphs: lines below each other with one marker, up to a blank one. An item of a list is a paragraph of its
    /// own, a comment behind code too; a block of code within a comment is none.
    pub(super) comments: usize,
    /// Paragraphs whose first word is one of [`CLAUSES`], unless their first sentence is a question.
    pub(super) clauses: usize,
}

impl Prose {
    /// Adds a file's comments.
    pub(super) fn add(&mut self, text: &str) {
        let paragraphs = paragraphs(text);
        self.comments += paragraphs.len();
        self.clauses += paragraphs.iter().filter(|paragraph| is_clause(paragraph)).count();
    }

    /// The comments of both.
    pub(super) fn plus(self, other: Self) -> Self {
        Self { comments: self.comments + other.comments, clauses: self.clauses + other.clauses }
    }

    /// Clause-comments among a thousand comments, rounded up.
    pub(super) fn clauses_in_1000(self) -> usize {
        (self.clauses * 1000).div_ceil(self.comments.max(1))
    }
}

/// The paragraphs of all comments, each on one line.
pub(super) fn paragraphs(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut is_code = false;
    let mut above: Option<Comment> = None;
    for comment in comments(text) {
        let line = comment.text.trim();
        if line.starts_with("```") {
            is_code = !is_code;
        }
        if is_code || line.is_empty() || line.starts_with("```") {
            above = None;
            continue;
        }
        let item = ["- ", "* "].iter().find_map(|bullet| line.strip_prefix(bullet));
        match found.last_mut() {
            Some(paragraph) if item.is_none() && above.is_some_and(|above| comment.continues(above)) => {
                paragraph.push(' ');
                paragraph.push_str(line);
            }
            Some(_) | None => found.push(item.unwrap_or(line).to_owned()),
        }
        above = Some(comment);
    }
    found
}

/// Whether a paragraph begins as a subordinate clause does.
fn is_clause(paragraph: &str) -> bool {
    let first = paragraph.split(|character: char| !character.is_alphanumeric() && character != '-').next();
    let sentence = paragraph.split_inclusive(['.', '?', '!']).next().unwrap_or_default();
    first.is_some_and(|first| CLAUSES.contains(&first)) && !sentence.ends_with('?')
}
