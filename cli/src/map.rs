//! An arena and what moves in it in characters.

use baudbot_proto::v1;

/// A picture with y upwards. A character is about twice as high as it is wide.
pub(crate) struct Map {
    cells: Vec<Vec<char>>,
    min: (f64, f64),
    /// Metres a column; a row is twice that.
    scale: f64,
}

impl Map {
    /// The arena, and room for the robots where they are at first.
    pub(crate) fn new(
        world: &v1::DescribeWorldResponse,
        robots: &[v1::RobotTruth],
        rows: usize,
        columns: usize,
    ) -> Self {
        let (min, max) = bounds(world, robots);
        let (width, height) = (max.0 - min.0, max.1 - min.1);
        let (rows, columns) = (rows.clamp(5, MOST), columns.clamp(10, MOST));
        let scale = (width / (columns - 1) as f64).max(height / (2 * (rows - 1)) as f64).max(1e-9);
        let columns = (width / scale).round() as usize + 1;
        let rows = (height / scale / 2.0).round() as usize + 1;
        let mut map = Self { cells: vec![vec![' '; columns]; rows], min, scale };
        for polygon in &world.polygons {
            map.corners(polygon.points.iter().map(|p| (p.x_m, p.y_m)), polygon.closed, '#');
        }
        for disc in &world.circles {
            let center = disc.center.unwrap_or_default();
            map.circle((center.x_m, center.y_m), disc.radius_m, '#');
        }
        map
    }

    /// The picture with all that moves in it: outlines, and arrows that point where robots head.
    pub(crate) fn with_frame(&self, world: &v1::DescribeWorldResponse, frame: &v1::WatchResponse) -> String {
        let mut map = Self { cells: self.cells.clone(), ..*self };
        for (thing, body) in frame.things.iter().zip(&world.things) {
            let outline = body.outline.clone().unwrap_or_default();
            let pose = (thing.x_m, thing.y_m, thing.heading_rad);
            map.outline(pose, &outline.points, outline.radius_m, '+');
        }
        for (robot, body) in frame.robots.iter().zip(&world.robots) {
            let pose = (robot.x_m, robot.y_m, robot.heading_rad);
            map.outline(pose, &body.outline, body.radius_m, '·');
        }
        for robot in &frame.robots {
            map.dot((robot.x_m, robot.y_m), if robot.collided { 'X' } else { arrow(robot.heading_rad) });
        }
        let rows = map.cells.iter().rev().map(|row| row.iter().collect::<String>());
        rows.map(|row| format!("{}\n", row.trim_end())).collect()
    }

    /// Points outside are not drawn.
    fn dot(&mut self, (x, y): (f64, f64), mark: char) {
        let column = ((x - self.min.0) / self.scale).round();
        let row = ((y - self.min.1) / self.scale / 2.0).round();
        if column < 0.0 || row < 0.0 {
            return;
        }
        if let Some(cell) = self.cells.get_mut(row as usize).and_then(|row| row.get_mut(column as usize)) {
            *cell = mark;
        }
    }

    fn line(&mut self, a: (f64, f64), b: (f64, f64), mark: char) {
        // No line of the arena is longer than the picture is wide and high.
        let steps = (2.0 * (b.0 - a.0).hypot(b.1 - a.1) / self.scale).ceil().clamp(1.0, 1e3) as usize;
        for i in 0..=steps {
            let t = i as f64 / steps as f64;
            self.dot((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)), mark);
        }
    }

    fn corners(
        &mut self,
        corners: impl ExactSizeIterator<Item = (f64, f64)> + Clone,
        closed: bool,
        mark: char,
    ) {
        let sides = if closed { corners.len() } else { corners.len().saturating_sub(1) };
        let ends = corners.clone().cycle().skip(1);
        for (start, end) in corners.zip(ends).take(sides) {
            self.line(start, end, mark);
        }
    }

    /// A body at a pose: its corners in its own frame, or a disc if it has none.
    fn outline(&mut self, (x, y, heading): (f64, f64, f64), corners: &[v1::Point], radius: f64, mark: char) {
        if corners.is_empty() {
            return self.circle((x, y), radius, mark);
        }
        let (sin, cos) = heading.sin_cos();
        let place = |p: &v1::Point| (x + p.x_m * cos - p.y_m * sin, y + p.x_m * sin + p.y_m * cos);
        self.corners(corners.iter().map(place), true, mark);
    }

    fn circle(&mut self, center: (f64, f64), radius: f64, mark: char) {
        let steps = (2.0 * std::f64::consts::TAU * radius / self.scale).ceil().clamp(8.0, 1e3) as usize;
        for i in 0..steps {
            let angle = std::f64::consts::TAU * i as f64 / steps as f64;
            self.dot((center.0 + radius * angle.cos(), center.1 + radius * angle.sin()), mark);
        }
    }
}

fn bounds(world: &v1::DescribeWorldResponse, robots: &[v1::RobotTruth]) -> ((f64, f64), (f64, f64)) {
    let corners = world.polygons.iter().flat_map(|polygon| &polygon.points).map(|p| (p.x_m, p.y_m, 0.0));
    let center = |disc: &v1::Disc| disc.center.unwrap_or_default();
    let discs = world.circles.iter().map(|disc| (center(disc).x_m, center(disc).y_m, disc.radius_m));
    // A robot in an empty plane needs room to drive in.
    let room = |radius: f64| if world.polygons.is_empty() { radius + 1.0 } else { radius };
    let robots =
        robots.iter().zip(&world.robots).map(|(robot, body)| (robot.x_m, robot.y_m, room(body.radius_m)));
    let (mut min, mut max) = ((f64::INFINITY, f64::INFINITY), (f64::NEG_INFINITY, f64::NEG_INFINITY));
    for (x, y, radius) in corners.chain(discs).chain(robots) {
        min = (min.0.min(x - radius), min.1.min(y - radius));
        max = (max.0.max(x + radius), max.1.max(y + radius));
    }
    if min.0 <= max.0 { (min, max) } else { ((0.0, 0.0), (0.0, 0.0)) }
}

fn arrow(heading: f64) -> char {
    const ARROWS: [char; 8] = ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'];
    let eighth = (heading / std::f64::consts::FRAC_PI_4).round().rem_euclid(8.0);
    ARROWS[eighth as usize % 8]
}

/// Most rows or columns of a picture.
const MOST: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> v1::DescribeWorldResponse {
        let point = |x_m, y_m| v1::Point { x_m, y_m };
        let points = vec![point(0.0, 0.0), point(6.0, 0.0), point(6.0, 4.0), point(0.0, 4.0)];
        v1::DescribeWorldResponse {
            polygons: vec![v1::Polygon { points, closed: true, ..Default::default() }],
            robots: vec![v1::ObservedRobot { radius_m: 0.0, ..Default::default() }],
            ..Default::default()
        }
    }

    fn frame(robots: &[v1::RobotTruth]) -> v1::WatchResponse {
        v1::WatchResponse { robots: robots.to_vec(), ..Default::default() }
    }

    #[test]
    fn a_room_with_a_robot() {
        let robots = [v1::RobotTruth { x_m: 3.0, y_m: 4.0 - 0.2, heading_rad: 1.6, ..Default::default() }];
        let text = Map::new(&room(), &robots, 40, 61).with_frame(&room(), &frame(&robots));
        let rows: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        assert_eq!((rows.len(), rows[0].len()), (21, 61));
        assert!(rows[0].iter().chain(&rows[20]).all(|&c| c == '#'));
        assert!(rows[1..20].iter().all(|row| row[0] == '#' && row[60] == '#'));
        assert_eq!(rows[1][30], '↑');
        assert_eq!(text.matches(' ').count(), 19 * 59 - 1);
    }

    #[test]
    fn an_open_line_stays_open_and_a_box_is_drawn_where_it_is() {
        let mut world = room();
        world.polygons[0].closed = false;
        let corner = |x_m, y_m| v1::Point { x_m, y_m };
        let points = vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)];
        let outline = Some(v1::Outline { points, ..Default::default() });
        world.things.push(v1::ObservedThing { outline, ..Default::default() });
        let thing = v1::ThingTruth { x_m: 3.0, y_m: 2.0, ..Default::default() };
        let frame = v1::WatchResponse { things: vec![thing], ..Default::default() };
        let text = Map::new(&world, &[], 40, 61).with_frame(&world, &frame);
        let rows: Vec<Vec<char>> = text.lines().map(|line| line.chars().collect()).collect();
        assert!(rows[1..20].iter().all(|row| row[0] != '#' && row[60] == '#'), "{text}");
        let (top, middle): (String, String) = (rows[7].iter().collect(), rows[10].iter().collect());
        assert!(top.contains("+++++++++++") && middle.contains("+         +"), "{text}");
    }

    #[test]
    fn arrows_follow_the_heading() {
        let headings = [0.0, 0.8, 1.6, 2.4, 3.2, -3.1, -2.4, -1.6, -0.8, -0.1];
        assert_eq!(headings.map(arrow).iter().collect::<String>(), "→↗↑↖←←↙↓↘→");
    }

    #[test]
    fn who_is_outside_is_not_drawn_and_an_empty_world_is() {
        let far = [v1::RobotTruth { x_m: -100.0, y_m: 1e300, ..Default::default() }];
        let near = [v1::RobotTruth { x_m: 1.0, y_m: 1.0, ..Default::default() }];
        assert!(!Map::new(&room(), &near, 40, 61).with_frame(&room(), &frame(&far)).contains('→'));
        let nothing = v1::DescribeWorldResponse::default();
        assert_eq!(Map::new(&nothing, &[], 40, 61).with_frame(&nothing, &frame(&[])), "\n");
    }
}
