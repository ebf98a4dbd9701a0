//! Plans in SVG.
//!
//! `usvg` resolves styles, transforms, `use` and units; what it gives back are paths. Only outlines and whether they
//! are filled matter here: a style sheet of our own takes strokes, markers, masks and the like out of its hands, so
//! that a shape counts whether it can be seen on paper or not. `display`, `visibility` and an opacity of 0 hide a shape
//! from us, too, and so does a clip path around it. Text and images are passed over. The entry of the scenario may
//! choose among the shapes; a note names what is left out.

use std::collections::HashMap;
use std::path::Path;

use usvg::{Group, Tree};

use super::clip::{self, Clipped};
use super::drawing::{self, Drawing, Elements};
use super::entry::{Choice, Plan, Wanted};
use super::mapped::Mapped;
use super::marks::Mark;
use super::outlines::{self, Outline, Placement, Rim};
use super::problem::{DrawingError, ShapeError};
use super::select::{Paint, Selector, Traits, listed};
use super::shape::{FileNote, MAX_SHAPES, Shape};
use crate::error::FileError;
use crate::file;
use crate::note::Weight;

/// The shapes of the drawing, in the order of the file.
pub(crate) fn shapes(path: &Path, plan: &Plan) -> Result<Mapped, FileError> {
    let text = file::text(path)?;
    on_a_large_stack(|| drawing(&text, plan)).map_err(|problem| FileError::new(path, problem))
}

/// The parser goes down into each element within another, up to 1024 of them, on its thread's stack; those
/// of most threads are too small for that. It is not our code: should it panic, the file is refused.
fn on_a_large_stack<T: Send>(
    work: impl FnOnce() -> Result<T, DrawingError> + Send,
) -> Result<T, DrawingError> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work);
        let thread = thread.map_err(DrawingError::NoThread)?;
        thread.join().unwrap_or_else(|_| Err(DrawingError::ParserGaveUp))
    })
}

fn drawing(text: &str, plan: &Plan) -> Result<Mapped, DrawingError> {
    let drawing = Drawing::read(text)?;
    let tree = drawing.tree(Some(STYLE))?;
    let placement = Placement { scale: plan.scale, height: f64::from(tree.size().height()) };
    let mut found = Found::default();
    collect(tree.root(), &mut Above::default(), &mut found);
    let traits = traits(&drawing, &found.paths, &plan.choice)?;
    let mut walls = Walls::default();
    for (i, (found_path, traits)) in found.paths.iter().zip(&traits).enumerate() {
        let path = found_path.path;
        let name = name(path, i);
        let of_element = |problem| DrawingError::Shape { shape: name.clone(), problem };
        if found_path.is_in(&plan.marks) {
            // A place is no wall.
        } else if !plan.choice.takes(traits) {
            walls.left_out.push(name);
        } else {
            let outlines = outlines::of_path(path, &placement).map_err(of_element)?;
            walls.corners += outlines.iter().map(|outline| outline.points.len()).sum::<usize>();
            match clip::clipped(&outlines, &found_path.clips, &placement).map_err(of_element)? {
                Clipped::Whole => walls.take(shapes_of(path, outlines).map_err(of_element)?, &name),
                Clipped::Away => found.clipped += 1,
            }
        }
        if walls.shapes.len() > MAX_SHAPES || walls.corners > MAX_CORNERS {
            return Err(DrawingError::Size);
        }
    }
    let marks: Vec<Mark> =
        plan.marks.iter().map(|wanted| wanted.find(&tree, &placement)).collect::<Result<_, _>>()?;
    let notes = notes(&drawing, &tree, &found, (&walls, &traits), plan)?;
    Ok(Mapped { shapes: walls.shapes, notes, marks })
}

/// The name of the shape for people.
fn name(path: &usvg::Path, i: usize) -> String {
    let id = Some(path.id()).filter(|id| drawing::is_given(id));
    id.map_or_else(|| format!("shape {i}, counted from 0,"), |id| format!("the shape `{id}`"))
}

/// The walls of a drawing.
#[derive(Default)]
struct Walls {
    shapes: Vec<Shape>,
    /// The number of the shapes that are solid, and the name of the first.
    solid: Vec<(usize, String)>,
    corners: usize,
    left_out: Vec<String>,
}

impl Walls {
    fn take(&mut self, shapes: Vec<Shape>, name: &str) {
        let first = self.shapes.len();
        self.shapes.extend(shapes);
        let solid = (first..self.shapes.len()).filter(|&i| self.shapes[i].solid);
        self.solid.extend(solid.map(|i| (i, name.to_owned())));
    }
}

/// The shapes of a path: solid where it is filled and has no hole.
fn shapes_of(path: &usvg::Path, outlines: Vec<Outline>) -> Result<Vec<Shape>, ShapeError> {
    let fill = path.fill().filter(|fill| fill.opacity().get() > 0.0);
    let mut rims = Vec::new();
    if let Some(fill) = fill {
        let closed: Vec<_> = outlines.iter().filter(|outline| outline.closed).collect();
        if let Some(outline) = closed.iter().find(|outline| outline.points.len() < 3) {
            return Err(ShapeError::TooFewCorners(outline.points.len()));
        }
        if !closed.iter().all(|outline| outline.is_simple()) {
            return Err(ShapeError::CrossesItself);
        }
        rims = outlines::rims(&closed, fill.rule())?;
    }
    let mut rims = rims.into_iter();
    let shapes = outlines.into_iter().map(|Outline { points, closed }| {
        let solid = closed && rims.next() == Some(Rim::Solid);
        Shape { points, solid, closed }
    });
    Ok(shapes.filter(|shape| shape.points.len() > 1).collect())
}

/// A path that is not hidden.
struct FoundPath<'a> {
    path: &'a usvg::Path,
    /// The ids of the groups and references that it is in.
    groups: Vec<&'a str>,
    /// The paths that clip the shape, each with the place of its group.
    clips: Vec<(&'a usvg::ClipPath, usvg::Transform)>,
}

impl FoundPath<'_> {
    /// Whether it is such a place, or a part of one.
    fn is_in(&self, places: &[Wanted]) -> bool {
        places.iter().any(|place| self.path.id() == place.id || self.groups.contains(&&*place.id))
    }
}

/// The paths of a drawing, and how many are hidden.
#[derive(Default)]
struct Found<'a> {
    paths: Vec<FoundPath<'a>>,
    transparent: usize,
    clipped: usize,
}

/// The surroundings of a node of the tree.
#[derive(Default)]
struct Above<'a> {
    groups: Vec<&'a str>,
    clips: Vec<(&'a usvg::ClipPath, usvg::Transform)>,
    is_transparent: bool,
}

fn collect<'a>(group: &'a Group, above: &mut Above<'a>, found: &mut Found<'a>) {
    let (groups, clips, was_transparent) = (above.groups.len(), above.clips.len(), above.is_transparent);
    above.groups.extend(Some(group.id()).filter(|id| !id.is_empty()));
    above.clips.extend(group.clip_path().map(|clip| (clip, group.abs_transform())));
    above.is_transparent |= group.opacity().get() == 0.0;
    for node in group.children() {
        match node {
            usvg::Node::Group(group) => collect(group, above, found),
            usvg::Node::Path(_) if above.is_transparent => found.transparent += 1,
            usvg::Node::Path(path) if path.is_visible() => {
                let (groups, clips) = (above.groups.clone(), above.clips.clone());
                found.paths.push(FoundPath { path, groups, clips });
            }
            usvg::Node::Path(_) | usvg::Node::Image(_) | usvg::Node::Text(_) => {}
        }
    }
    above.groups.truncate(groups);
    above.clips.truncate(clips);
    above.is_transparent = was_transparent;
}

/// The traits by which shapes can be chosen; none are collected without a choice.
fn traits(drawing: &Drawing, paths: &[FoundPath<'_>], choice: &Choice) -> Result<Vec<Traits>, DrawingError> {
    if choice.selectors().next().is_none() {
        return Ok(paths.iter().map(|_| Traits::default()).collect());
    }
    let elements = drawing.elements()?;
    let has_strokes = choice.selectors().any(Selector::is_about_strokes);
    // As it is without our style sheet, in which all have a stroke.
    let tree = has_strokes.then(|| drawing.tree(None)).transpose()?;
    let mut as_drawn = Found::default();
    if let Some(tree) = &tree {
        collect(tree.root(), &mut Above::default(), &mut as_drawn);
    }
    let key = |found: &FoundPath<'_>| [&found.groups[..], &[found.path.id()]].concat().join("\n");
    let strokes: HashMap<_, _> = as_drawn
        .paths
        .iter()
        .map(|found| (key(found), found.path.stroke().map_or(Paint::Nothing, |stroke| paint(stroke.paint()))))
        .collect();
    Ok(paths
        .iter()
        .map(|found| {
            let mut traits = of_elements(&elements, found);
            traits.fill = Some(found.path.fill().map_or(Paint::Nothing, |fill| paint(fill.paint())));
            traits.stroke = has_strokes.then(|| strokes.get(&key(found)).copied().unwrap_or(Paint::Nothing));
            traits
        })
        .collect())
}

fn of_elements(elements: &Elements, found: &FoundPath<'_>) -> Traits {
    let mut traits = Traits::default();
    for id in found.groups.iter().copied().chain([found.path.id()]) {
        if let Some(element) = elements.of(id) {
            traits.ids.extend(element.ids.iter().cloned());
            traits.classes.extend(element.classes.iter().cloned());
            traits.layers.extend(element.layers.iter().cloned());
        }
    }
    traits
}

fn paint(paint: &usvg::Paint) -> Paint {
    match paint {
        usvg::Paint::Color(color) => Paint::Rgb(color.red, color.green, color.blue),
        usvg::Paint::LinearGradient(_) | usvg::Paint::RadialGradient(_) | usvg::Paint::Pattern(_) => {
            Paint::Other
        }
    }
}

/// The notes on the drawing.
fn notes(
    drawing: &Drawing,
    tree: &Tree,
    found: &Found<'_>,
    (walls, traits): (&Walls, &[Traits]),
    plan: &Plan,
) -> Result<Vec<FileNote>, DrawingError> {
    let warning = |text| FileNote { weight: Weight::Warning, field: "svg", text };
    let mut notes = Vec::new();
    for (field, selectors) in [("only", &plan.choice.only), ("without", &plan.choice.without)] {
        let idle = selectors.iter().filter_map(|selector| selector.chooses_nothing(traits));
        notes.extend(idle.map(|text| FileNote { weight: Weight::Warning, field, text }));
    }
    let left_out = left_out(drawing, found, walls)?;
    if !left_out.is_empty() {
        let text = format!("left out: {}", left_out.join("; "));
        notes.push(FileNote { weight: Weight::Remark, field: "svg", text });
    }
    if walls.shapes.is_empty() {
        let why = if left_out.is_empty() {
            String::new()
        } else {
            format!(" but what is left out: {}", left_out.join("; "))
        };
        notes.push(warning(format!("there is no wall{why}; draw walls as lines or shapes")));
    }
    let size = [tree.size().width(), tree.size().height()].map(f64::from);
    let page_m2 = size[0] * size[1] * plan.scale.m_per_unit * plan.scale.m_per_unit;
    let covering = walls.solid.iter().find(|(i, _)| covers(&walls.shapes, *i, page_m2));
    notes.extend(covering.map(|(_, name)| {
        warning(format!(
            "{name} is filled and covers everything, so nothing is free within it: set its fill to none if its edge is a wall, or leave it \
             out by `without`"
        ))
    }));
    Ok(notes)
}

/// The kinds of elements that are no wall and no place, each with its number.
fn left_out(drawing: &Drawing, found: &Found<'_>, walls: &Walls) -> Result<Vec<String>, DrawingError> {
    let [images, texts] = drawing.passed_over()?;
    let mut left_out = Vec::new();
    if let Some(names) = listed(walls.left_out.iter().map(|name| short(name)).collect::<Vec<_>>().iter()) {
        left_out
            .push(format!("{} by `only` and `without` ({names})", counted(walls.left_out.len(), "shape")));
    }
    let others = [
        (found.transparent, "shape that can be seen through"),
        (found.clipped, "shape outside its clip path"),
        (images, "image"),
        (texts, "text"),
    ];
    left_out
        .extend(others.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(count, what)));
    Ok(left_out)
}

/// A name without the words around it.
fn short(name: &str) -> String {
    let id = name.strip_prefix("the shape `").and_then(|name| name.strip_suffix('`'));
    id.map_or_else(|| name.trim_end_matches(", counted from 0,").to_owned(), str::to_owned)
}

fn counted(count: usize, what: &str) -> String {
    let (first, rest) = what.split_once(' ').unwrap_or((what, ""));
    let plural = if count == 1 { "" } else { "s" };
    let rest = if count == 1 { rest.to_owned() } else { rest.replacen("its", "their", 1) };
    format!("{count} {first}{plural} {rest}").trim_end().to_owned()
}

/// Whether a solid shape has nine tenths of the page in it, or all other shapes.
fn covers(shapes: &[Shape], i: usize, page_m2: f64) -> bool {
    let shape = &shapes[i];
    if shape.area_m2() >= MOST_OF * page_m2 {
        return true;
    }
    let mut others = shapes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other).peekable();
    others.peek().is_some() && others.all(|other| shape.contains(other))
}

/// The part of a page for a shape that covers it.
const MOST_OF: f64 = 0.9;

/// Every shape has a stroke, so that none is left out as invisible, and nothing but itself to be drawn.
const STYLE: &str = "* { stroke: black !important; stroke-width: 1 !important; stroke-dasharray: none !important; \
    stroke-opacity: 1 !important; marker-start: none !important; marker-mid: none !important; \
    marker-end: none !important; mask: none !important; filter: none !important }";

/// Bytes, of which only those that are used are taken from the machine.
const STACK: usize = 256 << 20;

/// The most corners of all shapes of a drawing. The check whether one crosses itself takes time in proportion to the
/// square of its corners.
pub(crate) const MAX_CORNERS: usize = 1_000_000;

impl Choice {
    fn selectors(&self) -> impl Iterator<Item = &Selector> {
        self.only.iter().chain(&self.without)
    }

    fn takes(&self, shape: &Traits) -> bool {
        let is_among = |selectors: &[Selector]| selectors.iter().any(|selector| selector.chooses(shape));
        (self.only.is_empty() || is_among(&self.only)) && !is_among(&self.without)
    }
}
