//! An SVG as elements, and as the tree that `usvg` makes of them.
//!
//! Elements that draw or group get an id if they have none, in a copy of the text: the parser keeps ids, and nothing
//! else by which the element of a path is known.

use std::collections::{BTreeMap, HashMap};
use std::str::FromStr;

use svgtypes::{NumberListParser, PathParser, Transform, ViewBox};
use usvg::roxmltree::{Document, Node, ParsingOptions};
use usvg::{ImageHrefResolver, Options, Tree};

use super::problem::DrawingError;

/// The text of a drawing in its own units, its upper left corner at (0, 0).
pub(crate) struct Drawing {
    text: String,
}

/// The attributes of elements by their ids.
#[derive(Default)]
pub(crate) struct Elements(HashMap<String, Element>);

/// An element that draws or groups.
#[derive(Clone, Default)]
pub(crate) struct Element {
    /// The element's id and those of the groups that it is in, innermost first; none that were made here.
    pub(crate) ids: Vec<String>,
    pub(crate) classes: Vec<String>,
    /// The names of the layers that it is in: groups of Inkscape's with a label, and others with an id.
    pub(crate) layers: Vec<String>,
}

impl Drawing {
    /// # Errors
    /// If it is no drawing, or has something that the parser would ignore silently.
    pub(crate) fn read(text: &str) -> Result<Self, DrawingError> {
        let document = document(text)?;
        check(&document)?;
        Ok(Self { text: rewritten(text, &document) })
    }

    /// The tree that `usvg` makes of it with a style sheet of ours.
    pub(crate) fn tree(&self, style: Option<&str>) -> Result<Tree, DrawingError> {
        let options = Options {
            style_sheet: style.map(str::to_owned),
            // An image may be any file on this machine.
            image_href_resolver: ImageHrefResolver {
                resolve_data: Box::new(|_, _, _| None),
                resolve_string: Box::new(|_, _| None),
            },
            ..Options::default()
        };
        Tree::from_xmltree(&document(&self.text)?, &options).map_err(DrawingError::Svg)
    }

    pub(crate) fn elements(&self) -> Result<Elements, DrawingError> {
        let document = document(&self.text)?;
        let with_ids = || document.descendants().filter_map(|node| Some((node.attribute("id")?, node)));
        let all: HashMap<&str, Node<'_, '_>> = with_ids().collect();
        let mut elements = Elements::default();
        for (id, node) in with_ids().filter(|(_, node)| is_kept(node)) {
            let mut element = Element::of(node);
            // Of what is drawn by reference, the paths have no ids.
            let href = node.attributes().find(|attribute| attribute.name() == "href");
            let used = href.and_then(|href| all.get(href.value().strip_prefix('#')?));
            if let Some(used) = used.filter(|_| node.tag_name().name() == "use") {
                element.take_own(*used);
            }
            elements.0.entry(id.to_owned()).or_insert(element);
        }
        Ok(elements)
    }

    /// The number of images and of texts, which are passed over.
    pub(crate) fn passed_over(&self) -> Result<[usize; 2], DrawingError> {
        let document = document(&self.text)?;
        let count = |name| document.descendants().filter(|node| node.tag_name().name() == name).count();
        Ok(["image", "text"].map(count))
    }
}

impl Elements {
    pub(crate) fn of(&self, id: &str) -> Option<&Element> {
        self.0.get(id)
    }
}

impl Element {
    fn of(node: Node<'_, '_>) -> Self {
        let mut element = Self::default();
        for node in node.ancestors().filter(Node::is_element) {
            let id = element.take_own(node);
            let label = node.attributes().find(|attribute| {
                attribute.name() == "label"
                    && attribute.namespace().is_some_and(|space| space.contains("inkscape"))
            });
            if node.tag_name().name() == "g" {
                element.layers.extend(label.map(|label| label.value()).or(id).map(str::to_owned));
            }
        }
        element
    }

    /// Adds id and classes of an element itself, and gives the id back.
    fn take_own<'a>(&mut self, node: Node<'a, '_>) -> Option<&'a str> {
        let id = node.attribute("id").filter(|id| is_given(id));
        self.ids.extend(id.map(str::to_owned));
        let classes = node.attribute("class").unwrap_or_default().split_whitespace();
        self.classes.extend(classes.map(str::to_owned));
        id
    }
}

/// Whether it is an id that the author of the drawing gave.
pub(crate) fn is_given(id: &str) -> bool {
    !id.is_empty() && !id.starts_with(MADE)
}

/// Ids that were made here begin so.
const MADE: &str = "made-by-baudbot-";

fn is_kept(node: &Node<'_, '_>) -> bool {
    let names = ["path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "g", "use"];
    names.contains(&node.tag_name().name())
}

fn document(text: &str) -> Result<Document<'_>, DrawingError> {
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(DrawingError::Xml)
}

/// Refuses what the parser would ignore silently.
fn check(document: &Document<'_>) -> Result<(), DrawingError> {
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        return Err(DrawingError::Root(root.tag_name().name().to_owned()));
    }
    match root.attribute("viewBox") {
        Some(view_box) => {
            ViewBox::from_str(view_box).map_err(DrawingError::ViewBox)?;
        }
        None => {
            let is_length =
                |name| root.attribute(name).is_some_and(|length| !length.trim_end().ends_with('%'));
            if !is_length("width") || !is_length("height") {
                return Err(DrawingError::NoSize);
            }
        }
    }
    for node in document.descendants() {
        for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if let Err(error) = sound(node.tag_name().name(), attribute.name(), attribute.value()) {
                let line = document.text_pos_at(attribute.range().start).row;
                let attribute = attribute.name().to_owned();
                return Err(DrawingError::Attribute { line, attribute, error });
            }
        }
    }
    Ok(())
}

/// Whether the value of an element's attribute can be read to its end.
fn sound(element: &str, attribute: &str, value: &str) -> Result<(), svgtypes::Error> {
    match (element, attribute) {
        ("path", "d") => PathParser::from(value).try_for_each(|segment| segment.map(drop)),
        ("polygon" | "polyline", "points") => {
            NumberListParser::from(value).try_for_each(|number| number.map(drop))
        }
        (_, "transform") if value.trim() != "none" => Transform::from_str(value).map(drop),
        _ => Ok(()),
    }
}

/// The text with an id for each element that draws or groups; and without the size on paper, if it has a view box: the parser would
/// scale the drawing to it.
fn rewritten(text: &str, document: &Document<'_>) -> String {
    let root = document.root_element();
    // The changes by their beginnings: how far each reaches, and what comes there.
    let mut changes: BTreeMap<usize, (usize, String)> = BTreeMap::new();
    if root.attribute("viewBox").is_some() {
        let is_size = |name| matches!(name, "width" | "height" | "preserveAspectRatio");
        let sizes = root
            .attributes()
            .filter(|attribute| attribute.namespace().is_none() && is_size(attribute.name()));
        changes.extend(sizes.map(|size| (size.range().start, (size.range().end, String::new()))));
    }
    for (i, node) in document.descendants().filter(is_kept).enumerate() {
        if node.attribute("id").is_none() {
            let start = node.range().start;
            let name = text[start..].find(|c: char| c.is_ascii_whitespace() || c == '/' || c == '>');
            // An element that an entity stands for begins elsewhere.
            let behind = name.filter(|_| text[start..].starts_with('<')).map(|length| start + length);
            changes.extend(behind.map(|behind| (behind, (behind, format!(" id=\"{MADE}{i}\"")))));
        }
    }
    let mut rewritten = String::with_capacity(text.len());
    let mut from = 0;
    for (start, (end, new)) in changes {
        rewritten += &text[from..start];
        rewritten += &new;
        from = end;
    }
    rewritten + &text[from..]
}

const MAX_NODES: u32 = 4_000_000;
