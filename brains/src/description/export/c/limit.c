/* The same way more slowly, where a wheel would be faster than the limit. */
static void brain_limit(brain_real *signals, brain_real limit) {
  brain_real left = signals[0] < 0 ? -signals[0] : signals[0], right = signals[1] < 0 ? -signals[1] : signals[1];
  brain_real largest = left > right ? left : right;
  if (largest > limit) {
    signals[0] = brain_clamp(signals[0] * (limit / largest), -limit, limit);
    signals[1] = brain_clamp(signals[1] * (limit / largest), -limit, limit);
  }
}
