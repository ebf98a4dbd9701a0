/** A brain in JavaScript, to begin with: the same as in Python. */
export const JAVASCRIPT = `// Follows the wall on its right. This is called at each step of the robot;
// what is kept in memory is there at the next one.
const speed = 0.4;
const gain = 1.0;
const wanted = 0.3; // nearness of the wall: 0 is out of range, 1 is very near

function step(turn, memory) {
  const ahead = Math.max(turn.value("ir_front", 1), turn.value("ir_front_left", 1));
  if (ahead > wanted) {
    return { left: -0.5 * speed, right: 0.5 * speed }; // a corner: to the left
  }
  const right = Math.max(turn.value("ir_right", 0), turn.value("ir_front_right", 0));
  const turning = gain * speed * (right - wanted); // too near: to the left
  return { left: speed - turning, right: speed + turning };
}
`;
