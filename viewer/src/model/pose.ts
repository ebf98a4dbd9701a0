/** Poses in the plane. */

export interface Pose {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

/** The same angle in (-π, π]. */
export function wrapped(angle_rad: number): number {
  const turn = 2 * Math.PI;
  const rest = angle_rad - turn * Math.floor((angle_rad + Math.PI) / turn);
  return rest === -Math.PI ? Math.PI : rest;
}

/** A point of a frame whose pose this is, in the frame in which the pose is given. */
export function outOf(frame: Pose, x_m: number, y_m: number): { x_m: number; y_m: number } {
  const [cos, sin] = [Math.cos(frame.heading_rad), Math.sin(frame.heading_rad)];
  return { x_m: frame.x_m + cos * x_m - sin * y_m, y_m: frame.y_m + sin * x_m + cos * y_m };
}

/** a⁻¹ ∘ b: the pose b as seen from a. */
export function relative(a: Pose, b: Pose): Pose {
  const [cos, sin] = [Math.cos(a.heading_rad), Math.sin(a.heading_rad)];
  const [dx, dy] = [b.x_m - a.x_m, b.y_m - a.y_m];
  return { x_m: cos * dx + sin * dy, y_m: cos * dy - sin * dx, heading_rad: b.heading_rad - a.heading_rad };
}

/** a ∘ b: the pose b, which is given in a's frame. */
export function composed(a: Pose, b: Pose): Pose {
  return { ...outOf(a, b.x_m, b.y_m), heading_rad: a.heading_rad + b.heading_rad };
}
