/* The place of the greatest number, of equal ones the first. */
static uint16_t brain_greatest(const brain_real *numbers, uint16_t count) {
  uint16_t i, best = count;
  for (i = 0; i < count; i++) {
    if (numbers[i] == numbers[i] && (best == count || numbers[i] > numbers[best])) best = i;
  }
  return best == count ? 0 : best;
}
