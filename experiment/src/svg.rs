//! Elements of SVG as text.
//!
//! A crate for this would keep the whole picture as a tree and leave the form of numbers to us all the same; what is
//! needed of it is what is below.

use std::fmt::Write;

use baudbot_sim::printable::is_printable;

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
    /// An element that has an end.
    pub fn put(&mut self, element: Element) {
        let _ = match element.inside.is_empty() {
            true => writeln!(self.text, "<{}/>", element.tag()),
            false => writeln!(self.text, "<{}>{}</{}>", element.tag(), element.inside, element.name),
        };
    }

    /// The begin of an element: what is put is in it until it is closed.
    pub fn open(&mut self, element: Element) {
        let _ = writeln!(self.text, "<{}>{}", element.tag(), element.inside);
    }

    /// The end of an element that was opened.
    pub fn close(&mut self, name: &str) {
        let _ = writeln!(self.text, "</{name}>");
    }

    /// Dots at the ends of lines that have no length, if there are any.
    pub fn put_dots(&mut self, dots: &str) {
        if !dots.is_empty() {
            let dots = Element::new("path").set("d", dots).set("fill", "none");
            self.put(dots.set("stroke-width", "4").set("stroke-linecap", "round"));
        }
    }

    /// All of another canvas.
    pub fn append(&mut self, other: &Self) {
        self.text += &other.text;
    }

    /// Whether nothing was put into it.
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

    /// An attribute of any text, in place of the one of this name that it may have: XML allows only one.
    pub fn set(mut self, name: &'static str, value: &str) -> Self {
        match self.attributes.iter_mut().find(|(other, _)| *other == name) {
            Some((_, old)) => *old = escape(value),
            None => self.attributes.push((name, escape(value))),
        }
        self
    }

    /// An attribute that is a number.
    pub fn number(self, name: &'static str, value: f64) -> Self {
        self.set(name, &px(value))
    }

    /// What a browser shows when the mouse rests on it.
    pub fn titled(mut self, title: &str) -> Self {
        let _ = write!(self.inside, "<title>{}</title>", escape(title));
        self
    }

    /// Text in it.
    pub fn text(mut self, text: &str) -> Self {
        self.inside += &escape(text);
        self
    }

    /// Another element in it.
    pub fn with(mut self, child: Self) -> Self {
        let mut canvas = Canvas::default();
        canvas.put(child);
        self.inside += canvas.text.trim_end();
        self
    }

    /// What stands between the brackets that begin it.
    fn tag(&self) -> String {
        let attribute = |(name, value): &(&str, String)| format!(" {name}=\"{value}\"");
        self.name.to_owned() + &self.attributes.iter().map(attribute).collect::<String>()
    }
}

/// A number with at most two decimals: a hundredth of a pixel is seen by nobody. What is far outside of every
/// picture is brought nearer, as not everybody who draws can count that far.
pub fn px(value: f64) -> String {
    let near = if value.is_finite() { value.clamp(-FAR, FAR) } else { 0.0 };
    let text = format!("{near:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text as it may stand in an element or an attribute. A character that XML does not know at all, or that nobody would see, is
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

/// Farther than any picture reaches.
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
