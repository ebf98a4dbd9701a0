/* The parts in which a step is done: x, rounded up, from 1 to 1000. */
static uint16_t brain_parts(brain_real x) {
  uint16_t parts = x > 1 ? x < 1000 ? (uint16_t)x : 1000 : 1;
  return parts < x && parts < 1000 ? parts + 1 : parts;
}
