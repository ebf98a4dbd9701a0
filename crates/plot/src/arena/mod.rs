//! Arenas from above: a scenario at its start, with the trails of a run, with a planned path, or with a pose search.
//!
//! From the picture inwards:
//!
//! 1. This file puts it together: the plan with its frame and its names, and blocks beside it or below it.
//! 2. `lens` enlarges robots that are small in the plan, `key` says what the colours mean, `block` makes columns of both,
//!    and `kinds` finds robots that are alike.
//! 3. `pins` draws the chip of a robot that runs a program of the user's own. `ground`, `walls`, `things`, `body` and `senses` draw what there is, from the floor upwards, into any window;
//!    `trails`, `route` and `pose_search` draw over it; `contours` finds the lines of one height of a potential field.
//! 4. `view` is such a window, `extent` the part of the world in it, `frame` its axes, and `labels` finds room for names.
//!
//! The same scenario gives the same bytes on every machine: whatever needs a sine or a root takes it from
//! `baudbot_geometry::math`.

mod block;
mod body;
mod contours;
mod extent;
mod frame;
mod ground;
mod key;
mod kinds;
mod labels;
mod lens;
mod pins;
mod pose_search;
mod route;
mod senses;
#[cfg(test)]
mod tests;
mod things;
mod trails;
mod view;
mod walls;

use std::sync::Arc;

use baudbot_sim::raycast::RayCaster;
use baudbot_sim::{Scenario, World};

use self::block::{Block, GAP, WIDTH};
pub use self::contours::{Contour, contours};
use self::kinds::Kind;
use self::labels::{Labels, Style};
pub use self::pose_search::{Attempt, PoseSearch};
pub use self::route::Route;
pub use self::trails::{Collision, Trail, Trails};
use self::view::View;
use crate::caption;
use crate::palette::{self, INK, PALE_INK};
use crate::svg::{self, Canvas, Element, Place, text};
use crate::text::{shortened, width, wrapped};

/// The picture of a scenario at its start. `label` stands for the name of a scenario that has none.
pub fn draw(scenario: &Scenario, label: &str) -> String {
    picture(scenario, label, Shown::Starts)
}

/// The picture of a scenario with the trails of its robots, without what they sense at their starts.
pub fn draw_trails(scenario: &Scenario, label: &str, trails: &Trails) -> String {
    picture(scenario, label, Shown::Trails(trails))
}

/// The picture of a scenario with a planned path, and without its robots.
pub fn draw_route(scenario: &Scenario, label: &str, route: &Route) -> String {
    picture(scenario, label, Shown::Route(route))
}

/// The picture of a scenario with the search for a robot's pose.
pub fn draw_pose_search(scenario: &Scenario, label: &str, search: &PoseSearch) -> String {
    picture(scenario, label, Shown::PoseSearch(search))
}

/// The contents of the arena.
#[derive(Clone, Copy)]
enum Shown<'a> {
    /// Robots at their starts, and what they sense there.
    Starts,
    /// The trails of a run.
    Trails(&'a Trails),
    /// A planned path.
    Route(&'a Route),
    /// The search for a robot's pose.
    PoseSearch(&'a PoseSearch),
}

fn picture(scenario: &Scenario, label: &str, shown: Shown<'_>) -> String {
    let world = World::new(Arc::new(scenario.clone()));
    let caster = RayCaster::new(&world);
    let kinds = kinds::of(&scenario.robots);
    let start = extent::of(scenario);
    let went = match shown {
        Shown::Trails(trails) => trails.bounds(&scenario.robots),
        Shown::PoseSearch(search) => Some(search.bounds()),
        Shown::Starts | Shown::Route(_) => None,
    };
    let bounds = went.map_or(start, |went| start.union(&went));
    let is_wide = bounds.size().x > 1.5 * bounds.size().y;
    let most = if is_wide { (960.0, 700.0) } else { (660.0, 760.0) };
    let scale = (most.0 / bounds.size().x).min(most.1 / bounds.size().y);
    let text_room = if is_wide { most.0 } else { scale * bounds.size().x + GAP + WIDTH };
    let head = head(scenario, label, shown, text_room);
    let view = View { world: bounds, scale, left: frame::LEFT, top: head.height };
    let lenses = match shown {
        Shown::Starts => Lenses::new(&kinds, scale),
        Shown::Trails(_) | Shown::Route(_) | Shown::PoseSearch(_) => Lenses::none(),
    };
    let plan = Plan { view, world: &world, caster: &caster, kinds: &kinds, lenses: &lenses, shown };
    let mut canvas = Canvas::default();
    canvas.append(&head.canvas);
    plan.draw(&mut canvas);
    let blocks = block::columns(&mut canvas, &plan.blocks(), columns(&view, is_wide));
    let (right, bottom) = (view.left + view.width(), view.top + view.height() + frame::BELOW);
    let size = (right.max(blocks.0) + GAP, bottom.max(blocks.1));
    document(scenario, label, shown, size, &canvas)
}

/// The kinds of robots that are enlarged, and the height of the windows on them.
struct Lenses<'a> {
    kinds: Vec<&'a Kind<'a>>,
    height: f64,
}

impl<'a> Lenses<'a> {
    fn new(kinds: &'a [Kind<'a>], scale: f64) -> Self {
        let is_small = |kind: &&Kind<'_>| 2.0 * kind.robot.drive.radius_m * scale < SMALL_PX;
        let kinds: Vec<_> = kinds.iter().filter(is_small).take(MOST_LENSES).collect();
        let height = if kinds.len() > 1 { 250.0 } else { 300.0 };
        Self { kinds, height }
    }

    fn none() -> Self {
        Self { kinds: Vec::new(), height: 0.0 }
    }

    fn has(&self, kind: &Kind<'_>) -> bool {
        self.kinds.iter().any(|other| other.first == kind.first)
    }
}

/// The whole file.
fn document(
    scenario: &Scenario,
    label: &str,
    shown: Shown<'_>,
    (width, height): (f64, f64),
    inside: &Canvas,
) -> String {
    let (width, height) = (width.ceil(), height.ceil());
    let mut canvas = Canvas::default();
    let root = svg::root((width, height)).set("role", "img").set("font-family", FONT);
    canvas.open(root.titled(&format!("{}, seen from above", name(scenario, label))));
    canvas.put(Element::new("desc").text(&format!("{} ", told(scenario, shown).join(" "))));
    canvas.open(Element::new("defs"));
    ground::definitions(&mut canvas, &scenario.surroundings);
    canvas.close("defs");
    canvas.put(svg::paper((width, height)));
    canvas.append(inside);
    canvas.close("svg");
    canvas.into_text()
}

fn name<'a>(scenario: &'a Scenario, label: &'a str) -> &'a str {
    if scenario.name.is_empty() { label } else { &scenario.name }
}

/// The title: the scenario, and the run.
fn told(scenario: &Scenario, shown: Shown<'_>) -> Vec<String> {
    let (about, facts) = match shown {
        Shown::Starts | Shown::Route(_) | Shown::PoseSearch(_) => (caption::about(scenario, false), None),
        Shown::Trails(trails) => (trails.about.clone(), Some(trails.facts.clone())),
    };
    [Some(about), facts].into_iter().flatten().filter(|text| !text.is_empty()).collect()
}

/// Name, description, and what ran.
fn head(scenario: &Scenario, label: &str, shown: Shown<'_>, room: f64) -> Block {
    let mut canvas = Canvas::default();
    let name = shortened(name(scenario, label), 20.0, room);
    canvas.put(text((24.0, 34.0), 20.0, INK, &name).set("font-weight", "600"));
    let mut y = 38.0;
    for line in told(scenario, shown).iter().flat_map(|text| wrapped(text, 13.0, room, 3)) {
        y += 18.0;
        canvas.put(text((24.0, y), 13.0, PALE_INK, &line));
    }
    Block { canvas, height: y + 16.0 }
}

/// The beginnings of columns: one beside a plan that leaves room there, and as many below it as are not wider.
fn columns(plan: &View, is_wide: bool) -> Vec<Place> {
    let beside = (!is_wide).then_some((plan.left + plan.width() + GAP, plan.top));
    let fit = ((plan.width() + GAP + 4.0) / (WIDTH + GAP)).floor() as usize;
    let bottom = plan.top + plan.height() + frame::BELOW;
    let below = (0..fit).map(|i| (plan.left + i as f64 * (WIDTH + GAP), bottom));
    beside.into_iter().chain(below).collect()
}

/// The plan, and what it shows.
struct Plan<'a> {
    view: View,
    world: &'a World,
    caster: &'a RayCaster<'a>,
    kinds: &'a [Kind<'a>],
    lenses: &'a Lenses<'a>,
    shown: Shown<'a>,
}

impl Plan<'_> {
    /// The figures beside it or below it.
    fn blocks(&self) -> Vec<Block> {
        let scenario = self.world.scenario();
        let surroundings = key::of_surroundings(scenario, self.shown);
        let own = match self.shown {
            Shown::Starts => Vec::new(),
            Shown::Trails(trails) => vec![trails::key(scenario, trails)],
            Shown::Route(route) => vec![route::key(route)],
            Shown::PoseSearch(search) => {
                vec![pose_search::enlarged(search, scenario, self.view.scale), pose_search::key(search)]
            }
        };
        if !own.is_empty() {
            return own.into_iter().chain(surroundings).collect();
        }
        let sizes = (self.lenses.height, self.view.scale);
        let lens = |(i, kind): (usize, &&Kind<'_>)| lens::draw(i, kind, self.world, self.caster, sizes);
        let lenses = self.lenses.kinds.iter().enumerate().map(lens);
        let keys = self.kinds.iter().take(MOST_LENSES).map(key::of_kind);
        let rest = (self.kinds.len() > MOST_LENSES).then(key::of_rest);
        let pins = self.kinds.iter().take(MOST_LENSES).filter_map(pins::draw);
        let keys = keys.chain(pins);
        lenses.chain(keys).chain(rest).chain(surroundings).collect()
    }

    fn draw(&self, canvas: &mut Canvas) {
        let (view, scenario): (&View, &Scenario) = (&self.view, self.world.scenario());
        canvas.put(Element::new("clipPath").set("id", "plan").with(view.frame()));
        canvas.open(Element::group().set("clip-path", "url(#plan)"));
        ground::draw(canvas, view, scenario);
        if let Shown::Route(route) = self.shown {
            route::draw_cells(canvas, view, route);
        }
        frame::grid(canvas, view);
        walls::draw(canvas, view, &scenario.arena);
        things::draw(canvas, view, scenario, true);
        match self.shown {
            Shown::Starts => self.draw_robots(canvas),
            Shown::Route(route) => route::draw_path(canvas, view, route),
            Shown::PoseSearch(search) => pose_search::draw(canvas, view, scenario, search),
            Shown::Trails(trails) => {
                canvas.open(Element::group().set("opacity", "0.4"));
                scenario.robots.iter().for_each(|robot| body::draw(canvas, view, robot));
                canvas.close("g");
                trails::draw(canvas, view, scenario, trails);
            }
        }
        let corner = (view.left + view.width(), view.top + view.height());
        let mut labels = Labels::new((view.left + 3.0, view.top + 3.0), (corner.0 - 3.0, corner.1 - 3.0));
        self.label(&mut labels);
        canvas.append(&labels.into_canvas());
        canvas.close("g");
        frame::axes(canvas, view);
    }

    /// Robots at their starts, with the rays of their sensors.
    fn draw_robots(&self, canvas: &mut Canvas) {
        let (view, caster, robots) = (&self.view, self.caster, &self.world.scenario().robots);
        let is_crowd = robots.len() > CROWD;
        for robot in robots.iter().enumerate().take(MOST_FANS) {
            match is_crowd {
                true => senses::brief_fans(canvas, view, caster, robot),
                false => senses::fans(canvas, view, caster, robot),
            }
        }
        for robot in robots {
            body::draw(canvas, view, robot);
        }
        if !is_crowd {
            robots.iter().enumerate().for_each(|robot| senses::mounts(canvas, view, caster, robot));
        }
        for kind in &self.lenses.kinds {
            lens::mark(canvas, view, kind, self.lenses.height);
        }
    }

    /// Names: the robots' first, then what is nearest to what a reader asks.
    fn label(&self, labels: &mut Labels) {
        let (view, scenario): (&View, &Scenario) = (&self.view, self.world.scenario());
        let lenses = self.lenses;
        let robots = if matches!(self.shown, Shown::Route(_) | Shown::PoseSearch(_)) {
            &[][..]
        } else {
            &scenario.robots
        };
        for robot in robots {
            labels.keep_disc(view.at(robot.start.pose.position), view.length(body::reach(robot)) + 1.0);
        }
        let outside = walls::label_inside(labels, view, &scenario.arena);
        let is_start = matches!(self.shown, Shown::Starts);
        let is_told = |kind: &&Kind<'_>| !lenses.has(kind) && robots.len() <= CROWD && is_start;
        for kind in self.kinds.iter().filter(is_told) {
            lens::label_sensors(labels, view, self.caster, kind);
        }
        let named = if robots.len() > MOST_NAMES { 0 } else { robots.len() };
        for (i, robot) in robots.iter().enumerate().take(named) {
            let (x, y) = view.at(robot.start.pose.position);
            let lens = lenses.kinds.iter().find(|kind| kind.first == i);
            let above = lens.map(|kind| lens::above(view, kind, lenses.height));
            let color = if is_start { palette::ROBOT.to_owned() } else { trails::color(robots, i) };
            let style = Style { size: 12.0, color: &color, bold: true };
            let off = view.length(body::reach(robot)) + 10.0;
            let side = off + 0.5 * width(&robot.name, 13.0);
            let places = [(x, y + off), (x, y - off), (x + side, y), (x - side, y), (x, y + off + 14.0)];
            let far = [(x - side, y + off), (x + side, y + off), (x - side, y - off), (x + side, y - off)];
            labels.put(&robot.name, style, above.into_iter().chain(places).chain(far));
        }
        things::label(labels, view, scenario);
        ground::label(labels, view, scenario);
        walls::label_outside(labels, view, &scenario.arena, &outside);
    }
}

const FONT: &str = "system-ui, Helvetica, Arial, sans-serif";
/// A robot narrower than this is enlarged, in pixels.
const SMALL_PX: f64 = 40.0;
/// More windows than this are no help.
const MOST_LENSES: usize = 4;
/// The number of robots beyond which rays and mounts are drawn in the windows only.
const CROWD: usize = 50;
/// More robots than this are not named, but for their titles: only those at the crowd's edge would be.
const MOST_NAMES: usize = 200;
/// Fans of so many robots are drawn: each costs time, and a picture of more is one colour.
const MOST_FANS: usize = 2000;
