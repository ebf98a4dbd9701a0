//! Elements of SVG as text, and the shapes that every picture is made of.
//!
//! A crate for SVG would keep the picture as a tree, and would leave the form of numbers to the caller all the same.

mod path;

use std::fmt::Write;

use baudbot_fields::printable::is_printable;

pub use self::path::{Place, arrow_head, drawn, path, rectangle, simplified};
use crate::palette::{FRAME, PAPER};

/// Elements one after the other.
#[derive(Debug, Default)]
pub struct Canvas {
    text: String,
}

/// An element with its attributes.
#[derive(Clone, Debug)]
pub struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    inside: String,
}

impl Canvas {
    /// Adds an element.
    pub fn put(&mut self, element: Element) {
        let _ = match element.inside.is_empty() {
            true => writeln!(self.text, "<{}/>", element.tag()),
            false => writeln!(self.text, "<{}>{}</{}>", element.tag(), element.inside, element.name),
        };
    }

    /// Opens an element: it contains what is added until it is closed.
    pub fn open(&mut self, element: Element) {
        let _ = writeln!(self.text, "<{}>{}", element.tag(), element.inside);
    }

    /// Closes the element that was opened last; `name` is its name.
    pub fn close(&mut self, name: &str) {
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Adds dots, which are lines of no length with round ends, if there are any.
    pub fn put_dots(&mut self, dots: &str) {
        if !dots.is_empty() {
            let dots = Element::new("path").set("d", dots).set("fill", "none");
            self.put(dots.set("stroke-width", "4").set("stroke-linecap", "round"));
        }
    }

    /// Adds all elements of another canvas.
    pub fn append(&mut self, other: &Self) {
        self.text += &other.text;
    }

    /// Whether it has no elements.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// The text of all its elements.
    pub fn into_text(self) -> String {
        self.text
    }
}

impl Element {
    /// An element without attributes.
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: Vec::new(), inside: String::new() }
    }

    /// A group, to share attributes and a title.
    pub fn group() -> Self {
        Self::new("g")
    }

    /// Sets an attribute to a text, in place of the value that it may have: XML allows one attribute of a name.
    pub fn set(mut self, name: &'static str, value: &str) -> Self {
        match self.attributes.iter_mut().find(|(other, _)| *other == name) {
            Some((_, old)) => *old = escape(value),
            None => self.attributes.push((name, escape(value))),
        }
        self
    }

    /// Sets an attribute to a number.
    pub fn number(self, name: &'static str, value: f64) -> Self {
        self.set(name, &px(value))
    }

    /// Adds the tooltip of the element.
    pub fn titled(mut self, title: &str) -> Self {
        let _ = write!(self.inside, "<title>{}</title>", escape(title));
        self
    }

    /// Adds text to the element.
    pub fn text(mut self, text: &str) -> Self {
        self.inside += &escape(text);
        self
    }

    /// Adds a child.
    pub fn with(mut self, child: Self) -> Self {
        let mut canvas = Canvas::default();
        canvas.put(child);
        self.inside += canvas.text.trim_end();
        self
    }

    /// The start tag without its brackets.
    fn tag(&self) -> String {
        let attribute = |(name, value): &(&str, String)| format!(" {name}=\"{value}\"");
        self.name.to_owned() + &self.attributes.iter().map(attribute).collect::<String>()
    }
}

/// The root of a picture with this width and height, in pixels.
pub fn root((width, height): (f64, f64)) -> Element {
    let root = Element::new("svg").set("xmlns", "http://www.w3.org/2000/svg").number("width", width);
    root.number("height", height).set("viewBox", &format!("0 0 {} {}", px(width), px(height)))
}

/// The background of a picture with this width and height, in pixels.
pub fn paper((width, height): (f64, f64)) -> Element {
    let paper = rectangle((0.5, 0.5), (width - 1.0, height - 1.0)).set("rx", "10");
    paper.set("fill", PAPER).set("stroke", FRAME)
}

/// Text of a size in pixels, which begins at a place.
pub fn text((x, y): Place, size: f64, color: &str, text: &str) -> Element {
    let at = Element::new("text").number("x", x).number("y", y).number("font-size", size);
    at.set("fill", color).text(text)
}

/// A number with at most two decimals: a hundredth of a pixel is too small to see. Numbers far outside of every picture
/// are clamped, since not every viewer can count that far.
pub fn px(value: f64) -> String {
    let near = if value.is_finite() { value.clamp(-FAR, FAR) } else { 0.0 };
    let text = format!("{near:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// The text escaped for an element or an attribute. Characters that XML does not allow, or that are invisible, are
/// replaced.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\t' | '\n' | '\r' => escaped.push(' '),
            c if is_printable(c) && !matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(c),
            _ => escaped.push('\u{fffd}'),
        }
    }
    escaped
}

/// No picture is larger, in pixels.
const FAR: f64 = 1e7;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_a_meaning_in_xml_is_escaped() {
        assert_eq!(escape("a<b>&\"c\"\u{1}\n"), "a&lt;b&gt;&amp;&quot;c&quot;\u{fffd} ");
    }

    #[test]
    fn numbers_are_short_and_always_numbers() {
        let texts = [1.0, 0.126, -0.001, 10.0, f64::NAN, 1e300, -2.5].map(px);
        assert_eq!(texts, ["1", "0.13", "0", "10", "0", "10000000", "-2.5"]);
    }

    #[test]
    fn elements_nest() {
        let mut canvas = Canvas::default();
        canvas.open(Element::group().titled("1 < 2"));
        canvas.put(Element::new("circle").number("r", 2.5).set("fill", "red").number("r", 1.5));
        canvas.close("g");
        let expected = "<g><title>1 &lt; 2</title>\n<circle r=\"1.5\" fill=\"red\"/>\n</g>\n";
        assert_eq!(canvas.into_text(), expected);
    }
}
